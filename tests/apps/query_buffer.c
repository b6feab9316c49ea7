/*
 * A buffer that receives results of queries is bound while a query consists of many draws of the
 * scene and of the panel. Only the program's own questions may write to it.
 */
#include "common/fixed.h"

#include <string.h>

#define BYTES 64
#define OFFSET 8
#define UNTOUCHED 0xAA

static GLuint query, buffer;

static void setup(app *a)
{
    (void)a;
    unsigned char bytes[BYTES];
    memset(bytes, UNTOUCHED, sizeof bytes);
    glGenQueries(1, &query);
    glGenBuffers(1, &buffer);
    glBindBuffer(GL_QUERY_BUFFER, buffer);
    glBufferData(GL_QUERY_BUFFER, BYTES, bytes, GL_DYNAMIC_READ);
    glBindBuffer(GL_QUERY_BUFFER, 0);
}

/* Checks all bytes of the buffer except for the result, which is returned. */
static GLuint content(app *a, const char *what)
{
    unsigned char bytes[BYTES];
    glGetBufferSubData(GL_QUERY_BUFFER, 0, BYTES, bytes);
    for (int i = 0; i < BYTES; ++i)
        if (i < OFFSET || i >= OFFSET + 4)
            app_check(a, bytes[i] == UNTOUCHED, "%s: byte %d of the buffer is %d", what, i, bytes[i]);
    GLuint value = 0;
    memcpy(&value, bytes + OFFSET, sizeof value);
    return value;
}

/* Draws squares of the scene and of the panel in turn, all of them visible, with a query. */
static void count(app *a)
{
    glBeginQuery(GL_SAMPLES_PASSED, query);
    for (int i = 0; i < 40; ++i) {
        fixed_square(0.5f, 4.0f - 0.02f * (float)i);
        fixed_begin_pixels(a);
        glRecti(0, 0, 3, 3);
        fixed_end_pixels();
    }
    glEndQuery(GL_SAMPLES_PASSED);
}

static void draw(app *a)
{
    fixed_cube(a);
    glLoadIdentity();
    glClear(GL_DEPTH_BUFFER_BIT);
    count(a);
    GLuint expected = 0;
    glGetQueryObjectuiv(query, GL_QUERY_RESULT, &expected);
    app_check(a, expected > 1000, "squares of %u samples", expected);

    glClear(GL_DEPTH_BUFFER_BIT);
    glBindBuffer(GL_QUERY_BUFFER, buffer);
    count(a);
    app_check_error(a, "after a query");
    content(a, "after a query");
    glGetQueryObjectuiv(query, GL_QUERY_RESULT, (GLuint *)OFFSET);
    app_check_error(a, "after a question");
    GLuint value = content(a, "after a question");
    app_check(a, value == expected, "the result is %u in a buffer, and %u without it", value, expected);
    glBeginConditionalRender(query, GL_QUERY_WAIT);
    fixed_square(0.1f, 2.0f);
    glEndConditionalRender();
    app_check_error(a, "after conditional rendering");
    app_check(a, content(a, "after conditional rendering") == expected, "conditional rendering writes a result");
    glBindBuffer(GL_QUERY_BUFFER, 0);
}

int main(int argc, char **argv)
{
    static const app_program self = {"query_buffer", API_GL_COMPATIBILITY, 4, 4, setup, draw, NULL};
    return app_main(argc, argv, &self);
}
