/*
 * glRect in a scene: 8 x 8 rectangles tile the cube's faces -z and +z. With glRect the whole
 * rectangle has one colour, that of its middle.
 */
#include "common/fixed.h"

enum { CELLS = 8 };

static void draw(app *a)
{
    fixed_cube(a);
    glDisable(GL_DEPTH_TEST);
    for (int face = -1; face <= 1; face += 2) {
        glPushMatrix();
        glTranslatef(0, 0, (float)face);
        for (int row = 0; row < CELLS; row++) {
            for (int column = 0; column < CELLS; column++) {
                float left = 2.0f * (float)column / CELLS - 1.0f, bottom = 2.0f * (float)row / CELLS - 1.0f;
                float side = 2.0f / CELLS;
                glColor3f(0.5f + 0.5f * (left + 0.5f * side), 0.5f + 0.5f * (bottom + 0.5f * side),
                          0.5f + 0.5f * (float)face);
                glRectf(left, bottom, left + side, bottom + side);
            }
        }
        glPopMatrix();
    }
    glEnable(GL_DEPTH_TEST);
    app_check_error(a, "after glRect");
}

int main(int argc, char **argv)
{
    static const app_program self = {"rectangles", API_GL_COMPATIBILITY, 0, 0, NULL, draw, NULL};
    return app_main(argc, argv, &self);
}
