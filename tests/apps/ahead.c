/*
 * Small objects straight ahead, drawn by Begin/End and by display lists. Views to the sides cannot
 * show them.
 */
#include "common/fixed.h"

static void triangle(float x, float size)
{
    glBegin(GL_TRIANGLES);
    glColor3f(1.0f, 0.5f, 0.0f);
    glVertex3f(x - size, -size, -5.0f);
    glVertex3f(x + size, -size, -5.0f);
    glColor3f(0.0f, 0.5f, 1.0f);
    glVertex3f(x, size, -5.0f);
    glEnd();
}

static void draw(app *a)
{
    static GLuint list;
    if (list == 0) {
        list = glGenLists(1);
        glNewList(list, GL_COMPILE);
        triangle(0.5f, 0.3f);
        glColor3f(0.0f, 1.0f, 0.0f);
        glEndList();
    }
    app_clear();
    glMatrixMode(GL_PROJECTION);
    glLoadMatrixf(a->projection.m);
    glMatrixMode(GL_MODELVIEW);
    glLoadIdentity();
    triangle(-0.5f, 0.3f);
    glCallList(list);
    /* The state that the list set is valid although most views did not run the list. */
    GLfloat colour[4] = {0};
    glGetFloatv(GL_CURRENT_COLOR, colour);
    app_check(a, colour[1] == 1.0f && colour[0] == 0.0f, "the colour after the list is %g %g", (double)colour[0], (double)colour[1]);
    /* This object is behind the eye. No view of the rig fisheye shows it, but its colour stays. */
    glPushMatrix();
    glTranslatef(0.0f, 0.0f, 10.0f);
    triangle(0.0f, 0.3f);
    glPopMatrix();
    glGetFloatv(GL_CURRENT_COLOR, colour);
    app_check(a, colour[2] == 1.0f && colour[0] == 0.0f, "the colour after the triangle behind is %g %g", (double)colour[0], (double)colour[2]);
    app_check_error(a, "at the end of a frame");
}

int main(int argc, char **argv)
{
    static const app_program self = {"ahead", API_GL_COMPATIBILITY, 0, 0, NULL, draw, NULL};
    return app_main(argc, argv, &self);
}
