/*
 * Direction test as a toolkit draws it: a context without a window draws the scene into a texture.
 * Another context, which shares the texture, draws the window with it. A third one has a window that
 * shows nothing. With --mode docked the scene fills only a small part of the window. With --mode panes
 * it fills most of it, between widgets; with panes-copied it is copied there. With --mode unmapped the
 * first context has a window, which is not mapped. With --mode late another window is mapped after its
 * context became current for the only time, and shows the scene from then on.
 */
#include "common/fixed.h"

#include <GL/glx.h>
#include <string.h>

static GLXContext studio;
static GLXDrawable nowhere;
static GLuint framebuffer, reader, picture, depth;
static int width, height; /* of the texture */

static bool is_mode(const app *a, const char *mode)
{
    return a->mode != NULL && strcmp(a->mode, mode) == 0;
}

static bool has_panes(const app *a)
{
    return is_mode(a, "panes") || is_mode(a, "panes-copied");
}

static void setup(app *a)
{
    width = has_panes(a) ? a->window.width * 7 / 8 : a->window.width;
    height = has_panes(a) ? a->window.height * 3 / 4 : a->window.height;
    a->projection = matrix_perspective(a->fov, (double)width / height, a->near, a->far);
    /* A window beside it that is never swapped, with a context that draws to it once. */
    window_request beside = a->request;
    beside.x += 300;
    const window hidden = window_open_beside(&a->window, &beside);
    GLXContext first = glXCreateNewContext(a->window.display, a->window.config, GLX_RGBA_TYPE, a->window.context, True);
    glXMakeContextCurrent(a->window.display, hidden.window, hidden.window, first);
    glClear(GL_COLOR_BUFFER_BIT);
    window_make_current(&a->window);
    static const int attributes[] = {GLX_PBUFFER_WIDTH, 1, GLX_PBUFFER_HEIGHT, 1, None};
    studio = glXCreateNewContext(a->window.display, a->window.config, GLX_RGBA_TYPE, a->window.context, True);
    if (is_mode(a, "unmapped")) {
        const window unmapped = window_open_beside(&a->window, &beside);
        XUnmapWindow(a->window.display, unmapped.window);
        XSync(a->window.display, False);
        nowhere = unmapped.window;
        window_make_current(&a->window);
    } else {
        nowhere = glXCreatePbuffer(a->window.display, a->window.config, attributes);
    }
    app_check(a, studio != NULL, "there is no second context");
    glGenTextures(1, &picture);
    glBindTexture(GL_TEXTURE_2D, picture);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
    glTexImage2D(GL_TEXTURE_2D, 0, GL_RGBA8, width, height, 0, GL_RGBA, GL_UNSIGNED_BYTE, NULL);
}

static void make_framebuffer(void)
{
    glGenRenderbuffers(1, &depth);
    glBindRenderbuffer(GL_RENDERBUFFER, depth);
    glRenderbufferStorage(GL_RENDERBUFFER, GL_DEPTH_COMPONENT24, width, height);
    glGenFramebuffers(1, &framebuffer);
    glBindFramebuffer(GL_FRAMEBUFFER, framebuffer);
    glFramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, picture, 0);
    glFramebufferRenderbuffer(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, GL_RENDERBUFFER, depth);
    glViewport(0, 0, width, height);
}

/* Draws a rectangle of the window, in pixels. */
static void rectangle(int left, int bottom, int across, int up)
{
    glBegin(GL_QUADS);
    for (int i = 0; i < 4; i++) {
        int x = i == 1 || i == 2, y = i >= 2;
        glTexCoord2i(x, y);
        glVertex2i(left + x * across, bottom + y * up);
    }
    glEnd();
}

/* Shows the texture in a rectangle of the window. */
static void show(int left, int bottom, int across, int up)
{
    glEnable(GL_TEXTURE_2D);
    glBindTexture(GL_TEXTURE_2D, picture);
    glColor3f(1.0f, 1.0f, 1.0f);
    rectangle(left, bottom, across, up);
    glDisable(GL_TEXTURE_2D);
}

/* Copies the texture to a place of the window. */
static void copy(int left, int bottom)
{
    if (reader == 0) {
        glGenFramebuffers(1, &reader);
        glBindFramebuffer(GL_READ_FRAMEBUFFER, reader);
        glFramebufferTexture2D(GL_READ_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, picture, 0);
    }
    glBindFramebuffer(GL_READ_FRAMEBUFFER, reader);
    glBlitFramebuffer(0, 0, width, height, left, bottom, left + width, bottom + height, GL_COLOR_BUFFER_BIT, GL_NEAREST);
    glBindFramebuffer(GL_READ_FRAMEBUFFER, 0);
}

/*
 * Draws into the scene's picture without perspective: a white square, and in a viewport of its own, over
 * everything, a blue one.
 */
static void draw_mark(void)
{
    glMatrixMode(GL_PROJECTION);
    glLoadIdentity();
    glMatrixMode(GL_MODELVIEW);
    glLoadIdentity();
    glDisable(GL_DEPTH_TEST);
    glColor3f(1.0f, 1.0f, 1.0f);
    glRectf(-0.8f, -0.8f, -0.5f, -0.5f);
    glClear(GL_DEPTH_BUFFER_BIT);
    glViewport(width - 60, 10, 40, 40);
    glColor3f(0.0f, 0.0f, 1.0f);
    glRectf(-1.0f, -1.0f, 1.0f, 1.0f);
    glViewport(0, 0, width, height);
}

/* Draws the widgets around the scene, an orange background below it and a green menu above it. */
static void draw_panes(const app *a)
{
    int left = a->window.width - width, bottom = a->window.height / 8;
    glColor3f(1.0f, 0.5f, 0.0f);
    rectangle(0, 0, a->window.width, a->window.height);
    if (is_mode(a, "panes"))
        show(left, bottom, width, height);
    else
        copy(left, bottom);
    glColor3f(0.0f, 0.5f, 0.0f);
    rectangle(0, bottom + height, a->window.width, a->window.height - bottom - height);
}

static void go_on_in_another_window(app *a)
{
    window late = window_open_beside(&a->window, &a->request);
    XUnmapWindow(late.display, late.window);
    XSync(late.display, False);
    late.context = glXCreateNewContext(late.display, a->window.config, GLX_RGBA_TYPE, a->window.context, True);
    window_make_current(&late);
    XMapWindow(late.display, late.window);
    XSync(late.display, False);
    a->window = late;
}

static void draw(app *a)
{
    if (is_mode(a, "late")) {
        if (a->frame == 4)
            go_on_in_another_window(a);
        fixed_cube(a);
        return;
    }
    glXMakeContextCurrent(a->window.display, nowhere, nowhere, studio);
    if (framebuffer == 0)
        make_framebuffer();
    fixed_cube(a);
    if (has_panes(a))
        draw_mark();
    app_check_error(a, "in the context without a window");
    window_make_current(&a->window);
    glClear(GL_COLOR_BUFFER_BIT | (is_mode(a, "unmapped") ? GL_DEPTH_BUFFER_BIT : 0));
    fixed_begin_pixels(a);
    if (has_panes(a))
        draw_panes(a);
    else if (is_mode(a, "docked"))
        show(0, 0, a->window.width / 2, a->window.height / 2);
    else
        show(0, 0, a->window.width, a->window.height);
    fixed_end_pixels();
    app_check_error(a, "in the window");
}

int main(int argc, char **argv)
{
    static const app_program self = {"toolkit", API_GL_COMPATIBILITY, 0, 0, setup, draw, NULL};
    return app_main(argc, argv, &self);
}
