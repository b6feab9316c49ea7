/*
 * Changes the size of its window after each of the first three frames, and then after every
 * fiftieth frame. With --mode fixed it does so only after the first frame, as programs that fix the
 * size of their window when they have a context.
 */
#include "common/fixed.h"

static void draw(app *a)
{
    fixed_cube(a);
    if (a->mode != NULL || app_is_first_read(a))
        return;
    image picture = image_read_framebuffer(a->window.width, a->window.height);
    app_check_cube_picture(a, &picture, "after a resize");
    image_free(&picture);
}

static void after(app *a)
{
    static const int sizes[3][2] = {{200, 260}, {333, 177}, {300, 300}};
    if (a->mode != NULL) {
        if (a->frame == 0)
            window_resize(&a->window, 200, 260);
        return;
    }
    if (a->frame >= 3 && a->frame % 50 != 49)
        return;
    GLint old[4], now[4];
    glGetIntegerv(GL_VIEWPORT, old);
    window_resize(&a->window, sizes[a->frame % 3][0], sizes[a->frame % 3][1]);
    glGetIntegerv(GL_VIEWPORT, now);
    app_check(a, now[0] == old[0] && now[1] == old[1] && now[2] == old[2] && now[3] == old[3],
              "a resize changed the program's viewport to %d %d %d %d", now[0], now[1], now[2], now[3]);
    app_update_matrices(a);
    glViewport(0, 0, a->window.width, a->window.height);
    glGetIntegerv(GL_VIEWPORT, now);
    app_check(a, now[2] == a->window.width && now[3] == a->window.height, "the viewport is %dx%d after glViewport",
              now[2], now[3]);
}

int main(int argc, char **argv)
{
    static const app_program self = {"resize", API_GL_COMPATIBILITY, 0, 0, NULL, draw, after};
    return app_main(argc, argv, &self);
}
