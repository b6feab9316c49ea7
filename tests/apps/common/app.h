/* Parts that the test programs share: options, the frame loop, pictures, checks. */
#ifndef APPS_APP_H
#define APPS_APP_H

#include "cube.h"
#include "gl.h"
#include "matrix.h"
#include "window.h"

#include <stdbool.h>

typedef struct app {
    /* Options. */
    double fov;        /* vertical field of view in degrees */
    double yaw, pitch; /* turn of the camera in degrees, right- and up-positive */
    double near, far;  /* near and far plane; the cube is 10 away, its corners 17.3 */
    int frames;        /* frames to present; 0: until the program is killed */
    bool fbo;          /* draw into a framebuffer object, then copy it to the window */
    const char *mode;  /* mode of the program; NULL: its first */
    const char *dump;  /* PPM file for glReadPixels before each swap */
    const char *shot;  /* PPM file for the X server's picture after each swap */
    const char *answers; /* text file, for programs that write OpenGL's answers */
    unsigned seed;       /* seed for random actions */
    window_request request;

    /* State. */
    window window;
    int frame;                           /* number of the frame that is drawn, from 0 */
    matrix4 projection, view, modelview; /* modelview = view * scale(CUBE_SCALE) */
    int complaints;
} app;

/* A program: the context that it needs, and its functions. Any function but draw may be NULL. */
typedef struct {
    const char *name;
    window_api api;
    int major, minor;
    void (*setup)(app *a); /* once, with the context current */
    void (*draw)(app *a);  /* in each frame; must also clear */
    void (*after)(app *a); /* in each frame, after the swap */
} app_program;

/* Runs the program: returns the exit status of main, 0 or 1. */
int app_main(int argc, char **argv, const app_program *program);

/* Computes projection, view and modelview for the window's size. app_main calls it before setup. */
void app_update_matrices(app *a);

/*
 * Reads a pixel of the window in the first frame. Cupola may answer a program's first read-back
 * from other pictures than the program's own, and then writes a message. From the next frame on the
 * answers are checked.
 * Returns whether this is the first frame.
 */
bool app_is_first_read(const app *a);

/* The clears with which every direction test begins a frame. The cube never has this colour. */
void app_clear(void);

/* Counts and prints a finding when `good` is false. The program then exits with 1. */
void app_check(app *a, bool good, const char *format, ...);

/* Checks that no GL error is pending. */
void app_check_error(app *a, const char *where);

/* Colour of the cube in the middle of pixel (x, y from the top) of the plain window, 0...255. */
void app_expected_colour(const app *a, int x, int y, double rgb[3]);

/* Compares pixels of a picture from glReadPixels with app_expected_colour, on a 16 x 16 grid. */
void app_check_cube_picture(app *a, const image *picture, const char *what);

#endif
