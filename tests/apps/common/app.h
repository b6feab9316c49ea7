/* What the test programs share: options, the frame loop, pictures, checks. */
#ifndef APPS_APP_H
#define APPS_APP_H

#include "cube.h"
#include "gl.h"
#include "matrix.h"
#include "window.h"

#include <stdbool.h>

typedef struct app {
    /* Options. */
    double fov;        /* vertical field of view, degrees */
    double yaw, pitch; /* camera turn, degrees, right- and up-positive */
    double near, far;  /* planes of the camera; the cube is 10 away, its corners 17.3 */
    int frames;        /* frames to present; 0: until killed */
    bool fbo;          /* draw into an FBO of our own, then copy it to the window */
    const char *mode;  /* which of a program's ways; NULL: its first */
    const char *dump;  /* PPM of glReadPixels before each swap */
    const char *shot;  /* PPM of what the X server shows after each swap */
    window_request request;

    /* State. */
    window window;
    int frame;                           /* number of the frame that is being drawn, from 0 */
    matrix4 projection, view, modelview; /* modelview = view * scale(CUBE_SCALE) */
    int complaints;
} app;

/* One program: how it asks for its context and what it draws. Any function but draw may be NULL. */
typedef struct {
    const char *name;
    window_api api;
    int major, minor;
    void (*setup)(app *a); /* once, with the context current */
    void (*draw)(app *a);  /* each frame; clears too */
    void (*after)(app *a); /* each frame, after the swap and before the next frame */
} app_program;

/* Runs the program: returns the exit status of main, 0 or 1. */
int app_main(int argc, char **argv, const app_program *program);

/* Computes projection, view and modelview for the window's size. app_main calls it before setup. */
void app_update_matrices(app *a);

/*
 * Reads a pixel of the window in the first frame. Cupola may answer a program's first read-back from other
 * pictures than its own, and says so; from the next frame on the answers are judged.
 * Returns whether this is the first frame.
 */
bool app_is_first_read(const app *a);

/* The clears that every direction test begins a frame with. The colour is one the cube never has. */
void app_clear(void);

/* Counts and prints a finding when `good` is false. The program then exits with 1. */
void app_check(app *a, bool good, const char *format, ...);

/* Checks that no GL error is pending. */
void app_check_error(app *a, const char *where);

/* The colour that the cube has in the middle of pixel (x, y from the top) of the plain window, 0...255. */
void app_expected_colour(const app *a, int x, int y, double rgb[3]);

/* Checks pixels of a picture that glReadPixels gave against app_expected_colour, on a 16 x 16 grid. */
void app_check_cube_picture(app *a, const image *picture, const char *what);

#endif
