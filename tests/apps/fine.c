/*
 * The direction test with the cube cut into small cells, for methods that project vertices: as triangles (the
 * default), or as a point in the middle of each cell (--mode points). --mode ball puts the cells on a sphere.
 */
#include "common/cells.h"
#include "common/product.h"

#include <string.h>

static GLuint array;
static bool points;
static GLsizei index_count;

static void setup(app *a)
{
    points = a->mode && strcmp(a->mode, "points") == 0;
    cells all = cells_new(points, a->mode && strcmp(a->mode, "ball") == 0);
    index_count = (GLsizei)all.index_count;
    product_program();
    GLuint buffers[2];
    glGenVertexArrays(1, &array);
    glBindVertexArray(array);
    glGenBuffers(2, buffers);
    glBindBuffer(GL_ARRAY_BUFFER, buffers[0]);
    glBufferData(GL_ARRAY_BUFFER, (GLsizeiptr)(all.corner_count * sizeof(cell_corner)), all.corners, GL_STATIC_DRAW);
    glBindBuffer(GL_ELEMENT_ARRAY_BUFFER, buffers[1]);
    glBufferData(GL_ELEMENT_ARRAY_BUFFER, (GLsizeiptr)(all.index_count * sizeof(GLuint)), all.indices, GL_STATIC_DRAW);
    glVertexAttribPointer(0, 3, GL_FLOAT, GL_FALSE, sizeof(cell_corner), (const void *)offsetof(cell_corner, position));
    glVertexAttribPointer(1, 3, GL_FLOAT, GL_FALSE, sizeof(cell_corner), (const void *)offsetof(cell_corner, colour));
    glEnableVertexAttribArray(0);
    glEnableVertexAttribArray(1);
    cells_free(&all);
}

static void draw(app *a)
{
    glClearColor(0.0f, 0.0f, 0.0f, 1.0f);
    glClear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
    glEnable(GL_DEPTH_TEST);
    product_matrices(a);
    glBindVertexArray(array);
    if (points)
        glDrawArrays(GL_POINTS, 0, CELL_POINTS);
    else
        glDrawElements(GL_TRIANGLES, index_count, GL_UNSIGNED_INT, NULL);
}

int main(int argc, char **argv)
{
    static const app_program self = {"fine", API_GL_CORE, 3, 3, setup, draw, NULL};
    return app_main(argc, argv, &self);
}
