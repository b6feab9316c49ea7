/*
 * Direction test in a core 3.3 context with the matrices in a std140 uniform block. The blocks of
 * several draws are in one buffer, and glBindBufferRange selects one.
 */
#include "common/app.h"
#include "common/mesh.h"
#include "common/shader.h"

#include <string.h>

static const char vertex[] =
    "#version 330 core\n"
    "layout(location = 0) in vec3 position;\n"
    "layout(location = 1) in vec3 colour;\n"
    "layout(std140) uniform Camera {\n"
    "    vec4 tint;\n"
    "    mat4 projection;\n"
    "    mat4 modelview;\n"
    "};\n"
    "out vec3 shade;\n"
    "void main() {\n"
    "    shade = colour * tint.rgb;\n"
    "    gl_Position = projection * (modelview * vec4(position, 1.0));\n"
    "}\n";

enum { BLOCK_FLOATS = 4 + 16 + 16, BINDING = 3 };

static mesh cube;
static GLuint program, buffer;
static GLint stride;

static void setup(app *a)
{
    (void)a;
    const shader_source stages[] = {{GL_VERTEX_SHADER, vertex}, {GL_FRAGMENT_SHADER, shader_shade}};
    program = program_build(stages, 2);
    glUniformBlockBinding(program, glGetUniformBlockIndex(program, "Camera"), BINDING);
    GLint alignment = 256;
    glGetIntegerv(GL_UNIFORM_BUFFER_OFFSET_ALIGNMENT, &alignment);
    int size = BLOCK_FLOATS * (int)sizeof(float);
    stride = (size + alignment - 1) / alignment * alignment;
    glGenBuffers(1, &buffer);
    glBindBuffer(GL_UNIFORM_BUFFER, buffer);
    glBufferData(GL_UNIFORM_BUFFER, 2 * stride, NULL, GL_DYNAMIC_DRAW);
    cube = mesh_cube();
}

static void draw(app *a)
{
    app_clear();
    float block[BLOCK_FLOATS] = {1, 1, 1, 1};
    memcpy(block + 4, a->projection.m, sizeof a->projection.m);
    memcpy(block + 20, a->modelview.m, sizeof a->modelview.m);
    glBindBuffer(GL_UNIFORM_BUFFER, buffer);
    glBufferSubData(GL_UNIFORM_BUFFER, 0, sizeof block, block);
    glBufferSubData(GL_UNIFORM_BUFFER, stride, sizeof block, block);
    glUseProgram(program);
    mesh_bind(&cube);
    for (int half = 0; half < 2; half++) {
        glBindBufferRange(GL_UNIFORM_BUFFER, BINDING, buffer, half * stride, sizeof block);
        glDrawElements(GL_TRIANGLES, 18, GL_UNSIGNED_SHORT,
                       (const char *)NULL + (size_t)half * 18 * sizeof cube_indices[0]);
    }
}

int main(int argc, char **argv)
{
    static const app_program self = {"core330_block", API_GL_CORE, 3, 3, setup, draw, NULL};
    return app_main(argc, argv, &self);
}
