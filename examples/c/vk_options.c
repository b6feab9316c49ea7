#include "vk_options.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

bool options_read(int argc, char **argv, options *found)
{
    *found = (options){.frames = 3, .width = 640, .height = 640, .fov = 75.0, .rig = "fisheye", .views = "atlas"};
    for (int i = 1; i < argc; i++) {
        const char *name = argv[i], *value = i + 1 < argc ? argv[i + 1] : "";
        i++; /* most have a value */
        if (strcmp(name, "--frames") == 0)
            found->frames = atoi(value);
        else if (strcmp(name, "--yaw") == 0)
            found->yaw = atof(value);
        else if (strcmp(name, "--pitch") == 0)
            found->pitch = atof(value);
        else if (strcmp(name, "--fov") == 0)
            found->fov = atof(value);
        else if (strcmp(name, "--picture") == 0)
            found->picture = value;
        else if (strcmp(name, "--rig") == 0)
            found->rig = value;
        else if (strcmp(name, "--views") == 0)
            found->views = value;
        else if (strcmp(name, "--size") == 0 && sscanf(value, "%dx%d", &found->width, &found->height) == 2)
            ;
        else if (i--, strcmp(name, "--window") == 0)
            found->window = true;
        else if (strcmp(name, "--own-images") == 0)
            found->own_images = true;
        else if (strcmp(name, "--one-by-one") == 0)
            found->one_by_one = true;
        else {
            fprintf(stderr,
                    "%s is not an option; the options are --window, --frames N, --size WxH, --yaw DEGREES, "
                    "--pitch DEGREES, --fov DEGREES, --picture FILE, and for vk_dome --rig RIG, "
                    "--views atlas|layers|images, --own-images, --one-by-one\n",
                    name);
            return false;
        }
    }
    return true;
}
