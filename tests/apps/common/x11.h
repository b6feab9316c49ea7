/* Windows of X11 that wait until the server has done what it was asked for. */
#ifndef APPS_X11_H
#define APPS_X11_H

#include <X11/Xlib.h>

/* Ends the program where there is no server. */
Display *x11_open(void);

/* The window selects StructureNotifyMask. */
void x11_map(Display *display, Window window);
void x11_resize(Display *display, Window window, int width, int height);

#endif
