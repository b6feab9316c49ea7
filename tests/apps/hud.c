/*
 * A head-up display over the cube, drawn in the three ways that programs use: glOrtho in pixels,
 * identity matrices, and a shader without a matrix. Each draws a half-transparent white square. Its
 * pixels are the mean of white and the cube.
 *
 * --mode first: only in the first two frames; again: in these and from the 61st on; never: in none; always: in all. In
 * these modes nothing is read back and compared.
 */
#include "common/fixed.h"
#include "common/program.h"

#include <math.h>
#include <string.h>

static const char vertex[] = "#version 120\nattribute vec2 position;\nvoid main() { gl_Position = vec4(position, 0.0, 1.0); }\n";
static const char fragment[] = "#version 120\nvoid main() { gl_FragColor = vec4(1.0, 1.0, 1.0, 0.5); }\n";

static GLuint program;

/* The squares, in fractions of the window: left, bottom, right, top. */
static const float squares[3][4] = {
    {0.125f, 0.125f, 0.25f, 0.25f}, {0.75f, 0.125f, 0.875f, 0.25f}, {0.4375f, 0.75f, 0.5625f, 0.875f}};

static void setup(app *a)
{
    (void)a;
    const shader_source stages[] = {{GL_VERTEX_SHADER, vertex}, {GL_FRAGMENT_SHADER, fragment}};
    program = program_build(stages, 2);
}

static void square(const float *s, float scale_x, float scale_y, float offset)
{
    glBegin(GL_QUADS);
    glVertex2f(scale_x * s[0] + offset, scale_y * s[1] + offset);
    glVertex2f(scale_x * s[2] + offset, scale_y * s[1] + offset);
    glVertex2f(scale_x * s[2] + offset, scale_y * s[3] + offset);
    glVertex2f(scale_x * s[0] + offset, scale_y * s[3] + offset);
    glEnd();
}

static void check(app *a)
{
    image picture = image_read_framebuffer(a->window.width, a->window.height);
    for (int i = 0; i < 3; i++) {
        int x = (int)(0.5f * (squares[i][0] + squares[i][2]) * (float)picture.width);
        int y = (int)((1.0f - 0.5f * (squares[i][1] + squares[i][3])) * (float)picture.height);
        double cube[3];
        app_expected_colour(a, x, y, cube);
        const unsigned char *rgb = image_at(&picture, x, y);
        for (int k = 0; k < 3; k++) {
            double expected = 0.5 * cube[k] + 127.5;
            app_check(a, fabs(rgb[k] - expected) <= 2.5, "square %d channel %d is %d instead of %.1f", i, k, rgb[k],
                      expected);
        }
    }
    image_free(&picture);
}

static bool is_drawn(const app *a)
{
    if (!a->mode || strcmp(a->mode, "always") == 0)
        return true;
    bool again = strcmp(a->mode, "again") == 0;
    return (again || strcmp(a->mode, "first") == 0) && (a->frame < 2 || (again && a->frame >= 60));
}

static void draw(app *a)
{
    fixed_cube(a);
    if (!is_drawn(a))
        return;
    glEnable(GL_BLEND);
    glBlendFunc(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA);
    glColor4f(1.0f, 1.0f, 1.0f, 0.5f);
    fixed_begin_pixels(a);
    square(squares[0], (float)a->window.width, (float)a->window.height, 0.0f);
    glMatrixMode(GL_PROJECTION);
    glLoadIdentity();
    square(squares[1], 2.0f, 2.0f, -1.0f);
    fixed_end_pixels();

    glDisable(GL_DEPTH_TEST);
    glUseProgram(program);
    const float *s = squares[2];
    const float corners[8] = {2 * s[0] - 1, 2 * s[1] - 1, 2 * s[2] - 1, 2 * s[1] - 1,
                              2 * s[0] - 1, 2 * s[3] - 1, 2 * s[2] - 1, 2 * s[3] - 1};
    glVertexAttribPointer(0, 2, GL_FLOAT, GL_FALSE, 0, corners);
    glEnableVertexAttribArray(0);
    glDrawArrays(GL_TRIANGLE_STRIP, 0, 4);
    glDisableVertexAttribArray(0);
    glUseProgram(0);
    glEnable(GL_DEPTH_TEST);
    glDisable(GL_BLEND);
    if (!a->mode && !app_is_first_read(a))
        check(a);
}

int main(int argc, char **argv)
{
    static const app_program self = {"hud", API_GL_COMPATIBILITY, 0, 0, setup, draw, NULL};
    return app_main(argc, argv, &self);
}
