/*
 * Direction test with the fixed-function pipeline and EXT_framebuffer_object: the scene is drawn into a texture,
 * and a textured quad shows it.
 */
#include "common/app.h"
#include "common/fixed.h"

static GLuint framebuffer, texture, depth;

static void setup(app *a)
{
    glGenTextures(1, &texture);
    glBindTexture(GL_TEXTURE_2D, texture);
    glTexImage2D(GL_TEXTURE_2D, 0, GL_RGBA, a->window.width, a->window.height, 0, GL_RGBA, GL_UNSIGNED_BYTE, NULL);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
    glGenRenderbuffersEXT(1, &depth);
    glBindRenderbufferEXT(GL_RENDERBUFFER_EXT, depth);
    glRenderbufferStorageEXT(GL_RENDERBUFFER_EXT, GL_DEPTH_COMPONENT, a->window.width, a->window.height);
    glGenFramebuffersEXT(1, &framebuffer);
    glBindFramebufferEXT(GL_FRAMEBUFFER_EXT, framebuffer);
    glFramebufferTexture2DEXT(GL_FRAMEBUFFER_EXT, GL_COLOR_ATTACHMENT0_EXT, GL_TEXTURE_2D, texture, 0);
    glFramebufferRenderbufferEXT(GL_FRAMEBUFFER_EXT, GL_DEPTH_ATTACHMENT_EXT, GL_RENDERBUFFER_EXT, depth);
    app_check(a, glCheckFramebufferStatusEXT(GL_FRAMEBUFFER_EXT) == GL_FRAMEBUFFER_COMPLETE_EXT, "no framebuffer");
    glBindFramebufferEXT(GL_FRAMEBUFFER_EXT, 0);
}

static void draw(app *a)
{
    glBindFramebufferEXT(GL_FRAMEBUFFER_EXT, framebuffer);
    glDisable(GL_TEXTURE_2D);
    fixed_cube(a);
    glBindFramebufferEXT(GL_FRAMEBUFFER_EXT, 0);
    fixed_begin_pixels(a);
    glEnable(GL_TEXTURE_2D);
    glColor3f(1.0f, 1.0f, 1.0f);
    glBegin(GL_QUADS);
    for (int i = 0; i < 4; i++) {
        float x = (float)(i == 1 || i == 2), y = (float)(i >> 1);
        glTexCoord2f(x, y);
        glVertex2f(x * (float)a->window.width, y * (float)a->window.height);
    }
    glEnd();
    fixed_end_pixels();
}

int main(int argc, char **argv)
{
    static const app_program self = {"ext_framebuffer", API_GL_COMPATIBILITY, 2, 1, setup, draw, NULL};
    return app_main(argc, argv, &self);
}
