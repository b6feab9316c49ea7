#include "window.h"

#include "gl.h"
#include "x11.h"

#include <X11/Xutil.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static void fail(const char *message)
{
    fprintf(stderr, "%s\n", message);
    exit(1);
}

void window_create_x11(window *w, const window_request *request, void *visual_info)
{
    const XVisualInfo *visual = visual_info;
    Window root = RootWindow(w->display, visual->screen);
    XSetWindowAttributes attributes;
    memset(&attributes, 0, sizeof attributes);
    attributes.colormap = XCreateColormap(w->display, root, visual->visual, AllocNone);
    attributes.event_mask = StructureNotifyMask | ExposureMask | KeyPressMask;
    w->window = XCreateWindow(w->display, root, request->x, request->y, (unsigned)request->width,
                              (unsigned)request->height, 0, visual->depth, InputOutput, visual->visual,
                              CWColormap | CWEventMask | CWBorderPixel, &attributes);
    w->width = request->width;
    w->height = request->height;
    XStoreName(w->display, w->window, "cupola test");
    x11_map(w->display, w->window);
}

static void open_on(window *w, const window_request *request)
{
    w->egl = request->egl || request->api == API_GLES;
    if (w->egl) {
        window_open_egl(w, request);
    } else {
#if defined(APP_GLES)
        fail("GLES needs EGL");
#else
        window_open_glx(w, request);
#endif
    }
    window_make_current(w);
}

window window_open(const window_request *request)
{
    window w;
    memset(&w, 0, sizeof w);
    w.display = x11_open();
    open_on(&w, request);
    return w;
}

window window_open_beside(const window *first, const window_request *request)
{
    window w;
    memset(&w, 0, sizeof w);
    w.display = first->display;
    open_on(&w, request);
    return w;
}

void window_make_current(const window *w)
{
#if !defined(APP_GLES)
    if (!w->egl) {
        window_make_current_glx(w);
        return;
    }
#endif
    window_make_current_egl(w);
}

void window_release(const window *w)
{
#if !defined(APP_GLES)
    if (!w->egl) {
        window_release_glx(w);
        return;
    }
#endif
    window_release_egl(w);
}

void window_swap(const window *w)
{
#if !defined(APP_GLES)
    if (!w->egl) {
        window_swap_glx(w);
        return;
    }
#endif
    window_swap_egl(w);
}

void window_resize(window *w, int width, int height)
{
    x11_resize(w->display, w->window, width, height);
    w->width = width;
    w->height = height;
}

void window_show(const window *w, bool shown)
{
    if (shown)
        XMapWindow(w->display, w->window);
    else
        XUnmapWindow(w->display, w->window);
    XWindowAttributes now;
    do {
        XGetWindowAttributes(w->display, w->window, &now);
    } while ((now.map_state == IsViewable) != shown);
}

image window_shot(const window *w)
{
    glFinish();
    XSync(w->display, False);
    XImage *shot = XGetImage(w->display, w->window, 0, 0, (unsigned)w->width, (unsigned)w->height, AllPlanes, ZPixmap);
    if (shot == NULL)
        fail("XGetImage failed");
    if (shot->red_mask != 0xff0000 || shot->green_mask != 0xff00 || shot->blue_mask != 0xff)
        fail("the window is not 8-bit RGB");
    image picture = image_new(w->width, w->height);
    unsigned char *to = picture.rgb;
    for (int y = 0; y < w->height; y++) {
        for (int x = 0; x < w->width; x++) {
            unsigned long pixel = XGetPixel(shot, x, y);
            *to++ = (unsigned char)(pixel >> 16);
            *to++ = (unsigned char)(pixel >> 8);
            *to++ = (unsigned char)pixel;
        }
    }
    XDestroyImage(shot);
    return picture;
}

void window_close(window *w)
{
#if !defined(APP_GLES)
    if (!w->egl)
        window_close_glx(w);
#endif
    if (w->egl)
        window_close_egl(w);
    XDestroyWindow(w->display, w->window);
    XSync(w->display, False);
}
