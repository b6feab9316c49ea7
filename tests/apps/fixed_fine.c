/*
 * The cells of the direction test, drawn through the fixed-function pipeline: by Begin/End (the
 * default), or with --mode list, arrays or buffers. --mode lit draws a ball with lights, materials,
 * fog, a texture with generated coordinates and a clip plane. These are all parts of the pipeline's
 * vertex stage.
 */
#include "common/app.h"
#include "common/cells.h"

#include <string.h>

static cells all;
static GLuint list, buffers[2];
static bool arrays, lit;

static bool is(const app *a, const char *mode)
{
    return a->mode && strcmp(a->mode, mode) == 0;
}

static void corner(unsigned index)
{
    const cell_corner *c = &all.corners[index];
    glColor3fv(c->colour);
    /* Normal of the ball, whose middle is the eye. It points inwards. */
    glNormal3f(-c->position[0], -c->position[1], -c->position[2]);
    glVertex3fv(c->position);
}

static void triangles(void)
{
    glBegin(GL_TRIANGLES);
    for (size_t i = 0; i < all.index_count; i++)
        corner(all.indices[i]);
    glEnd();
}

static void lights(void)
{
    static const float ahead[4] = {0.3f, 0.2f, 4.0f, 1.0f}, aside[4] = {1.0f, 0.5f, 0.2f, 0.0f};
    static const float spot[3] = {0.3f, 0.1f, -1.0f}, blue[4] = {0.2f, 0.3f, 0.9f, 1.0f};
    static const float shine[4] = {0.9f, 0.8f, 0.7f, 1.0f}, dark[4] = {0.1f, 0.1f, 0.1f, 1.0f};
    glPushMatrix();
    glLoadIdentity();
    glLightfv(GL_LIGHT0, GL_POSITION, ahead);
    glLightfv(GL_LIGHT0, GL_SPOT_DIRECTION, spot);
    glPopMatrix();
    glLightf(GL_LIGHT0, GL_SPOT_CUTOFF, 70.0f);
    glLightf(GL_LIGHT0, GL_SPOT_EXPONENT, 2.0f);
    glLightf(GL_LIGHT0, GL_LINEAR_ATTENUATION, 0.02f);
    glLightfv(GL_LIGHT2, GL_POSITION, aside);
    glLightfv(GL_LIGHT2, GL_DIFFUSE, blue);
    glLightfv(GL_LIGHT2, GL_SPECULAR, shine);
    glLightModelfv(GL_LIGHT_MODEL_AMBIENT, dark);
    glLightModeli(GL_LIGHT_MODEL_LOCAL_VIEWER, 1);
    glLightModeli(GL_LIGHT_MODEL_TWO_SIDE, 1);
    glLightModeli(GL_LIGHT_MODEL_COLOR_CONTROL, GL_SEPARATE_SPECULAR_COLOR);
    glMaterialfv(GL_FRONT_AND_BACK, GL_SPECULAR, shine);
    glMaterialf(GL_FRONT_AND_BACK, GL_SHININESS, 12.0f);
    glColorMaterial(GL_FRONT_AND_BACK, GL_AMBIENT_AND_DIFFUSE);
    glEnable(GL_COLOR_MATERIAL);
    glEnable(GL_NORMALIZE);
    glEnable(GL_LIGHTING);
    glEnable(GL_LIGHT0);
    glEnable(GL_LIGHT2);
}

static void surroundings(void)
{
    static const GLubyte texels[2][2][3] = {{{255, 255, 255}, {160, 200, 255}}, {{255, 200, 160}, {200, 200, 200}}};
    static const float along[4] = {0.05f, 0.0f, 0.02f, 0.3f}, grey[4] = {0.4f, 0.4f, 0.5f, 1.0f};
    static const double plane[4] = {0.0, 1.0, 0.3, 0.6};
    glTexImage2D(GL_TEXTURE_2D, 0, GL_RGB, 2, 2, 0, GL_RGB, GL_UNSIGNED_BYTE, texels);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
    glTexGeni(GL_S, GL_TEXTURE_GEN_MODE, GL_EYE_LINEAR);
    glTexGenfv(GL_S, GL_EYE_PLANE, along);
    glTexGeni(GL_T, GL_TEXTURE_GEN_MODE, GL_SPHERE_MAP);
    glEnable(GL_TEXTURE_GEN_S);
    glEnable(GL_TEXTURE_GEN_T);
    glEnable(GL_TEXTURE_2D);
    glFogi(GL_FOG_MODE, GL_EXP);
    glFogf(GL_FOG_DENSITY, 0.02f);
    glFogfv(GL_FOG_COLOR, grey);
    glEnable(GL_FOG);
    glClipPlane(GL_CLIP_PLANE0, plane);
    glEnable(GL_CLIP_PLANE0);
}

static void setup(app *a)
{
    lit = is(a, "lit");
    arrays = is(a, "arrays") || is(a, "buffers");
    all = cells_new(false, lit);
    if (is(a, "list") || lit) {
        list = glGenLists(1);
        glNewList(list, GL_COMPILE);
        if (lit)
            surroundings();
        triangles();
        glEndList();
    }
    if (is(a, "buffers")) {
        glGenBuffers(2, buffers);
        glBindBuffer(GL_ARRAY_BUFFER, buffers[0]);
        glBufferData(GL_ARRAY_BUFFER, (GLsizeiptr)(all.corner_count * sizeof(cell_corner)), all.corners, GL_STATIC_DRAW);
        glBindBuffer(GL_ELEMENT_ARRAY_BUFFER, buffers[1]);
        glBufferData(GL_ELEMENT_ARRAY_BUFFER, (GLsizeiptr)(all.index_count * sizeof(GLuint)), all.indices, GL_STATIC_DRAW);
    }
    if (arrays) {
        const char *start = buffers[0] ? NULL : (const char *)all.corners;
        glVertexPointer(3, GL_FLOAT, sizeof(cell_corner), start + offsetof(cell_corner, position));
        glColorPointer(3, GL_FLOAT, sizeof(cell_corner), start + offsetof(cell_corner, colour));
        glEnableClientState(GL_VERTEX_ARRAY);
        glEnableClientState(GL_COLOR_ARRAY);
    }
}

static void draw(app *a)
{
    glClearColor(0.0f, 0.0f, 0.0f, 1.0f);
    glClear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
    glEnable(GL_DEPTH_TEST);
    glMatrixMode(GL_PROJECTION);
    glLoadMatrixf(a->projection.m);
    glMatrixMode(GL_MODELVIEW);
    glLoadMatrixf(a->modelview.m);
    if (lit)
        lights();
    if (list)
        glCallList(list);
    else if (arrays)
        glDrawElements(GL_TRIANGLES, (GLsizei)all.index_count, GL_UNSIGNED_INT, buffers[1] ? NULL : all.indices);
    else
        triangles();
    float after[4];
    glGetFloatv(GL_CURRENT_COLOR, after);
    const cell_corner *last = &all.corners[all.indices[all.index_count - 1]];
    app_check(a, arrays || lit || (after[0] == last->colour[0] && after[2] == last->colour[2]),
              "the current colour is not the last one");
}

int main(int argc, char **argv)
{
    static const app_program self = {"fixed_fine", API_GL_COMPATIBILITY, 0, 0, setup, draw, NULL};
    return app_main(argc, argv, &self);
}
