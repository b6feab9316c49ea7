#include "forms.h"

#include "program.h"
#include "shader.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

const void *form_of(const app *a, const void *forms, size_t size, size_t count)
{
    if (a->mode == NULL)
        return forms;
    for (const char *form = forms; count > 0; form += size, count--) {
        const char *name;
        memcpy(&name, form, sizeof name);
        if (strcmp(name, a->mode) == 0)
            return form;
    }
    fprintf(stderr, "there is no form %s\n", a->mode);
    exit(2);
}

GLuint form_program(const char *vertex)
{
    const shader_source stages[] = {{GL_VERTEX_SHADER, vertex}, {GL_FRAGMENT_SHADER, shader_shade}};
    return program_build(stages, 2);
}

void form_block(GLuint program)
{
    const GLuint block = glGetUniformBlockIndex(program, "B");
    if (block == GL_INVALID_INDEX)
        return;
    GLuint buffer;
    glUniformBlockBinding(program, block, 2);
    glGenBuffers(1, &buffer);
    glBindBufferBase(GL_UNIFORM_BUFFER, 2, buffer);
}
