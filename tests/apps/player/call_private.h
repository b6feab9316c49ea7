/* Declarations that only the files of call.h use. */
#ifndef APPS_CALL_PRIVATE_H
#define APPS_CALL_PRIVATE_H

#include "call.h"

#include <stddef.h>
#include <stdint.h>

enum { CALL_SLOTS = 16 };

/* Memory at an address that is the same in each process. */
#define CALL_MEMORY 0x100000000000ULL
enum {
    CALL_INPUT = 0,                   /* read by OpenGL: small 32-bit numbers */
    CALL_INPUT_MARGIN = 1 << 19,      /* margin before a call's input, for negative indices */
    CALL_INPUT_SIZE = 16 << 20,
    CALL_SMALL = CALL_INPUT_SIZE,     /* written by one call and part of the answer, as CALL_BIG is */
    CALL_SMALL_SIZE = 512, /* size for each such argument */
    CALL_BIG = CALL_SMALL + (1 << 13),
    CALL_BIG_SIZE = 1 << 18,
    CALL_UNREAD = CALL_BIG + (1 << 20), /* written by one call and not part of the answer */
    CALL_FEEDBACK = CALL_UNREAD + (4 << 20),
    CALL_LISTS = CALL_FEEDBACK + (1 << 16), /* space for the lists in a call's arguments */
    CALL_MEMORY_SIZE = CALL_LISTS + (1 << 18),
};

struct call_function {
    char name[56];
    void *address;
    bool is_draw, takes_indices, is_read, asks_program, asks_varying;
};

/* Names of the current context by kind and slot. */
extern unsigned long long call_names[26][CALL_SLOTS];
extern bool call_has_fixed_function;

const call_function *call_find(const char *name);
/* Whether a draw reads vertices from no memory of the process except CALL_INPUT. */
bool call_is_safe(const call_function *function);
/*
 * Whether Mesa 22.3 neither writes beyond a buffer nor reads freed memory with these arguments.
 * `seventh` is the argument after the first six.
 */
bool call_arguments_are_safe(const call_function *function, const uint64_t *arguments, uint64_t seventh);

#endif
