/*
 * Wide points, wide lines and triangles drawn as wide lines. Each is small, in a colour of its own,
 * in one of many directions: number i is 10 + 10 (i mod 8) degrees off the camera's axis, turned
 * around the axis by 37 i degrees. --mode smooth draws a fan of smooth lines instead.
 */
#include "common/fixed.h"

#include <math.h>
#include <string.h>

enum { MARKS = 48 };
static const double degree = 3.14159265358979323846 / 180.0;

/* A place near mark i, displaced to the side by a part of its distance. */
static void place(int i, double aside, float to[3])
{
    double off = (10 + 10 * (i % 8)) * degree, around = 37 * i * degree;
    double x = sin(off) * cos(around), y = sin(off) * sin(around), z = -cos(off);
    to[0] = (float)(8.0 * (x - aside * sin(around)));
    to[1] = (float)(8.0 * (y + aside * cos(around)));
    to[2] = (float)(8.0 * z);
}

static void colour(int i)
{
    glColor3f(0.3f + 0.1f * (float)(i % 8), 0.3f + 0.1f * (float)(i / 8), 0.4f);
}

static void draw_smooth_lines(void)
{
    glEnable(GL_LINE_SMOOTH);
    glEnable(GL_BLEND);
    glBlendFunc(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA);
    glLineWidth(2.0f);
    glColor3f(1.0f, 1.0f, 1.0f);
    glBegin(GL_LINES);
    for (int i = -20; i < 20; i++) {
        glVertex3f(-20.0f, -1.0f + 0.13f * (float)i, -10.0f);
        glVertex3f(20.0f, -2.0f + 0.1f * (float)i, -15.0f);
    }
    glEnd();
}

static void draw(app *a)
{
    static GLuint list;
    float at[3], beside[3];
    glClearColor(0.0f, 0.0f, 0.0f, 1.0f);
    glClear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
    glMatrixMode(GL_PROJECTION);
    glLoadMatrixf(a->projection.m);
    glMatrixMode(GL_MODELVIEW);
    glLoadIdentity();
    if (a->mode != NULL && strcmp(a->mode, "smooth") == 0) {
        draw_smooth_lines();
        return;
    }
    glPointSize(61.0f);
    glLineWidth(31.0f);
    for (int i = 0; i < MARKS; i++) {
        place(i, 0.0, at);
        place(i, 0.03, beside);
        colour(i);
        if (i % 4 == 0) {
            glBegin(GL_POINTS);
            glVertex3fv(at);
            glEnd();
        } else if (i % 4 == 1) {
            if (list == 0)
                list = glGenLists(1);
            glNewList(list, GL_COMPILE_AND_EXECUTE);
            glBegin(GL_LINES);
            glVertex3fv(at);
            glVertex3fv(beside);
            glEnd();
            glEndList();
        } else {
            float corners[9];
            place(i, 0.0, corners);
            place(i, 0.03, corners + 3);
            place(i, -0.03, corners + 6);
            corners[0] *= 1.02f;
            glEnableClientState(GL_VERTEX_ARRAY);
            glVertexPointer(3, GL_FLOAT, 0, corners);
            if (i % 4 == 2) {
                glPolygonMode(GL_FRONT_AND_BACK, GL_LINE);
                glDrawArrays(GL_TRIANGLES, 0, 3);
                glPolygonMode(GL_FRONT_AND_BACK, GL_FILL);
            } else {
                glDrawArrays(GL_POINTS, 0, 1);
            }
            glDisableClientState(GL_VERTEX_ARRAY);
        }
    }
}

int main(int argc, char **argv)
{
    static const app_program self = {"outlines", API_GL_COMPATIBILITY, 0, 0, NULL, draw, NULL};
    return app_main(argc, argv, &self);
}
