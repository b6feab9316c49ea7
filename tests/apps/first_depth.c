/*
 * The very first read asks for depth and stencil. It must get those of the picture and not of an
 * empty window. With the mode "partial" up to a fifth of the pixels may be those of an empty
 * window, in depth and stencil, because no view shows them.
 */
#include "common/fixed.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { LABEL = 5 };

/*
 * Distance of the cube's wall along the camera's axis, in the direction of a pixel (from the bottom
 * left).
 */
static double expected_distance(const app *a, int x, int y)
{
    double right = (2.0 * (x + 0.5) / a->window.width - 1.0) / a->projection.m[0];
    double up = (2.0 * (y + 0.5) / a->window.height - 1.0) / a->projection.m[5];
    double greatest = 0.0;
    for (int axis = 0; axis < 3; axis++) {
        /* The cube's axes are the columns of the camera's rotation. */
        const float *column = a->view.m + 4 * axis;
        greatest = fmax(greatest, fabs(right * column[0] + up * column[1] - column[2]));
    }
    return CUBE_SCALE / greatest;
}

static void draw(app *a)
{
    glClear(GL_STENCIL_BUFFER_BIT);
    glEnable(GL_STENCIL_TEST);
    glStencilFunc(GL_ALWAYS, LABEL, 0xff);
    glStencilOp(GL_KEEP, GL_KEEP, GL_REPLACE);
    fixed_cube(a);
    glDisable(GL_STENCIL_TEST);
    if (a->frame < 2)
        return;
    size_t width = (size_t)a->window.width, pixels = width * (size_t)a->window.height;
    GLfloat *depth = malloc(pixels * sizeof *depth);
    GLubyte *stencil = malloc(pixels);
    if (depth == NULL || stencil == NULL)
        abort();
    glReadPixels(0, 0, a->window.width, a->window.height, GL_DEPTH_COMPONENT, GL_FLOAT, depth);
    glPixelStorei(GL_PACK_ALIGNMENT, 1);
    glReadPixels(0, 0, a->window.width, a->window.height, GL_STENCIL_INDEX, GL_UNSIGNED_BYTE, stencil);
    glPixelStorei(GL_PACK_ALIGNMENT, 4);
    int wrong = 0, unlabelled = 0, empty = 0;
    double worst = 0.0;
    for (size_t i = 0; i < pixels; i++) {
        if (depth[i] == 1.0f && stencil[i] == 0) {
            empty++;
            continue;
        }
        double clip = 2.0 * depth[i] - 1.0;
        double distance = 2.0 * a->far * a->near / (a->far + a->near - clip * (a->far - a->near));
        double error = fabs(distance / expected_distance(a, (int)(i % width), (int)(i / width)) - 1.0);
        worst = fmax(worst, error);
        /* A texel of a view may be half a pixel aside, and the wall may be oblique there. */
        wrong += error > 0.02;
        unlabelled += stencil[i] != LABEL;
    }
    app_check(a, wrong == 0, "frame %d: %d of %zu depths are wrong, the worst distance by %.1f %%", a->frame, wrong,
              pixels, 100.0 * worst);
    app_check(a, unlabelled == 0, "frame %d: %d of %zu stencil values are wrong", a->frame, unlabelled, pixels);
    size_t most = a->mode != NULL && strcmp(a->mode, "partial") == 0 && a->frame == 2 ? pixels / 5 : 0;
    app_check(a, (size_t)empty <= most, "frame %d: %d of %zu pixels are empty", a->frame, empty, pixels);
    free(depth);
    free(stencil);
    app_check_error(a, "after the reads");
}

int main(int argc, char **argv)
{
    static const app_program self = {"first_depth", API_GL_COMPATIBILITY, 0, 0, NULL, draw, NULL};
    return app_main(argc, argv, &self);
}
