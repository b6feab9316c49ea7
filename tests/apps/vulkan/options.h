/* The options of the direction test with Vulkan. */
#ifndef APPS_VULKAN_OPTIONS_H
#define APPS_VULKAN_OPTIONS_H

#include "direction.h"

typedef enum { PASS_1, PASS_2, PASS_DYNAMIC, PASS_IMAGELESS } pass_kind;
typedef enum { MATRIX_PUSH, MATRIX_BLOCK, MATRIX_DYNAMIC_BLOCK, MATRIX_COPIED, MATRIX_PUSHED_SET } matrix_kind;

typedef enum { CELLS_NONE, CELLS_TRIANGLES, CELLS_BALL, CELLS_BEHIND, CELLS_POINTS } cells_kind;
typedef enum { STAGE_VERTEX, STAGE_GEOMETRY, STAGE_TESSELLATION } stage_kind;

/* Depth is cleared, or drawn as well, in a pass of its own; shaders could read it. */
typedef enum { DEPTH_TOGETHER, DEPTH_CLEARED, DEPTH_DRAWN, DEPTH_READABLE } depth_kind;

/* The matrix is one, or an array of its columns, or of its rows, or one that comes after the vector. */
typedef enum { ARRAY_NONE, ARRAY_COLUMNS, ARRAY_ROWS, ARRAY_ROW_VECTOR } array_kind;

typedef struct {
    direction_options direction;
    int samples, resizes;
    int draws; /* so often is the cube drawn in a frame, each time with another matrix that shows the same */
    pass_kind pass;
    matrix_kind matrix;
    stage_kind stage; /* the last one before rasterisation */
    cells_kind cells; /* how small the parts are that the cube is drawn in */
    bool once, srgb, columns, flip, secondary, indirect, fixed, copy_window;
    bool follow; /* make a new swapchain where presenting says that it should be */
    depth_kind depth; /* of it, before the pass that draws colours */
    array_kind array; /* in push constants */
    bool clip, place; /* what is beside the window is not drawn; the place in the window is shown */
    int flat; /* 0: nothing, 1: over the cube, 2: before it */
    const char *memory;
} vulkan_options;

/* What the program was asked for. */
extern vulkan_options options;

/* Reads the command line; ends the program where it is not understood. */
void parse(int argc, char **argv);

#endif
