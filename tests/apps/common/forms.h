/* Programs of a direction test in several forms, of which `--mode` names one. */
#ifndef APPS_FORMS_H
#define APPS_FORMS_H

#include "app.h"
#include "gl.h"

/* The form of this name, the first one where none is named, among `count` of `size` bytes, which begin with their name. Ends the
 * program where there is none. */
const void *form_of(const app *a, const void *forms, size_t size, size_t count);

/* A program of a vertex shader with an output `shade`, which is the colour. */
GLuint form_program(const char *vertex);

/* Gives the uniform block `B`, if the program has it, a buffer, and binds that. */
void form_block(GLuint program);

#endif
