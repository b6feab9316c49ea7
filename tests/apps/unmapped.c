/* Unmaps its window after the second frame and maps it again after the sixth. */
#include "common/fixed.h"

static void draw(app *a)
{
    fixed_cube(a);
}

static void after(app *a)
{
    if (a->frame == 1)
        window_show(&a->window, false);
    if (a->frame == 5)
        window_show(&a->window, true);
}

int main(int argc, char **argv)
{
    static const app_program self = {"unmapped", API_GL_COMPATIBILITY, 0, 0, NULL, draw, after};
    return app_main(argc, argv, &self);
}
