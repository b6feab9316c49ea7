/* Command line options of both Vulkan examples. */
#ifndef VK_OPTIONS_H
#define VK_OPTIONS_H

#include <stdbool.h>

typedef struct {
    bool window;         /* in a window, not off screen */
    int frames;          /* 0: until the window is closed */
    int width, height;   /* pixels */
    double yaw, pitch;   /* of the camera, degrees */
    double fov;          /* vertical field of view of the plain program, degrees */
    const char *picture; /* file for the last picture off screen */
    /* vk_dome only. */
    const char *rig;       /* a preset or a file */
    const char *views;     /* atlas, layers or images */
    bool own_images;       /* the program makes the images */
    bool one_by_one;       /* layers are drawn one after another, without multiview */
} options;

/* Reads the options. Prints a message and returns false if an argument is not an option. */
bool options_read(int argc, char **argv, options *found);

#endif
