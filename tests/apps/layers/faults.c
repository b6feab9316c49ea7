/*
 * Two Vulkan layers around Cupola, in one library. VK_LAYER_TEST_above notes which function the
 * program calls. From this VK_LAYER_TEST_below knows which calls are Cupola's own. It counts the
 * calls and has a fault. This works because Cupola starts no thread, so that each of its calls is
 * made during a call of the program. At the end of the process a line for each function is written
 * to the file in FAULTS_REPORT: its name, the number of calls by Cupola, and the number by the
 * program. x86-64 only, one instance and one device.
 *
 * FAULTS is one fault:
 *   call NAME FIRST LAST RESULT     Cupola's calls FIRST to LAST of a function do nothing and
 *                                   return RESULT
 *   program NAME FIRST LAST RESULT  the same for the program's calls
 *   missing NAME                    the driver has no such function
 *   limit NAME VALUE                Cupola gets this value of a limit of the device
 *   memory|queues|formats|surface|features MASK
 *                                   Cupola gets only these flags of each kind of memory, of each
 *                                   family of queues, of each format, or of the surface, and no
 *                                   feature if MASK is 0
 *   barrier 0|1|2                   the driver has a present barrier, which a window cannot join,
 *                                   can join, or cannot join although the driver said so
 *   told MODE                       nothing; the present mode of each swapchain is written to stderr
 */
#define _GNU_SOURCE
#include "layer.h"

#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>

#define MOST 4096

/*
 * Stub for a function of the next layer. Its code calls `decide` with the stub's address and
 * continues at the address that `decide` returns.
 */
struct stub {
    unsigned char code[16];
    void (*entry)(void);
    void *target;
    const struct layer *layer;
    const char *name;
    /* Index of the argument that distinguishes the program's call from Cupola's calls; -1: none. */
    int mark;
    uint64_t calls[2];
};

enum caller { CUPOLA, PROGRAM };

static struct stub *stubs;
static int count;

static struct {
    char kind[16], name[64];
    long first, last;
    VkResult result;
} fault;

/* Call of the program that is active on this thread, as the layer above notes it. */
static __thread struct {
    const char *name;
    uint64_t arguments[6];
    bool passed;
} now;

void note_program_call(const char *name)
{
    now.name = name;
    now.passed = false;
    memset(now.arguments, 0, sizeof now.arguments);
}

/* Index of the argument with the program's own address or handle. */
static int mark_of(const char *name)
{
    static const struct {
        const char *start;
        int place;
    } marks[] = {{"vkCreateGraphicsPipelines", 5},
                 {"vkCreateComputePipelines", 5},
                 {"vkCreate", 3},
                 {"vkAllocateMemory", 3},
                 {"vkAllocate", 2},
                 {"vkBindBufferMemory2", 2},
                 {"vkBindImageMemory2", 2},
                 {"vkBind", 1},
                 {"vkMapMemory", 5},
                 {"vkQueueSubmit", 2},
                 {"vkWaitForFences", 2},
                 {"vkResetFences", 2},
                 {"vkGetQueryPoolResults", 5},
                 {"vkGetSwapchainImagesKHR", 3},
                 {"vkBeginCommandBuffer", 0},
                 {"vkEndCommandBuffer", 0},
                 {"vkDestroy", 1},
                 {"vkFreeMemory", 1}};
    for (size_t i = 0; i < sizeof marks / sizeof marks[0]; i++)
        if (strncmp(name, marks[i].start, strlen(marks[i].start)) == 0)
            return marks[i].place;
    return -1;
}

static enum caller caller_of(const struct stub *stub, const uint64_t *arguments)
{
    if (now.name == NULL || now.passed || strcmp(now.name, stub->name) != 0)
        return CUPOLA;
    if (stub->mark >= 0 && arguments[stub->mark] != now.arguments[stub->mark])
        return CUPOLA;
    now.passed = true;
    return PROGRAM;
}

static intptr_t refuse(void)
{
    return fault.result;
}

static intptr_t refuse_pipelines(VkDevice device, VkPipelineCache cache, uint32_t number, const void *infos,
                                 const VkAllocationCallbacks *allocator, VkPipeline *made)
{
    (void)device, (void)cache, (void)infos, (void)allocator;
    memset(made, 0, number * sizeof *made);
    return fault.result;
}

/*
 * Calls that wait are made although the program gets the error. Calls with a result that is no
 * error are made, too.
 */
static void *refused_target;

static intptr_t refuse_after(intptr_t a, intptr_t b, intptr_t c, intptr_t d, intptr_t e, intptr_t f)
{
    intptr_t (*function)(intptr_t, intptr_t, intptr_t, intptr_t, intptr_t, intptr_t);
    memcpy(&function, &refused_target, sizeof function);
    function(a, b, c, d, e, f);
    return fault.result;
}

static void *refusing(const struct stub *stub)
{
    const bool after = fault.result > 0 || strncmp(stub->name, "vkWait", 6) == 0 || strncmp(stub->name, "vkQueuePresent", 14) == 0;
    void *address;
    refused_target = stub->target;
    if (after)
        address = (void *)(intptr_t)refuse_after;
    else if (strstr(stub->name, "Pipelines") != NULL)
        address = (void *)(intptr_t)refuse_pipelines;
    else
        address = (void *)(intptr_t)refuse;
    return address;
}

/* Returns the address at which a call continues. The instructions below call it. */
void *decide(struct stub *stub, const uint64_t *arguments);

