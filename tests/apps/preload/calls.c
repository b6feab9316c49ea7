/*
 * A vendor library for GLX between Cupola and Mesa. CUPOLA_GLX_REAL names it. It counts the calls
 * of each OpenGL function and can refuse them. At the end of the process it writes the numbers to
 * the file in CALLS_REPORT, one function per line. For each address that is asked for, it returns a
 * few instructions that count the call and continue in the driver with all registers unchanged. So
 * it does not depend on the function's parameters. x86-64 only.
 *
 * CALLS_FAULT is one fault:
 *   call NAME FIRST LAST   calls FIRST to LAST of a function do nothing, return 0 and set
 *                          GL_OUT_OF_MEMORY
 *   lost NAME FIRST LAST   the same without the error
 *   missing NAME           the driver has no such function
 *   number ENUM VALUE      glGetIntegerv returns VALUE
 *   string ENUM TEXT       glGetString returns TEXT, and glGetStringi, too, if ENUM is
 *                          GL_EXTENSIONS
 *   status ENUM VALUE      glGetShaderiv and glGetProgramiv return VALUE
 *   swaps ANSWER           the driver has GLX_NV_swap_group, whose functions return ANSWER; their
 *                          arguments and swap intervals are written to stderr
 */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <stdbool.h>
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

static struct {
    char kind[16], name[64];
    unsigned long first, last; /* or ENUM and VALUE */
    char text[128];
} fault;

/* Function some of whose calls are refused, and the number of its calls so far. */
void *refused_target;
static unsigned long refused_calls;
static unsigned pending_error;

/* Address at which the call continues. The instructions below use it. */
void *refused_next(void);

static intptr_t nothing(void)
{
    return 0;
}

void *refused_next(void)
{
    unsigned long call = ++refused_calls;
    void *next = refused_target;
    if (call < fault.first || call > fault.last)
        return next;
    if (strcmp(fault.kind, "call") == 0)
        pending_error = 0x0505; /* GL_OUT_OF_MEMORY */
    intptr_t (*function)(void) = nothing;
    memcpy(&next, &function, sizeof next);
    return next;
}

/* Calls refused_next with all registers for parameters saved, then jumps to what it returns. */
void refused_entry(void);
__asm__(".text\n"
        ".globl refused_entry\n"
        ".hidden refused_entry\n"
        "refused_entry:\n"
        "push %rbp\n mov %rsp, %rbp\n sub $0xc0, %rsp\n"
        "movups %xmm0, 0x00(%rsp)\n movups %xmm1, 0x10(%rsp)\n movups %xmm2, 0x20(%rsp)\n movups %xmm3, 0x30(%rsp)\n"
        "movups %xmm4, 0x40(%rsp)\n movups %xmm5, 0x50(%rsp)\n movups %xmm6, 0x60(%rsp)\n movups %xmm7, 0x70(%rsp)\n"
        "mov %rdi, 0x80(%rsp)\n mov %rsi, 0x88(%rsp)\n mov %rdx, 0x90(%rsp)\n mov %rcx, 0x98(%rsp)\n"
        "mov %r8, 0xa0(%rsp)\n mov %r9, 0xa8(%rsp)\n mov %rax, 0xb0(%rsp)\n"
        "call refused_next@PLT\n mov %rax, %r11\n"
        "movups 0x00(%rsp), %xmm0\n movups 0x10(%rsp), %xmm1\n movups 0x20(%rsp), %xmm2\n movups 0x30(%rsp), %xmm3\n"
        "movups 0x40(%rsp), %xmm4\n movups 0x50(%rsp), %xmm5\n movups 0x60(%rsp), %xmm6\n movups 0x70(%rsp), %xmm7\n"
        "mov 0x80(%rsp), %rdi\n mov 0x88(%rsp), %rsi\n mov 0x90(%rsp), %rdx\n mov 0x98(%rsp), %rcx\n"
        "mov 0xa0(%rsp), %r8\n mov 0xa8(%rsp), %r9\n mov 0xb0(%rsp), %rax\n"
        "leave\n jmp *%r11\n");

/* Functions of the driver that the functions below replace. */
static unsigned (*driver_error)(void);
static void (*driver_integers)(unsigned name, int *values);
static const unsigned char *(*driver_string)(unsigned name);
static const unsigned char *(*driver_indexed_string)(unsigned name, unsigned index);
static void (*driver_shader)(unsigned shader, unsigned name, int *value);
static void (*driver_program)(unsigned program, unsigned name, int *value);

static unsigned answer_error(void)
{
    unsigned error = pending_error;
    pending_error = 0;
    return error != 0 ? error : driver_error();
}

static void answer_integers(unsigned name, int *values)
{
    driver_integers(name, values);
    if (name == fault.first)
        *values = (int)fault.last;
}

