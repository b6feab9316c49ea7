/*
 * Ways in which a program ends. It draws to its window, swaps all frames but the last, and ends as
 * --mode says. The exit status is 7 if the program can choose it.
 *
 * early, late: a handler of atexit makes no context current. It is registered before the window is
 * opened (early), or after that and before the first draw (late).
 *
 * busy, idle: the program continues to draw (busy) or does nothing (idle) until it is ended.
 * killed, killed-idle: another process ends it.
 */
#include "common/fixed.h"

#include <GL/glx.h>
#include <pthread.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

enum { STATUS = 7 };

static app program;

static void release(void)
{
    window_release(&program.window);
}

static void *end_here(void *unused)
{
    (void)unused;
    window_make_current(&program.window);
    fixed_cube(&program);
    exit(STATUS);
}

/* Draws to a window of the thread until the process ends. */
static void *draw_for_ever(void *ready)
{
    app other = program;
    window_request request = program.request;
    request.x += 40;
    other.window = window_open(&request);
    for (;;) {
        fixed_cube(&other);
        window_swap(&other.window);
        pthread_barrier_t *barrier = ready;
        if (barrier != NULL)
            pthread_barrier_wait(barrier);
        ready = NULL;
    }
    return NULL;
}

/* Another process sends a signal after some time. */
static void kill_from_outside(void)
{
    if (fork() == 0) {
        const struct timespec a_while = {0, 300000000};
        nanosleep(&a_while, NULL);
        kill(getppid(), SIGTERM);
        _exit(0);
    }
}

static void wait_for(pid_t child)
{
    int status = 0;
    if (waitpid(child, &status, 0) != child || status != 0) {
        fprintf(stderr, "the child ended with %d\n", status);
        _exit(1);
    }
}

static bool is(const char *mode)
{
    return strcmp(program.mode, mode) == 0;
}

static void setup(app *a)
{
    program = *a;
    if (a->mode == NULL)
        exit(1);
    if (is("late"))
        atexit(release);
}

static void end(void)
{
    if (is("exit") || is("early") || is("late"))
        exit(STATUS);
    if (is("_exit"))
        _exit(STATUS);
    if (is("abort"))
        abort();
    if (is("terminate"))
        raise(SIGTERM);
    if (is("fault")) {
        int *volatile nowhere = NULL;
        *nowhere = 1;
    }
    if (is("killed") || is("killed-idle"))
        kill_from_outside();
    while (is("idle") || is("killed-idle"))
        pause();
    while (is("busy") || is("killed")) {
        fixed_cube(&program);
        window_swap(&program.window);
    }
    if (is("thread")) {
        window_release(&program.window);
        pthread_t thread;
        if (pthread_create(&thread, NULL, end_here, NULL) == 0)
            pthread_join(thread, NULL);
    }
    if (is("drawing")) {
        pthread_t thread;
        pthread_barrier_t ready;
        pthread_barrier_init(&ready, NULL, 2);
        if (pthread_create(&thread, NULL, draw_for_ever, &ready) == 0)
            pthread_barrier_wait(&ready);
        exit(STATUS);
    }
    if (is("fork")) {
        pid_t child = fork();
        if (child == 0)
            _exit(0);
        wait_for(child);
        exit(STATUS);
    }
    if (is("exec")) {
        pid_t child = fork();
        if (child == 0) {
            execlp("true", "true", (char *)NULL);
            _exit(1);
        }
        wait_for(child);
        exit(STATUS);
    }
    if (is("closed")) {
        /* Closes the display first, without destroying the context. */
        window_release(&program.window);
        XCloseDisplay(program.window.display);
        exit(STATUS);
    }
    if (is("closed-current")) {
        XCloseDisplay(program.window.display);
        exit(STATUS);
    }
}

static void draw(app *a)
{
    program = *a;
    fixed_cube(a);
    if (a->frame + 1 == a->frames) {
        /* The draws are finished here, so that the driver has no work at the end. */
        glFinish();
        end();
    }
}

int main(int argc, char **argv)
{
    XInitThreads();
    for (int i = 1; i + 1 < argc; i++) {
        if (strcmp(argv[i], "--mode") == 0 && strcmp(argv[i + 1], "early") == 0)
            atexit(release);
    }
    static const app_program self = {"ending", API_GL_COMPATIBILITY, 0, 0, setup, draw, NULL};
    return app_main(argc, argv, &self);
}
