/* The options of the direction test with Vulkan. */
#ifndef APPS_VULKAN_OPTIONS_H
#define APPS_VULKAN_OPTIONS_H

#include <stdbool.h>
#include <stdint.h>

typedef enum { PASS_1, PASS_2, PASS_DYNAMIC, PASS_IMAGELESS } pass_kind;
typedef enum { MATRIX_PUSH, MATRIX_BLOCK, MATRIX_DYNAMIC_BLOCK, MATRIX_COPIED } matrix_kind;

typedef struct {
    double fov, yaw, pitch;
    int frames, x, y, samples, resizes;
    uint32_t width, height;
    pass_kind pass;
    matrix_kind matrix;
    bool once, srgb, columns, flip, secondary, indirect, fixed, copy_window;
    int flat; /* 0: nothing, 1: over the cube, 2: before it */
    const char *shot, *memory;
} vulkan_options;

/* What the program was asked for. */
extern vulkan_options options;

/* Reads the command line; ends the program where it is not understood. */
void parse(int argc, char **argv);

#endif
