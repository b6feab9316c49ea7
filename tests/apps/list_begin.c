/*
 * Display lists that begin a primitive, end one, or contain only vertices, and lists that call
 * those.
 */
#include "common/fixed.h"
#include "common/probe.h"

enum { BEGIN, VERTICES, END, NESTED, DEEP, WHOLE, BEGIN_AND_VERTICES, AT_ONCE, LISTS };
enum { COLUMNS = 8 };

static GLuint lists;

static void vertices(void)
{
    glVertex2f(0.0f, 0.0f);
    glVertex2f(20.0f, 0.0f);
    glVertex2f(20.0f, 20.0f);
    glVertex2f(0.0f, 20.0f);
}

static void setup(app *a)
{
    (void)a;
    lists = glGenLists(LISTS);
    glNewList(lists + BEGIN, GL_COMPILE);
    glBegin(GL_QUADS);
    glEndList();
    glNewList(lists + VERTICES, GL_COMPILE);
    vertices();
    glEndList();
    glNewList(lists + END, GL_COMPILE);
    glEnd();
    glEndList();
    glNewList(lists + NESTED, GL_COMPILE);
    glCallList(lists + VERTICES);
    glEndList();
    glNewList(lists + DEEP, GL_COMPILE);
    glColor3f(1.0f, 1.0f, 0.0f);
    glCallList(lists + NESTED);
    glEndList();
    glNewList(lists + WHOLE, GL_COMPILE);
    glBegin(GL_QUADS);
    glCallList(lists + VERTICES);
    glEnd();
    glEndList();
    glNewList(lists + BEGIN_AND_VERTICES, GL_COMPILE);
    glBegin(GL_QUADS);
    vertices();
    glEndList();
}

static int places;

/* The next draws are at the next place. */
static void next(int red, int green, int blue)
{
    glLoadIdentity();
    glTranslatef((float)(5 + 30 * (places % COLUMNS)), (float)(5 + 30 * (places / COLUMNS)), 0.0f);
    places++;
    glColor3f((float)red, (float)green, (float)blue);
}

static void draw(app *a)
{
    glClearColor(0.0f, 0.0f, 0.0f, 1.0f);
    glClear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
    fixed_begin_pixels(a);
    places = 0;

    next(1, 0, 0);
    glBegin(GL_QUADS);
    glCallList(lists + VERTICES);
    glEnd();
    next(0, 1, 0);
    glBegin(GL_QUADS);
    glCallList(lists + DEEP);
    glEnd();
    next(0, 0, 1);
    glCallList(lists + BEGIN);
    glCallList(lists + VERTICES);
    glCallList(lists + END);
    next(1, 0, 1);
    glBegin(GL_QUADS);
    vertices();
    glCallList(lists + END);
    next(0, 1, 1);
    glCallList(lists + BEGIN);
    vertices();
    glEnd();
    next(1, 1, 1);
    glCallList(lists + WHOLE);
    next(1, 0, 0);
    glCallList(lists + BEGIN_AND_VERTICES);
    glCallList(lists + END);
    app_check_error(a, "after the lists");

    /* glBegin within glBegin is an error. The following vertices are drawn. */
    next(0, 1, 0);
    glBegin(GL_QUADS);
    glCallList(lists + BEGIN);
    glCallList(lists + VERTICES);
    glCallList(lists + END);
    app_check(a, glGetError() == GL_INVALID_OPERATION, "glBegin in a list between glBegin and glEnd is no error");
    next(0, 0, 1);
    glBegin(GL_QUADS);
    vertices();
    glEnd();

    /*
     * glEndList between glBegin and glEnd of a list that is also executed is an error. The list
     * ends nevertheless.
     */
    next(1, 1, 0);
    glNewList(lists + AT_ONCE, GL_COMPILE_AND_EXECUTE);
    glBegin(GL_QUADS);
    vertices();
    glEndList();
    glEnd();
    app_check(a, glGetError() == GL_INVALID_OPERATION, "glEndList between glBegin and glEnd is no error");
    app_check_error(a, "after a list that ended between glBegin and glEnd");
    glLoadIdentity();
    fixed_end_pixels();

    static const int colours[][3] = {{1, 0, 0}, {1, 1, 0}, {0, 0, 1}, {1, 0, 1}, {0, 1, 1},
                                     {1, 1, 1}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, 1, 0}};
    for (int i = 0; i < places; i++)
        probe(a, 15 + 30 * (i % COLUMNS), 15 + 30 * (i / COLUMNS), colours[i][0], colours[i][1], colours[i][2], "lists");
}

int main(int argc, char **argv)
{
    static const app_program self = {"list_begin", API_GL_COMPATIBILITY, 0, 0, setup, draw, NULL};
    return app_main(argc, argv, &self);
}
