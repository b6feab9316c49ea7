/* Shader programs. Failures end the program with the driver's log. */
#ifndef APPS_PROGRAM_H
#define APPS_PROGRAM_H

#include "gl.h"

typedef struct {
    GLenum stage;
    const char *source;
} shader_source;

/* Compiles and links `count` stages; attribute "position" is at 0 and "colour" at 1. */
GLuint program_build(const shader_source *stages, int count);

#endif
