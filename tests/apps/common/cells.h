/*
 * The cube, or a ball with the cube's colours, divided into small cells, for methods that project
 * vertices.
 */
#ifndef APPS_CELLS_H
#define APPS_CELLS_H

#include <stdbool.h>
#include <stddef.h>

enum { CELLS = 64, CELL_FACES = 6, CELL_POINTS = CELL_FACES * CELLS * CELLS };

typedef struct {
    float position[3], colour[3];
} cell_corner;

typedef struct {
    cell_corner *corners;
    size_t corner_count;
    unsigned *indices; /* of triangles; none if the corners are points in the middle of the cells */
    size_t index_count;
} cells;

/*
 * With `ball` the cells are on a sphere. Its points have the colours of the cube's points in the
 * same direction.
 */
cells cells_new(bool points, bool ball);

void cells_free(cells *all);

#endif
