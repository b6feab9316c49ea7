/* Shader programs of core 3.3 and of GLES that draw the direction test's cube. */
#ifndef APPS_SHADER_H
#define APPS_SHADER_H

#include "app.h"
#include "program.h"

/* A fragment shader of core 3.3. It writes the colour of the vertices, `in vec3 shade`. */
extern const char shader_shade[];

/* A program with one uniform for each of the two matrices. */
typedef struct {
    GLuint program;
    GLint projection, modelview;
} shader_pair;

/* Builds the program of `count` stages. Its uniforms have these names. */
shader_pair shader_pair_build(const shader_source *stages, int count, const char *projection, const char *modelview);

/* Makes the program current and sets the app's matrices. */
void shader_pair_use(const shader_pair *pair, const app *a);

#endif
