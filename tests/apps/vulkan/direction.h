/* What the programs of the direction test have in common: their options, the camera, the choice among names. */
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
    const char *shot; /* what the X server shows in the end, as a PPM */
} direction_options;

#define DIRECTION_DEFAULTS {.fov = 75.0, .frames = 3, .width = 256, .height = 256}
#define DIRECTION_USAGE "[--fov DEG] [--yaw DEG] [--pitch DEG] [--frames N] [--size WxH] [--at X,Y] [--shot FILE.ppm]"

/* Takes one of these options; whether it is one, with a value that is understood. */
bool take_direction(direction_options *options, const char *option, const char *value);

/* Which of `count` names a value is; -1: none of them. */
int choice(const char *value, const char *const names[], int count);

/* The cube's matrix for a picture of this size, in Vulkan's clip space; `up`: y points up, for a viewport of negative
 * height. */
matrix4 direction_matrix(const direction_options *options, VkExtent2D extent, bool up);

#endif
