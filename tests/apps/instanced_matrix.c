/*
 * Direction test in a core 4.5 context. The shader gets its matrix from a vertex attribute.
 * `--mode`: `array`, an array with a value for each instance; `second`, the same from its second
 * value on; `constant`, no array; `vertices`, an array with a value for each vertex. Four vectors of
 * each instance: `columns`; `rows`, as rows; `models`, the matrices of models, while a uniform has the
 * camera.
 */
#include "common/app.h"
#include "common/mesh.h"
#include "common/shader.h"

#include <stdio.h>
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

static const char vectors[] =
    "layout(location = 0) in vec3 position;\n"
    "layout(location = 1) in vec3 colour;\n"
    "layout(location = 3) in vec4 tint;\n"
    "layout(location = 4) in vec4 x;\n"
    "layout(location = 5) in vec4 y;\n"
    "layout(location = 6) in vec4 z;\n"
    "layout(location = 7) in vec4 w;\n"
    "uniform mat4 camera;\n"
    "out vec3 shade;\n"
    "void main() {\n"
    "    shade = colour + tint.rgb;\n"
    "    vec4 at = vec4(position, 1.0) + 0.0 * tint;\n"
    "#if defined(ROWS)\n"
    "    gl_Position = vec4(dot(x, at), dot(y, at), dot(z, at), dot(w, at));\n"
    "#elif defined(MODELS)\n"
    "    gl_Position = camera * (mat4(x, y, z, w) * at);\n"
    "#else\n"
    "    gl_Position = mat4(x, y, z, w) * at;\n"
    "#endif\n"
    "}\n";

enum { PLACE = 4, HEAD = 32 };

static mesh cube;
static GLuint program, buffer;
static bool constant, second, vertices, columns, rows, models;

static void setup(app *a)
{
    constant = a->mode && strcmp(a->mode, "constant") == 0;
    second = a->mode && strcmp(a->mode, "second") == 0;
    vertices = a->mode && strcmp(a->mode, "vertices") == 0;
    columns = a->mode && strcmp(a->mode, "columns") == 0;
    rows = a->mode && strcmp(a->mode, "rows") == 0;
    models = a->mode && strcmp(a->mode, "models") == 0;
    char text[2000];
    const char *form = rows ? "#define ROWS\n" : models ? "#define MODELS\n" : "";
    snprintf(text, sizeof text, "#version 330 core\n%s%s", form, vectors);
    const char *used = columns || rows || models ? text : vertex;
    const shader_source stages[] = {{GL_VERTEX_SHADER, used}, {GL_FRAGMENT_SHADER, shader_shade}};
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

static matrix4 transposed(matrix4 from)
{
    matrix4 to;
    for (int i = 0; i < 16; i++)
        to.m[i] = from.m[i % 4 * 4 + i / 4];
    return to;
}

static void draw(app *a)
{
    /* If the second value is drawn with, the first value has another lens. */
    const double aspect = (double)a->window.width / a->window.height;
    const matrix4 other = matrix_perspective(0.6 * a->fov, aspect, a->near, a->far);
    matrix4 values[CUBE_CORNERS];
    for (int i = 0; i < CUBE_CORNERS; i++)
        values[i] = models ? a->modelview : matrix_multiply(i == 0 && second ? other : a->projection, a->modelview);
    for (int i = 0; rows && i < CUBE_CORNERS; i++)
        values[i] = transposed(values[i]);
    app_clear();
    glUseProgram(program);
    if (models)
        glUniformMatrix4fv(glGetUniformLocation(program, "camera"), 1, GL_FALSE, a->projection.m);
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
