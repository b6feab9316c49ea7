/*
 * A read of one pixel takes much less time than a read of the whole window, because only that pixel
 * is prepared.
 */
#include "common/fixed.h"
#include "common/probe.h"

#include <stdlib.h>
#include <time.h>

enum { READS = 15 };

static double seconds(void)
{
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

/*
 * Shortest time of several reads, each after a small rectangle was drawn. The shortest excludes the
 * time of other processes.
 */
static double time_of(int width, int height, unsigned char *pixels)
{
    double least = 1e9;
    for (int i = 0; i < READS; i++) {
        glRecti(0, 0, 5, 5);
        glFinish();
        double start = seconds();
        glReadPixels(0, 0, width, height, GL_RGBA, GL_UNSIGNED_BYTE, pixels);
        double time = seconds() - start;
        if (time < least)
            least = time;
    }
    return least;
}

static void draw(app *a)
{
    app_clear();
    fixed_begin_pixels(a);
    glColor3f(1.0f, 0.0f, 0.0f);
    unsigned char *pixels = malloc(4 * (size_t)a->window.width * (size_t)a->window.height);
    if (pixels != NULL && !app_is_first_read(a)) {
        double one = time_of(1, 1, pixels), all = time_of(a->window.width, a->window.height, pixels);
        probe(a, 2, 2, 1, 0, 0, "the rectangle");
        app_check(a, 2.0 * one < all, "a read of one pixel takes %g s, of all pixels %g s", one, all);
    }
    free(pixels);
    fixed_end_pixels();
}

int main(int argc, char **argv)
{
    static const app_program self = {"small_reads", API_GL_COMPATIBILITY, 0, 0, NULL, draw, NULL};
    return app_main(argc, argv, &self);
}
