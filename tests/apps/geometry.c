/*
 * Direction test whose last stage before rasterisation is a geometry shader, which projects. With
 * `--mode shared` the vertex shader is also the last such stage of another program. That program is
 * linked before this one is linked again.
 */
#include "common/app.h"
#include "common/mesh.h"
#include "common/shader.h"

#include <string.h>

static const char vertex[] =
    "#version 330 core\n"
    "layout(location = 0) in vec3 position;\n"
    "uniform mat4 MV;\n"
    "out vec3 corner;\n"
    "void main() {\n"
    "    corner = position;\n"
    "    gl_Position = MV * vec4(position, 1.0);\n"
    "}\n";
/* Splits each triangle at its centre. No side is split: a vertex within a neighbour's side would leave gaps. */
static const char geometry[] =
    "#version 330 core\n"
    "layout(triangles) in;\n"
    "layout(triangle_strip, max_vertices = 9) out;\n"
    "uniform mat4 P;\n"
    "in vec3 corner[];\n"
    "out vec3 shade;\n"
    "void emit(vec3 place, vec4 eye) {\n"
    "    shade = 0.5 + 0.5 * place;\n"
    "    gl_Position = P * eye;\n"
    "    EmitVertex();\n"
    "}\n"
    "void main() {\n"
    "    vec3 centre = (corner[0] + corner[1] + corner[2]) / 3.0;\n"
    "    vec4 eye = (gl_in[0].gl_Position + gl_in[1].gl_Position + gl_in[2].gl_Position) / 3.0;\n"
    "    for (int i = 0; i < 3; i++) {\n"
    "        int next = i == 2 ? 0 : i + 1;\n"
    "        emit(corner[i], gl_in[i].gl_Position);\n"
    "        emit(corner[next], gl_in[next].gl_Position);\n"
    "        emit(centre, eye);\n"
    "        EndPrimitive();\n"
    "    }\n"
    "}\n";

static mesh cube;
static shader_pair pair;

static void link_again(app *a)
{
    GLuint shaders[3];
    GLsizei count = 0;
    const GLuint other = glCreateProgram();
    glGetAttachedShaders(pair.program, 3, &count, shaders);
    for (GLsizei i = 0; i < count; i++) {
        GLint kind = 0;
        glGetShaderiv(shaders[i], GL_SHADER_TYPE, &kind);
        if (kind == GL_VERTEX_SHADER)
            glAttachShader(other, shaders[i]);
    }
    glLinkProgram(other);
    glLinkProgram(pair.program);
    app_check(a, count == 3, "%d shaders are attached", count);
    pair.projection = glGetUniformLocation(pair.program, "P");
    pair.modelview = glGetUniformLocation(pair.program, "MV");
}

static void setup(app *a)
{
    const shader_source stages[] = {
        {GL_VERTEX_SHADER, vertex}, {GL_GEOMETRY_SHADER, geometry}, {GL_FRAGMENT_SHADER, shader_shade}};
    pair = shader_pair_build(stages, 3, "P", "MV");
    if (a->mode != NULL && strcmp(a->mode, "shared") == 0)
        link_again(a);
    cube = mesh_cube();
}

static void draw(app *a)
{
    app_clear();
    shader_pair_use(&pair, a);
    mesh_bind(&cube);
    glDrawElements(GL_TRIANGLES, CUBE_INDICES, GL_UNSIGNED_SHORT, NULL);
}

int main(int argc, char **argv)
{
    static const app_program self = {"geometry", API_GL_CORE, 3, 3, setup, draw, NULL};
    return app_main(argc, argv, &self);
}
