/* Prints the number of requests to the X server in a frame. */
#include "common/fixed.h"

#include <stdio.h>

static unsigned long before;

static void draw(app *a)
{
    fixed_cube(a);
}

static void after(app *a)
{
    unsigned long now = NextRequest(a->window.display);
    /* The first frames create objects. */
    if (a->frame > 1)
        fprintf(stderr, "requests %lu\n", now - before);
    before = now;
}

int main(int argc, char **argv)
{
    static const app_program self = {"requests", API_GL_COMPATIBILITY, 0, 0, NULL, draw, after};
    return app_main(argc, argv, &self);
}
