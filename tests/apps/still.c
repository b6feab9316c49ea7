/*
 * A scene of the fixed-function pipeline that is the same in each frame, until from frame CHANGES on something is not:
 * --mode says what. Whatever it is, the picture must follow.
 */
#include "common/fixed.h"

#include <string.h>

enum { CHANGES = 24, SIDE = 8 };

static const char *mode = "still";
static GLuint texture, feedback, list, outer, names[2];
static float corners[4][3];

static bool is(const char *name)
{
    return strcmp(mode, name) == 0;
}

/* Whether what `name` stands for is to be so in this frame. */
static bool now(const app *a, const char *name)
{
    return a->frame >= CHANGES && is(name);
}

static void fill(unsigned char texels[SIDE * SIDE][4], int shift)
{
    for (int i = 0; i < SIDE * SIDE; i++) {
        bool on = ((i % SIDE / 2 + i / SIDE / 2 + shift) & 1) != 0;
        texels[i][0] = on ? 255 : 40;
        texels[i][1] = (unsigned char)(30 * (i % SIDE));
        texels[i][2] = on ? 60 : 200;
        texels[i][3] = 255;
    }
}

static void new_texture(GLuint *name, int shift)
{
    unsigned char texels[SIDE * SIDE][4];
    fill(texels, shift);
    glGenTextures(1, name);
    glBindTexture(GL_TEXTURE_2D, *name);
    glTexImage2D(GL_TEXTURE_2D, 0, GL_RGBA8, SIDE, SIDE, 0, GL_RGBA, GL_UNSIGNED_BYTE, texels);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
}

static void square(float x, float y, float z, float half)
{
    static const float ends[4][2] = {{-1, -1}, {1, -1}, {1, 1}, {-1, 1}};
    glBegin(GL_QUADS);
    glNormal3f(0.3f, 0.2f, 0.9f);
    for (int i = 0; i < 4; i++) {
        glTexCoord2f(0.5f + 0.5f * ends[i][0], 0.5f + 0.5f * ends[i][1]);
        glVertex3f(x + half * ends[i][0], y + half * ends[i][1], z);
    }
    glEnd();
}

static void compile(GLuint name, float red)
{
    glNewList(name, GL_COMPILE);
    glColor3f(red, 0.6f, 0.2f);
    square(0.0f, -1.5f, -5.0f, 0.6f);
    glEndList();
}

static void setup(app *a)
{
    if (a->mode != NULL)
        mode = a->mode;
    new_texture(&texture, 0);
    glGenTextures(1, &feedback);
    glBindTexture(GL_TEXTURE_2D, feedback);
    glTexImage2D(GL_TEXTURE_2D, 0, GL_RGBA8, 64, 64, 0, GL_RGBA, GL_UNSIGNED_BYTE, NULL);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
    glBindTexture(GL_TEXTURE_2D, texture);
    list = glGenLists(4);
    outer = list + 1;
    names[0] = list + 2;
    names[1] = list + 3;
    compile(list, 0.9f);
    compile(names[0], 0.9f);
    compile(names[1], 0.1f);
    glNewList(outer, GL_COMPILE);
    glPushMatrix();
    glTranslatef(2.0f, 0.0f, 0.0f);
    glCallList(list);
    glPopMatrix();
    glEndList();
    for (int i = 0; i < 4; i++) {
        corners[i][0] = i == 1 || i == 2 ? -1.0f : -2.0f;
        corners[i][1] = i > 1 ? -1.0f : -2.0f;
        corners[i][2] = -5.0f;
    }
    if (is("rotated_on") || is("scrolled_on")) {
        glMatrixMode(GL_MODELVIEW);
        glLoadIdentity();
    }
    if (is("client_array")) {
        glVertexPointer(3, GL_FLOAT, 0, corners);
        glEnableClientState(GL_VERTEX_ARRAY);
    }
}

