/*
 * The cells in buffers, for shaders with the position at location 0 and the colour at location 1.
 */
#ifndef APPS_CELL_ARRAY_H
#define APPS_CELL_ARRAY_H

#include "gl.h"

#include <stdbool.h>

typedef struct {
    GLuint array;
    GLsizei index_count; /* number of unsigned integers, for triangles; 0 for points */
} cell_array;

/* Creates the array, which stays bound. `points` and `ball` are as in cells.h. */
cell_array cell_array_new(bool points, bool ball);

#endif
