/* Options of vk_scenes. */
#ifndef APPS_VULKAN_SCENES_OPTIONS_H
#define APPS_VULKAN_SCENES_OPTIONS_H

#include "direction.h"

typedef enum {
    READ, PART, CLEAR, BEHIND, NEWEST, LIBRARY, PARTS, INDEPENDENT, MULTIVIEW,
    /* Ways that draw off screen: */
    POST, MATRICES, CHAIN, PLACE, BLIT, RESOLVE, PASSES, HALF, DEPTHS, COMPUTE, PICK, BACKGROUND,
    GRADIENT, PLACED, SMALL, MOST,
    WAYS
} way_kind;

typedef struct {
    direction_options direction;
    way_kind way;
    const char *picture;
} scenes_options;

extern scenes_options options;

/* Takes the command line. Ends the program if it is wrong. */
void parse(int argc, char **argv);

#endif
