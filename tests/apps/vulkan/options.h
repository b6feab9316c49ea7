/* The options of the direction test with Vulkan. */
#ifndef APPS_VULKAN_OPTIONS_H
#define APPS_VULKAN_OPTIONS_H

#include "direction.h"

typedef enum { PASS_1, PASS_2, PASS_DYNAMIC, PASS_IMAGELESS } pass_kind;
typedef enum {
    MATRIX_PUSH,
    MATRIX_BLOCK,
    MATRIX_DYNAMIC_BLOCK,
    MATRIX_COPIED,
    MATRIX_PUSHED_SET,
    MATRIX_INSTANCE, /* attribute of each instance */
    MATRIX_INSTANCE_COPIED,
    MATRIX_VERTICES, /* attribute of each vertex */
    MATRIX_ADDRESS, /* behind an address in push constants */
    MATRIX_ADDRESS_IN_BLOCK,
    MATRIX_ADDRESS_SUM, /* as MATRIX_ADDRESS, with a number that the shader adds */
    MATRIX_LARGE, /* copied together with much else */
    MATRIX_FILLED /* written by fills, number by number */
} matrix_kind;

typedef enum { CELLS_NONE, CELLS_TRIANGLES, CELLS_BALL, CELLS_BEHIND, CELLS_POINTS } cells_kind;
typedef enum { STAGE_VERTEX, STAGE_GEOMETRY, STAGE_TESSELLATION } stage_kind;

/*
 * Depth is cleared, or also drawn, in a separate pass. With DEPTH_READABLE shaders could read it.
 */
typedef enum { DEPTH_TOGETHER, DEPTH_CLEARED, DEPTH_DRAWN, DEPTH_READABLE } depth_kind;

/* Form of the matrix: one, an array of its columns or rows, or one that stands after the vector. */
typedef enum { ARRAY_NONE, ARRAY_COLUMNS, ARRAY_ROWS, ARRAY_ROW_VECTOR } array_kind;

typedef struct {
    direction_options direction;
    int samples, resizes;
    int draws; /* number of draws of the cube in a frame, each with another matrix that shows the same */
    pass_kind pass;
    matrix_kind matrix;
    stage_kind stage; /* last stage before rasterisation */
    cells_kind cells; /* size of the parts in which the cube is drawn */
    bool once, srgb, columns, flip, secondary, indirect, fixed, copy_window;
    bool follow; /* make a new swapchain if presenting asks for it */
    depth_kind depth; /* depth of the cube before the pass that draws colours */
    array_kind array; /* form of the matrix in push constants */
    bool clip, place; /* discards fragments beside the window; shows the place in the window */
    int flat; /* 0: nothing, 1: over the cube, 2: before it, 3: instead of it */
    const char *memory;
} vulkan_options;

/* Options of this run of the program. */
extern vulkan_options options;

/* Reads the command line. Ends the program if it is wrong. */
void parse(int argc, char **argv);

#endif
