#include "image.h"

#include "gl.h"

#include <stdio.h>
#include <stdlib.h>

image image_new(int width, int height)
{
    image picture = {width, height, calloc((size_t)width * (size_t)height, 3)};
    if (picture.rgb == NULL) {
        fprintf(stderr, "out of memory\n");
        exit(1);
    }
    return picture;
}

void image_free(image *picture)
{
    free(picture->rgb);
    picture->rgb = NULL;
}

const unsigned char *image_at(const image *picture, int x, int y)
{
    return picture->rgb + 3 * ((size_t)y * (size_t)picture->width + (size_t)x);
}

image image_read_framebuffer(int width, int height)
{
    image picture = image_new(width, height);
    unsigned char *rgba = calloc((size_t)width * (size_t)height, 4);
    if (rgba == NULL) {
        fprintf(stderr, "out of memory\n");
        exit(1);
    }
    glPixelStorei(GL_PACK_ALIGNMENT, 4);
    glReadPixels(0, 0, width, height, GL_RGBA, GL_UNSIGNED_BYTE, rgba);
    for (int y = 0; y < height; y++) {
        const unsigned char *from = rgba + 4 * (size_t)(height - 1 - y) * (size_t)width;
        unsigned char *to = picture.rgb + 3 * (size_t)y * (size_t)width;
        for (int x = 0; x < width; x++) {
            to[3 * x + 0] = from[4 * x + 0];
            to[3 * x + 1] = from[4 * x + 1];
            to[3 * x + 2] = from[4 * x + 2];
        }
    }
    free(rgba);
    return picture;
}

bool image_write_ppm(const image *picture, const char *path)
{
    char temporary[4096];
    if (snprintf(temporary, sizeof temporary, "%s.part", path) >= (int)sizeof temporary)
        return false;
    FILE *file = fopen(temporary, "wb");
    if (file == NULL) {
        perror(temporary);
        return false;
    }
    size_t count = 3 * (size_t)picture->width * (size_t)picture->height;
    bool good = fprintf(file, "P6\n%d %d\n255\n", picture->width, picture->height) > 0 &&
                fwrite(picture->rgb, 1, count, file) == count;
    good = fclose(file) == 0 && good;
    return good && rename(temporary, path) == 0;
}
