/* A display list runs while the attribute stack is full. The content of the stack must stay. */
#include "common/fixed.h"

static void draw(app *a)
{
    static GLuint list;
    fixed_cube(a);
    if (list == 0) {
        list = glGenLists(1);
        glNewList(list, GL_COMPILE);
        glBegin(GL_TRIANGLES);
        glVertex3f(-9.0f, -9.0f, 0.0f);
        glVertex3f(9.0f, -9.0f, 0.0f);
        glVertex3f(0.0f, 9.0f, 0.0f);
        glEnd();
        glEndList();
    }
    GLint most = 0, depth = 0;
    glGetIntegerv(GL_MAX_ATTRIB_STACK_DEPTH, &most);
    for (int i = 0; i < most; i++)
        glPushAttrib(GL_CURRENT_BIT);
    glColorMask(GL_FALSE, GL_FALSE, GL_FALSE, GL_FALSE);
    glDepthMask(GL_FALSE);
    glCallList(list);
    glColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
    glDepthMask(GL_TRUE);
    glGetIntegerv(GL_ATTRIB_STACK_DEPTH, &depth);
    app_check(a, depth == most, "%d attributes are on the stack instead of %d", depth, most);
    app_check_error(a, "after a list");
    for (int i = 0; i < most; i++)
        glPopAttrib();
    app_check_error(a, "after the stack was emptied");
}

int main(int argc, char **argv)
{
    static const app_program self = {"attribute_stack", API_GL_COMPATIBILITY, 0, 0, NULL, draw, NULL};
    return app_main(argc, argv, &self);
}
