/*
 * Direction test with a vertex program in assembly language (ARB_vertex_program). `--mode` names
 * the place of its matrix: `state`, the fixed-function matrices; `environment` and `local`, rows in
 * parameters of the program; `columns`, columns in parameters.
 */
#include "common/fixed.h"
#include "common/mesh.h"

#include <stdio.h>
#include <string.h>

#define TRANSFORM \
    "DP4 result.position.x, m[0], vertex.position;\n" \
    "DP4 result.position.y, m[1], vertex.position;\n" \
    "DP4 result.position.z, m[2], vertex.position;\n" \
    "DP4 result.position.w, m[3], vertex.position;\n" \
    "MOV result.color, vertex.color;\n" \
    "END\n"

static const char *const forms[][2] = {
    {"state", "!!ARBvp1.0\nPARAM m[4] = { state.matrix.mvp };\n" TRANSFORM},
    {"environment", "!!ARBvp1.0\nPARAM m[4] = { program.env[8..11] };\n" TRANSFORM},
    {"local", "!!ARBvp1.0\nPARAM m[4] = { program.local[3..6] };\n" TRANSFORM},
    {"columns",
     "!!ARBvp1.0\n# a comment; result.position\nOUTPUT place = result.position;\nATTRIB v = vertex.position;\nTEMP t;\n"
     "MUL t, v.x, program.env[0];\nMAD t, v.y, program.env[1], t;\nMAD t, v.z, program.env[2], t;\n"
     "MAD place, v.w, program.env[3], t;\nMOV result.color, vertex.color;\nEND\n"},
};

enum { FORMS = sizeof forms / sizeof forms[0] };

static const char *const *used = forms[0];
static GLuint name;

static void setup(app *a)
{
    for (int i = 0; i < FORMS; i++)
        if (a->mode && strcmp(forms[i][0], a->mode) == 0)
            used = forms[i];
    glGenProgramsARB(1, &name);
    glBindProgramARB(GL_VERTEX_PROGRAM_ARB, name);
    glProgramStringARB(GL_VERTEX_PROGRAM_ARB, GL_PROGRAM_FORMAT_ASCII_ARB, (GLsizei)strlen(used[1]), used[1]);
    if (glGetError() != GL_NO_ERROR)
        fprintf(stderr, "%s\n", (const char *)glGetString(GL_PROGRAM_ERROR_STRING_ARB));
}

/* OpenGL must return the text that the program gave. */
static void check_text(app *a)
{
    GLint length = 0, bound = 0;
    char text[1024] = "";
    glGetProgramivARB(GL_VERTEX_PROGRAM_ARB, GL_PROGRAM_LENGTH_ARB, &length);
    glGetProgramivARB(GL_VERTEX_PROGRAM_ARB, GL_PROGRAM_BINDING_ARB, &bound);
    app_check(a, length == (GLint)strlen(used[1]), "the program has %d characters", length);
    app_check(a, (GLuint)bound == name, "program %d is bound", bound);
    if (length < (GLint)sizeof text)
        glGetProgramStringARB(GL_VERTEX_PROGRAM_ARB, GL_PROGRAM_STRING_ARB, text);
    app_check(a, strcmp(text, used[1]) == 0, "another text: %s", text);
}

static void draw(app *a)
{
    const matrix4 m = matrix_multiply(a->projection, a->modelview), rows = matrix_transposed(m);
    const bool state = used == forms[0];
    app_clear();
    glBindProgramARB(GL_VERTEX_PROGRAM_ARB, name);
    for (GLuint i = 0; i < 4; i++) {
        glProgramEnvParameter4fvARB(GL_VERTEX_PROGRAM_ARB, 8 + i, rows.m + 4 * i);
        glProgramEnvParameter4fvARB(GL_VERTEX_PROGRAM_ARB, i, m.m + 4 * i);
        glProgramLocalParameter4fvARB(GL_VERTEX_PROGRAM_ARB, 3 + i, rows.m + 4 * i);
    }
    glMatrixMode(GL_PROJECTION);
    glLoadIdentity();
    if (state)
        glLoadMatrixf(a->projection.m);
    glMatrixMode(GL_MODELVIEW);
    glLoadIdentity();
    if (state)
        glLoadMatrixf(a->modelview.m);
    glEnable(GL_VERTEX_PROGRAM_ARB);
    glBegin(GL_TRIANGLES);
    for (int i = 0; i < CUBE_INDICES; i++) {
        glColor3fv(cube_colours[cube_indices[i]]);
        glVertex3fv(cube_positions[cube_indices[i]]);
    }
    glEnd();
    check_text(a);
    glDisable(GL_VERTEX_PROGRAM_ARB);
    app_check_error(a, "a vertex program");
}

int main(int argc, char **argv)
{
    static const app_program self = {"assembly_camera", API_GL_COMPATIBILITY, 0, 0, setup, draw, NULL};
    return app_main(argc, argv, &self);
}
