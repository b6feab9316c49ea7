/*
 * Begin/End of every mode, several after each other with only current attributes between them. All
 * must be drawn.
 */
#include "common/fixed.h"
#include "common/probe.h"

#include <GL/glx.h>

enum { COUNT = 4, SIZE = 20 };

typedef struct {
    GLenum mode;
    int count;
    int corners[6]; /* bit 0: to the right, bit 1: up */
    const char *name;
} shape;

static const shape shapes[] = {
    {GL_TRIANGLE_STRIP, 4, {0, 1, 2, 3}, "strip"},     {GL_TRIANGLE_FAN, 4, {0, 1, 3, 2}, "fan"},
    {GL_QUAD_STRIP, 4, {0, 1, 2, 3}, "quad strip"},    {GL_POLYGON, 4, {0, 1, 3, 2}, "polygon"},
    {GL_QUADS, 4, {0, 1, 3, 2}, "quads"},              {GL_TRIANGLES, 6, {0, 1, 3, 0, 3, 2}, "triangles"},
    {GL_LINE_STRIP, 4, {0, 1, 3, 2}, "line strip"},    {GL_LINE_LOOP, 4, {0, 1, 3, 2}, "line loop"},
    {GL_LINES, 4, {0, 1, 3, 2}, "lines"},              {GL_POINTS, 4, {0, 1, 3, 2}, "points"},
};

enum { SHAPES = sizeof shapes / sizeof shapes[0] };

static bool is_line(const shape *s)
{
    return s->mode == GL_LINE_STRIP || s->mode == GL_LINE_LOOP || s->mode == GL_LINES || s->mode == GL_POINTS;
}

/* Two squares of one strip with a primitive restart between them. */
static void draw_restarted(void)
{
    void (*restart)(void) = (void (*)(void))glXGetProcAddressARB((const GLubyte *)"glPrimitiveRestartNV");
    glColor3f(0.0f, 1.0f, 0.0f);
    glBegin(GL_TRIANGLE_STRIP);
    for (int i = 0; i < 8; i++) {
        if (i == 4)
            restart();
        glVertex2i(205 + 30 * (i / 4) + 10 * (i & 1), 10 + 10 * (i >> 1 & 1));
    }
    glEnd();
}

static void draw(app *a)
{
    glClearColor(0.0f, 0.0f, 0.0f, 1.0f);
    glClear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
    fixed_begin_pixels(a);
    for (int i = 0; i < SHAPES; i++) {
        for (int n = 0; n < COUNT; n++) {
            glColor3f(n & 1 ? 1.0f : 0.0f, 1.0f, n & 2 ? 1.0f : 0.0f);
            glBegin(shapes[i].mode);
            for (int k = 0; k < shapes[i].count; k++) {
                int corner = shapes[i].corners[k];
                /* Lines and points are in the middle of pixels. */
                glVertex2f((float)(10 + 24 * n + (corner & 1) * SIZE) + 0.5f,
                           (float)(5 + 24 * i + (corner >> 1) * SIZE) + 0.5f);
            }
            glEnd();
        }
        app_check_error(a, shapes[i].name);
    }
    draw_restarted();
    fixed_end_pixels();
    probe(a, 210, 15, 0, 1, 0, "before a restart");
    probe(a, 225, 15, 0, 0, 0, "at a restart");
    probe(a, 240, 15, 0, 1, 0, "after a restart");
    for (int i = 0; i < SHAPES; i++) {
        for (int n = 0; n < COUNT; n++) {
            int inside = is_line(&shapes[i]) ? 0 : SIZE / 2;
            probe(a, 10 + 24 * n + inside, 5 + 24 * i + inside, n & 1, 1, n >> 1 & 1, shapes[i].name);
        }
    }
    /* Errors must still be reported. */
    glBegin(GL_LINE_LOOP);
    glClear(GL_COLOR_BUFFER_BIT);
    glEnd();
    app_check(a, glGetError() == GL_INVALID_OPERATION, "glClear between glBegin and glEnd is no error");
}

int main(int argc, char **argv)
{
    static const app_program self = {"flat_modes", API_GL_COMPATIBILITY, 0, 0, NULL, draw, NULL};
    return app_main(argc, argv, &self);
}
