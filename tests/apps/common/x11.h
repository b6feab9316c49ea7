/* Functions for windows of X11. They wait until the server has done what was requested. */
#ifndef APPS_X11_H
#define APPS_X11_H

#include <X11/Xlib.h>

/* Opens the display. Ends the program if there is no server. */
Display *x11_open(void);

/* Maps the window, which must select StructureNotifyMask. */
void x11_map(Display *display, Window window);
void x11_resize(Display *display, Window window, int width, int height);

#endif
