/*
 * Runs a program and gives its window other sizes meanwhile: vk_resizer WxH RESIZES PAUSE MEMORY PROGRAM [ARGUMENT…].
 * The window is the one of that size, which therefore has to be a rare one. PAUSE, milliseconds, is between two sizes; after each pause the resident
 * memory of the program, in pages, is appended to the file MEMORY. Exits as the program does, or with 1 where it ended
 * before its window had all sizes.
 */
#include "memory.h"

#include <X11/Xlib.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

/* Another client may destroy its window at any time. */
static int ignore(Display *display, XErrorEvent *error)
{
    (void)display;
    (void)error;
    return 0;
}

static void wait_milliseconds(long milliseconds)
{
    const struct timespec time = {milliseconds / 1000, milliseconds % 1000 * 1000000};
    nanosleep(&time, NULL);
}

static bool is_wanted(Display *display, Window window, int width, int height)
{
    XWindowAttributes has;
    return XGetWindowAttributes(display, window, &has) != 0 && has.map_state == IsViewable && has.width == width &&
           has.height == height;
}

static Window find_window(Display *display, int width, int height)
{
    Window root, parent, *all = NULL, wanted = None;
    unsigned int count = 0;
    if (XQueryTree(display, DefaultRootWindow(display), &root, &parent, &all, &count) == 0)
        return None;
    for (unsigned int i = 0; i < count && wanted == None; i++)
        if (is_wanted(display, all[i], width, height))
            wanted = all[i];
    XFree(all);
    return wanted;
}

static bool has_ended(pid_t program, int *status)
{
    return waitpid(program, status, WNOHANG) == program;
}

int main(int argc, char **argv)
{
    int width, height;
    Display *display = argc > 5 && sscanf(argv[1], "%dx%d", &width, &height) == 2 ? XOpenDisplay(NULL) : NULL;
    if (display == NULL) {
        fprintf(stderr, "usage: vk_resizer WxH RESIZES PAUSE MEMORY PROGRAM [ARGUMENT...], with an X display\n");
        return 2;
    }
    XSetErrorHandler(ignore);
    const int resizes = atoi(argv[2]);
    const long pause = atol(argv[3]);
    const pid_t program = fork();
    if (program == 0) {
        execvp(argv[5], argv + 5);
        perror(argv[5]);
        _exit(127);
    }
    Window window = None;
    int status = 0, done = 0;
    bool ended = false;
    while (!ended && window == None) {
        wait_milliseconds(20);
        window = find_window(display, width, height);
        ended = has_ended(program, &status);
    }
    while (!ended && done < resizes) {
        done++;
        XResizeWindow(display, window, (unsigned)(width + done % 2 * 31 + done % 7), (unsigned)(height + done % 2 * 31));
        XSync(display, False);
        wait_milliseconds(pause);
        ended = has_ended(program, &status);
        if (!ended)
            write_memory(argv[4], program);
    }
    if (!ended && waitpid(program, &status, 0) < 0)
        perror("waitpid");
    XCloseDisplay(display);
    if (done < resizes || (ended && done == resizes)) {
        fprintf(stderr, "the program ended after %d of %d sizes\n", done, resizes);
        return 1;
    }
    return WIFEXITED(status) ? WEXITSTATUS(status) : 1;
}
