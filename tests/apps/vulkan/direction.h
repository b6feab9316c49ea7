/*
 * Parts that the programs of the direction test share: options, the camera, the choice among names.
 */
#ifndef APPS_VULKAN_DIRECTION_H
#define APPS_VULKAN_DIRECTION_H

#include "../common/matrix.h"

#include <stdbool.h>
#include <stdint.h>
#include <vulkan/vulkan.h>

typedef struct {
    double fov, yaw, pitch;
    int frames, x, y;
    uint32_t width, height;
    const char *shot; /* PPM file for the X server's picture at the end */
} direction_options;

#define DIRECTION_DEFAULTS {.fov = 75.0, .frames = 3, .width = 256, .height = 256}
#define DIRECTION_USAGE "[--fov DEG] [--yaw DEG] [--pitch DEG] [--frames N] [--size WxH] [--at X,Y] [--shot FILE.ppm]"

/* Takes one of these options. Returns whether `option` is one and its value is valid. */
bool take_direction(direction_options *options, const char *option, const char *value);

/* Index of a value among `count` names, or -1. */
int choice(const char *value, const char *const names[], int count);

/*
 * Matrix of the cube for a picture of this size, in Vulkan's clip space. With `up` y points up, for
 * a viewport of negative height.
 */
matrix4 direction_matrix(const direction_options *options, VkExtent2D extent, bool up);

#endif
