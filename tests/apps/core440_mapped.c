/*
 * Direction test in a core 4.4 context with the matrices in a uniform block. The buffer stays
 * mapped, so that after the first frame no call shows that the matrices change.
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
    "    mat4 projection;\n"
    "    mat4 modelview;\n"
    "};\n"
    "out vec3 shade;\n"
    "void main() {\n"
    "    shade = colour;\n"
    "    gl_Position = projection * (modelview * vec4(position, 1.0));\n"
    "}\n";

static mesh cube;
static float *block;

static void setup(app *a)
{
    (void)a;
    const shader_source stages[] = {{GL_VERTEX_SHADER, vertex}, {GL_FRAGMENT_SHADER, shader_shade}};
    const GLbitfield flags = GL_MAP_WRITE_BIT | GL_MAP_PERSISTENT_BIT | GL_MAP_COHERENT_BIT;
    enum { SIZE = 32 * sizeof(float) };
    GLuint program = program_build(stages, 2), buffer;
    glUseProgram(program);
    glUniformBlockBinding(program, glGetUniformBlockIndex(program, "Camera"), 2);
    glGenBuffers(1, &buffer);
    glBindBuffer(GL_UNIFORM_BUFFER, buffer);
    glBufferStorage(GL_UNIFORM_BUFFER, SIZE, NULL, flags);
    glBindBufferBase(GL_UNIFORM_BUFFER, 2, buffer);
    block = glMapBufferRange(GL_UNIFORM_BUFFER, 0, SIZE, flags);
    cube = mesh_cube();
}

static void draw(app *a)
{
    /* The first frame has another lens than the frames that are checked. */
    double aspect = (double)a->window.width / a->window.height;
    matrix4 first = matrix_perspective(0.6 * a->fov, aspect, a->near, a->far);
    app_clear();
    app_check(a, block != NULL, "the buffer is not mapped");
    if (block == NULL)
        return;
    glFinish();
    memcpy(block, a->frame == 0 ? first.m : a->projection.m, sizeof first.m);
    memcpy(block + 16, a->modelview.m, sizeof a->modelview.m);
    mesh_bind(&cube);
    glDrawElements(GL_TRIANGLES, CUBE_INDICES, GL_UNSIGNED_SHORT, NULL);
}

int main(int argc, char **argv)
{
    static const app_program self = {"core440_mapped", API_GL_CORE, 4, 4, setup, draw, NULL};
    return app_main(argc, argv, &self);
}
