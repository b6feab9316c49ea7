/*
 * An old program that uses names of display lists and textures without asking OpenGL for them. It
 * has drawn in immediate mode before. Names that Cupola has created until then must not collide
 * with them.
 */
#include "common/app.h"
#include "common/fixed.h"
#include "common/gl.h"

enum { NAMES = 40, EDGE = 4 };

static void setup(app *a)
{
    fixed_cube(a);
    unsigned char texels[EDGE * EDGE * 3];
    for (GLuint name = 1; name <= NAMES; name++) {
        for (int i = 0; i < EDGE * EDGE * 3; i++)
            texels[i] = (unsigned char)name;
        glBindTexture(GL_TEXTURE_2D, name);
        glTexImage2D(GL_TEXTURE_2D, 0, GL_RGB, EDGE, EDGE, 0, GL_RGB, GL_UNSIGNED_BYTE, texels);
        app_check_error(a, "after a texture");
    }
    glBindTexture(GL_TEXTURE_2D, 0);
    /*
     * Each list has commands that Cupola records separately, so that Cupola needs names of its own
     * between them.
     */
    for (GLuint name = 1; name <= NAMES; name++) {
        glNewList(name, GL_COMPILE);
        glPushMatrix();
        glTranslatef(0.0f, 0.0f, 0.0f);
        glColor3ub((GLubyte)name, 2, 3);
        glPopMatrix();
        glEndList();
    }
}

static void draw(app *a)
{
    fixed_cube(a);
    for (GLuint name = 1; name <= NAMES; name++) {
        GLfloat colour[4];
        glCallList(name);
        glGetFloatv(GL_CURRENT_COLOR, colour);
        app_check(a, (int)(colour[0] * 255.0f + 0.5f) == (int)name, "list %u set %g", name, (double)colour[0]);
        unsigned char texels[EDGE * EDGE * 3] = {0};
        glBindTexture(GL_TEXTURE_2D, name);
        glGetTexImage(GL_TEXTURE_2D, 0, GL_RGB, GL_UNSIGNED_BYTE, texels);
        app_check(a, texels[5] == name, "texture %u holds %d", name, texels[5]);
    }
    glBindTexture(GL_TEXTURE_2D, 0);
}

int main(int argc, char **argv)
{
    static const app_program self = {"own_names", API_GL_COMPATIBILITY, 2, 1, setup, draw, NULL};
    return app_main(argc, argv, &self);
}
