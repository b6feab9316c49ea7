/*
 * Direction test in GLES 2 through EGL: ESSL 100, attributes, one matrix for the view and one for
 * the projection. Fragments beside the window are discarded.
 */
#include "common/app.h"
#include "common/mesh.h"
#include "common/shader.h"

static const char vertex[] =
    "attribute vec3 position;\n"
    "attribute vec3 colour;\n"
    "uniform mat4 modelview;\n"
    "uniform mat4 projection;\n"
    "varying vec3 shade;\n"
    "void main() {\n"
    "    shade = colour;\n"
    "    gl_Position = projection * modelview * vec4(position, 1.0);\n"
    "}\n";
static const char fragment[] =
    "precision highp float;\n"
    "varying vec3 shade;\n"
    "uniform vec2 size;\n"
    "void main() {\n"
    "    if (any(greaterThan(gl_FragCoord.xy, size))) discard;\n"
    "    gl_FragColor = vec4(shade, 1.0);\n"
    "}\n";

static mesh cube;
static shader_pair pair;

static void setup(app *a)
{
    (void)a;
    const shader_source stages[] = {{GL_VERTEX_SHADER, vertex}, {GL_FRAGMENT_SHADER, fragment}};
    pair = shader_pair_build(stages, 2, "projection", "modelview");
    cube = mesh_cube();
}

static void draw(app *a)
{
    app_clear();
    shader_pair_use(&pair, a);
    glUniform2f(glGetUniformLocation(pair.program, "size"), (float)a->window.width, (float)a->window.height);
    mesh_bind(&cube);
    glDrawElements(GL_TRIANGLES, CUBE_INDICES, GL_UNSIGNED_SHORT, 0);
}

int main(int argc, char **argv)
{
    static const app_program self = {"gles2", API_GLES, 2, 0, setup, draw, NULL};
    return app_main(argc, argv, &self);
}
