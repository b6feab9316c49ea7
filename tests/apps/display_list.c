/*
 * Direction test with display lists: six lists for the faces, called by glCallLists from a list
 * that changes the matrices around them, called from a list for the whole frame, projection included.
 */
#include "common/app.h"

static GLuint faces, cube, frame;

static void setup(app *a)
{
    faces = glGenLists(6);
    for (unsigned face = 0; face < 6; face++) {
        glNewList(faces + face, GL_COMPILE);
        glBegin(GL_TRIANGLES);
        for (unsigned i = 6 * face; i < 6 * face + 6; i++) {
            glColor3fv(cube_colours[cube_indices[i]]);
            glVertex3fv(cube_positions[cube_indices[i]]);
        }
        glEnd();
        glEndList();
    }

    static const GLubyte all[6] = {0, 1, 2, 3, 4, 5};
    cube = glGenLists(1);
    glNewList(cube, GL_COMPILE);
    glPushAttrib(GL_TRANSFORM_BIT | GL_LIST_BIT);
    glMatrixMode(GL_MODELVIEW);
    glPushMatrix();
    glScaled(CUBE_SCALE, CUBE_SCALE, CUBE_SCALE);
    glListBase(faces);
    glCallLists(6, GL_UNSIGNED_BYTE, all);
    glPopMatrix();
    glPopAttrib();
    glEndList();

    frame = glGenLists(1);
    glNewList(frame, GL_COMPILE);
    app_clear();
    glMatrixMode(GL_PROJECTION);
    glLoadMatrixf(a->projection.m);
    glMatrixMode(GL_MODELVIEW);
    glLoadMatrixf(a->view.m);
    glCallList(cube);
    glEndList();
}

static void draw(app *a)
{
    glCallList(frame);
    float top[16];
    glGetFloatv(GL_PROJECTION_MATRIX, top);
    bool same = true;
    for (int i = 0; i < 16; i++)
        same = same && top[i] == a->projection.m[i];
    app_check(a, same, "glGet does not return the projection that a display list loaded");
}

int main(int argc, char **argv)
{
    static const app_program program = {"display_list", API_GL_COMPATIBILITY, 0, 0, setup, draw, NULL};
    return app_main(argc, argv, &program);
}
