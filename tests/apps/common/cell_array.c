#include "cell_array.h"

#include "cells.h"

cell_array cell_array_new(bool points, bool ball)
{
    cells all = cells_new(points, ball);
    cell_array made = {0, (GLsizei)all.index_count};
    GLuint buffers[2];
    glGenVertexArrays(1, &made.array);
    glBindVertexArray(made.array);
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
    return made;
}
