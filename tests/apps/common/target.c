#include "target.h"

#include "program.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#if defined(APP_GLES) && APP_GLES == 2
#define COLOUR_FORMAT GL_RGB
#define DEPTH_FORMAT GL_DEPTH_COMPONENT16
static const char quad_vertex[] = "attribute vec2 position; varying vec2 place;\n"
                                  "void main() { place = 0.5 + 0.5 * position; gl_Position = vec4(position, 0.0, 1.0); }\n";
static const char quad_fragment[] = "precision highp float; uniform sampler2D picture; varying vec2 place;\n"
                                    "void main() { gl_FragColor = texture2D(picture, place); }\n";
#else
#define COLOUR_FORMAT GL_RGB8
#define DEPTH_FORMAT GL_DEPTH_COMPONENT24
#endif

target target_create(int width, int height)
{
    target t;
    memset(&t, 0, sizeof t);
    t.width = width;
    t.height = height;
    glGenTextures(1, &t.colour);
    glBindTexture(GL_TEXTURE_2D, t.colour);
    glTexImage2D(GL_TEXTURE_2D, 0, COLOUR_FORMAT, width, height, 0, GL_RGB, GL_UNSIGNED_BYTE, NULL);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
    glBindTexture(GL_TEXTURE_2D, 0);
    glGenRenderbuffers(1, &t.depth);
    glBindRenderbuffer(GL_RENDERBUFFER, t.depth);
    glRenderbufferStorage(GL_RENDERBUFFER, DEPTH_FORMAT, width, height);
    glGenFramebuffers(1, &t.framebuffer);
    glBindFramebuffer(GL_FRAMEBUFFER, t.framebuffer);
    glFramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, t.colour, 0);
    glFramebufferRenderbuffer(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, GL_RENDERBUFFER, t.depth);
    GLenum status = glCheckFramebufferStatus(GL_FRAMEBUFFER);
    if (status != GL_FRAMEBUFFER_COMPLETE) {
        fprintf(stderr, "the program's own framebuffer is incomplete: 0x%x\n", status);
        exit(1);
    }
    glBindFramebuffer(GL_FRAMEBUFFER, 0);
#if defined(APP_GLES) && APP_GLES == 2
    static const float corners[8] = {-1, -1, 1, -1, -1, 1, 1, 1};
    const shader_source stages[] = {{GL_VERTEX_SHADER, quad_vertex}, {GL_FRAGMENT_SHADER, quad_fragment}};
    t.program = program_build(stages, 2);
    GLint bound = 0;
    glGetIntegerv(GL_ARRAY_BUFFER_BINDING, &bound);
    glGenBuffers(1, &t.quad);
    glBindBuffer(GL_ARRAY_BUFFER, t.quad);
    glBufferData(GL_ARRAY_BUFFER, sizeof corners, corners, GL_STATIC_DRAW);
    glBindBuffer(GL_ARRAY_BUFFER, (GLuint)bound);
#endif
    return t;
}

void target_bind(const target *t)
{
    glBindFramebuffer(GL_FRAMEBUFFER, t->framebuffer);
}

void target_present(const target *t)
{
#if defined(APP_GLES) && APP_GLES == 2
    /*
     * The programs bind their own buffers and pointers in each frame, so only these bindings are
     * restored.
     */
    glBindFramebuffer(GL_FRAMEBUFFER, 0);
    glDisable(GL_DEPTH_TEST);
    glUseProgram(t->program);
    glBindTexture(GL_TEXTURE_2D, t->colour);
    glBindBuffer(GL_ARRAY_BUFFER, t->quad);
    glEnableVertexAttribArray(0);
    glVertexAttribPointer(0, 2, GL_FLOAT, GL_FALSE, 0, NULL);
    glDrawArrays(GL_TRIANGLE_STRIP, 0, 4);
    glBindTexture(GL_TEXTURE_2D, 0);
#else
    glBindFramebuffer(GL_READ_FRAMEBUFFER, t->framebuffer);
    glBindFramebuffer(GL_DRAW_FRAMEBUFFER, 0);
    glBlitFramebuffer(0, 0, t->width, t->height, 0, 0, t->width, t->height, GL_COLOR_BUFFER_BIT, GL_NEAREST);
    glBindFramebuffer(GL_FRAMEBUFFER, 0);
#endif
}
