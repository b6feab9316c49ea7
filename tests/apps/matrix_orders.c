/*
 * Direction test in a core 4.5 context. The shaders multiply row vectors, have their matrices by
 * rows, or have cameras with three rows or columns. `--mode` names the form.
 */
#include "common/app.h"
#include "common/forms.h"
#include "common/mesh.h"

#include <string.h>

#define SHADER(declarations, position) \
    "#version 400 core\n" \
    "layout(location = 0) in vec3 position;\n" \
    "layout(location = 1) in vec3 colour;\n" \
    "out vec3 shade;\n" declarations "\n" \
    "void main() { shade = colour; vec4 v = vec4(position, 1.0); gl_Position = " position "; }\n"

typedef struct {
    const char *name, *vertex;
    bool row_vector; /* the vector stands before the block's matrix */
} form;

static const form forms[] = {
    {"view_4x3", SHADER("uniform mat4 P; uniform mat4x3 V43;", "P * vec4(V43 * v, 1.0)"), false},
    {"view_3x4", SHADER("uniform mat4 P; uniform mat3x4 V34;", "P * vec4(v * V34, 1.0)"), false},
    {"row_vector", SHADER("uniform mat4 MT;", "v * MT"), false},
    {"row_vector_parts", SHADER("uniform mat4 PT; uniform mat4 VT;", "v * VT * PT"), false},
    {"row_vector_transposed", SHADER("uniform mat4 M;", "v * transpose(M)"), false},
    {"block_by_rows", SHADER("layout(std140, row_major) uniform B { mat4 m; };", "m * v"), false},
    {"block_row_vector", SHADER("layout(std140) uniform B { mat4 m; };", "v * m"), true},
    {"block_by_rows_row_vector", SHADER("layout(std140, row_major) uniform B { mat4 m; };", "v * m"), true},
    {"double", SHADER("uniform dmat4 D;", "vec4(D * dvec4(v))"), false},
    {"double_block", SHADER("layout(std140) uniform B { dmat4 m; };", "vec4(m * dvec4(v))"), false},
    {"double_block_by_rows",
     SHADER("layout(std140, row_major) uniform B { float x; dmat4 m; };", "vec4(dvec4(v) * m + x)"), true},
};

enum { FORMS = sizeof forms / sizeof forms[0] };

static mesh cube;
static const form *used = forms;
static GLuint program;

static void setup(app *a)
{
    used = form_of(a, forms, sizeof forms[0], FORMS);
    program = form_program(used->vertex);
    cube = mesh_cube();
    form_block(program);
}

static GLint place(const char *name)
{
    return glGetUniformLocation(program, name);
}

/* Sets the uniforms that the form has. */
static void set_uniforms(const app *a, const matrix4 *m)
{
    double twice[16];
    float columns[12], rows[12];
    for (int i = 0; i < 16; i++)
        twice[i] = m->m[i];
    for (int row = 0; row < 3; row++)
        for (int column = 0; column < 4; column++)
            columns[3 * column + row] = rows[4 * row + column] = a->modelview.m[4 * column + row];
    glUniformMatrix4fv(place("M"), 1, GL_FALSE, m->m);
    glUniformMatrix4fv(place("MT"), 1, GL_TRUE, m->m);
    glUniformMatrix4fv(place("P"), 1, GL_FALSE, a->projection.m);
    glUniformMatrix4fv(place("PT"), 1, GL_TRUE, a->projection.m);
    glUniformMatrix4fv(place("VT"), 1, GL_TRUE, a->modelview.m);
    glUniformMatrix4x3fv(place("V43"), 1, GL_FALSE, columns);
    glUniformMatrix3x4fv(place("V34"), 1, GL_FALSE, rows);
    glUniformMatrix4dv(place("D"), 1, GL_FALSE, twice);
}

static void set_block(const matrix4 *m)
{
    const char *name = "m";
    GLuint index;
    GLint kind, offset, stride, by_rows;
    glGetUniformIndices(program, 1, &name, &index);
    if (index == GL_INVALID_INDEX)
        return;
    glGetActiveUniformsiv(program, 1, &index, GL_UNIFORM_TYPE, &kind);
    glGetActiveUniformsiv(program, 1, &index, GL_UNIFORM_OFFSET, &offset);
    glGetActiveUniformsiv(program, 1, &index, GL_UNIFORM_MATRIX_STRIDE, &stride);
    glGetActiveUniformsiv(program, 1, &index, GL_UNIFORM_IS_ROW_MAJOR, &by_rows);
    char bytes[512] = {0};
    /* Storing by rows transposes the matrix, and multiplying a row vector transposes it again. */
    const matrix4 memory = (by_rows != 0) != used->row_vector ? matrix_transposed(*m) : *m;
    for (int i = 0; i < 16; i++) {
        const double twice = memory.m[i];
        char *at = bytes + offset + i / 4 * stride;
        if (kind == GL_DOUBLE_MAT4)
            memcpy(at + i % 4 * 8, &twice, sizeof twice);
        else
            memcpy(at + i % 4 * 4, &memory.m[i], sizeof memory.m[i]);
    }
    glBufferData(GL_UNIFORM_BUFFER, sizeof bytes, bytes, GL_DYNAMIC_DRAW);
}

static void draw(app *a)
{
    const matrix4 m = matrix_multiply(a->projection, a->modelview);
    app_clear();
    glUseProgram(program);
    set_uniforms(a, &m);
    set_block(&m);
    mesh_bind(&cube);
    glDrawElements(GL_TRIANGLES, CUBE_INDICES, GL_UNSIGNED_SHORT, NULL);
    app_check_error(a, "a matrix");
}

int main(int argc, char **argv)
{
    static const app_program self = {"matrix_orders", API_GL_CORE, 4, 5, setup, draw, NULL};
    return app_main(argc, argv, &self);
}
