/* Direction test in a core 3.3 context with a single model-view-projection uniform. */
#include "common/app.h"
#include "common/mesh.h"
#include "common/program.h"

static const char vertex[] =
    "#version 330 core\n"
    "layout(location = 0) in vec3 position;\n"
    "layout(location = 1) in vec3 colour;\n"
    "uniform mat4 MVP;\n"
    "out vec3 shade;\n"
    "void main() {\n"
    "    shade = colour;\n"
    "    gl_Position = MVP * vec4(position, 1.0);\n"
    "}\n";
static const char fragment[] =
    "#version 330 core\nin vec3 shade;\nout vec4 result;\nvoid main() { result = vec4(shade, 1.0); }\n";

static mesh cube;
static GLuint program;
static GLint location;

static void setup(app *a)
{
    (void)a;
    const shader_source stages[] = {{GL_VERTEX_SHADER, vertex}, {GL_FRAGMENT_SHADER, fragment}};
    program = program_build(stages, 2);
    location = glGetUniformLocation(program, "MVP");
    cube = mesh_cube();
}

static void draw(app *a)
{
    app_clear();
    glUseProgram(program);
    matrix4 mvp = matrix_multiply(a->projection, a->modelview);
    glUniformMatrix4fv(location, 1, GL_FALSE, mvp.m);
    mesh_bind(&cube);
    glDrawElements(GL_TRIANGLES, CUBE_INDICES, GL_UNSIGNED_SHORT, NULL);
}

int main(int argc, char **argv)
{
    static const app_program self = {"core330_mvp", API_GL_CORE, 3, 3, setup, draw, NULL};
    return app_main(argc, argv, &self);
}
