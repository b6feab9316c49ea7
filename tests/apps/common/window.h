/* An X11 window with a GL context, by GLX or by EGL. Failures end the program with a message. */
#ifndef APPS_WINDOW_H
#define APPS_WINDOW_H

#include "image.h"

#include <X11/Xlib.h>
#include <stdbool.h>

typedef enum {
    API_GL_COMPATIBILITY,
    API_GL_CORE,
    API_GLES
} window_api;

typedef struct {
    window_api api;
    int major, minor; /* requested version; compatibility contexts ignore it */
    int x, y, width, height; /* x, y: place on the screen; XGetImage returns the topmost windows */
    int samples; /* number of samples; 0: no multisampling */
    bool single; /* one buffer: drawing is visible after a flush; GLX only */
    bool accumulation; /* with an accumulation buffer; GLX only */
    bool srgb;   /* written colours are encoded as sRGB; GLX only */
    bool egl;    /* EGL instead of GLX; always for API_GLES */
} window_request;

typedef struct {
    Display *display;
    Window window;
    int width, height;
    bool egl;
    void *config;  /* GLXFBConfig or EGLConfig */
    void *context; /* GLXContext or EGLContext */
    void *egl_display, *egl_surface;
} window;

/* Opens and maps a window, and makes its context current. */
window window_open(const window_request *request);

/* Opens a second window on the same display with a separate context. */
window window_open_beside(const window *first, const window_request *request);

void window_make_current(const window *w);

/* Makes no context current. */
void window_release(const window *w);

void window_swap(const window *w);

/* Asks for another size, and waits until the server has given it. */
void window_resize(window *w, int width, int height);

/* Maps or unmaps the window, and waits until that is done. */
void window_show(const window *w, bool shown);

/* Picture that the X server shows in the window, that is, the last presented picture. */
image window_shot(const window *w);

void window_close(window *w);

/* Functions that only the files of window.h use. */
void window_create_x11(window *w, const window_request *request, void *visual_info);
void window_open_glx(window *w, const window_request *request);
void window_open_egl(window *w, const window_request *request);
void window_make_current_glx(const window *w);
void window_make_current_egl(const window *w);
void window_release_glx(const window *w);
void window_release_egl(const window *w);
void window_swap_glx(const window *w);
void window_swap_egl(const window *w);
void window_close_glx(window *w);
void window_close_egl(window *w);

#endif
