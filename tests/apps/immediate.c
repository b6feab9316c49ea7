/* Direction test in immediate mode with the fixed-function matrices. */
#include "common/app.h"

static void draw(app *a)
{
    app_clear();
    glMatrixMode(GL_PROJECTION);
    glLoadMatrixf(a->projection.m);
    glMatrixMode(GL_MODELVIEW);
    glLoadIdentity();
    glRotated(-a->pitch, 1, 0, 0);
    glRotated(a->yaw, 0, 1, 0);
    glPushMatrix();
    glScaled(CUBE_SCALE, CUBE_SCALE, CUBE_SCALE);
    /*
     * Half of the faces are triangles, the others are quads and a strip, because OpenGL assembles
     * each in another way.
     */
    glBegin(GL_TRIANGLES);
    for (int i = 0; i < 18; i++) {
        glColor3fv(cube_colours[cube_indices[i]]);
        glVertex3fv(cube_positions[cube_indices[i]]);
    }
    glEnd();
    static const unsigned char quads[2][4] = {{2, 3, 7, 6}, {0, 1, 3, 2}};
    glBegin(GL_QUADS);
    for (int i = 0; i < 8; i++) {
        const float *c = cube_colours[quads[i / 4][i % 4]], *p = cube_positions[quads[i / 4][i % 4]];
        glColor4f(c[0], c[1], c[2], 1.0f);
        glVertex3d(p[0], p[1], p[2]);
    }
    glEnd();
    static const unsigned char strip[4] = {4, 5, 6, 7};
    glBegin(GL_TRIANGLE_STRIP);
    for (int i = 0; i < 4; i++) {
        const float *p = cube_positions[strip[i]];
        glColor3ub(p[0] > 0 ? 255 : 0, p[1] > 0 ? 255 : 0, p[2] > 0 ? 255 : 0);
        glVertex4f(p[0], p[1], p[2], 1.0f);
    }
    glEnd();
    glPopMatrix();
}

int main(int argc, char **argv)
{
    static const app_program program = {"immediate", API_GL_COMPATIBILITY, 0, 0, NULL, draw, NULL};
    return app_main(argc, argv, &program);
}
