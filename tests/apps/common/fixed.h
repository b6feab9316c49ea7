/* The cube with fixed-function matrices, for programs that test something else. */
#ifndef APPS_FIXED_H
#define APPS_FIXED_H

#include "app.h"

/* Clears, loads the app's projection and view, and draws the cube in immediate mode. */
void fixed_cube(const app *a);

/* Draws a square of this half width straight ahead at this distance. */
void fixed_square(float half, float distance);

/* Fixed-function matrices for drawing in window pixels, origin at the bottom left, depth test off. */
void fixed_begin_pixels(const app *a);
void fixed_end_pixels(void);

#endif
