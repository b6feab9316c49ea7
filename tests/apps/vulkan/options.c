#include "options.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

vulkan_options options = {.direction = DIRECTION_DEFAULTS, .samples = 1, .draws = 1};

static void usage(void)
{
    fprintf(stderr, "usage: vk_cube " DIRECTION_USAGE "\n"
                    "  [--samples N] [--pass 1|2|dynamic|imageless] [--matrix push|block|dynamic|copied|pushed|instance|instance-copied|vertices|address|address-in-block|address-sum|large|filled] [--once] [--srgb] [--flip]\n"
                    "  [--follow] [--secondary] [--indirect] [--fixed] [--columns] [--copy-window] [--flat over|before|only] [--depth cleared|drawn|readable] [--array columns|rows|row-vector] [--cells triangles|ball|behind|points]\n"
                    "  [--stage vertex|geometry|tessellation] [--resizes N] [--memory FILE] [--draws N] [--clip] [--place]\n");
    exit(2);
}

static int known(const char *value, const char *const names[], int count)
{
    const int found = choice(value, names, count);
    if (found < 0)
        usage();
    return found;
}

static bool is_flag(const char *option)
{
    const struct {
        const char *name;
        bool *flag;
    } flags[] = {{"--once", &options.once},         {"--srgb", &options.srgb},         {"--flip", &options.flip},
                 {"--secondary", &options.secondary}, {"--indirect", &options.indirect}, {"--fixed", &options.fixed},
                 {"--copy-window", &options.copy_window}, {"--columns", &options.columns},
                 {"--follow", &options.follow},   {"--clip", &options.clip},         {"--place", &options.place}};
    for (size_t i = 0; i < sizeof flags / sizeof flags[0]; i++) {
        if (strcmp(option, flags[i].name) == 0) {
            *flags[i].flag = true;
            return true;
        }
    }
    return false;
}

void parse(int argc, char **argv)
{
    static const char *const passes[] = {"1", "2", "dynamic", "imageless"};
    static const char *const matrices[] = {"push", "block", "dynamic", "copied", "pushed", "instance",
                                           "instance-copied", "vertices", "address", "address-in-block", "address-sum",
                                           "large", "filled"};
    static const char *const cells[] = {"none", "triangles", "ball", "behind", "points"};
    static const char *const stages[] = {"vertex", "geometry", "tessellation"};
    static const char *const flats[] = {"none", "over", "before", "only"};
    static const char *const arrays[] = {"none", "columns", "rows", "row-vector"};
    static const char *const depths[] = {"together", "cleared", "drawn", "readable"};
    for (int i = 1; i < argc; i++) {
        const char *option = argv[i];
        if (is_flag(option))
            continue;
        const char *value = i + 1 < argc ? argv[++i] : NULL;
        if (value == NULL)
            usage();
        else if (strcmp(option, "--samples") == 0)
            options.samples = atoi(value);
        else if (strcmp(option, "--resizes") == 0)
            options.resizes = atoi(value);
        else if (strcmp(option, "--draws") == 0)
            options.draws = atoi(value);
        else if (strcmp(option, "--pass") == 0)
            options.pass = (pass_kind)known(value, passes, 4);
        else if (strcmp(option, "--matrix") == 0)
            options.matrix = (matrix_kind)known(value, matrices, 13);
        else if (strcmp(option, "--flat") == 0)
            options.flat = known(value, flats, 4);
        else if (strcmp(option, "--depth") == 0)
            options.depth = (depth_kind)known(value, depths, 4);
        else if (strcmp(option, "--array") == 0)
            options.array = (array_kind)known(value, arrays, 4);
        else if (strcmp(option, "--cells") == 0)
            options.cells = (cells_kind)known(value, cells, 5);
        else if (strcmp(option, "--stage") == 0)
            options.stage = (stage_kind)known(value, stages, 3);
        else if (strcmp(option, "--memory") == 0)
            options.memory = value;
        else if (!take_direction(&options.direction, option, value))
            usage();
    }
}
