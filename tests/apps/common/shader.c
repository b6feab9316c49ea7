#include "shader.h"

const char shader_shade[] =
    "#version 330 core\nin vec3 shade;\nout vec4 result;\nvoid main() { result = vec4(shade, 1.0); }\n";

shader_pair shader_pair_build(const shader_source *stages, int count, const char *projection, const char *modelview)
{
    const GLuint program = program_build(stages, count);
    return (shader_pair){program, glGetUniformLocation(program, projection), glGetUniformLocation(program, modelview)};
}

void shader_pair_use(const shader_pair *pair, const app *a)
{
    glUseProgram(pair->program);
    glUniformMatrix4fv(pair->projection, 1, GL_FALSE, a->projection.m);
    glUniformMatrix4fv(pair->modelview, 1, GL_FALSE, a->modelview.m);
}
