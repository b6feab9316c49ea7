/* Direction tests with several forms, of which `--mode` selects one. */
#ifndef APPS_FORMS_H
#define APPS_FORMS_H

#include "app.h"
#include "gl.h"

/*
 * Form of the name in `--mode`, or the first one if none is named. `forms` has `count` forms of
 * `size` bytes, which begin with their name. Ends the program if there is no such form.
 */
const void *form_of(const app *a, const void *forms, size_t size, size_t count);

/* A program with this vertex shader, whose output `shade` is the colour. */
GLuint form_program(const char *vertex);

/* If the program has the uniform block `B`, gives the block a buffer and binds the buffer. */
void form_block(GLuint program);

#endif
