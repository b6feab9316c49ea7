#include "app.h"

#include "target.h"
#include "waiting.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const double degree = 3.14159265358979323846 / 180.0;

static void usage(const char *name)
{
    fprintf(stderr,
            "usage: %s [--fov DEG] [--yaw DEG] [--pitch DEG] [--frames N] [--size WxH] [--at X,Y] [--samples N] [--egl]\n"
            "       [--near N] [--far N] [--srgb] [--single] [--fbo] [--mode NAME] [--dump FILE.ppm]\n"
            "       [--shot FILE.ppm] [--answers FILE] [--seed N] [--accumulation]\n",
            name);
    exit(2);
}

static void parse(app *a, int argc, char **argv)
{
    for (int i = 1; i < argc; i++) {
        const char *option = argv[i];
        if (strcmp(option, "--fbo") == 0) {
            a->fbo = true;
            continue;
        }
        if (strcmp(option, "--single") == 0) {
            a->request.single = true;
            continue;
        }
        if (strcmp(option, "--accumulation") == 0) {
            a->request.accumulation = true;
            continue;
        }
        if (strcmp(option, "--egl") == 0) {
            a->request.egl = true;
            continue;
        }
        if (strcmp(option, "--srgb") == 0) {
            a->request.srgb = true;
            continue;
        }
        const char *value = i + 1 < argc ? argv[++i] : NULL;
        if (value == NULL)
            usage(argv[0]);
        else if (strcmp(option, "--fov") == 0)
            a->fov = atof(value);
        else if (strcmp(option, "--yaw") == 0)
            a->yaw = atof(value);
        else if (strcmp(option, "--pitch") == 0)
            a->pitch = atof(value);
        else if (strcmp(option, "--near") == 0)
            a->near = atof(value);
        else if (strcmp(option, "--far") == 0)
            a->far = atof(value);
        else if (strcmp(option, "--frames") == 0)
            a->frames = atoi(value);
        else if (strcmp(option, "--answers") == 0)
            a->answers = value;
        else if (strcmp(option, "--seed") == 0)
            a->seed = (unsigned)strtoul(value, NULL, 10);
        else if (strcmp(option, "--samples") == 0)
            a->request.samples = atoi(value);
        else if (strcmp(option, "--at") == 0 && sscanf(value, "%d,%d", &a->request.x, &a->request.y) == 2)
            continue;
        else if (strcmp(option, "--mode") == 0)
            a->mode = value;
        else if (strcmp(option, "--dump") == 0)
            a->dump = value;
        else if (strcmp(option, "--shot") == 0)
            a->shot = value;
        else if (strcmp(option, "--size") != 0 ||
                 sscanf(value, "%dx%d", &a->request.width, &a->request.height) != 2 || a->request.width < 1 ||
                 a->request.height < 1)
            usage(argv[0]);
    }
}

void app_update_matrices(app *a)
{
    double aspect = (double)a->window.width / a->window.height;
    a->projection = matrix_perspective(a->fov, aspect, a->near, a->far);
    a->view = matrix_camera(a->yaw, a->pitch);
    a->modelview = matrix_multiply(a->view, matrix_scale(CUBE_SCALE));
}

void app_clear(void)
{
    glClearColor(0.25f, 0.25f, 0.25f, 1.0f);
    glClear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
    glEnable(GL_DEPTH_TEST);
    glDisable(GL_CULL_FACE);
}

bool app_is_first_read(const app *a)
{
    if (a->frame > 0)
        return false;
    unsigned char pixel[4];
    glReadPixels(0, 0, 1, 1, GL_RGBA, GL_UNSIGNED_BYTE, pixel);
    return true;
}

void app_check(app *a, bool good, const char *format, ...)
{
    if (good)
        return;
    /* Only the first findings are printed. A thousand would hide them. */
    if (a->complaints++ < 20) {
        va_list arguments;
        va_start(arguments, format);
        fprintf(stderr, "frame %d: ", a->frame);
        vfprintf(stderr, format, arguments);
        fprintf(stderr, "\n");
        va_end(arguments);
    }
}

