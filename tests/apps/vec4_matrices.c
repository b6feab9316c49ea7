/*
 * Direction test in a core 4.5 context. The matrices of the shaders are elements of arrays of vec4,
 * as translators from other languages write them. `--mode` names the form.
 */
#include "common/app.h"
#include "common/forms.h"
#include "common/mesh.h"

#include <stdio.h>
#include <string.h>

#define HEAD \
    "#version 330 core\n" \
    "layout(location = 0) in vec3 position;\n" \
    "layout(location = 1) in vec3 colour;\n" \
    "out vec3 shade;\n"

#define BODY(statements) "void main() { shade = colour; vec4 v = vec4(position, 1.0); " statements " }\n"

/* As HLSLcc and Unity write it. */
#define SUM(array) \
    "vec4 t = v.yyyy * " array "[1]; t = " array "[0] * v.xxxx + t; t = " array "[2] * v.zzzz + t; " \
    "gl_Position = " array "[3] * v.wwww + t;"

/* As Cg writes it. */
#define PRODUCTS(a0, a1, a2, a3) \
    "vec4 r; r.x = dot(" a0 ", v); r.y = dot(" a1 ", v); r.z = dot(" a2 ", v.xyzw); r.w = dot(" a3 ".xyzw, v); " \
    "gl_Position = r;"

typedef enum { WHOLE, ELEMENTS, SCALARS, BY_NAME, BLOCK } way;

typedef struct {
    const char *name, *vertex;
    way way;
    bool rows;
    int first, length; /* elements of the array */
} form;

static const form forms[] = {
    {"columns", HEAD "uniform vec4 m[4];\n" BODY(SUM("m")), WHOLE, false, 0, 4},
    {"rows", HEAD "uniform vec4 m[4];\n" BODY(PRODUCTS("m[0]", "m[1]", "m[2]", "m[3]")), WHOLE, true, 0, 4},
    {"elements", HEAD "uniform vec4 m[4];\n" BODY(SUM("m")), ELEMENTS, false, 0, 4},
    {"scalars", HEAD "uniform vec4 m[4];\n" BODY(PRODUCTS("m[0]", "m[1]", "m[2]", "m[3]")), SCALARS, true, 0, 4},
    {"by_name", HEAD "uniform vec4 m[4];\n" BODY(SUM("m")), BY_NAME, false, 0, 4},
    /* As Wine and others translate all constant registers. */
    {"registers", HEAD "uniform vec4 m[96];\n" BODY(PRODUCTS("m[21]", "m[22]", "m[23]", "m[24]") " gl_Position += m[0];"),
     WHOLE, true, 21, 96},
    /* As MojoShader writes it. */
    {"macros",
     HEAD "uniform vec4 m[12];\n#define c7 m[7]\n#define c8 m[8]\n#define c9 m[9]\n#define c10 m[10]\n"
     BODY(PRODUCTS("c7", "c8", "c9", "c10")), WHOLE, true, 7, 12},
    /* As SPIRV-Cross writes flattened blocks. */
    {"constructor", HEAD "uniform vec4 m[6];\n" BODY("gl_Position = mat4(m[2], m[3], m[4], m[5]) * v;"), WHOLE, false, 2, 6},
    {"constructor_rows", HEAD "uniform vec4 m[4];\n" BODY("gl_Position = v * mat4(m[0], m[1], m[2], m[3]);"), WHOLE, true,
     0, 4},
    /* The text does not show which elements are used. */
    {"computed",
     HEAD "uniform vec4 m[12]; uniform int from;\n"
     BODY("for (int i = 0; i < 4; i++) gl_Position[i] = dot(m[from + i], v);"), WHOLE, true, 8, 12},
    {"block", HEAD "layout(std140) uniform Camera { vec4 tint; vec4 m[8]; };\n" BODY(SUM("m")), BLOCK, false, 0, 8},
    {"block_rows",
     HEAD "layout(std140) uniform Camera { vec4 tint; vec4 m[8]; } camera;\n"
     BODY(PRODUCTS("camera.m[4]", "camera.m[5]", "camera.m[6]", "camera.m[7]")), BLOCK, true, 4, 8},
};

enum { FORMS = sizeof forms / sizeof forms[0], MOST = 96 };

static mesh cube;
static GLuint program, buffer;
static const form *used;

static void setup(app *a)
{
    used = form_of(a, forms, sizeof forms[0], FORMS);
    program = form_program(used->vertex);
    cube = mesh_cube();
    if (used->way == BLOCK) {
        glUniformBlockBinding(program, glGetUniformBlockIndex(program, "Camera"), 2);
        glGenBuffers(1, &buffer);
        glBindBufferBase(GL_UNIFORM_BUFFER, 2, buffer);
        glBufferData(GL_UNIFORM_BUFFER, 4 * (1 + MOST) * sizeof(float), NULL, GL_DYNAMIC_DRAW);
    }
}

static GLint element(int index)
{
    char name[16];
    snprintf(name, sizeof name, "m[%d]", index);
    return glGetUniformLocation(program, name);
}

/* Sets the elements. `vectors` are those of the matrix, `all` are those of the array. */
static void set(float (*vectors)[4], float (*all)[4])
{
    glUseProgram(program);
    if (glGetUniformLocation(program, "from") >= 0)
        glUniform1i(glGetUniformLocation(program, "from"), used->first);
    switch (used->way) {
    case WHOLE:
        glUniform4fv(element(0), used->length, all[0]);
        break;
    case ELEMENTS: /* sets a part, and single elements */
        glUniform4fv(element(2), 2, vectors[2]);
        glUniform4fv(element(1), 1, vectors[1]);
        glUniform4fv(element(0), 1, vectors[0]);
        break;
    case SCALARS:
        for (int i = 0; i < 4; i++)
            glUniform4f(element(i), vectors[i][0], vectors[i][1], vectors[i][2], vectors[i][3]);
        break;
    case BY_NAME:
        glUseProgram(0);
        glProgramUniform4fv(program, element(0), 3, vectors[0]);
        glProgramUniform4f(program, element(3), vectors[3][0], vectors[3][1], vectors[3][2], vectors[3][3]);
        glUseProgram(program);
        break;
    case BLOCK:
        glBufferSubData(GL_UNIFORM_BUFFER, 4 * sizeof(float), 4 * used->length * sizeof(float), all);
        break;
    }
}

static void draw(app *a)
{
    matrix4 m = matrix_multiply(a->projection, a->modelview);
    float all[MOST][4] = {{0}};
    if (used->rows)
        m = matrix_transposed(m);
    memcpy(all + used->first, m.m, sizeof m.m);
    app_clear();
    set(all + used->first, all);
    mesh_bind(&cube);
    glDrawElements(GL_TRIANGLES, CUBE_INDICES, GL_UNSIGNED_SHORT, NULL);
    app_check_error(a, "a matrix of vectors");
}

int main(int argc, char **argv)
{
    static const app_program self = {"vec4_matrices", API_GL_CORE, 4, 5, setup, draw, NULL};
    return app_main(argc, argv, &self);
}
