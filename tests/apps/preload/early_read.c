/*
 * An LD_PRELOAD library for programs that use GLX or libwaffle. It reads one pixel when a context
 * becomes current for the first time. Under Cupola such a program has its own picture from the
 * first frame on. Otherwise it has it only from the frame after its first read.
 */
#define _GNU_SOURCE
#include <GL/glx.h>
#include <dlfcn.h>
#include <pthread.h>
#include <stdbool.h>
#include <stddef.h>

enum { CONTEXTS = 256 };

typedef void (*function)(void);
typedef function (*find_function)(const char *name);

/* The next definition of a function after the one in this library. */
static function next(const char *name)
{
    function found;
    *(void **)&found = dlsym(RTLD_NEXT, name);
    return found;
}

static function command(const char *name)
{
    static const char *const finders[] = {"glXGetProcAddressARB", "eglGetProcAddress"};
    function found = next(name);
    for (int i = 0; found == NULL && i < 2; i++) {
        find_function find = (find_function)next(finders[i]);
        if (find != NULL)
            found = find(name);
    }
    return found;
}

static bool is_new(const void *context)
{
    static const void *known[CONTEXTS];
    static pthread_mutex_t lock = PTHREAD_MUTEX_INITIALIZER;
    bool new = context != NULL;
    pthread_mutex_lock(&lock);
    for (int i = 0; new && i < CONTEXTS; i++) {
        if (known[i] == NULL) {
            known[i] = context;
            break;
        }
        new = known[i] != context;
    }
    pthread_mutex_unlock(&lock);
    return new;
}

static void read_pixel(const void *context)
{
    if (!is_new(context))
        return;
    unsigned char pixel[4];
    void (*read)(GLint, GLint, GLsizei, GLsizei, GLenum, GLenum, void *) =
        (void (*)(GLint, GLint, GLsizei, GLsizei, GLenum, GLenum, void *))command("glReadPixels");
    GLenum (*error)(void) = (GLenum(*)(void))command("glGetError");
    if (read == NULL || error == NULL)
        return;
    read(0, 0, 1, 1, GL_RGBA, GL_UNSIGNED_BYTE, pixel);
    /* A context without a window refuses the read. */
    error();
}

bool waffle_make_current(void *display, void *window, void *context)
{
    bool (*real)(void *, void *, void *) = (bool (*)(void *, void *, void *))next("waffle_make_current");
    if (!real(display, window, context))
        return false;
    read_pixel(context);
    return true;
}

Bool glXMakeCurrent(Display *display, GLXDrawable drawable, GLXContext context)
{
    Bool (*real)(Display *, GLXDrawable, GLXContext) =
        (Bool(*)(Display *, GLXDrawable, GLXContext))next("glXMakeCurrent");
    if (!real(display, drawable, context))
        return False;
    read_pixel(context);
    return True;
}

Bool glXMakeContextCurrent(Display *display, GLXDrawable draw, GLXDrawable read, GLXContext context)
{
    Bool (*real)(Display *, GLXDrawable, GLXDrawable, GLXContext) =
        (Bool(*)(Display *, GLXDrawable, GLXDrawable, GLXContext))next("glXMakeContextCurrent");
    if (!real(display, draw, read, context))
        return False;
    read_pixel(context);
    return True;
}
