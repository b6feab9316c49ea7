/*
 * One context for two windows, as toolkits use it. A window must show the same whether it is
 * swapped while it is current or after the other became current.
 */
#include "common/fixed.h"
#include "common/window.h"

#include <GL/glx.h>
#include <string.h>

static window other;
static GLXWindow drawable;
static image expected;

static void make_current(app *a, GLXDrawable to)
{
    app_check(a, glXMakeCurrent(a->window.display, to, a->window.context), "cannot make the window current");
}

static void setup(app *a)
{
    window_request request = a->request;
    request.x += 300;
    other = window_open_beside(&a->window, &request);
    make_current(a, a->window.window);
    drawable = glXCreateWindow(a->window.display, a->window.config, other.window, NULL);
}

static void draw(app *a)
{
    bool later = a->frame % 2 == 1;
    make_current(a, drawable);
    if (later) {
        /* A clear in between, so that an old picture differs from the right one. */
        glClearColor(0.0f, 1.0f, 0.0f, 1.0f);
        glClear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
        glXSwapBuffers(a->window.display, drawable);
    }
    fixed_cube(a);
    if (later)
        make_current(a, a->window.window);
    glXSwapBuffers(a->window.display, drawable);
    glXWaitGL();
    image shown = window_shot(&other);
    if (later) {
        app_check(a, memcmp(shown.rgb, expected.rgb, (size_t)(3 * shown.width * shown.height)) == 0,
                  "a window that is swapped while it is not current shows something else");
        image_free(&shown);
        image_free(&expected);
    } else {
        expected = shown;
        make_current(a, a->window.window);
    }
    app_check_error(a, "after the other window");
    fixed_cube(a);
}

int main(int argc, char **argv)
{
    static const app_program self = {"one_context", API_GL_COMPATIBILITY, 0, 0, setup, draw, NULL};
    return app_main(argc, argv, &self);
}
