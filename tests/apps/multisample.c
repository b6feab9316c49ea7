/*
 * A window with four samples. The program must see them, and the presented picture must have smooth
 * edges. A framebuffer of the program stays bound for reading.
 */
#include "common/fixed.h"
#include "common/target.h"

static void setup(app *a)
{
    target own = target_create(1, 1);
    (void)a;
    glBindFramebuffer(GL_FRAMEBUFFER, own.framebuffer);
    glClearColor(1, 0, 0, 1);
    glClear(GL_COLOR_BUFFER_BIT);
    glBindFramebuffer(GL_DRAW_FRAMEBUFFER, 0);
}

static void read_own(app *a, const char *when)
{
    GLubyte red[4] = {0};
    glReadPixels(0, 0, 1, 1, GL_RGBA, GL_UNSIGNED_BYTE, red);
    app_check(a, red[0] == 255 && red[1] == 0, "%s the program's own framebuffer has the red %d and the green %d", when,
              red[0], red[1]);
}

static void draw(app *a)
{
    GLint samples = 0, buffers = 0;
    glGetIntegerv(GL_SAMPLES, &samples);
    glGetIntegerv(GL_SAMPLE_BUFFERS, &buffers);
    app_check(a, samples == a->request.samples && buffers == 1, "GL_SAMPLES is %d and GL_SAMPLE_BUFFERS %d", samples,
              buffers);
    fixed_cube(a);
    /* A black triangle in front of the camera with oblique edges. */
    glColor3f(0, 0, 0);
    glLoadIdentity();
    glBegin(GL_TRIANGLES);
    glVertex3f(-0.5f, -0.5f, -2.0f);
    glVertex3f(0.5f, -0.37f, -2.0f);
    glVertex3f(0.11f, 0.5f, -2.0f);
    glEnd();
    read_own(a, "after drawing,");
}

/*
 * Reads the X server's picture, because llvmpipe's glReadPixels reads only one sample of a
 * multisampled window.
 */
static void after(app *a)
{
    image picture = window_shot(&a->window);
    int intermediate = 0;
    read_own(a, "after the swap,");
    for (int y = 0; y < picture.height; y++) {
        for (int x = 1; x + 1 < picture.width; x++) {
            int left = image_at(&picture, x - 1, y)[0], right = image_at(&picture, x + 1, y)[0];
            int bright = left > right ? left : right, dark = left > right ? right : left;
            int value = image_at(&picture, x, y)[0];
            intermediate += dark == 0 && bright > 64 && value * 10 > bright && value * 10 < bright * 9;
        }
    }
    app_check(a, intermediate > 20, "only %d pixels are between black and the cube", intermediate);
    image_free(&picture);
}

int main(int argc, char **argv)
{
    char *with_samples[64];
    int count = 0;
    for (; count < argc && count < 60; count++)
        with_samples[count] = argv[count];
    with_samples[count++] = "--samples";
    with_samples[count++] = "4";
    static const app_program self = {"multisample", API_GL_COMPATIBILITY, 0, 0, setup, draw, after};
    return app_main(count, with_samples, &self);
}
