/*
 * A colour, a normal and a texture coordinate that come after the last vertex of a primitive, as old
 * programs set what follows: the vertices before have what was current when they came.
 */
#include "common/app.h"
#include "common/gl.h"

static void draw(app *a)
{
    app_clear();
    glMatrixMode(GL_PROJECTION);
    glLoadMatrixf(a->projection.m);
    glMatrixMode(GL_MODELVIEW);
    glLoadIdentity();
    glDisable(GL_DEPTH_TEST);
    glShadeModel(GL_FLAT);
    for (int i = 0; i < 2; i++) {
        glColor3f(1.0f, 0.0f, 1.0f);
        glBegin(GL_QUADS);
        glVertex3f(-9.0f, -9.0f, -5.0f);
        glVertex3f(9.0f, -9.0f, -5.0f);
        glVertex3f(9.0f, 9.0f, -5.0f);
        glVertex3f(-9.0f, 9.0f, -5.0f);
        glColor3f(0.0f, 1.0f, 0.0f);
        glNormal3f(1.0f, 0.0f, 0.0f);
        glTexCoord2f(0.5f, 0.25f);
        glEnd();
    }
    GLfloat colour[4], normal[3], texture[4];
    glGetFloatv(GL_CURRENT_COLOR, colour);
    glGetFloatv(GL_CURRENT_NORMAL, normal);
    glGetFloatv(GL_CURRENT_TEXTURE_COORDS, texture);
    app_check(a, colour[0] == 0.0f && colour[1] == 1.0f, "the colour after the end is %g %g", (double)colour[0], (double)colour[1]);
    app_check(a, normal[0] == 1.0f && normal[2] == 0.0f, "the normal after the end is %g %g", (double)normal[0], (double)normal[2]);
    app_check(a, texture[0] == 0.5f && texture[1] == 0.25f, "the texture coordinate after the end is %g %g", (double)texture[0], (double)texture[1]);
    unsigned char rgb[3] = {0};
    glReadPixels(a->window.width / 2, a->window.height / 2, 1, 1, GL_RGB, GL_UNSIGNED_BYTE, rgb);
    app_check(a, rgb[0] == 255 && rgb[1] == 0 && rgb[2] == 255, "the middle is %d %d %d instead of 255 0 255", rgb[0], rgb[1], rgb[2]);
    app_check_error(a, "at the end of a frame");
}

int main(int argc, char **argv)
{
    static const app_program self = {"trailing_attribute", API_GL_COMPATIBILITY, 2, 1, NULL, draw, NULL};
    return app_main(argc, argv, &self);
}
