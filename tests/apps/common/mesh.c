#include "mesh.h"

#include "cube.h"

#include <stddef.h>

static void attach(const mesh *m)
{
    glBindBuffer(GL_ARRAY_BUFFER, m->positions);
    glVertexAttribPointer(0, 3, GL_FLOAT, GL_FALSE, 0, NULL);
    glEnableVertexAttribArray(0);
    glBindBuffer(GL_ARRAY_BUFFER, m->colours);
    glVertexAttribPointer(1, 3, GL_FLOAT, GL_FALSE, 0, NULL);
    glEnableVertexAttribArray(1);
    glBindBuffer(GL_ELEMENT_ARRAY_BUFFER, m->indices);
}

mesh mesh_cube(void)
{
    mesh m = {0, 0, 0, 0};
#if !defined(APP_GLES) || APP_GLES >= 3
    glGenVertexArrays(1, &m.array);
    glBindVertexArray(m.array);
#endif
    glGenBuffers(1, &m.positions);
    glBindBuffer(GL_ARRAY_BUFFER, m.positions);
    glBufferData(GL_ARRAY_BUFFER, sizeof cube_positions, cube_positions, GL_STATIC_DRAW);
    glGenBuffers(1, &m.colours);
    glBindBuffer(GL_ARRAY_BUFFER, m.colours);
    glBufferData(GL_ARRAY_BUFFER, sizeof cube_colours, cube_colours, GL_STATIC_DRAW);
    glGenBuffers(1, &m.indices);
    glBindBuffer(GL_ELEMENT_ARRAY_BUFFER, m.indices);
    glBufferData(GL_ELEMENT_ARRAY_BUFFER, sizeof cube_indices, cube_indices, GL_STATIC_DRAW);
    attach(&m);
    return m;
}

void mesh_bind(const mesh *m)
{
#if !defined(APP_GLES) || APP_GLES >= 3
    glBindVertexArray(m->array);
#else
    attach(m);
#endif
}
