/*
 * Direction test as a toolkit draws it: a context without a window draws the scene into a texture.
 * Another context, which shares the texture, draws the window with it. With --mode docked the scene
 * fills only a part of the window.
 */
#include "common/fixed.h"

#include <GL/glx.h>
#include <string.h>

static GLXContext studio;
static GLXPbuffer nowhere;
static GLuint framebuffer, picture, depth;

static void setup(app *a)
{
    static const int attributes[] = {GLX_PBUFFER_WIDTH, 1, GLX_PBUFFER_HEIGHT, 1, None};
    studio = glXCreateNewContext(a->window.display, a->window.config, GLX_RGBA_TYPE, a->window.context, True);
    nowhere = glXCreatePbuffer(a->window.display, a->window.config, attributes);
    app_check(a, studio != NULL, "there is no second context");
    glGenTextures(1, &picture);
    glBindTexture(GL_TEXTURE_2D, picture);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
    glTexImage2D(GL_TEXTURE_2D, 0, GL_RGBA8, a->window.width, a->window.height, 0, GL_RGBA, GL_UNSIGNED_BYTE, NULL);
}

static void make_framebuffer(const app *a)
{
    glGenRenderbuffers(1, &depth);
    glBindRenderbuffer(GL_RENDERBUFFER, depth);
    glRenderbufferStorage(GL_RENDERBUFFER, GL_DEPTH_COMPONENT24, a->window.width, a->window.height);
    glGenFramebuffers(1, &framebuffer);
    glBindFramebuffer(GL_FRAMEBUFFER, framebuffer);
    glFramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, picture, 0);
    glFramebufferRenderbuffer(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, GL_RENDERBUFFER, depth);
    glViewport(0, 0, a->window.width, a->window.height);
}

static void compose(float part)
{
    glMatrixMode(GL_PROJECTION);
    glLoadIdentity();
    glMatrixMode(GL_MODELVIEW);
    glLoadIdentity();
    glDisable(GL_DEPTH_TEST);
    glEnable(GL_TEXTURE_2D);
    glBindTexture(GL_TEXTURE_2D, picture);
    glColor3f(1.0f, 1.0f, 1.0f);
    glBegin(GL_QUADS);
    for (int i = 0; i < 4; i++) {
        float x = i == 1 || i == 2, y = i >= 2;
        glTexCoord2f(x, y);
        glVertex2f(2.0f * part * x - 1.0f, 2.0f * part * y - 1.0f);
    }
    glEnd();
}

static void draw(app *a)
{
    glXMakeContextCurrent(a->window.display, nowhere, nowhere, studio);
    if (framebuffer == 0)
        make_framebuffer(a);
    fixed_cube(a);
    app_check_error(a, "in the context without a window");
    window_make_current(&a->window);
    glClear(GL_COLOR_BUFFER_BIT);
    compose(a->mode != NULL && strcmp(a->mode, "docked") == 0 ? 0.5f : 1.0f);
}

int main(int argc, char **argv)
{
    static const app_program self = {"toolkit", API_GL_COMPATIBILITY, 0, 0, setup, draw, NULL};
    return app_main(argc, argv, &self);
}
