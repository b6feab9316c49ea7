/* The cube in buffers, for the programs with shaders. */
#ifndef APPS_MESH_H
#define APPS_MESH_H

#include "gl.h"

typedef struct {
    GLuint array, positions, colours, indices; /* array is 0 in GLES 2, which has no vertex array objects */
} mesh;

/* Positions at attribute 0 and colours at attribute 1. */
mesh mesh_cube(void);

/* Binds the buffers. Then glDrawElements(..., CUBE_INDICES, GL_UNSIGNED_SHORT, NULL) draws. */
void mesh_bind(const mesh *m);

#endif
