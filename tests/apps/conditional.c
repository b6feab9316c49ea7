/*
 * Conditional rendering that is open while the buffers are swapped. It must apply only to the
 * program's draws.
 */
#include "common/fixed.h"

static void draw(app *a)
{
    static GLuint query;
    if (query != 0)
        glEndConditionalRender();
    else
        glGenQueries(1, &query);
    fixed_cube(a);
    glBeginQuery(GL_SAMPLES_PASSED, query);
    glEndQuery(GL_SAMPLES_PASSED);
    /* No sample passed the query, so nothing is drawn from here on. */
    glBeginConditionalRender(query, GL_QUERY_WAIT);
    glClearColor(1.0f, 0.0f, 1.0f, 1.0f);
    glClear(GL_COLOR_BUFFER_BIT);
    app_check_error(a, "at the end of a frame");
}

int main(int argc, char **argv)
{
    static const app_program self = {"conditional", API_GL_COMPATIBILITY, 3, 0, NULL, draw, NULL};
    return app_main(argc, argv, &self);
}
