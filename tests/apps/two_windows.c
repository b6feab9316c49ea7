/* Two windows with a context each, drawn in turn; each must keep its own state and picture. */
#include "common/fixed.h"

static app other;
static bool opened;

static void draw_and_check(app *a, int width, int height, const char *name)
{
    GLint viewport[4];
    glGetIntegerv(GL_VIEWPORT, viewport);
    app_check(a, viewport[2] == width && viewport[3] == height, "%s: the viewport is %dx%d instead of %dx%d", name,
              viewport[2], viewport[3], width, height);
    fixed_cube(a);
    if (app_is_first_read(a))
        return;
    image picture = image_read_framebuffer(width, height);
    app_check_cube_picture(a, &picture, name);
    image_free(&picture);
    app_check_error(a, name);
}

static void draw(app *a)
{
    if (!opened) {
        other = *a;
        other.complaints = 0;
        other.yaw = a->yaw + 120.0;
        other.request.x += 300;
        other.request.width = 200;
        other.request.height = 150;
        other.window = window_open_beside(&a->window, &other.request);
        app_update_matrices(&other);
        glViewport(0, 0, other.window.width, other.window.height);
        opened = true;
    }
    other.frame = a->frame;
    window_make_current(&other.window);
    draw_and_check(&other, 200, 150, "second window");
    window_make_current(&a->window);
    draw_and_check(a, a->window.width, a->window.height, "first window");
    window_make_current(&other.window);
    window_swap(&other.window);
    window_make_current(&a->window);
    a->complaints += other.complaints;
    other.complaints = 0;
}

int main(int argc, char **argv)
{
    static const app_program self = {"two_windows", API_GL_COMPATIBILITY, 0, 0, NULL, draw, NULL};
    return app_main(argc, argv, &self);
}