void app_check_error(app *a, const char *where)
{
    GLenum error = glGetError();
    app_check(a, error == GL_NO_ERROR, "GL error 0x%x %s", error, where);
}

void app_expected_colour(const app *a, int x, int y, double rgb[3])
{
    double height = tan(0.5 * a->fov * degree), width = height * a->window.width / a->window.height;
    double eye[3] = {
        width * ((x + 0.5) / a->window.width * 2.0 - 1.0),
        height * (1.0 - (y + 0.5) / a->window.height * 2.0),
        -1.0,
    };
    double cp = cos(a->pitch * degree), sp = sin(a->pitch * degree);
    double cy = cos(a->yaw * degree), sy = sin(a->yaw * degree);
    double pitched[3] = {eye[0], cp * eye[1] - sp * eye[2], sp * eye[1] + cp * eye[2]};
    double world[3] = {cy * pitched[0] - sy * pitched[2], pitched[1], sy * pitched[0] + cy * pitched[2]};
    double longest = fmax(fabs(world[0]), fmax(fabs(world[1]), fabs(world[2])));
    for (int i = 0; i < 3; i++)
        rgb[i] = 255.0 * (0.5 + 0.5 * world[i] / longest);
}

void app_check_cube_picture(app *a, const image *picture, const char *what)
{
    for (int row = 0; row < 16; row++) {
        for (int column = 0; column < 16; column++) {
            int x = (2 * column + 1) * picture->width / 32, y = (2 * row + 1) * picture->height / 32;
            double expected[3];
            app_expected_colour(a, x, y, expected);
            const unsigned char *rgb = image_at(picture, x, y);
            for (int i = 0; i < 3; i++) {
                app_check(a, fabs(rgb[i] - expected[i]) <= 2.0, "%s: pixel (%d, %d) channel %d is %d instead of %.1f",
                          what, x, y, i, rgb[i], expected[i]);
            }
        }
    }
}

int app_main(int argc, char **argv, const app_program *program)
{
    app a;
    memset(&a, 0, sizeof a);
    a.fov = 75.0;
    a.near = CUBE_NEAR;
    a.far = CUBE_FAR;
    a.request.api = program->api;
    a.request.major = program->major;
    a.request.minor = program->minor;
    a.request.width = a.request.height = 320;
    parse(&a, argc, argv);

    a.window = window_open(&a.request);
#if !defined(APP_GLES)
    if (a.request.srgb)
        glEnable(GL_FRAMEBUFFER_SRGB);
#endif
    app_update_matrices(&a);
    glViewport(0, 0, a.window.width, a.window.height);
    if (program->setup != NULL)
        program->setup(&a);
    target own;
    if (a.fbo)
        own = target_create(a.window.width, a.window.height);
    app_check_error(&a, "after the set-up");

    for (a.frame = 0; a.frames == 0 || a.frame < a.frames; a.frame += frame_counts()) {
        if (a.fbo)
            target_bind(&own);
        program->draw(&a);
        app_check_error(&a, "after drawing");
        if (a.dump != NULL) {
            image picture = image_read_framebuffer(a.window.width, a.window.height);
            app_check(&a, image_write_ppm(&picture, a.dump), "cannot write %s", a.dump);
            image_free(&picture);
        }
        if (a.fbo)
            target_present(&own);
        if (a.request.single)
            glFlush();
        else
            window_swap(&a.window);
        app_check_error(&a, "after the swap");
        if (a.shot != NULL) {
            image picture = window_shot(&a.window);
            app_check(&a, image_write_ppm(&picture, a.shot), "cannot write %s", a.shot);
            image_free(&picture);
        }
        if (program->after != NULL)
            program->after(&a);
    }
    if (a.complaints > 20)
        fprintf(stderr, "… and %d findings more\n", a.complaints - 20);
    window_close(&a.window);
    XCloseDisplay(a.window.display);
    return a.complaints == 0 ? 0 : 1;
}
