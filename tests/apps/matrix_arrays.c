/*
 * Direction test in a core 4.5 context. The camera of the shaders is an element of an array of
 * matrices. The elements have different lenses unless the form says otherwise. `--mode` names the
 * form.
 */
#include "common/app.h"
#include "common/forms.h"
#include "common/mesh.h"

#include <stdio.h>
#include <string.h>

#define SHADER(declarations, element) \
    "#version 430 core\n" \
    "layout(location = 0) in vec3 position;\n" \
    "layout(location = 1) in vec3 colour;\n" \
    "out vec3 shade;\n" declarations "\n" \
    "void main() { shade = colour; gl_Position = " element " * vec4(position, 1.0); }\n"

typedef struct {
    const char *name, *vertex;
    bool same; /* all elements are the same */
} form;

static const form forms[] = {
    {"constant", SHADER("uniform mat4 cams[4];", "cams[2]"), false},
    {"uniform", SHADER("uniform mat4 cams[4]; uniform int which;", "cams[which]"), false},
    {"unsigned", SHADER("uniform mat4 cams[4]; uniform uint which;", "cams[which]"), false},
    {"same", SHADER("uniform mat4 cams[4];", "cams[gl_InstanceID + 2]"), true},
    {"instance", SHADER("uniform mat4 cams[4];", "cams[gl_InstanceID + 2]"), false},
    {"block_constant", SHADER("layout(std140) uniform B { mat4 cams[4]; };", "cams[2]"), false},
    {"block_uniform", SHADER("layout(std140) uniform B { mat4 cams[4]; } b; uniform int which;", "b.cams[which]"), false},
    {"block_same", SHADER("layout(std140) uniform B { mat4 cams[4]; };", "cams[gl_InstanceID + 2]"), true},
    {"block_instance", SHADER("layout(std140) uniform B { mat4 cams[4]; };", "cams[gl_InstanceID + 2]"), false},
    {"block_index", SHADER("layout(std140) uniform B { int which; mat4 cams[4]; };", "cams[which]"), false},
    {"structures", SHADER("struct camera { vec4 eye; mat4 m; }; uniform camera cams[4];", "cams[2].m"), false},
};

enum { FORMS = sizeof forms / sizeof forms[0], CAMERAS = 4, USED = 2 };

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

static void draw(app *a)
{
    const double aspect = (double)a->window.width / a->window.height;
    matrix4 cameras[CAMERAS];
    for (int i = 0; i < CAMERAS; i++) {
        const matrix4 other = matrix_perspective(20.0 + 5.0 * i, aspect, a->near, a->far);
        cameras[i] = matrix_multiply(i == USED || used->same ? a->projection : other, a->modelview);
    }
    app_clear();
    glUseProgram(program);
    glUniformMatrix4fv(place("cams"), CAMERAS, GL_FALSE, cameras[0].m);
    for (int i = 0; i < CAMERAS; i++) {
        char name[16];
        snprintf(name, sizeof name, "cams[%d].m", i);
        glUniformMatrix4fv(place(name), 1, GL_FALSE, cameras[i].m);
    }
    if (strcmp(used->name, "unsigned") == 0)
        glUniform1ui(place("which"), USED);
    else
        glUniform1i(place("which"), USED);
    if (glGetUniformBlockIndex(program, "B") != GL_INVALID_INDEX) {
        const int index[4] = {USED};
        const bool indexed = strcmp(used->name, "block_index") == 0;
        glBufferData(GL_UNIFORM_BUFFER, sizeof index + sizeof cameras, index, GL_DYNAMIC_DRAW);
        glBufferSubData(GL_UNIFORM_BUFFER, indexed ? sizeof index : 0, sizeof cameras, cameras);
    }
    mesh_bind(&cube);
    glDrawElements(GL_TRIANGLES, CUBE_INDICES, GL_UNSIGNED_SHORT, NULL);
    app_check_error(a, "an array of matrices");
}

int main(int argc, char **argv)
{
    static const app_program self = {"matrix_arrays", API_GL_CORE, 4, 5, setup, draw, NULL};
    return app_main(argc, argv, &self);
}
