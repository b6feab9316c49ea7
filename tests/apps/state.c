/*
 * Sets every kind of state to unusual values, and asks for all of it after each draw and each swap.
 * Nothing may have changed. It uses a core context, so that the answer is the driver's and not a
 * default.
 */
#include "common/app.h"
#include "common/mesh.h"
#include "common/shader.h"
#include "common/states.h"

#include <string.h>

static const char vertex[] =
    "#version 330 core\n"
    "layout(location = 0) in vec3 position;\n"
    "layout(location = 1) in vec3 colour;\n"
    "uniform mat4 P;\n"
    "uniform mat4 MV;\n"
    "out vec3 shade;\n"
    "void main() { shade = colour; gl_Position = P * (MV * vec4(position, 1.0)); }\n";

static mesh cube;
static GLuint program;
static states before;

static void compare(app *a, const char *when)
{
    int different = states_compare(&before, when);
    app_check(a, different == 0, "%d values have changed", different);
}

static void setup(app *a)
{
    const shader_source stages[] = {{GL_VERTEX_SHADER, vertex}, {GL_FRAGMENT_SHADER, shader_shade}};
    program = program_build(stages, 2);
    cube = mesh_cube();
    glUseProgram(program);
    glUniformMatrix4fv(glGetUniformLocation(program, "P"), 1, GL_FALSE, a->projection.m);
    glUniformMatrix4fv(glGetUniformLocation(program, "MV"), 1, GL_FALSE, a->modelview.m);
    states_make_unusual(a->window.width, a->window.height);
    before = states_take();
}

static void draw(app *a)
{
    glClear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT | GL_STENCIL_BUFFER_BIT);
    compare(a, "a clear");
    glDrawElements(GL_TRIANGLES, CUBE_INDICES, GL_UNSIGNED_SHORT, NULL);
    compare(a, "a draw");
}

static void after(app *a)
{
    compare(a, "the swap");
    GLfloat matrix[16];
    glGetUniformfv(program, glGetUniformLocation(program, "P"), matrix);
    app_check(a, memcmp(matrix, a->projection.m, sizeof matrix) == 0, "the swap changed a uniform");
}

int main(int argc, char **argv)
{
    static const app_program self = {"state", API_GL_CORE, 3, 3, setup, draw, after};
    return app_main(argc, argv, &self);
}
