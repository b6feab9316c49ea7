/*
 * The direction test with the cube cut into small cells, for methods that project vertices: as triangles (the
 * default), or as a point in the middle of each cell (--mode points). --mode ball puts the cells on a sphere, whose
 * points have the colours of the cube's in the same direction.
 */
#include "common/app.h"
#include "common/program.h"

#include <math.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

enum { CELLS = 64, FACES = 6, CORNERS = FACES * (CELLS + 1) * (CELLS + 1), POINTS = FACES * CELLS * CELLS };

static const char vertex[] =
    "#version 330 core\n"
    "layout(location = 0) in vec3 position;\n"
    "layout(location = 1) in vec3 colour;\n"
    "uniform mat4 MVP;\n"
    "out vec3 shade;\n"
    "void main() {\n"
    "    shade = colour;\n"
    "    gl_Position = MVP * vec4(position, 1.0);\n"
    "}\n";
static const char fragment[] =
    "#version 330 core\nin vec3 shade;\nout vec4 result;\nvoid main() { result = vec4(shade, 1.0); }\n";

typedef struct {
    float position[3], colour[3];
} corner;

static GLuint program, array;
static GLint matrix;
static bool points;

/* A point of a face of the cube, at (u, v) in -1...1. */
static corner at(int face, double u, double v, bool ball)
{
    double p[3];
    const int axis = face / 2;
    p[axis] = face % 2 ? 1.0 : -1.0;
    p[(axis + 1) % 3] = u;
    p[(axis + 2) % 3] = v;
    const double length = ball ? sqrt(p[0] * p[0] + p[1] * p[1] + p[2] * p[2]) : 1.0;
    corner c;
    for (int i = 0; i < 3; i++) {
        c.position[i] = (float)(p[i] / length);
        c.colour[i] = (float)(0.5 + 0.5 * p[i]);
    }
    return c;
}

static void setup(app *a)
{
    points = a->mode && strcmp(a->mode, "points") == 0;
    const bool ball = a->mode && strcmp(a->mode, "ball") == 0;
    const shader_source stages[] = {{GL_VERTEX_SHADER, vertex}, {GL_FRAGMENT_SHADER, fragment}};
    program = program_build(stages, 2);
    matrix = glGetUniformLocation(program, "MVP");

    const int side = points ? CELLS : CELLS + 1;
    corner *corners = malloc(sizeof(corner) * CORNERS);
    GLuint *indices = malloc(sizeof(GLuint) * POINTS * 6);
    size_t count = 0, used = 0;
    for (int face = 0; face < FACES; face++)
        for (int row = 0; row < side; row++)
            for (int column = 0; column < side; column++) {
                const double middle = points ? 0.5 : 0.0;
                const double u = 2.0 * (column + middle) / CELLS - 1.0, v = 2.0 * (row + middle) / CELLS - 1.0;
                if (!points && row < CELLS && column < CELLS) {
                    const GLuint first = (GLuint)count;
                    const GLuint cell[6] = {first,     first + 1,    first + side,
                                            first + 1, first + side, first + side + 1};
                    memcpy(indices + used, cell, sizeof cell);
                    used += 6;
                }
                corners[count++] = at(face, u, v, ball);
            }
    GLuint buffers[2];
    glGenVertexArrays(1, &array);
    glBindVertexArray(array);
    glGenBuffers(2, buffers);
    glBindBuffer(GL_ARRAY_BUFFER, buffers[0]);
    glBufferData(GL_ARRAY_BUFFER, (GLsizeiptr)(count * sizeof(corner)), corners, GL_STATIC_DRAW);
    glBindBuffer(GL_ELEMENT_ARRAY_BUFFER, buffers[1]);
    glBufferData(GL_ELEMENT_ARRAY_BUFFER, (GLsizeiptr)(used * sizeof(GLuint)), indices, GL_STATIC_DRAW);
    glVertexAttribPointer(0, 3, GL_FLOAT, GL_FALSE, sizeof(corner), (const void *)offsetof(corner, position));
    glVertexAttribPointer(1, 3, GL_FLOAT, GL_FALSE, sizeof(corner), (const void *)offsetof(corner, colour));
    glEnableVertexAttribArray(0);
    glEnableVertexAttribArray(1);
    free(corners);
    free(indices);
}

static void draw(app *a)
{
    glClearColor(0.0f, 0.0f, 0.0f, 1.0f);
    glClear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
    glEnable(GL_DEPTH_TEST);
    glUseProgram(program);
    const matrix4 together = matrix_multiply(a->projection, a->modelview);
    glUniformMatrix4fv(matrix, 1, GL_FALSE, together.m);
    glBindVertexArray(array);
    if (points)
        glDrawArrays(GL_POINTS, 0, POINTS);
    else
        glDrawElements(GL_TRIANGLES, POINTS * 6, GL_UNSIGNED_INT, NULL);
}

int main(int argc, char **argv)
{
    static const app_program self = {"fine", API_GL_CORE, 3, 3, setup, draw, NULL};
    return app_main(argc, argv, &self);
}
