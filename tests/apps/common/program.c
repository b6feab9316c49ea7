#include "program.h"

#include <stdio.h>
#include <stdlib.h>

GLuint program_build(const shader_source *stages, int count)
{
    char log[2048] = "";
    GLuint program = glCreateProgram();
    for (int i = 0; i < count; i++) {
        GLint good = 0;
        GLuint shader = glCreateShader(stages[i].stage);
        glShaderSource(shader, 1, &stages[i].source, NULL);
        glCompileShader(shader);
        glGetShaderiv(shader, GL_COMPILE_STATUS, &good);
        if (!good) {
            glGetShaderInfoLog(shader, (GLsizei)sizeof log, NULL, log);
            fprintf(stderr, "shader %d does not compile:\n%s\n%s\n", i, log, stages[i].source);
            exit(1);
        }
        glAttachShader(program, shader);
        glDeleteShader(shader);
    }
    glBindAttribLocation(program, 0, "position");
    glBindAttribLocation(program, 1, "colour");
    glLinkProgram(program);
    GLint good = 0;
    glGetProgramiv(program, GL_LINK_STATUS, &good);
    if (!good) {
        glGetProgramInfoLog(program, (GLsizei)sizeof log, NULL, log);
        fprintf(stderr, "program does not link:\n%s\n", log);
        exit(1);
    }
    return program;
}
