/* Direction test in a core 3.3 context by a shader that has no matrix: it computes its own lens and camera. */
#include "common/app.h"
#include "common/mesh.h"
#include "common/shader.h"

static const char vertex[] =
    "#version 330 core\n"
    "layout(location = 0) in vec3 position;\n"
    "layout(location = 1) in vec3 colour;\n"
    "uniform vec3 axes[3];\n"
    "uniform vec4 lens;\n"
    "out vec3 shade;\n"
    "void main() {\n"
    "    shade = colour;\n"
    "    vec3 eye = vec3(dot(axes[0], position), dot(axes[1], position), dot(axes[2], position));\n"
    "    gl_Position = vec4(lens.xy * eye.xy, lens.z * eye.z + lens.w, -eye.z);\n"
    "}\n";

static mesh cube;
static GLuint program;

static void setup(app *a)
{
    (void)a;
    const shader_source stages[] = {{GL_VERTEX_SHADER, vertex}, {GL_FRAGMENT_SHADER, shader_shade}};
    program = program_build(stages, 2);
    cube = mesh_cube();
}

static void draw(app *a)
{
    app_clear();
    glUseProgram(program);
    const float *m = a->modelview.m, *p = a->projection.m;
    const float rows[9] = {m[0], m[4], m[8], m[1], m[5], m[9], m[2], m[6], m[10]};
    glUniform3fv(glGetUniformLocation(program, "axes"), 3, rows);
    glUniform4f(glGetUniformLocation(program, "lens"), p[0], p[5], p[10], p[14]);
    mesh_bind(&cube);
    glDrawElements(GL_TRIANGLES, CUBE_INDICES, GL_UNSIGNED_SHORT, NULL);
}

int main(int argc, char **argv)
{
    static const app_program self = {"no_matrix", API_GL_CORE, 3, 3, setup, draw, NULL};
    return app_main(argc, argv, &self);
}
