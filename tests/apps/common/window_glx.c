#include "window.h"

#include <GL/glx.h>
#include <GL/glxext.h>
#include <stdio.h>
#include <stdlib.h>

static void fail(const char *message)
{
    fprintf(stderr, "%s\n", message);
    exit(1);
}

void window_open_glx(window *w, const window_request *request)
{
    int multisampled[] = {
        GLX_X_RENDERABLE, True, GLX_DRAWABLE_TYPE, GLX_WINDOW_BIT, GLX_RENDER_TYPE, GLX_RGBA_BIT,
        GLX_X_VISUAL_TYPE, GLX_TRUE_COLOR, GLX_RED_SIZE, 8, GLX_GREEN_SIZE, 8, GLX_BLUE_SIZE, 8,
        GLX_DEPTH_SIZE, 24, GLX_STENCIL_SIZE, 8, GLX_DOUBLEBUFFER, !request->single,
        GLX_ACCUM_RED_SIZE, request->accumulation ? 8 : 0, GLX_ACCUM_GREEN_SIZE, request->accumulation ? 8 : 0,
        GLX_ACCUM_BLUE_SIZE, request->accumulation ? 8 : 0,
        GLX_SAMPLE_BUFFERS, request->samples > 0, GLX_SAMPLES, request->samples,
        GLX_FRAMEBUFFER_SRGB_CAPABLE_ARB, request->srgb ? True : (int)GLX_DONT_CARE, None,
    };
    int count = 0;
    GLXFBConfig *configs = glXChooseFBConfig(w->display, DefaultScreen(w->display), multisampled, &count);
    if (configs == NULL || count == 0)
        fail("no GLX configuration");
    GLXFBConfig config = configs[0];
    XFree(configs);
    XVisualInfo *visual = glXGetVisualFromFBConfig(w->display, config);
    if (visual == NULL)
        fail("the GLX configuration has no visual");
    window_create_x11(w, request, visual);
    XFree(visual);

    GLXContext context;
    if (request->api == API_GL_CORE) {
        PFNGLXCREATECONTEXTATTRIBSARBPROC create = (PFNGLXCREATECONTEXTATTRIBSARBPROC)glXGetProcAddressARB(
            (const GLubyte *)"glXCreateContextAttribsARB");
        const int attributes[] = {
            GLX_CONTEXT_MAJOR_VERSION_ARB, request->major, GLX_CONTEXT_MINOR_VERSION_ARB, request->minor,
            GLX_CONTEXT_PROFILE_MASK_ARB, GLX_CONTEXT_CORE_PROFILE_BIT_ARB, None,
        };
        context = create != NULL ? create(w->display, config, NULL, True, attributes) : NULL;
    } else {
        context = glXCreateNewContext(w->display, config, GLX_RGBA_TYPE, NULL, True);
    }
    if (context == NULL)
        fail("cannot create the GLX context");
    w->config = config;
    w->context = context;
}

void window_make_current_glx(const window *w)
{
    if (!glXMakeCurrent(w->display, w->window, w->context))
        fail("glXMakeCurrent failed");
}

void window_release_glx(const window *w)
{
    if (!glXMakeCurrent(w->display, None, NULL))
        fail("glXMakeCurrent of nothing failed");
}

void window_swap_glx(const window *w)
{
    glXSwapBuffers(w->display, w->window);
}

void window_close_glx(window *w)
{
    glXMakeCurrent(w->display, None, NULL);
    glXDestroyContext(w->display, w->context);
}
