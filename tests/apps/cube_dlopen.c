/*
 * Direction test by a program that does not link GL. It loads libGL with dlopen(RTLD_LOCAL), as
 * GLFW and SDL do, and gets the GLX calls by dlsym and the GL calls by glXGetProcAddressARB.
 */
#include "common/cube.h"
#include "common/matrix.h"

#include <GL/gl.h>
#include <GL/glx.h>
#include <X11/Xlib.h>
#include <X11/Xutil.h>
#include <dlfcn.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static void *library;

static void fail(const char *message)
{
    fprintf(stderr, "%s\n", message);
    exit(1);
}

/*
 * ISO C cannot convert an object's address to a function's address. The bits are copied, as POSIX
 * recommends.
 */
static void load(void *function, const char *name)
{
    void *address = dlsym(library, name);
    if (address == NULL)
        fail(name);
    memcpy(function, &address, sizeof address);
}

static __GLXextFuncPtr (*get_proc_address)(const GLubyte *);

static void ask(void *function, const char *name)
{
    __GLXextFuncPtr address = get_proc_address((const GLubyte *)name);
    if (address == NULL)
        fail(name);
    memcpy(function, &address, sizeof address);
}

int main(int argc, char **argv)
{
    double fov = 75.0, yaw = 0.0, pitch = 0.0;
    int frames = 0, close = 0, x = 0, y = 0, width = 320, height = 320;
    for (int i = 1; i + 1 < argc; i += 2) {
        if (strcmp(argv[i], "--fov") == 0)
            fov = atof(argv[i + 1]);
        else if (strcmp(argv[i], "--yaw") == 0)
            yaw = atof(argv[i + 1]);
        else if (strcmp(argv[i], "--pitch") == 0)
            pitch = atof(argv[i + 1]);
        else if (strcmp(argv[i], "--frames") == 0)
            frames = atoi(argv[i + 1]);
        else if (strcmp(argv[i], "--close") == 0)
            close = atoi(argv[i + 1]);
        else if (strcmp(argv[i], "--at") == 0 && sscanf(argv[i + 1], "%d,%d", &x, &y) == 2)
            continue;
        else if (strcmp(argv[i], "--size") != 0 || sscanf(argv[i + 1], "%dx%d", &width, &height) != 2)
            fail("usage: cube_dlopen [--fov DEG] [--yaw DEG] [--pitch DEG] [--frames N] [--at X,Y] [--size WxH]"
                 " [--close 1]");
    }

    library = dlopen("libGL.so.1", RTLD_LAZY | RTLD_LOCAL);
    if (library == NULL)
        fail(dlerror());
    XVisualInfo *(*choose_visual)(Display *, int, int *);
    GLXContext (*create_context)(Display *, XVisualInfo *, GLXContext, Bool);
    Bool (*make_current)(Display *, GLXDrawable, GLXContext);
    void (*swap_buffers)(Display *, GLXDrawable);
    load(&get_proc_address, "glXGetProcAddressARB");
    load(&choose_visual, "glXChooseVisual");
    load(&create_context, "glXCreateContext");
    load(&make_current, "glXMakeCurrent");
    load(&swap_buffers, "glXSwapBuffers");

    Display *display = XOpenDisplay(NULL);
    if (display == NULL)
        fail("cannot open the X display");
    int wanted[] = {GLX_RGBA, GLX_DOUBLEBUFFER, GLX_RED_SIZE, 8, GLX_GREEN_SIZE, 8, GLX_BLUE_SIZE, 8, GLX_DEPTH_SIZE,
                    24, None};
    XVisualInfo *visual = choose_visual(display, DefaultScreen(display), wanted);
    if (visual == NULL)
        fail("no visual");
    Window root = RootWindow(display, visual->screen);
    XSetWindowAttributes attributes;
    memset(&attributes, 0, sizeof attributes);
    attributes.colormap = XCreateColormap(display, root, visual->visual, AllocNone);
    attributes.event_mask = StructureNotifyMask;
    Window window = XCreateWindow(display, root, x, y, (unsigned)width, (unsigned)height, 0, visual->depth, InputOutput,
                                  visual->visual, CWColormap | CWEventMask | CWBorderPixel, &attributes);
    XMapWindow(display, window);
    XEvent event;
    do {
        XNextEvent(display, &event);
    } while (event.type != MapNotify);
    GLXContext context = create_context(display, visual, NULL, True);
    if (context == NULL || !make_current(display, window, context))
        fail("no context");

    void (*viewport)(GLint, GLint, GLsizei, GLsizei);
    void (*clear)(GLbitfield), (*enable)(GLenum), (*matrix_mode)(GLenum), (*load_matrix)(const GLfloat *);
    void (*begin)(GLenum), (*end)(void), (*colour)(const GLfloat *), (*vertex)(const GLfloat *);
    GLenum (*get_error)(void);
    ask(&viewport, "glViewport");
    ask(&clear, "glClear");
    ask(&enable, "glEnable");
    ask(&matrix_mode, "glMatrixMode");
    ask(&load_matrix, "glLoadMatrixf");
    ask(&begin, "glBegin");
    ask(&end, "glEnd");
    ask(&colour, "glColor3fv");
    load(&vertex, "glVertex3fv");
    load(&get_error, "glGetError");

    matrix4 projection = matrix_perspective(fov, (double)width / height, CUBE_NEAR, CUBE_FAR);
    matrix4 modelview = matrix_multiply(matrix_camera(yaw, pitch), matrix_scale(CUBE_SCALE));
    int wrong = 0;
    viewport(0, 0, width, height);
    for (int frame = 0; frames == 0 || frame < frames; frame++) {
        clear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
        enable(GL_DEPTH_TEST);
        matrix_mode(GL_PROJECTION);
        load_matrix(projection.m);
        matrix_mode(GL_MODELVIEW);
        load_matrix(modelview.m);
        begin(GL_TRIANGLES);
        for (int i = 0; i < CUBE_INDICES; i++) {
            colour(cube_colours[cube_indices[i]]);
            vertex(cube_positions[cube_indices[i]]);
        }
        end();
        swap_buffers(display, window);
        GLenum error = get_error();
        if (error != GL_NO_ERROR) {
            fprintf(stderr, "frame %d: GL error 0x%x\n", frame, error);
            wrong = 1;
        }
    }
    if (close) {
        void (*destroy_context)(Display *, GLXContext);
        load(&destroy_context, "glXDestroyContext");
        make_current(display, None, NULL);
        destroy_context(display, context);
        XCloseDisplay(display);
        dlclose(library);
    }
    return wrong;
}
