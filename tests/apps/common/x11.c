#include "x11.h"

#include <stdio.h>
#include <stdlib.h>

static Bool is_map_of(Display *display, XEvent *event, XPointer wanted)
{
    (void)display;
    return event->type == MapNotify && event->xmap.window == *(Window *)(void *)wanted;
}

static Bool is_configure_of(Display *display, XEvent *event, XPointer wanted)
{
    (void)display;
    return event->type == ConfigureNotify && event->xconfigure.window == *(Window *)(void *)wanted;
}

Display *x11_open(void)
{
    Display *display = XOpenDisplay(NULL);
    if (display == NULL) {
        fprintf(stderr, "cannot open the X display (is DISPLAY set?)\n");
        exit(1);
    }
    return display;
}

void x11_map(Display *display, Window window)
{
    XMapWindow(display, window);
    XEvent event;
    XIfEvent(display, &event, is_map_of, (XPointer)&window);
}

void x11_resize(Display *display, Window window, int width, int height)
{
    XResizeWindow(display, window, (unsigned)width, (unsigned)height);
    XEvent event;
    do {
        XIfEvent(display, &event, is_configure_of, (XPointer)&window);
    } while (event.xconfigure.width != width || event.xconfigure.height != height);
}
