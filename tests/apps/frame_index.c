/*
 * Paints the number of each frame into its pixels: 24 columns, white for 1, the highest bit at the
 * left. Writes the number and the time at which it asks for the swap (monotonic clock,
 * nanoseconds). --mode RATE[,FRAME,WIDTHxHEIGHT]: frames per second, without it as many as possible,
 * and a size that the window gets after a frame.
 */
#include "common/app.h"

#include <stdio.h>
#include <stdlib.h>
#include <time.h>

enum { BITS = 24 };

static struct timespec next;
static FILE *times;

static void setup(app *a)
{
    clock_gettime(CLOCK_MONOTONIC, &next);
    times = a->answers ? fopen(a->answers, "w") : NULL;
}

static void keep_rate(const app *a)
{
    if (!a->mode)
        return;
    next.tv_nsec += (long)(1e9 / atof(a->mode));
    while (next.tv_nsec >= 1000000000) {
        next.tv_nsec -= 1000000000;
        next.tv_sec++;
    }
    clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &next, NULL);
}

static void draw(app *a)
{
    const int number = a->frame + 1, width = a->window.width, height = a->window.height;
    keep_rate(a);
    glDisable(GL_SCISSOR_TEST);
    glClearColor(0, 0, 0, 1);
    glClear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
    glEnable(GL_SCISSOR_TEST);
    glClearColor(1, 1, 1, 1);
    for (int column = 0; column < BITS; column++) {
        const int left = column * width / BITS, right = (column + 1) * width / BITS;
        if (number >> (BITS - 1 - column) & 1) {
            glScissor(left, 0, right - left, height);
            glClear(GL_COLOR_BUFFER_BIT);
        }
    }
    if (times) {
        struct timespec now;
        clock_gettime(CLOCK_MONOTONIC, &now);
        fprintf(times, "%d %lld\n", number, (long long)now.tv_sec * 1000000000 + now.tv_nsec);
        fflush(times);
    }
}

static void after(app *a)
{
    int frame, width, height;
    if (a->mode && sscanf(a->mode, "%*[0-9.],%d,%dx%d", &frame, &width, &height) == 3 && a->frame + 1 == frame) {
        window_resize(&a->window, width, height);
        glViewport(0, 0, width, height);
    }
}

int main(int argc, char **argv)
{
    static const app_program program = {"frame_index", API_GL_COMPATIBILITY, 0, 0, setup, draw, after};
    return app_main(argc, argv, &program);
}
