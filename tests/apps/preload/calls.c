/*
 * A vendor library for GLX between Cupola and Mesa that counts the calls of each OpenGL function:
 * CUPOLA_GLX_REAL names it. At the end of the process it writes them, one function a line, to the file in CALLS_REPORT.
 * Each address that is asked for gets a few instructions in front that count, and then go on with all registers as they
 * were, whatever the function's parameters are. x86-64 only.
 */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>

#define MOST 8192

struct stub {
    unsigned char code[16];
    uint64_t calls;
    void *target;
};

/* The first two of libglvnd's imports. */
struct imports {
    int (*is_screen_supported)(void *display, int screen);
    void *(*get_proc_address)(const unsigned char *name);
};

static struct stub *stubs;
static char *names[MOST];
static int count;
static void *(*real_address)(const unsigned char *name);

static void *counted(const unsigned char *name)
{
    /* inc qword ptr [rip + 9]; jmp qword ptr [rip + 11] */
    static const unsigned char code[16] = {0x48, 0xff, 0x05, 9, 0, 0, 0, 0xff, 0x25, 11, 0, 0, 0};
    void *target = real_address(name);
    if (target == NULL || count == MOST)
        return target;
    for (int i = 0; i < count; i++)
        if (strcmp(names[i], (const char *)name) == 0)
            return &stubs[i];
    struct stub *stub = &stubs[count];
    memcpy(stub->code, code, sizeof code);
    stub->target = target;
    names[count] = malloc(strlen((const char *)name) + 1);
    strcpy(names[count++], (const char *)name);
    return stub;
}

static void report(void)
{
    const char *path = getenv("CALLS_REPORT");
    FILE *file = path == NULL ? NULL : fopen(path, "w");
    if (file == NULL)
        return;
    for (int i = 0; i < count; i++)
        if (stubs[i].calls > 0)
            fprintf(file, "%s %llu\n", names[i], (unsigned long long)stubs[i].calls);
    fclose(file);
}

int __glx_Main(uint32_t version, const void *exports, void *vendor, struct imports *imports)
{
    void *mesa = dlopen("libGLX_mesa.so.0", RTLD_NOW | RTLD_LOCAL);
    int (*real)(uint32_t, const void *, void *, struct imports *);
    void *address = mesa == NULL ? NULL : dlsym(mesa, "__glx_Main");
    memcpy(&real, &address, sizeof real);
    if (address == NULL || !real(version, exports, vendor, imports))
        return 0;
    stubs = mmap(NULL, MOST * sizeof *stubs, PROT_READ | PROT_WRITE | PROT_EXEC, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    if (stubs == MAP_FAILED)
        return 1;
    real_address = imports->get_proc_address;
    imports->get_proc_address = counted;
    atexit(report);
    return 1;
}
