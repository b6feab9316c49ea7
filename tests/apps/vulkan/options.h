/* The options of the direction test with Vulkan. */
#ifndef APPS_VULKAN_OPTIONS_H
#define APPS_VULKAN_OPTIONS_H

#include "direction.h"

typedef enum { PASS_1, PASS_2, PASS_DYNAMIC, PASS_IMAGELESS } pass_kind;
typedef enum { MATRIX_PUSH, MATRIX_BLOCK, MATRIX_DYNAMIC_BLOCK, MATRIX_COPIED } matrix_kind;

typedef struct {
    direction_options direction;
    int samples, resizes;
    pass_kind pass;
    matrix_kind matrix;
    bool once, srgb, columns, flip, secondary, indirect, fixed, copy_window;
    int flat; /* 0: nothing, 1: over the cube, 2: before it */
    const char *memory;
} vulkan_options;

/* What the program was asked for. */
extern vulkan_options options;

/* Reads the command line; ends the program where it is not understood. */
void parse(int argc, char **argv);

#endif
