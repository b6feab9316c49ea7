/*
 * An LD_PRELOAD library that replaces malloc and related functions. It counts the heap allocations
 * that Cupola makes in steady frames, that is, calls from Cupola's library. Rust's runtime is part
 * of that library, but allocations that the driver makes for Cupola are not counted. A frame ends
 * with a swap, or when a program calls steady_frame().
 *
 * STEADY_REPORT: file that gets the number and the places of the calls after frame LAST. Places are
 * offsets in the library for addr2line.
 */
#define _GNU_SOURCE
#include <EGL/egl.h>
#include <GL/glx.h>
#include <dlfcn.h>
#include <errno.h>
#include <link.h>
#include <pthread.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { FIRST = 20, LAST = 200, PLACES = 32 };

extern void *__libc_malloc(size_t size);
extern void *__libc_calloc(size_t count, size_t size);
extern void *__libc_realloc(void *old, size_t size);
extern void *__libc_memalign(size_t alignment, size_t size);

static int frame;
/* Address of Cupola's library, and of its executable part. */
static uintptr_t base, start, end;
static unsigned long count;
static uintptr_t places[PLACES];
static pthread_mutex_t lock = PTHREAD_MUTEX_INITIALIZER;

static void note(const void *caller)
{
    uintptr_t address = (uintptr_t)caller;
    if (frame < FIRST || frame >= LAST || address < start || address >= end)
        return;
    pthread_mutex_lock(&lock);
    count++;
    for (int i = 0; i < PLACES; i++) {
        if (places[i] == 0)
            places[i] = address - base;
        if (places[i] == address - base)
            break;
    }
    pthread_mutex_unlock(&lock);
}

void *malloc(size_t size)
{
    note(__builtin_return_address(0));
    return __libc_malloc(size);
}

void *calloc(size_t number, size_t size)
{
    note(__builtin_return_address(0));
    return __libc_calloc(number, size);
}

void *realloc(void *old, size_t size)
{
    note(__builtin_return_address(0));
    return __libc_realloc(old, size);
}

int posix_memalign(void **block, size_t alignment, size_t size)
{
    note(__builtin_return_address(0));
    *block = __libc_memalign(alignment, size);
    return *block != NULL ? 0 : ENOMEM;
}

void *aligned_alloc(size_t alignment, size_t size)
{
    note(__builtin_return_address(0));
    return __libc_memalign(alignment, size);
}

static int find(struct dl_phdr_info *info, size_t size, void *found)
{
    (void)size;
    const char *name = strrchr(info->dlpi_name, '/');
    if (name == NULL || strstr(name, "cupola") == NULL)
        return 0;
    for (int i = 0; i < info->dlpi_phnum; i++) {
        const ElfW(Phdr) *part = &info->dlpi_phdr[i];
        if (part->p_type == PT_LOAD && (part->p_flags & PF_X) != 0) {
            base = info->dlpi_addr;
            start = base + part->p_vaddr;
            end = start + part->p_memsz;
            ++*(int *)found;
        }
    }
    return 0;
}

static void report(int found)
{
    const char *path = getenv("STEADY_REPORT");
    FILE *file = path != NULL ? fopen(path, "w") : NULL;
    if (file == NULL)
        return;
    fprintf(file, "libraries %d\nallocations %lu\n", found, count);
    for (int i = 0; i < PLACES && places[i] != 0; i++)
        fprintf(file, "place 0x%lx\n", (unsigned long)places[i]);
    fclose(file);
}

/* A frame ended. */
void steady_frame(void)
{
    static int found;
    if (frame + 1 == FIRST)
        dl_iterate_phdr(find, &found);
    if (++frame == LAST)
        report(found);
}

void glXSwapBuffers(Display *display, GLXDrawable drawable)
{
    static void (*next)(Display *, GLXDrawable);
    if (next == NULL)
        *(void **)&next = dlsym(RTLD_NEXT, "glXSwapBuffers");
    next(display, drawable);
    steady_frame();
}

EGLBoolean eglSwapBuffers(EGLDisplay display, EGLSurface surface)
{
    static EGLBoolean (*next)(EGLDisplay, EGLSurface);
    if (next == NULL)
        *(void **)&next = dlsym(RTLD_NEXT, "eglSwapBuffers");
    EGLBoolean answer = next(display, surface);
    steady_frame();
    return answer;
}
