/*
 * Many small boxes in all directions. --mode culled: boxes beside the program's own picture are
 * left out, as many programs do. --mode asked: boxes beside the planes of the matrices that OpenGL
 * returns are left out. --mode ahead: there are only boxes in the middle of the picture.
 */
#include "common/fixed.h"

#include <math.h>
#include <string.h>

enum { BOXES = 400 };

static bool is(const app *a, const char *mode)
{
    return a->mode != NULL && strcmp(a->mode, mode) == 0;
}

/* Whether a part of a ball of radius 1 is in the picture. */
static bool is_seen(const app *a, const float centre[3])
{
    const matrix4 m = matrix_multiply(a->projection, a->modelview);
    float clip[4];
    for (int row = 0; row < 4; row++)
        clip[row] = m.m[row] * centre[0] + m.m[4 + row] * centre[1] + m.m[8 + row] * centre[2] + m.m[12 + row];
    const float across = clip[3] + 1.0f * (1.0f + a->projection.m[0]), up = clip[3] + 1.0f * (1.0f + a->projection.m[5]);
    return clip[3] > -1.0f && fabsf(clip[0]) < across && fabsf(clip[1]) < up;
}

/*
 * Whether a part of a ball of radius 1 is between the six planes of the matrices that OpenGL
 * returns.
 */
static bool is_between_planes(const float centre[3])
{
    matrix4 projection, modelview;
    glGetFloatv(GL_PROJECTION_MATRIX, projection.m);
    glGetFloatv(GL_MODELVIEW_MATRIX, modelview.m);
    const matrix4 m = matrix_multiply(projection, modelview);
    for (int plane = 0; plane < 6; plane++) {
        const float sign = plane % 2 == 0 ? 1.0f : -1.0f;
        float p[4];
        for (int column = 0; column < 4; column++)
            p[column] = m.m[4 * column + 3] + sign * m.m[4 * column + plane / 2];
        const float length = sqrtf(p[0] * p[0] + p[1] * p[1] + p[2] * p[2]);
        if (p[0] * centre[0] + p[1] * centre[1] + p[2] * centre[2] + p[3] < -length)
            return false;
    }
    return true;
}

static void box(const float centre[3])
{
    glColor3f(0.5f + 0.05f * centre[0], 0.5f + 0.05f * centre[1], 0.5f + 0.05f * centre[2]);
    glBegin(GL_QUADS);
    for (int corner = 0; corner < 4; corner++) {
        const float x = corner == 1 || corner == 2 ? 0.5f : -0.5f, y = corner >= 2 ? 0.5f : -0.5f;
        glVertex3f(centre[0] + x, centre[1] + y, centre[2]);
        glVertex3f(centre[0], centre[1] + x, centre[2] + y);
    }
    glEnd();
}

static void draw(app *a)
{
    app_clear();
    glMatrixMode(GL_PROJECTION);
    glLoadMatrixf(a->projection.m);
    glMatrixMode(GL_MODELVIEW);
    glLoadMatrixf(is(a, "ahead") ? matrix_scale(1).m : a->modelview.m);
    for (int i = 0; i < BOXES; i++) {
        /* Points of a spiral over the sphere. */
        const float up = -1.0f + 2.0f * ((float)i + 0.5f) / BOXES, angle = 2.39996f * (float)i;
        const float across = sqrtf(1.0f - up * up);
        float centre[3] = {9.0f * across * cosf(angle), 9.0f * up, 9.0f * across * sinf(angle)};
        if (is(a, "ahead")) {
            centre[0] *= 0.1f;
            centre[1] *= 0.1f;
            centre[2] = -20.0f;
        }
        const bool seen = is(a, "culled") ? is_seen(a, centre) : !is(a, "asked") || is_between_planes(centre);
        if (seen)
            box(centre);
    }
}

int main(int argc, char **argv)
{
    static const app_program self = {"beside", API_GL_COMPATIBILITY, 0, 0, NULL, draw, NULL};
    return app_main(argc, argv, &self);
}
