/*
 * A colour, a normal and a texture coordinate follow the last vertex of a primitive, as old
 * programs do to set the values of the next. The vertices before must keep the values that were
 * current then.
 */
#include "common/app.h"
#include "common/gl.h"

/* Ways to set an attribute. The driver converts the numbers of each in another way. */
static void set(int way)
{
    switch (way) {
    case 0: glColor3b(-100, 3, 127); break;
    case 1: glColor4s(-30000, 5, 32767, 1000); break;
    case 2: glColor3i(-2000000000, 7, 2147483647); break;
    case 3: glColor4ub(200, 3, 0, 90); break;
    case 4: glColor3us(60000, 1, 0); break;
    case 5: glColor4ui(4000000000u, 9, 0, 77); break;
    case 6: glColor4d(0.3, -2.0, 5.0, 0.1); break;
    case 7: glNormal3b(-100, 3, 127); break;
    case 8: glNormal3s(-30000, 5, 32767); break;
    case 9: glNormal3i(-2000000000, 7, 2147483647); break;
    case 10: glTexCoord4s(-7, 1, 2, 3); break; /* with fewer components Mesa keeps the old ones */
    case 11: glTexCoord4i(-7, 8, 9, 10); break;
    default: glTexCoord4d(0.1, 0.2, 0.3, 0.4); break;
    }
}

static void read_current(GLfloat values[12])
{
    for (int i = 0; i < 12; i++)
        values[i] = 0.0f;
    glGetFloatv(GL_CURRENT_COLOR, values);
    glGetFloatv(GL_CURRENT_NORMAL, values + 4);
    glGetFloatv(GL_CURRENT_TEXTURE_COORDS, values + 8);
}

/* Each way must leave the same values after the last vertex as outside of a primitive. */
static void check_conversions(app *a)
{
    for (int way = 0; way <= 12; way++) {
        GLfloat expected[12], values[12];
        set(way);
        read_current(expected);
        glColor4f(0.5f, 0.5f, 0.5f, 0.5f);
        glNormal3f(0.0f, 0.0f, 1.0f);
        glTexCoord4f(9.0f, 9.0f, 9.0f, 9.0f);
        glBegin(GL_POINTS);
        glVertex3f(0.0f, 0.0f, -5.0f);
        set(way);
        glEnd();
        read_current(values);
        int first = way <= 6 ? 0 : way <= 9 ? 4 : 8;
        for (int i = first; i < first + 4; i++) {
            float off = values[i] - expected[i];
            app_check(a, off <= 1e-6f && off >= -1e-6f, "way %d left %g in %d instead of %g", way, (double)values[i], i, (double)expected[i]);
        }
    }
}

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
    check_conversions(a);
    app_check_error(a, "at the end of a frame");
}

int main(int argc, char **argv)
{
    static const app_program self = {"trailing_attribute", API_GL_COMPATIBILITY, 2, 1, NULL, draw, NULL};
    return app_main(argc, argv, &self);
}
