/* Direction test with a window to which two contexts draw by turns before it is swapped. */
#include "common/fixed.h"

#include <GL/glx.h>

static GLXContext first, second;

static void half_cube(const app *a, int from)
{
    glMatrixMode(GL_PROJECTION);
    glLoadMatrixf(a->projection.m);
    glMatrixMode(GL_MODELVIEW);
    glLoadMatrixf(a->modelview.m);
    glEnable(GL_DEPTH_TEST);
    glBegin(GL_TRIANGLES);
    for (int i = from; i < from + CUBE_INDICES / 2; i++) {
        glColor3fv(cube_colours[cube_indices[i]]);
        glVertex3fv(cube_positions[cube_indices[i]]);
    }
    glEnd();
}

static void setup(app *a)
{
    first = a->window.context;
    second = glXCreateNewContext(a->window.display, a->window.config, GLX_RGBA_TYPE, first, True);
    app_check(a, second != NULL, "there is no second context");
}

static void draw(app *a)
{
    glXMakeCurrent(a->window.display, a->window.window, first);
    app_clear();
    half_cube(a, 0);
    app_check_error(a, "in the first context");
    glXMakeCurrent(a->window.display, a->window.window, second);
    half_cube(a, CUBE_INDICES / 2);
}

int main(int argc, char **argv)
{
    static const app_program self = {"two_contexts", API_GL_COMPATIBILITY, 0, 0, setup, draw, NULL};
    return app_main(argc, argv, &self);
}