/* State of every kind, each of which shows in the squares. */
static void set_state(const app *a)
{
    const float lamp[4] = {now(a, "light") ? -3.0f : 2.0f, 1.0f, 3.0f, 1.0f};
    const float shine[4] = {0.1f, now(a, "material") ? 0.9f : 0.2f, 0.3f, 1.0f};
    const float mist[4] = {0.2f, now(a, "fog") ? 0.9f : 0.2f, 0.2f, 1.0f};
    const float constant[4] = {0.5f, 0.5f, now(a, "environment") ? 1.0f : 0.0f, 1.0f};
    const double plane[4] = {1.0, 0.0, 0.0, now(a, "clip_plane") ? -0.2 : 3.0};
    glLightfv(GL_LIGHT0, GL_POSITION, lamp);
    static const float dull[4] = {0.3f, 0.3f, 0.3f, 1.0f};
    glMaterialfv(GL_FRONT_AND_BACK, GL_DIFFUSE, dull);
    glMaterialfv(GL_FRONT_AND_BACK, GL_EMISSION, shine);
    glFogi(GL_FOG_MODE, GL_LINEAR);
    glFogf(GL_FOG_START, 1.0f);
    glFogf(GL_FOG_END, now(a, "fog_end") ? 9.0f : 40.0f);
    glFogfv(GL_FOG_COLOR, mist);
    glTexEnvi(GL_TEXTURE_ENV, GL_TEXTURE_ENV_MODE, GL_BLEND);
    glTexEnvfv(GL_TEXTURE_ENV, GL_TEXTURE_ENV_COLOR, constant);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, now(a, "filter") ? GL_NEAREST : GL_LINEAR);
    glClipPlane(GL_CLIP_PLANE0, plane);
    glEnable(GL_CLIP_PLANE0);
    glPolygonMode(GL_FRONT_AND_BACK, now(a, "polygon_mode") ? GL_LINE : GL_FILL);
    glLineWidth(now(a, "line_width") ? 7.0f : 2.0f);
    glShadeModel(now(a, "shade_model") ? GL_FLAT : GL_SMOOTH);
    glDepthFunc(now(a, "depth_function") ? GL_GREATER : GL_LESS);
    glBlendFunc(GL_SRC_ALPHA, now(a, "blending") ? GL_ONE : GL_ZERO);
    glColorMask(1, now(a, "mask") ? 0 : 1, 1, 1);
    glAlphaFunc(now(a, "alpha") ? GL_NEVER : GL_ALWAYS, 0.5f);
    if (now(a, "stipple")) {
        GLubyte pattern[128];
        memset(pattern, 0x0F, sizeof pattern);
        glPolygonStipple(pattern);
        glEnable(GL_POLYGON_STIPPLE);
    }
}

static void draw_state(const app *a)
{
    set_state(a);
    glEnable(GL_FOG);
    glEnable(GL_TEXTURE_2D);
    glColor4f(1.0f, 1.0f, 1.0f, 0.7f);
    square(0.0f, 0.0f, -5.0f, 0.8f);
    glDisable(GL_TEXTURE_2D);
    glEnable(GL_LIGHTING);
    glEnable(GL_LIGHT0);
    square(-1.7f, 0.0f, -5.0f, 0.6f);
    glDisable(GL_LIGHTING);
    glEnable(GL_ALPHA_TEST);
    glEnable(GL_BLEND);
    glColor4f(now(a, "colour") ? 0.1f : 0.8f, 0.3f, 0.4f, 0.5f);
    square(1.7f, now(a, "vertex") ? 0.4f : 0.0f, -5.0f, 0.6f);
    glDisable(GL_BLEND);
    glDisable(GL_ALPHA_TEST);
    glDisable(GL_FOG);
    glBegin(GL_LINES);
    glColor3f(1.0f, 1.0f, 0.0f);
    glVertex3f(-2.0f, 1.4f, -5.0f);
    glColor3f(0.0f, 1.0f, 1.0f);
    glVertex3f(2.0f, 1.4f, -5.0f);
    glEnd();
    glDisable(GL_CLIP_PLANE0);
    glDisable(GL_POLYGON_STIPPLE);
    glPolygonMode(GL_FRONT_AND_BACK, GL_FILL);
    glColorMask(1, 1, 1, 1);
    glDepthFunc(GL_LESS);
}

