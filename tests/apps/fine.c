/*
 * The direction test with the cube cut into small cells, for methods that project vertices: as triangles (the
 * default), or as a point in the middle of each cell (--mode points). --mode ball puts the cells on a sphere.
 */
#include "common/cell_array.h"
#include "common/cells.h"
#include "common/product.h"

#include <string.h>

static cell_array built;
static bool points;

static void setup(app *a)
{
    points = a->mode && strcmp(a->mode, "points") == 0;
    built = cell_array_new(points, a->mode && strcmp(a->mode, "ball") == 0);
    product_program();
}

static void draw(app *a)
{
    glClearColor(0.0f, 0.0f, 0.0f, 1.0f);
    glClear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
    glEnable(GL_DEPTH_TEST);
    product_matrices(a);
    glBindVertexArray(built.array);
    if (points)
        glDrawArrays(GL_POINTS, 0, CELL_POINTS);
    else
        glDrawElements(GL_TRIANGLES, built.index_count, GL_UNSIGNED_INT, NULL);
}

int main(int argc, char **argv)
{
    static const app_program self = {"fine", API_GL_CORE, 3, 3, setup, draw, NULL};
    return app_main(argc, argv, &self);
}
