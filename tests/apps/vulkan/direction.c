#include "direction.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

bool take_direction(direction_options *options, const char *option, const char *value)
{
    if (strcmp(option, "--fov") == 0)
        options->fov = atof(value);
    else if (strcmp(option, "--yaw") == 0)
        options->yaw = atof(value);
    else if (strcmp(option, "--pitch") == 0)
        options->pitch = atof(value);
    else if (strcmp(option, "--frames") == 0)
        options->frames = atoi(value);
    else if (strcmp(option, "--shot") == 0)
        options->shot = value;
    else if (strcmp(option, "--at") == 0)
        return sscanf(value, "%d,%d", &options->x, &options->y) == 2;
    else
        return strcmp(option, "--size") == 0 && sscanf(value, "%ux%u", &options->width, &options->height) == 2;
    return true;
}

int choice(const char *value, const char *const names[], int count)
{
    for (int i = 0; i < count; i++)
        if (strcmp(value, names[i]) == 0)
            return i;
    return -1;
}

matrix4 direction_matrix(const direction_options *options, VkExtent2D extent, bool up)
{
    const double aspect = (double)extent.width / extent.height;
    matrix4 camera = matrix_multiply(matrix_camera(options->yaw, options->pitch), matrix_scale(10.0));
    matrix4 all = matrix_multiply(matrix_perspective(options->fov, aspect, 0.25, 100.0), camera);
    /* Converts from OpenGL's clip space: y points down, and depth begins at 0. */
    for (float *c = all.m; c < all.m + 16; c += 4) {
        c[1] = up ? c[1] : -c[1];
        c[2] = 0.5f * (c[2] + c[3]);
    }
    return all;
}