static void draw_lists(const app *a)
{
    if (now(a, "list"))
        compile(list, 0.1f);
    glCallList(outer);
    glPushMatrix();
    glTranslatef(-2.0f, 0.0f, 0.0f);
    const GLuint called = names[now(a, "names") ? 1 : 0] - list;
    glListBase(now(a, "list_base") ? list - 1 : list);
    glCallLists(1, GL_UNSIGNED_INT, &called);
    glPopMatrix();
}

static void draw(app *a)
{
    if (now(a, "idle"))
        return;
    glClearColor(now(a, "clear_colour") ? 0.5f : 0.1f, 0.1f, 0.2f, 1.0f);
    GLbitfield cleared = GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT;
    if (is("stencil"))
        glEnable(GL_STENCIL_TEST);
    if (now(a, "drawn_over"))
        cleared = GL_DEPTH_BUFFER_BIT;
    if (now(a, "partly_cleared")) {
        glEnable(GL_SCISSOR_TEST);
        glScissor(0, 0, a->window.width / 3, a->window.height);
    }
    glClear(cleared);
    glDisable(GL_SCISSOR_TEST);
    glEnable(GL_DEPTH_TEST);
    glMatrixMode(GL_PROJECTION);
    glLoadMatrixf(a->projection.m);
    glMatrixMode(GL_MODELVIEW);
    if (!is("rotated_on"))
        glLoadIdentity();
    if (now(a, "rotated_on"))
        glRotatef(2.0f, 0.0f, 1.0f, 0.0f);
    if (now(a, "turned"))
        glRotated(15.0, 0.0, 0.0, 1.0);
    if (is("scrolled_on")) {
        glMatrixMode(GL_TEXTURE);
        if (a->frame >= CHANGES)
            glTranslatef(0.04f, 0.0f, 0.0f);
        glMatrixMode(GL_MODELVIEW);
    }
    if (now(a, "texels")) {
        unsigned char texels[SIDE * SIDE][4];
        fill(texels, 1);
        glTexSubImage2D(GL_TEXTURE_2D, 0, 0, 0, SIDE, SIDE, GL_RGBA, GL_UNSIGNED_BYTE, texels);
    }
    if (is("stencil")) {
        /* What is counted up in each frame hides the square once there is enough. */
        glStencilFunc(GL_GREATER, 20, 0xFF);
        glStencilOp(GL_KEEP, GL_KEEP, GL_INCR);
    }
    draw_state(a);
    draw_lists(a);
    if (is("drawn_over") || is("partly_cleared")) {
        /* Where nothing is cleared this grows brighter in each frame. */
        glDisable(GL_DEPTH_TEST);
        glEnable(GL_BLEND);
        glBlendFunc(GL_ONE, GL_ONE);
        glColor3f(0.03f, 0.03f, 0.0f);
        square(0.0f, 2.2f, -5.0f, 0.8f);
        glDisable(GL_BLEND);
        glEnable(GL_DEPTH_TEST);
    }
    if (is("client_array")) {
        if (a->frame >= CHANGES)
            corners[2][0] = corners[1][0] = 0.2f;
        glColor3f(0.4f, 0.9f, 0.5f);
        glDrawArrays(GL_QUADS, 0, 4);
    }
    if (is("copied_back")) {
        /* The square shows the window as it was, itself included. */
        glEnable(GL_TEXTURE_2D);
        glBindTexture(GL_TEXTURE_2D, feedback);
        glTexEnvi(GL_TEXTURE_ENV, GL_TEXTURE_ENV_MODE, GL_REPLACE);
        square(0.0f, 2.0f, -5.0f, 0.9f);
        glCopyTexSubImage2D(GL_TEXTURE_2D, 0, 0, 0, 0, 0, 64, 64);
        glDisable(GL_TEXTURE_2D);
        glBindTexture(GL_TEXTURE_2D, texture);
    }
    if (is("left_colour"))
        glColor3f(1.0f, 1.0f, 1.0f);
    glPushAttrib(GL_CURRENT_BIT);
    square(1.0f, 2.0f, -6.0f, 0.5f);
    glPopAttrib();
    if (now(a, "left_colour"))
        glColor3f(0.0f, 0.0f, 1.0f);
}

int main(int argc, char **argv)
{
    static const app_program program = {"still", API_GL_COMPATIBILITY, 0, 0, setup, draw, NULL};
    return app_main(argc, argv, &program);
}
