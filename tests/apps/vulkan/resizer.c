/*
 * Runs a program and changes the size of its window: vk_resizer WxH RESIZES FRAMES MEMORY PROGRAM
 * [ARGUMENT…].
 * The window is found by its size WxH, which no other window should have. In each size the program
 * draws FRAMES frames. Then its resident memory, in pages, is appended to the file MEMORY. The exit
 * status is the program's. It is 1 if the program ended before its window had all sizes, or drew
 * nothing for ten seconds.
 *
 * Frames are counted instead of time, because a window may get another size after the program has
 * asked for the present size and before it has created its swapchain. A program that has drawn
 * several frames has done both.
 */
#include "memory.h"

#include <X11/Xlib.h>
#include <X11/extensions/Xdamage.h>
#include <signal.h>
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

/*
 * Waits until the window was drawn to `frames` times. Returns false if the program ended or drew
 * nothing for ten seconds.
 */
static bool wait_for_frames(Display *display, int damaged, int frames, pid_t program, int *status, bool *ended)
{
    const int most = 10000;
    for (int waited = 0; frames > 0 && waited < most; waited++) {
        while (XPending(display) > 0) {
            XEvent event;
            XNextEvent(display, &event);
            if (event.type == damaged) {
                frames--;
                waited = 0;
            }
        }
        *ended = has_ended(program, status);
        if (*ended)
            return false;
        wait_milliseconds(1);
    }
    return frames <= 0;
}

int main(int argc, char **argv)
{
    int width, height, first_event, first_error;
    Display *display = argc > 5 && sscanf(argv[1], "%dx%d", &width, &height) == 2 ? XOpenDisplay(NULL) : NULL;
    if (display == NULL || !XDamageQueryExtension(display, &first_event, &first_error)) {
        fprintf(stderr, "usage: vk_resizer WxH RESIZES FRAMES MEMORY PROGRAM [ARGUMENT...], with an X display (DAMAGE)\n");
        return 2;
    }
    XSetErrorHandler(ignore);
    const int resizes = atoi(argv[2]);
    const int frames = atoi(argv[3]);
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
    if (window != None)
        XDamageCreate(display, window, XDamageReportRawRectangles);
    bool draws = window != None;
    while (draws && done < resizes) {
        done++;
        XResizeWindow(display, window, (unsigned)(width + done % 2 * 31 + done % 7), (unsigned)(height + done % 2 * 31));
        XSync(display, False);
        draws = wait_for_frames(display, first_event + XDamageNotify, frames, program, &status, &ended);
        if (draws)
            write_memory(argv[4], program);
    }
    if (!draws && !ended)
        kill(program, SIGTERM);
    if (!ended && waitpid(program, &status, 0) < 0)
        perror("waitpid");
    XCloseDisplay(display);
    if (!draws) {
        fprintf(stderr, "the program %s after %d of %d sizes\n", ended ? "ended" : "drew nothing", done, resizes);
        return 1;
    }
    return WIFEXITED(status) ? WEXITSTATUS(status) : 1;
}
