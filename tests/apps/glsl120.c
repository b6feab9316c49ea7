/*
 * Direction test in GLSL 120 with the built-in matrices: half of the cube by ftransform(), half by
 * gl_ModelViewProjectionMatrix. The matrices come from glMatrixMode.
 */
#include "common/app.h"
#include "common/mesh.h"
#include "common/program.h"

static const char with_ftransform[] =
    "#version 120\n"
    "void main() {\n"
    "    gl_FrontColor = vec4(0.5 + 0.5 * gl_Vertex.xyz, 1.0);\n"
    "    gl_BackColor = gl_FrontColor;\n"
    "    gl_Position = ftransform();\n"
    "}\n";
static const char with_matrix[] =
    "#version 120\n"
    "attribute vec3 position;\n"
    "varying vec3 shade;\n"
    "void main() {\n"
    "    shade = 0.5 + 0.5 * position;\n"
    "    gl_Position = gl_ModelViewProjectionMatrix * vec4(position, 1.0);\n"
    "}\n";
static const char plain_fragment[] = "#version 120\nvoid main() { gl_FragColor = gl_Color; }\n";
static const char shade_fragment[] =
    "#version 120\nvarying vec3 shade;\nvoid main() { gl_FragColor = vec4(shade, 1.0); }\n";

static mesh cube;
static GLuint first, second;

static void setup(app *a)
{
    (void)a;
    const shader_source a_stages[] = {{GL_VERTEX_SHADER, with_ftransform}, {GL_FRAGMENT_SHADER, plain_fragment}};
    const shader_source b_stages[] = {{GL_VERTEX_SHADER, with_matrix}, {GL_FRAGMENT_SHADER, shade_fragment}};
    first = program_build(a_stages, 2);
    second = program_build(b_stages, 2);
    cube = mesh_cube();
}

static void draw(app *a)
{
    app_clear();
    glMatrixMode(GL_PROJECTION);
    glLoadMatrixf(a->projection.m);
    glMatrixMode(GL_MODELVIEW);
    glLoadMatrixf(a->modelview.m);
    mesh_bind(&cube);
    glUseProgram(first);
    glDrawElements(GL_TRIANGLES, 18, GL_UNSIGNED_SHORT, NULL);
    glUseProgram(second);
    glDrawElements(GL_TRIANGLES, 18, GL_UNSIGNED_SHORT, (const char *)NULL + 18 * sizeof cube_indices[0]);
    glUseProgram(0);
}

int main(int argc, char **argv)
{
    static const app_program program = {"glsl120", API_GL_COMPATIBILITY, 0, 0, setup, draw, NULL};
    return app_main(argc, argv, &program);
}
