/* An off-screen target of a program: colour and depth, shown in the window by a copy. */
#ifndef APPS_TARGET_H
#define APPS_TARGET_H

#include "gl.h"

typedef struct {
    GLuint framebuffer, colour, depth;
    GLuint program, quad; /* GLES 2 has no blit, so that a quad is drawn */
    int width, height;
} target;

target target_create(int width, int height);
void target_bind(const target *t);

/* Copies the target to framebuffer 0, which stays bound. */
void target_present(const target *t);

#endif
