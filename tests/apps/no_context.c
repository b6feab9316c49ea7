/* Direction test with a window that is swapped while no context is current. */
#include "common/fixed.h"

#include <GL/glx.h>

static void draw(app *a)
{
    window_make_current(&a->window);
    fixed_cube(a);
    app_check_error(a, "with a context");
    glXMakeCurrent(a->window.display, None, NULL);
}

int main(int argc, char **argv)
{
    static const app_program self = {"no_context", API_GL_COMPATIBILITY, 0, 0, NULL, draw, NULL};
    return app_main(argc, argv, &self);
}
