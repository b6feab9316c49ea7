/* Text as old programs draw it: glRasterPos and glBitmap, and glDrawPixels, over the cube. */
#include "common/fixed.h"

#include <math.h>
#include <stdlib.h>

/* A letter "T", 8 x 8, rows from the bottom. */
static const GLubyte letter[8] = {0x18, 0x18, 0x18, 0x18, 0x18, 0x18, 0xff, 0xff};

static void check_pixel(app *a, const image *picture, int x, int y_up, int r, int g, int b)
{
    const unsigned char *rgb = image_at(picture, x, picture->height - 1 - y_up);
    app_check(a, abs(rgb[0] - r) <= 1 && abs(rgb[1] - g) <= 1 && abs(rgb[2] - b) <= 1,
              "pixel (%d, %d from the bottom) is %d %d %d instead of %d %d %d", x, y_up, rgb[0], rgb[1], rgb[2], r, g,
              b);
}

static void draw(app *a)
{
    fixed_cube(a);
    fixed_begin_pixels(a);
    glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
    glColor3f(1, 1, 1);
    glRasterPos2i(20, 30);
    GLfloat place[4];
    GLboolean valid = GL_FALSE;
    glGetFloatv(GL_CURRENT_RASTER_POSITION, place);
    glGetBooleanv(GL_CURRENT_RASTER_POSITION_VALID, &valid);
    app_check(a, valid && fabsf(place[0] - 20) < 0.01f && fabsf(place[1] - 30) < 0.01f,
              "the raster position is %g %g instead of 20 30", (double)place[0], (double)place[1]);
    for (int i = 0; i < 3; i++)
        glBitmap(8, 8, 0, 0, 10, 0, letter);
    glGetFloatv(GL_CURRENT_RASTER_POSITION, place);
    app_check(a, fabsf(place[0] - 50) < 0.01f, "three letters move the raster position to %g instead of 50",
              (double)place[0]);

    static const GLubyte pixels[2 * 2 * 3] = {255, 0, 0, 0, 255, 0, 0, 0, 255, 255, 255, 0};
    glRasterPos2i(100, 30);
    glPixelZoom(4, 4);
    glDrawPixels(2, 2, GL_RGB, GL_UNSIGNED_BYTE, pixels);
    glPixelZoom(1, 1);
    fixed_end_pixels();

    /* A label at a place of the scene: its raster position is projected. */
    glLoadIdentity();
    glRasterPos3f(0, 0, -5);
    glGetFloatv(GL_CURRENT_RASTER_POSITION, place);
    app_check(a, fabsf(place[0] - 0.5f * (float)a->window.width) < 0.01f &&
                     fabsf(place[1] - 0.5f * (float)a->window.height) < 0.01f,
              "a label straight ahead is at %g %g", (double)place[0], (double)place[1]);
    glBitmap(8, 8, 4, 4, 0, 0, letter);

    if (app_is_first_read(a))
        return;
    image picture = image_read_framebuffer(a->window.width, a->window.height);
    for (int i = 0; i < 3; i++) {
        check_pixel(a, &picture, 20 + 10 * i, 37, 255, 255, 255);
        check_pixel(a, &picture, 23 + 10 * i, 30, 255, 255, 255);
    }
    check_pixel(a, &picture, 101, 31, 255, 0, 0);
    check_pixel(a, &picture, 106, 31, 0, 255, 0);
    check_pixel(a, &picture, 101, 36, 0, 0, 255);
    check_pixel(a, &picture, 106, 36, 255, 255, 0);
    image_free(&picture);
}

int main(int argc, char **argv)
{
    static const app_program self = {"text", API_GL_COMPATIBILITY, 0, 0, NULL, draw, NULL};
    return app_main(argc, argv, &self);
}
