/* Direction test in core 4.0. Each face of the cube is drawn by another kind of draw call. */
#include "common/app.h"
#include "common/mesh.h"
#include "common/shader.h"

#include <stddef.h>

static const char vertex[] =
    "#version 330 core\n"
    "layout(location = 0) in vec3 position;\n"
    "uniform mat4 P;\n"
    "uniform mat4 MV;\n"
    "uniform bool rows;\n"
    "out vec3 shade;\n"
    "void main() {\n"
    "    vec3 place = position;\n"
    "    /* Instances are the lower, middle and upper third of a face in y. */\n"
    "    if (rows) place.y = (position.y + 2.0 * float(gl_InstanceID) - 2.0) / 3.0;\n"
    "    shade = 0.5 + 0.5 * place;\n"
    "    gl_Position = P * (MV * vec4(place, 1.0));\n"
    "}\n";

static mesh cube;
static GLuint program, expanded_array, expanded, commands;
static GLint projection, modelview, rows;

static void setup(app *a)
{
    (void)a;
    const shader_source stages[] = {{GL_VERTEX_SHADER, vertex}, {GL_FRAGMENT_SHADER, shader_shade}};
    program = program_build(stages, 2);
    projection = glGetUniformLocation(program, "P");
    modelview = glGetUniformLocation(program, "MV");
    rows = glGetUniformLocation(program, "rows");
    cube = mesh_cube();

    /* The same cube without indices, six vertices for each face. */
    static float vertices[CUBE_INDICES][3];
    for (int i = 0; i < CUBE_INDICES; i++)
        for (int k = 0; k < 3; k++)
            vertices[i][k] = cube_positions[cube_indices[i]][k];
    glGenVertexArrays(1, &expanded_array);
    glBindVertexArray(expanded_array);
    glGenBuffers(1, &expanded);
    glBindBuffer(GL_ARRAY_BUFFER, expanded);
    glBufferData(GL_ARRAY_BUFFER, sizeof vertices, vertices, GL_STATIC_DRAW);
    glVertexAttribPointer(0, 3, GL_FLOAT, GL_FALSE, 0, NULL);
    glEnableVertexAttribArray(0);

    static const GLuint command[4] = {6, 1, 24, 0}; /* count, instances, first, 0: the face -z */
    glGenBuffers(1, &commands);
    glBindBuffer(GL_DRAW_INDIRECT_BUFFER, commands);
    glBufferData(GL_DRAW_INDIRECT_BUFFER, sizeof command, command, GL_STATIC_DRAW);
}

static const void *index_offset(int first)
{
    return (const char *)NULL + (size_t)first * sizeof cube_indices[0];
}

static void draw(app *a)
{
    app_clear();
    glUseProgram(program);
    glUniformMatrix4fv(projection, 1, GL_FALSE, a->projection.m);
    glUniformMatrix4fv(modelview, 1, GL_FALSE, a->modelview.m);

    mesh_bind(&cube);
    glUniform1i(rows, 1);
    glDrawElementsInstanced(GL_TRIANGLES, 6, GL_UNSIGNED_SHORT, index_offset(0), 3);
    glBindVertexArray(expanded_array);
    glDrawArraysInstanced(GL_TRIANGLES, 6, 6, 3);
    glUniform1i(rows, 0);
    static const GLint firsts[2] = {12, 15};
    static const GLsizei counts[2] = {3, 3};
    glMultiDrawArrays(GL_TRIANGLES, firsts, counts, 2);
    mesh_bind(&cube);
    const void *offsets[2] = {index_offset(18), index_offset(21)};
    glMultiDrawElements(GL_TRIANGLES, counts, GL_UNSIGNED_SHORT, offsets, 2);
    /* The corners of +z are those of -z with indices that are greater by four. */
    glDrawElementsBaseVertex(GL_TRIANGLES, 6, GL_UNSIGNED_SHORT, index_offset(24), 4);
    glBindVertexArray(expanded_array);
    glBindBuffer(GL_DRAW_INDIRECT_BUFFER, commands);
    glDrawArraysIndirect(GL_TRIANGLES, NULL);
}

int main(int argc, char **argv)
{
    static const app_program self = {"draws", API_GL_CORE, 4, 0, setup, draw, NULL};
    return app_main(argc, argv, &self);
}
