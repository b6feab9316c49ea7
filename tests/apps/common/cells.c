#include "cells.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* A point of a face of the cube, at (u, v) in -1...1. */
static cell_corner at(int face, double u, double v, bool ball)
{
    double p[3];
    const int axis = face / 2;
    p[axis] = face % 2 ? 1.0 : -1.0;
    p[(axis + 1) % 3] = u;
    p[(axis + 2) % 3] = v;
    const double length = ball ? sqrt(p[0] * p[0] + p[1] * p[1] + p[2] * p[2]) : 1.0;
    cell_corner c;
    for (int i = 0; i < 3; i++) {
        c.position[i] = (float)(p[i] / length);
        c.colour[i] = (float)(0.5 + 0.5 * p[i]);
    }
    return c;
}

cells cells_new(bool points, bool ball)
{
    const int side = points ? CELLS : CELLS + 1;
    cells all = {malloc(sizeof(cell_corner) * CELL_FACES * (CELLS + 1) * (CELLS + 1)), 0,
                 malloc(sizeof(unsigned) * CELL_POINTS * 6), 0};
    if (!all.corners || !all.indices)
        abort();
    for (int face = 0; face < CELL_FACES; face++)
        for (int row = 0; row < side; row++)
            for (int column = 0; column < side; column++) {
                const double middle = points ? 0.5 : 0.0;
                const double u = 2.0 * (column + middle) / CELLS - 1.0, v = 2.0 * (row + middle) / CELLS - 1.0;
                if (!points && row < CELLS && column < CELLS) {
                    const unsigned first = (unsigned)all.corner_count, below = first + (unsigned)side;
                    const unsigned cell[6] = {first, first + 1, below, below, first + 1, below + 1};
                    memcpy(all.indices + all.index_count, cell, sizeof cell);
                    all.index_count += 6;
                }
                all.corners[all.corner_count++] = at(face, u, v, ball);
            }
    return all;
}

void cells_free(cells *all)
{
    free(all->corners);
    free(all->indices);
}
