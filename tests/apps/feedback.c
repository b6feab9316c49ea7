/*
 * Transform feedback while the scene is drawn, and with rasterisation off. The recorded values and
 * their number must be those of one draw. If a draw is recorded twice, a buffer overflows.
 */
#include "common/app.h"
#include "common/mesh.h"
#include "common/program.h"

#include <stddef.h>
#include <string.h>

static const char vertex[] =
    "#version 400 core\n"
    "layout(location = 0) in vec3 position;\n"
    "layout(location = 1) in vec3 colour;\n"
    "uniform mat4 P;\n"
    "uniform mat4 MV;\n"
    "out vec3 shade;\n"
    "void main() { shade = colour; gl_Position = P * (MV * vec4(position, 1.0)); }\n";
static const char fragment[] =
    "#version 400 core\nin vec3 shade;\nout vec4 result;\nvoid main() { result = vec4(shade, 1.0); }\n";

enum { ROOM = 4 * CUBE_INDICES };
static mesh cube;
static GLuint program, buffer, query;

static void setup(app *a)
{
    const shader_source stages[] = {{GL_VERTEX_SHADER, vertex}, {GL_FRAGMENT_SHADER, fragment}};
    program = program_build(stages, 2);
    const char *names[] = {"shade"};
    glTransformFeedbackVaryings(program, 1, names, GL_INTERLEAVED_ATTRIBS);
    glLinkProgram(program);
    glUseProgram(program);
    glUniformMatrix4fv(glGetUniformLocation(program, "P"), 1, GL_FALSE, a->projection.m);
    glUniformMatrix4fv(glGetUniformLocation(program, "MV"), 1, GL_FALSE, a->modelview.m);
    cube = mesh_cube();
    glGenBuffers(1, &buffer);
    glBindBuffer(GL_TRANSFORM_FEEDBACK_BUFFER, buffer);
    glBufferData(GL_TRANSFORM_FEEDBACK_BUFFER, ROOM * 3 * sizeof(float), NULL, GL_STATIC_READ);
    glBindBufferBase(GL_TRANSFORM_FEEDBACK_BUFFER, 0, buffer);
    glGenQueries(1, &query);
}

static void record(app *a, const char *what)
{
    static float zero[ROOM * 3], recorded[ROOM * 3];
    glBufferSubData(GL_TRANSFORM_FEEDBACK_BUFFER, 0, sizeof zero, zero);
    glBeginQuery(GL_TRANSFORM_FEEDBACK_PRIMITIVES_WRITTEN, query);
    glBeginTransformFeedback(GL_TRIANGLES);
    glDrawElements(GL_TRIANGLES, CUBE_INDICES, GL_UNSIGNED_SHORT, NULL);
    glEndTransformFeedback();
    glEndQuery(GL_TRANSFORM_FEEDBACK_PRIMITIVES_WRITTEN);
    GLuint written = 0;
    glGetQueryObjectuiv(query, GL_QUERY_RESULT, &written);
    app_check(a, written == CUBE_INDICES / 3, "%s: %u triangles are recorded", what, written);
    glGetBufferSubData(GL_TRANSFORM_FEEDBACK_BUFFER, 0, sizeof recorded, recorded);
    for (int i = 0; i < CUBE_INDICES; i++) {
        const float *expected = cube_colours[cube_indices[i]];
        app_check(a, memcmp(recorded + 3 * i, expected, sizeof cube_colours[0]) == 0, "%s: vertex %d", what, i);
    }
    app_check(a, memcmp(recorded + 3 * CUBE_INDICES, zero, sizeof zero / 2) == 0, "%s: more than one draw", what);
}

static void draw(app *a)
{
    app_clear();
    glUseProgram(program);
    mesh_bind(&cube);
    glEnable(GL_RASTERIZER_DISCARD);
    record(a, "with rasterisation off");
    glDisable(GL_RASTERIZER_DISCARD);
    record(a, "while drawing");
}

int main(int argc, char **argv)
{
    static const app_program self = {"feedback", API_GL_CORE, 4, 0, setup, draw, NULL};
    return app_main(argc, argv, &self);
}
