/*
 * Direction test in GLES 3 through EGL: ESSL 300, vertex arrays, one model-view-projection matrix.
 * Fragments beside the window are discarded.
 */
#include "common/app.h"
#include "common/mesh.h"
#include "common/program.h"

static const char vertex[] =
    "#version 300 es\n"
    "layout(location = 0) in vec3 position;\n"
    "uniform mat4 mvp;\n"
    "out highp vec3 shade;\n"
    "void main() {\n"
    "    shade = 0.5 + 0.5 * position;\n"
    "    gl_Position = mvp * vec4(position, 1.0);\n"
    "}\n";
static const char fragment[] =
    "#version 300 es\n"
    "precision highp float;\n"
    "in highp vec3 shade;\n"
    "out vec4 result;\n"
    "uniform vec2 size;\n"
    "void main() {\n"
    "    if (any(greaterThan(gl_FragCoord.xy, size))) discard;\n"
    "    result = vec4(shade, 1.0);\n"
    "}\n";

static mesh cube;
static GLuint program;
static GLint location;

static void setup(app *a)
{
    (void)a;
    const shader_source stages[] = {{GL_VERTEX_SHADER, vertex}, {GL_FRAGMENT_SHADER, fragment}};
    program = program_build(stages, 2);
    location = glGetUniformLocation(program, "mvp");
    cube = mesh_cube();
}

static void draw(app *a)
{
    app_clear();
    glUseProgram(program);
    matrix4 mvp = matrix_multiply(a->projection, a->modelview);
    glUniformMatrix4fv(location, 1, GL_FALSE, mvp.m);
    glUniform2f(glGetUniformLocation(program, "size"), (float)a->window.width, (float)a->window.height);
    mesh_bind(&cube);
    glDrawRangeElements(GL_TRIANGLES, 0, CUBE_CORNERS - 1, CUBE_INDICES, GL_UNSIGNED_SHORT, 0);
}

int main(int argc, char **argv)
{
    static const app_program self = {"gles3", API_GLES, 3, 0, setup, draw, NULL};
    return app_main(argc, argv, &self);
}
