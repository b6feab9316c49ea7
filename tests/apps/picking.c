/*
 * GL_SELECT with a pick matrix, and GL_FEEDBACK. The answers must be those of the program's own
 * projection.
 */
#include "common/fixed.h"

#include <math.h>

static void faces(bool named)
{
    for (unsigned face = 0; face < 6; face++) {
        if (named)
            glLoadName(face + 1);
        glBegin(GL_TRIANGLES);
        for (unsigned i = 6 * face; i < 6 * face + 6; i++)
            glVertex3fv(cube_positions[cube_indices[i]]);
        glEnd();
    }
}

static void pick(app *a)
{
    GLuint hits[64];
    glSelectBuffer(64, hits);
    glRenderMode(GL_SELECT);
    glInitNames();
    glPushName(0);
    /* The middle 2 x 2 pixels of the window. */
    glMatrixMode(GL_PROJECTION);
    glLoadIdentity();
    glScalef(0.5f * (float)a->window.width, 0.5f * (float)a->window.height, 1.0f);
    glMultMatrixf(a->projection.m);
    glMatrixMode(GL_MODELVIEW);
    faces(true);
    GLint count = glRenderMode(GL_RENDER);
    /* The middle looks along the camera's axis: the face is that of the largest coordinate. */
    const float *m = a->view.m; /* its third row is the eye's z axis in the world */
    float forward[3] = {-m[2], -m[6], -m[10]};
    int axis = 0;
    for (int i = 1; i < 3; i++)
        if (fabsf(forward[i]) > fabsf(forward[axis]))
            axis = i;
    GLuint expected = 2u * (GLuint)axis + (forward[axis] > 0 ? 2u : 1u);
    app_check(a, count == 1, "the pick hits %d faces", count);
    if (count == 1)
        app_check(a, hits[0] == 1 && hits[3] == expected, "the pick hits face %u instead of %u", hits[3], expected);
}

static void feed_back(app *a)
{
    GLfloat tokens[64];
    glFeedbackBuffer(64, GL_2D, tokens);
    glMatrixMode(GL_PROJECTION);
    glLoadMatrixf(a->projection.m);
    glMatrixMode(GL_MODELVIEW);
    glPushMatrix();
    glLoadIdentity();
    glRenderMode(GL_FEEDBACK);
    glPassThrough(42.0f);
    glBegin(GL_POINTS);
    glVertex3f(0.0f, 0.0f, -3.0f);
    glEnd();
    GLint count = glRenderMode(GL_RENDER);
    glPopMatrix();
    app_check(a, count == 5 && tokens[0] == (GLfloat)GL_PASS_THROUGH_TOKEN && tokens[1] == 42.0f &&
                     tokens[2] == (GLfloat)GL_POINT_TOKEN, "feedback returns %d values", count);
    if (count == 5)
        app_check(a, fabsf(tokens[3] - 0.5f * (float)a->window.width) < 0.01f &&
                         fabsf(tokens[4] - 0.5f * (float)a->window.height) < 0.01f,
                  "feedback puts a point straight ahead at %g %g", (double)tokens[3], (double)tokens[4]);
}

static void draw(app *a)
{
    fixed_cube(a);
    pick(a);
    feed_back(a);
}

int main(int argc, char **argv)
{
    static const app_program self = {"picking", API_GL_COMPATIBILITY, 0, 0, NULL, draw, NULL};
    return app_main(argc, argv, &self);
}