void *decide(struct stub *stub, const uint64_t *arguments)
{
    if (stub->layer == &above) {
        now.name = stub->name;
        now.passed = false;
        memcpy(now.arguments, arguments, sizeof now.arguments);
        return stub->target;
    }
    const enum caller caller = caller_of(stub, arguments);
    const long call = (long)++stub->calls[caller];
    if (strcmp(fault.kind, "told") == 0 && strcmp(stub->name, "vkCreateSwapchainKHR") == 0)
        fprintf(stderr, "present mode %d\n", (int)((const VkSwapchainCreateInfoKHR *)arguments[1])->presentMode);
    if (strcmp(fault.kind, "barrier") == 0 && strcmp(stub->name, "vkCreateSwapchainKHR") == 0
        && take_barrier_of_swapchain((VkSwapchainCreateInfoKHR *)arguments[1]) && fault.result != VK_SUCCESS)
        return (void *)(intptr_t)refuse;
    if (strcmp(fault.kind, caller == CUPOLA ? "call" : "program") == 0 && strcmp(fault.name, stub->name) == 0)
        return call < fault.first || call > fault.last ? stub->target : refusing(stub);
    if (caller == CUPOLA) {
        void *lie = liar(fault.kind, stub->name, stub->target);
        return lie != NULL ? lie : stub->target;
    }
    return stub->target;
}

/* Calls decide with all registers for parameters saved, then jumps to what it returns. */
void stub_entry(void);
__asm__(".text\n"
        ".globl stub_entry\n"
        ".hidden stub_entry\n"
        "stub_entry:\n"
        "push %rbp\n mov %rsp, %rbp\n sub $0xc0, %rsp\n"
        "movups %xmm0, 0x40(%rsp)\n movups %xmm1, 0x50(%rsp)\n movups %xmm2, 0x60(%rsp)\n movups %xmm3, 0x70(%rsp)\n"
        "movups %xmm4, 0x80(%rsp)\n movups %xmm5, 0x90(%rsp)\n movups %xmm6, 0xa0(%rsp)\n movups %xmm7, 0xb0(%rsp)\n"
        "mov %rdi, 0x00(%rsp)\n mov %rsi, 0x08(%rsp)\n mov %rdx, 0x10(%rsp)\n mov %rcx, 0x18(%rsp)\n"
        "mov %r8, 0x20(%rsp)\n mov %r9, 0x28(%rsp)\n mov %rax, 0x30(%rsp)\n"
        "mov %r11, %rdi\n mov %rsp, %rsi\n"
        "call decide@PLT\n mov %rax, %r11\n"
        "movups 0x40(%rsp), %xmm0\n movups 0x50(%rsp), %xmm1\n movups 0x60(%rsp), %xmm2\n movups 0x70(%rsp), %xmm3\n"
        "movups 0x80(%rsp), %xmm4\n movups 0x90(%rsp), %xmm5\n movups 0xa0(%rsp), %xmm6\n movups 0xb0(%rsp), %xmm7\n"
        "mov 0x00(%rsp), %rdi\n mov 0x08(%rsp), %rsi\n mov 0x10(%rsp), %rdx\n mov 0x18(%rsp), %rcx\n"
        "mov 0x20(%rsp), %r8\n mov 0x28(%rsp), %r9\n mov 0x30(%rsp), %rax\n"
        "leave\n jmp *%r11\n");

static void report(void)
{
    const char *path = getenv("FAULTS_REPORT");
    FILE *file = path == NULL ? NULL : fopen(path, "w");
    if (file == NULL)
        return;
    for (int i = 0; i < count; i++)
        if (stubs[i].layer == &below && stubs[i].calls[CUPOLA] + stubs[i].calls[PROGRAM] > 0)
            fprintf(file, "%s %lu %lu\n", stubs[i].name, stubs[i].calls[CUPOLA], stubs[i].calls[PROGRAM]);
    fclose(file);
}

static void begin(void)
{
    stubs = mmap(NULL, MOST * sizeof *stubs, PROT_READ | PROT_WRITE | PROT_EXEC, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    if (stubs == MAP_FAILED)
        abort();
    const char *text = getenv("FAULTS");
    char result[16] = "0";
    if (text != NULL && sscanf(text, "%15s %63s %li %li %15s", fault.kind, fault.name, &fault.first, &fault.last, result) > 1)
        fault.result = (VkResult)strtol(result, NULL, 0);
    if (strcmp(text == NULL ? "" : text, "barrier 2") == 0)
        fault.result = VK_ERROR_INITIALIZATION_FAILED;
    set_lie(fault.name, strcmp(fault.kind, "limit") == 0 ? fault.first : strtol(fault.name, NULL, 0));
    atexit(report);
}

PFN_vkVoidFunction with_stub(const struct layer *layer, const char *name, PFN_vkVoidFunction target)
{
    /* lea r11, [rip - 7]; jmp qword ptr [rip + 3] */
    static const unsigned char code[16] = {0x4c, 0x8d, 0x1d, 0xf9, 0xff, 0xff, 0xff, 0xff, 0x25, 3, 0, 0, 0};
    PFN_vkVoidFunction address;
    if (stubs == NULL)
        begin();
    if (layer == &below && strcmp(fault.kind, "missing") == 0 && strcmp(fault.name, name) == 0)
        return NULL;
    if (target == NULL)
        return NULL;
    int index = 0;
    while (index < count && (stubs[index].layer != layer || strcmp(stubs[index].name, name) != 0))
        index++;
    struct stub *stub = &stubs[index];
    if (index == count) {
        if (count == MOST)
            abort();
        count++;
        memcpy(stub->code, code, sizeof code);
        stub->entry = stub_entry;
        stub->layer = layer;
        stub->name = strdup(name);
        stub->mark = mark_of(name);
        memcpy(&stub->target, &target, sizeof target);
    }
    memcpy(&address, &stub, sizeof stub);
    return address;
}
