/*
 * Direction test in a core 4.5 context. The shaders have their matrix in a storage block. The
 * elements of arrays have different lenses unless the form says otherwise. `--mode` names the form.
 */
#include "common/app.h"
#include "common/forms.h"
#include "common/mesh.h"

#include <string.h>

#define SHADER(declarations, matrix) \
    "#version 430 core\n" \
    "layout(location = 0) in vec3 position;\n" \
    "layout(location = 1) in vec3 colour;\n" \
    "out vec3 shade;\n" declarations "\n" \
    "void main() { shade = colour; gl_Position = " matrix " * vec4(position, 1.0); }\n"

typedef struct {
    const char *name, *vertex;
    int stride; /* in floats; 0: no array */
    bool same;
} form;

static const form forms[] = {
    {"member", SHADER("layout(std430, binding = 2) readonly buffer B { vec4 tint; mat4 m; } b;", "b.m"), 0, false},
    {"rows", SHADER("layout(std430, binding = 2, row_major) readonly buffer B { vec4 tint; mat4 m; };", "m"), 0, false},
    {"constant", SHADER("layout(std430, binding = 2) readonly buffer B { vec4 tint; mat4 all[]; };", "all[2]"), 16, false},
    {"far", SHADER("layout(std430, binding = 2) readonly buffer B { vec4 tint; mat4 all[]; };", "all[10]"), 16, false},
    {"uniform",
     SHADER("layout(std430, binding = 2) readonly buffer B { vec4 tint; mat4 all[]; }; uniform int which;", "all[which]"),
     16, false},
    {"same", SHADER("layout(std430, binding = 2) readonly buffer B { vec4 tint; mat4 all[]; };", "all[gl_InstanceID + 2]"),
     16, true},
    {"instance",
     SHADER("layout(std430, binding = 2) readonly buffer B { vec4 tint; mat4 all[]; };", "all[gl_InstanceID + 2]"), 16,
     false},
    {"structures",
     SHADER("struct camera { mat4 m; vec4 eye; };\n"
            "layout(std430, binding = 2) readonly buffer B { vec4 tint; camera all[]; };", "all[2].m"), 20, false},
    {"structure_by_uniform",
     SHADER("struct camera { mat4 m; vec4 eye; }; uniform uint which;\n"
            "layout(std430, binding = 2) readonly buffer B { vec4 tint; camera all[]; } b;", "b.all[which].m"), 20, false},
};

enum { FORMS = sizeof forms / sizeof forms[0], CAMERAS = 11, USED = 2, MOST = 4 + CAMERAS * 20 };

static mesh cube;
static const form *used = forms;
static GLuint program;

static void setup(app *a)
{
    used = form_of(a, forms, sizeof forms[0], FORMS);
    program = form_program(used->vertex);
    cube = mesh_cube();
    GLuint buffer;
    glGenBuffers(1, &buffer);
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 2, buffer);
    glBufferData(GL_SHADER_STORAGE_BUFFER, MOST * sizeof(float), NULL, GL_DYNAMIC_DRAW);
}

static void draw(app *a)
{
    const double aspect = (double)a->window.width / a->window.height;
    const matrix4 right = matrix_multiply(a->projection, a->modelview), turned = matrix_transposed(right);
    float values[MOST] = {1, 1, 1, 1};
    for (int i = 0; i < CAMERAS && used->stride != 0; i++) {
        const matrix4 other = matrix_perspective(20.0 + 5.0 * i, aspect, a->near, a->far);
        const matrix4 wrong = matrix_multiply(other, a->modelview);
        memcpy(values + 4 + i * used->stride, i == USED || i == CAMERAS - 1 || used->same ? right.m : wrong.m, sizeof right.m);
    }
    if (used->stride == 0)
        memcpy(values + 4, strcmp(used->name, "rows") == 0 ? turned.m : right.m, sizeof right.m);
    app_clear();
    glUseProgram(program);
    const GLint which = glGetUniformLocation(program, "which");
    if (strcmp(used->name, "uniform") == 0)
        glUniform1i(which, USED);
    else if (which >= 0)
        glUniform1ui(which, USED);
    glBufferSubData(GL_SHADER_STORAGE_BUFFER, 0, sizeof values, values);
    mesh_bind(&cube);
    glDrawElements(GL_TRIANGLES, CUBE_INDICES, GL_UNSIGNED_SHORT, NULL);
    app_check_error(a, "a storage block");
}

int main(int argc, char **argv)
{
    static const app_program self = {"storage_camera", API_GL_CORE, 4, 5, setup, draw, NULL};
    return app_main(argc, argv, &self);
}
