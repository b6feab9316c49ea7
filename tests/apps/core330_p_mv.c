/* Direction test in a core 3.3 context with one uniform for the projection and one for the model-view matrix. */
#include "common/app.h"
#include "common/mesh.h"
#include "common/shader.h"

static const char vertex[] =
    "#version 330 core\n"
    "layout(location = 0) in vec3 position;\n"
    "layout(location = 1) in vec3 colour;\n"
    "uniform mat4 P;\n"
    "uniform mat4 MV;\n"
    "out vec3 shade;\n"
    "void main() {\n"
    "    shade = colour;\n"
    "    vec4 eye = MV * vec4(position, 1.0);\n"
    "    gl_Position = P * eye;\n"
    "}\n";

static mesh cube;
static shader_pair pair;

static void setup(app *a)
{
    (void)a;
    const shader_source stages[] = {{GL_VERTEX_SHADER, vertex}, {GL_FRAGMENT_SHADER, shader_shade}};
    pair = shader_pair_build(stages, 2, "P", "MV");
    cube = mesh_cube();
}

static void draw(app *a)
{
    app_clear();
    shader_pair_use(&pair, a);
    mesh_bind(&cube);
    glDrawElements(GL_TRIANGLES, CUBE_INDICES, GL_UNSIGNED_SHORT, NULL);

    GLfloat value[16];
    GLint bound = 0;
    glGetUniformfv(pair.program, pair.projection, value);
    glGetIntegerv(GL_CURRENT_PROGRAM, &bound);
    app_check(a, value[0] == a->projection.m[0], "glGetUniform does not return the projection that was set");
    app_check(a, (GLuint)bound == pair.program, "GL_CURRENT_PROGRAM is %d instead of %u", bound, pair.program);
}

int main(int argc, char **argv)
{
    static const app_program self = {"core330_p_mv", API_GL_CORE, 3, 3, setup, draw, NULL};
    return app_main(argc, argv, &self);
}
