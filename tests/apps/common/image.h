/* Pictures: 8-bit RGB, row 0 at the top. */
#ifndef APPS_IMAGE_H
#define APPS_IMAGE_H

#include <stdbool.h>

typedef struct {
    int width, height;
    unsigned char *rgb;
} image;

/* A black picture. Ends the program if there is no memory. */
image image_new(int width, int height);

void image_free(image *picture);

/* Pixel at column x, row y from the top. */
const unsigned char *image_at(const image *picture, int x, int y);

/* Reads the read framebuffer of the current context by glReadPixels. */
image image_read_framebuffer(int width, int height);

/*
 * Writes a binary PPM file under a temporary name and renames it, so that a reader never sees a
 * part of the file.
 */
bool image_write_ppm(const image *picture, const char *path);

#endif
