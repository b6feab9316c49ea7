/*
 * Direction test by Begin/End. Each face sets its colours and corners in another way: shorts and
 * doubles, generic attributes, a secondary colour, materials between vertices, elements of arrays,
 * lists.
 */
#include "common/app.h"

static const unsigned char faces[6][4] = {{0, 2, 6, 4}, {1, 5, 7, 3}, {0, 4, 5, 1}, {2, 3, 7, 6}, {0, 1, 3, 2}, {4, 6, 7, 5}};

static void shorts_and_doubles(int corner)
{
    const float *c = cube_colours[corner], *p = cube_positions[corner];
    glColor3us(c[0] > 0 ? 65535 : 0, c[1] > 0 ? 65535 : 0, c[2] > 0 ? 65535 : 0);
    glVertex3d(p[0], p[1], p[2]);
}

static void generic_position(int corner)
{
    const float *p = cube_positions[corner];
    GLubyte colour[4] = {0, 0, 0, 255};
    for (int i = 0; i < 3; i++)
        colour[i] = cube_colours[corner][i] > 0 ? 255 : 0;
    glColor4ubv(colour);
    glVertexAttrib3s(0, (GLshort)p[0], (GLshort)p[1], (GLshort)p[2]);
}

static void secondary_colour(int corner)
{
    glColor3f(0.0f, 0.0f, 0.0f);
    glSecondaryColor3fv(cube_colours[corner]);
    glVertex3fv(cube_positions[corner]);
}

static void material(int corner)
{
    const float *c = cube_colours[corner];
    const GLfloat emission[4] = {c[0], c[1], c[2], 1.0f};
    glMaterialfv(GL_FRONT_AND_BACK, GL_EMISSION, emission);
    glVertex3fv(cube_positions[corner]);
}

/* Arrays of one element. The program changes their values from element to element. */
static float element_colour[3], element_position[3];

static void element(int corner)
{
    for (int i = 0; i < 3; i++) {
        element_colour[i] = cube_colours[corner][i];
        element_position[i] = cube_positions[corner][i];
    }
    glArrayElement(0);
}

static void list(int corner)
{
    static GLuint lists;
    if (lists == 0) {
        lists = glGenLists(CUBE_CORNERS);
        for (GLuint i = 0; i < CUBE_CORNERS; i++) {
            glNewList(lists + i, GL_COMPILE);
            glColor3fv(cube_colours[i]);
            glVertex3fv(cube_positions[i]);
            glEndList();
        }
    }
    glCallList(lists + (GLuint)corner);
}

static void face(int number, void (*corner)(int))
{
    glBegin(GL_QUADS);
    for (int i = 0; i < 4; i++)
        corner(faces[number][i]);
    /* Only vertices and attributes are allowed here. */
    glMatrixMode(GL_TEXTURE);
    glEnd();
}

static void draw(app *a)
{
    list(0); /* creates the lists; a vertex outside of a primitive has no effect */
    app_clear();
    glMatrixMode(GL_PROJECTION);
    glLoadMatrixf(a->projection.m);
    glMatrixMode(GL_MODELVIEW);
    glLoadMatrixf(a->modelview.m);
    app_check_error(a, "before the faces");
    face(0, shorts_and_doubles);
    face(1, generic_position);
    glEnable(GL_COLOR_SUM);
    face(2, secondary_colour);
    glDisable(GL_COLOR_SUM);
    const GLfloat black[4] = {0, 0, 0, 1};
    glLightModelfv(GL_LIGHT_MODEL_AMBIENT, black);
    glEnable(GL_LIGHTING);
    face(3, material);
    GLfloat emission[4] = {-1};
    glGetMaterialfv(GL_FRONT, GL_EMISSION, emission);
    app_check(a, emission[0] == cube_colours[faces[3][3]][0], "the emission after the end is %g", (double)emission[0]);
    glDisable(GL_LIGHTING);
    glEnableClientState(GL_COLOR_ARRAY);
    glEnableClientState(GL_VERTEX_ARRAY);
    glColorPointer(3, GL_FLOAT, 0, element_colour);
    glVertexPointer(3, GL_FLOAT, 0, element_position);
    face(4, element);
    glDisableClientState(GL_COLOR_ARRAY);
    glDisableClientState(GL_VERTEX_ARRAY);
    face(5, list);
    app_check(a, glGetError() == GL_INVALID_OPERATION, "a matrix mode between Begin and End is no error");
    while (glGetError() != GL_NO_ERROR) {}
}

int main(int argc, char **argv)
{
    static const app_program self = {"immediate_ways", API_GL_COMPATIBILITY, 2, 1, NULL, draw, NULL};
    return app_main(argc, argv, &self);
}
