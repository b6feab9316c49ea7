/* The accumulation buffer: the cube's picture is added from two halves, with every operation. */
#include "common/fixed.h"

static void draw(app *a)
{
    GLint bits = 0;
    glGetIntegerv(GL_ACCUM_RED_BITS, &bits);
    app_check(a, bits >= 8, "the accumulation buffer has %d bits", bits);
    glClearAccum(0.25f, 0.25f, 0.25f, 0.0f);
    glClear(GL_ACCUM_BUFFER_BIT);
    fixed_cube(a);
    glAccum(GL_ACCUM, 0.25f); /* 1/4 + C/4 */
    glAccum(GL_ADD, -0.25f);  /* C/4 */
    glAccum(GL_MULT, 2.0f);   /* C/2 */
    fixed_cube(a);
    glAccum(GL_ACCUM, 0.5f); /* C */
    glClearColor(1.0f, 0.0f, 1.0f, 1.0f);
    glClear(GL_COLOR_BUFFER_BIT);
    glAccum(GL_RETURN, 1.0f);
    /* GL_LOAD replaces the content. */
    glAccum(GL_LOAD, 0.5f);
    glAccum(GL_RETURN, 2.0f);
    app_check_error(a, "with the accumulation buffer");
    if (app_is_first_read(a))
        return;
    image picture = image_read_framebuffer(a->window.width, a->window.height);
    app_check_cube_picture(a, &picture, "glReadPixels after glAccum");
    image_free(&picture);
}

int main(int argc, char **argv)
{
    static const app_program self = {"accumulate", API_GL_COMPATIBILITY, 0, 0, NULL, draw, NULL};
    return app_main(argc, argv, &self);
}
