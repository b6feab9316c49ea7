#include "fixed.h"

void fixed_cube(const app *a)
{
    app_clear();
    glMatrixMode(GL_PROJECTION);
    glLoadMatrixf(a->projection.m);
    glMatrixMode(GL_MODELVIEW);
    glLoadMatrixf(a->modelview.m);
    glBegin(GL_TRIANGLES);
    for (int i = 0; i < CUBE_INDICES; i++) {
        glColor3fv(cube_colours[cube_indices[i]]);
        glVertex3fv(cube_positions[cube_indices[i]]);
    }
    glEnd();
}

void fixed_square(float half, float distance)
{
    glBegin(GL_QUADS);
    glVertex3f(-half, -half, -distance);
    glVertex3f(half, -half, -distance);
    glVertex3f(half, half, -distance);
    glVertex3f(-half, half, -distance);
    glEnd();
}

void fixed_begin_pixels(const app *a)
{
    glMatrixMode(GL_PROJECTION);
    glPushMatrix();
    glLoadIdentity();
    glOrtho(0, a->window.width, 0, a->window.height, -1, 1);
    glMatrixMode(GL_MODELVIEW);
    glPushMatrix();
    glLoadIdentity();
    glDisable(GL_DEPTH_TEST);
}

void fixed_end_pixels(void)
{
    glEnable(GL_DEPTH_TEST);
    glMatrixMode(GL_PROJECTION);
    glPopMatrix();
    glMatrixMode(GL_MODELVIEW);
    glPopMatrix();
}
