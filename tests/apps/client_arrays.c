/* Direction test with vertex arrays in client memory: glDrawElements, glDrawArrays, glArrayElement. */
#include "common/app.h"

static float expanded_positions[12][3], expanded_colours[12][3];

static void setup(app *a)
{
    (void)a;
    for (int i = 0; i < 12; i++) {
        for (int k = 0; k < 3; k++) {
            expanded_positions[i][k] = cube_positions[cube_indices[18 + i]][k];
            expanded_colours[i][k] = cube_colours[cube_indices[18 + i]][k];
        }
    }
}

static void draw(app *a)
{
    app_clear();
    glMatrixMode(GL_PROJECTION);
    glLoadMatrixf(a->projection.m);
    glMatrixMode(GL_MODELVIEW);
    glLoadMatrixf(a->view.m);
    glScaled(CUBE_SCALE, CUBE_SCALE, CUBE_SCALE);

    glEnableClientState(GL_VERTEX_ARRAY);
    glEnableClientState(GL_COLOR_ARRAY);
    glVertexPointer(3, GL_FLOAT, 0, cube_positions);
    glColorPointer(3, GL_FLOAT, 0, cube_colours);
    glDrawElements(GL_TRIANGLES, 18, GL_UNSIGNED_SHORT, cube_indices);
    glBegin(GL_TRIANGLES);
    for (int i = 30; i < 36; i++)
        glArrayElement(cube_indices[i]);
    glEnd();
    glVertexPointer(3, GL_FLOAT, 0, expanded_positions);
    glColorPointer(3, GL_FLOAT, 0, expanded_colours);
    glDrawArrays(GL_TRIANGLES, 0, 12);
    glDisableClientState(GL_COLOR_ARRAY);
    glDisableClientState(GL_VERTEX_ARRAY);
}

int main(int argc, char **argv)
{
    static const app_program program = {"client_arrays", API_GL_COMPATIBILITY, 0, 0, setup, draw, NULL};
    return app_main(argc, argv, &program);
}
