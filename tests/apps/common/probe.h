/* Colours of single pixels of the window, for programs that draw rectangles in pixels. */
#ifndef APPS_PROBE_H
#define APPS_PROBE_H

#include "app.h"

/* Checks that glReadPixels returns this colour, 0 or 1 per channel, at (x, y from the bottom). */
void probe(app *a, int x, int y, int red, int green, int blue, const char *what);

#endif
