/* Occlusion queries: visible objects have samples, and objects behind the cube's wall have none. */
#include "common/fixed.h"

static void triangle(float z)
{
    glBegin(GL_TRIANGLES);
    glVertex3f(-0.1f * z, -0.1f * z, z);
    glVertex3f(0.1f * z, -0.1f * z, z);
    glVertex3f(0.0f, 0.1f * z, z);
    glEnd();
}

static void draw(app *a)
{
    static GLuint queries[3];
    if (queries[0] == 0)
        glGenQueries(3, queries);
    fixed_cube(a);
    glLoadIdentity();
    glColorMask(GL_FALSE, GL_FALSE, GL_FALSE, GL_FALSE);
    glDepthMask(GL_FALSE);
    glBeginQuery(GL_SAMPLES_PASSED, queries[0]);
    triangle(-1.0f);
    glEndQuery(GL_SAMPLES_PASSED);
    glBeginQuery(GL_SAMPLES_PASSED, queries[1]);
    triangle(-50.0f);
    glEndQuery(GL_SAMPLES_PASSED);
    GLint current = 0;
    glBeginQuery(GL_ANY_SAMPLES_PASSED, queries[2]);
    glGetQueryiv(GL_ANY_SAMPLES_PASSED, GL_CURRENT_QUERY, &current);
    triangle(-1.0f);
    glEndQuery(GL_ANY_SAMPLES_PASSED);
    glColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
    glDepthMask(GL_TRUE);
    app_check(a, (GLuint)current == queries[2], "the current query is %d", current);
    GLuint seen = 0, hidden = 1, any = 0;
    glGetQueryObjectuiv(queries[0], GL_QUERY_RESULT, &seen);
    glGetQueryObjectuiv(queries[1], GL_QUERY_RESULT, &hidden);
    glGetQueryObjectuiv(queries[2], GL_QUERY_RESULT, &any);
    app_check(a, seen > 10, "an object in front has %u samples", seen);
    app_check(a, hidden == 0, "an object behind the wall has %u samples", hidden);
    app_check(a, any == 1, "any-samples of an object in front is %u", any);
}

int main(int argc, char **argv)
{
    static const app_program self = {"occlusion", API_GL_COMPATIBILITY, 0, 0, NULL, draw, NULL};
    return app_main(argc, argv, &self);
}
