/*
 * Clears parts of the window with the scissor, then draws the cube in a viewport of the left half
 * only.
 */
#include "common/fixed.h"

#include <stdlib.h>

static void check_pixel(app *a, const image *picture, int x, int y, int r, int g, int b)
{
    const unsigned char *rgb = image_at(picture, x, y);
    app_check(a, abs(rgb[0] - r) <= 1 && abs(rgb[1] - g) <= 1 && abs(rgb[2] - b) <= 1,
              "pixel (%d, %d) is %d %d %d instead of %d %d %d", x, y, rgb[0], rgb[1], rgb[2], r, g, b);
}

static void draw(app *a)
{
    int width = a->window.width, height = a->window.height;
    app_clear();
    glEnable(GL_SCISSOR_TEST);
    glScissor(width / 2, 0, width / 2, height / 2);
    glClearColor(1, 0, 0, 1);
    glClear(GL_COLOR_BUFFER_BIT);
    glScissor(width / 2, height / 2, width / 2, height / 2);
    glClearColor(0, 0, 1, 1);
    glClear(GL_COLOR_BUFFER_BIT);
    glScissor(width / 2 + 10, height / 2 + 10, 20, 30);
    static const float green[4] = {0, 1, 0, 1};
    glClearBufferfv(GL_COLOR, 0, green);
    glDisable(GL_SCISSOR_TEST);
    GLint box[4];
    glGetIntegerv(GL_SCISSOR_BOX, box);
    app_check(a, box[0] == width / 2 + 10 && box[1] == height / 2 + 10 && box[2] == 20 && box[3] == 30,
              "GL_SCISSOR_BOX is %d %d %d %d", box[0], box[1], box[2], box[3]);

    glViewport(0, 0, width / 2, height);
    GLint viewport[4];
    glGetIntegerv(GL_VIEWPORT, viewport);
    app_check(a, viewport[0] == 0 && viewport[1] == 0 && viewport[2] == width / 2 && viewport[3] == height,
              "GL_VIEWPORT is %d %d %d %d", viewport[0], viewport[1], viewport[2], viewport[3]);
    app half = *a;
    half.complaints = 0;
    half.window.width = width / 2;
    app_update_matrices(&half);
    glMatrixMode(GL_PROJECTION);
    glLoadMatrixf(half.projection.m);
    glMatrixMode(GL_MODELVIEW);
    glLoadMatrixf(half.modelview.m);
    glBegin(GL_TRIANGLES);
    for (int i = 0; i < CUBE_INDICES; i++) {
        glColor3fv(cube_colours[cube_indices[i]]);
        glVertex3fv(cube_positions[cube_indices[i]]);
    }
    glEnd();
    glViewport(0, 0, width, height);

    if (app_is_first_read(a))
        return;
    image picture = image_read_framebuffer(width, height);
    check_pixel(a, &picture, width * 3 / 4, height * 3 / 4, 255, 0, 0);
    check_pixel(a, &picture, width * 3 / 4, height / 4, 0, 0, 255);
    check_pixel(a, &picture, width / 2 + 15, height / 2 - 15, 0, 255, 0);
    check_pixel(a, &picture, width - 1, height - 1, 255, 0, 0);
    check_pixel(a, &picture, width - 1, 0, 0, 0, 255);
    image_free(&picture);
    picture = image_read_framebuffer(width / 2, height);
    app_check_cube_picture(&half, &picture, "left half");
    image_free(&picture);
    a->complaints += half.complaints;
}

int main(int argc, char **argv)
{
    static const app_program self = {"scissor", API_GL_COMPATIBILITY, 0, 0, NULL, draw, NULL};
    return app_main(argc, argv, &self);
}
