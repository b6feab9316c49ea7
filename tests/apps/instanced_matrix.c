/*
 * Direction test in a core 4.5 context. The shader gets its matrix from a vertex attribute.
 * `--mode`: `array`, an array with a value for each instance; `second`, the same from its second
 * value on; `constant`, no array; `vertices`, an array with a value for each vertex.
 */
#include "common/app.h"
#include "common/mesh.h"
#include "common/shader.h"

#include <string.h>

static const char vertex[] =
    "#version 330 core\n"
    "layout(location = 0) in vec3 position;\n"
    "layout(location = 1) in vec3 colour;\n"
    "layout(location = 4) in mat4 camera;\n"
    "out vec3 shade;\n"
    "void main() {\n"
    "    shade = colour;\n"
    "    gl_Position = camera * vec4(position, 1.0);\n"
    "}\n";

enum { PLACE = 4, HEAD = 32 };

static mesh cube;
static GLuint program, buffer;
static bool constant, second, vertices;

static void setup(app *a)
{
    constant = a->mode && strcmp(a->mode, "constant") == 0;
    second = a->mode && strcmp(a->mode, "second") == 0;
    vertices = a->mode && strcmp(a->mode, "vertices") == 0;
    const shader_source stages[] = {{GL_VERTEX_SHADER, vertex}, {GL_FRAGMENT_SHADER, shader_shade}};
    program = program_build(stages, 2);
    cube = mesh_cube();
    if (constant)
        return;
    mesh_bind(&cube);
    glGenBuffers(1, &buffer);
    glBindBuffer(GL_ARRAY_BUFFER, buffer);
    for (GLuint i = 0; i < 4; i++) {
        glVertexAttribPointer(PLACE + i, 4, GL_FLOAT, GL_FALSE, sizeof(matrix4), (char *)NULL + HEAD + 16 * i);
        glVertexAttribDivisor(PLACE + i, vertices ? 0 : 1);
        glEnableVertexAttribArray(PLACE + i);
    }
}

static void draw(app *a)
{
    /* If the second value is drawn with, the first value has another lens. */
    const double aspect = (double)a->window.width / a->window.height;
    const matrix4 other = matrix_perspective(0.6 * a->fov, aspect, a->near, a->far);
    matrix4 values[CUBE_CORNERS];
    for (int i = 0; i < CUBE_CORNERS; i++)
        values[i] = matrix_multiply(i == 0 && second ? other : a->projection, a->modelview);
    app_clear();
    glUseProgram(program);
    mesh_bind(&cube);
    if (constant) {
        for (GLuint i = 0; i < 4; i++)
            glVertexAttrib4fv(PLACE + i, values[0].m + 4 * i);
    } else {
        glBindBuffer(GL_ARRAY_BUFFER, buffer);
        glBufferData(GL_ARRAY_BUFFER, HEAD + sizeof values, NULL, GL_DYNAMIC_DRAW);
        glBufferSubData(GL_ARRAY_BUFFER, HEAD, sizeof values, values);
    }
    glDrawElementsInstancedBaseInstance(GL_TRIANGLES, CUBE_INDICES, GL_UNSIGNED_SHORT, NULL, 1, second ? 1 : 0);
    app_check_error(a, "a matrix of each instance");
}

int main(int argc, char **argv)
{
    static const app_program self = {"instanced_matrix", API_GL_CORE, 4, 5, setup, draw, NULL};
    return app_main(argc, argv, &self);
}
