#include "window.h"

#include <EGL/egl.h>
#include <X11/Xutil.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#ifndef EGL_OPENGL_ES3_BIT
#define EGL_OPENGL_ES3_BIT 0x0040
#endif
#ifndef EGL_CONTEXT_MINOR_VERSION
#define EGL_CONTEXT_MINOR_VERSION 0x30FB
#define EGL_CONTEXT_OPENGL_PROFILE_MASK 0x30FD
#define EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT 0x00000001
#endif

static void fail(const char *message)
{
    fprintf(stderr, "%s (EGL error 0x%x)\n", message, (unsigned)eglGetError());
    exit(1);
}

static EGLint renderable_bit(const window_request *request)
{
    if (request->api != API_GLES)
        return EGL_OPENGL_BIT;
    return request->major >= 3 ? EGL_OPENGL_ES3_BIT : EGL_OPENGL_ES2_BIT;
}

void window_open_egl(window *w, const window_request *request)
{
    EGLDisplay display = eglGetDisplay((EGLNativeDisplayType)w->display);
    if (display == EGL_NO_DISPLAY || !eglInitialize(display, NULL, NULL))
        fail("cannot initialise EGL on the X display");
    if (!eglBindAPI(request->api == API_GLES ? EGL_OPENGL_ES_API : EGL_OPENGL_API))
        fail("eglBindAPI failed");
    const EGLint wanted[] = {
        EGL_SURFACE_TYPE, EGL_WINDOW_BIT, EGL_RENDERABLE_TYPE, renderable_bit(request),
        EGL_RED_SIZE, 8, EGL_GREEN_SIZE, 8, EGL_BLUE_SIZE, 8, EGL_ALPHA_SIZE, 0, EGL_DEPTH_SIZE, 24, EGL_STENCIL_SIZE, 8,
        EGL_SAMPLE_BUFFERS, request->samples > 0, EGL_SAMPLES, request->samples, EGL_NONE,
    };
    EGLConfig configs[64];
    EGLint count = 0;
    if (!eglChooseConfig(display, wanted, configs, 64, &count) || count == 0)
        fail("no EGL configuration");

    /*
     * Uses the first configuration with the screen's own visual. A deeper visual would need a
     * compositor.
     */
    XVisualInfo *visual = NULL;
    EGLConfig config = configs[0];
    for (int i = 0; i < count && visual == NULL; i++) {
        EGLint id = 0;
        int found = 0;
        eglGetConfigAttrib(display, configs[i], EGL_NATIVE_VISUAL_ID, &id);
        XVisualInfo pattern;
        memset(&pattern, 0, sizeof pattern);
        pattern.visualid = (VisualID)id;
        visual = XGetVisualInfo(w->display, VisualIDMask, &pattern, &found);
        if (visual != NULL && visual->depth != 24) {
            XFree(visual);
            visual = NULL;
        }
        config = configs[i];
    }
    if (visual == NULL)
        fail("no EGL configuration has a 24-bit visual");
    window_create_x11(w, request, visual);
    XFree(visual);

    EGLSurface surface = eglCreateWindowSurface(display, config, (EGLNativeWindowType)w->window, NULL);
    if (surface == EGL_NO_SURFACE)
        fail("cannot create the EGL surface");
    const EGLint gles[] = {EGL_CONTEXT_CLIENT_VERSION, request->major, EGL_NONE};
    const EGLint core[] = {
        EGL_CONTEXT_CLIENT_VERSION, request->major, EGL_CONTEXT_MINOR_VERSION, request->minor,
        EGL_CONTEXT_OPENGL_PROFILE_MASK, EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT, EGL_NONE,
    };
    const EGLint compatibility[] = {EGL_NONE};
    const EGLint *attributes = request->api == API_GLES ? gles : request->api == API_GL_CORE ? core : compatibility;
    EGLContext context = eglCreateContext(display, config, EGL_NO_CONTEXT, attributes);
    if (context == EGL_NO_CONTEXT)
        fail("cannot create the EGL context");
    w->egl_display = display;
    w->egl_surface = surface;
    w->config = config;
    w->context = context;
}

void window_make_current_egl(const window *w)
{
    if (!eglMakeCurrent(w->egl_display, w->egl_surface, w->egl_surface, w->context))
        fail("eglMakeCurrent failed");
}

void window_release_egl(const window *w)
{
    if (!eglMakeCurrent(w->egl_display, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT))
        fail("eglMakeCurrent of nothing failed");
}

void window_swap_egl(const window *w)
{
    if (!eglSwapBuffers(w->egl_display, w->egl_surface))
        fail("eglSwapBuffers failed");
}

void window_close_egl(window *w)
{
    eglMakeCurrent(w->egl_display, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
    eglDestroyContext(w->egl_display, w->context);
    eglDestroySurface(w->egl_display, w->egl_surface);
}
