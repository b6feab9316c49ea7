#include "product.h"

#include "shader.h"

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

static GLuint program;
static GLint location;

void product_program(void)
{
    const shader_source stages[] = {{GL_VERTEX_SHADER, vertex}, {GL_FRAGMENT_SHADER, shader_shade}};
    program = program_build(stages, 2);
    location = glGetUniformLocation(program, "MVP");
}

void product_matrices(const app *a)
{
    const matrix4 together = matrix_multiply(a->projection, a->modelview);
    glUseProgram(program);
    glUniformMatrix4fv(location, 1, GL_FALSE, together.m);
}