static const unsigned char *answer_string(unsigned name)
{
    return name == fault.first ? (const unsigned char *)fault.text : driver_string(name);
}

static const unsigned char *answer_indexed_string(unsigned name, unsigned index)
{
    return name == fault.first ? (const unsigned char *)fault.text : driver_indexed_string(name, index);
}

static void answer_shader(unsigned shader, unsigned name, int *value)
{
    driver_shader(shader, name, value);
    if (name == fault.first)
        *value = (int)fault.last;
}

static void answer_program(unsigned program, unsigned name, int *value)
{
    driver_program(program, name, value);
    if (name == fault.first)
        *value = (int)fault.last;
}

static void (*driver_interval)(void *display, unsigned long drawable, int interval);

static void answer_interval(void *display, unsigned long drawable, int interval)
{
    fprintf(stderr, "swap interval %d\n", interval);
    driver_interval(display, drawable, interval);
}

static int join_group(void *display, unsigned long drawable, unsigned group)
{
    (void)display, (void)drawable;
    fprintf(stderr, "swap group %u\n", group);
    return (int)fault.first;
}

static int bind_barrier(void *display, unsigned group, unsigned barrier)
{
    (void)display;
    fprintf(stderr, "swap group %u at barrier %u\n", group, barrier);
    return (int)fault.first;
}

#define REPLACE(function, driver, answer) \
    if (strcmp(name, function) == 0) { \
        void (*ours)(void) = (void (*)(void))answer; \
        memcpy(&driver, &target, sizeof target); \
        memcpy(&target, &ours, sizeof ours); \
        return target; \
    }

/* Returns the function for `name`: the driver's, or one with the fault. */
static void *with_fault(const char *name, void *target)
{
    REPLACE("glGetError", driver_error, answer_error)
    if (strcmp(fault.kind, "swaps") == 0) {
        void *unused;
        REPLACE("glXSwapIntervalEXT", driver_interval, answer_interval)
        REPLACE("glXJoinSwapGroupNV", unused, join_group)
        REPLACE("glXBindSwapBarrierNV", unused, bind_barrier)
    }
    bool refuses = strcmp(fault.kind, "call") == 0 || strcmp(fault.kind, "lost") == 0;
    if (refuses && strcmp(fault.name, name) == 0) {
        void (*entry)(void) = refused_entry;
        refused_target = target;
        memcpy(&target, &entry, sizeof entry);
    } else if (strcmp(fault.kind, "missing") == 0 && strcmp(fault.name, name) == 0) {
        return NULL;
    } else if (strcmp(fault.kind, "number") == 0) {
        REPLACE("glGetIntegerv", driver_integers, answer_integers)
    } else if (strcmp(fault.kind, "string") == 0) {
        REPLACE("glGetString", driver_string, answer_string)
        REPLACE("glGetStringi", driver_indexed_string, answer_indexed_string)
    } else if (strcmp(fault.kind, "status") == 0) {
        REPLACE("glGetShaderiv", driver_shader, answer_shader)
        REPLACE("glGetProgramiv", driver_program, answer_program)
    }
    return target;
}

static void read_fault(void)
{
    const char *text = getenv("CALLS_FAULT");
    if (text == NULL || sscanf(text, "%15s %63s", fault.kind, fault.name) != 2)
        return;
    if (strcmp(fault.kind, "call") == 0 || strcmp(fault.kind, "lost") == 0) {
        sscanf(text, "%*s %*s %lu %lu", &fault.first, &fault.last);
    } else {
        fault.first = strtoul(fault.name, NULL, 0);
        sscanf(text, "%*s %*s %127[^\n]", fault.text);
        fault.last = (unsigned long)strtol(fault.text, NULL, 0);
    }
}

/* Whether the function is one of GLX_NV_swap_group that the driver gets by the fault. */
static bool is_of_swap_groups(const char *name)
{
    if (strcmp(fault.kind, "swaps") != 0)
        return false;
    return strcmp(name, "glXJoinSwapGroupNV") == 0 || strcmp(name, "glXBindSwapBarrierNV") == 0;
}

static void *counted(const unsigned char *name)
{
    /* inc qword ptr [rip + 9]; jmp qword ptr [rip + 11] */
    static const unsigned char code[16] = {0x48, 0xff, 0x05, 9, 0, 0, 0, 0xff, 0x25, 11, 0, 0, 0};
    void *target = real_address(name);
    if ((target == NULL && !is_of_swap_groups((const char *)name)) || count == MOST)
        return target;
    for (int i = 0; i < count; i++)
        if (strcmp(names[i], (const char *)name) == 0)
            return &stubs[i];
    target = with_fault((const char *)name, target);
    if (target == NULL)
        return NULL;
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
    read_fault();
    real_address = imports->get_proc_address;
    imports->get_proc_address = counted;
    atexit(report);
    return 1;
}
