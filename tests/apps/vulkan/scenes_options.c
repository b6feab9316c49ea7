#include "scenes_options.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const char *const ways[WAYS] = {"read",  "part",  "clear", "behind", "newest",  "library", "parts", "independent", "multiview", "post",
                                       "matrices",
                                       "chain", "place", "blit",  "resolve", "passes",  "half",  "depths",    "compute",
                                       "pick",  "background", "gradient", "placed", "small", "most"};

scenes_options options = {.direction = DIRECTION_DEFAULTS};

static void usage(void)
{
    fprintf(stderr, "usage: vk_scenes " DIRECTION_USAGE " [--picture FILE.ppm]\n"
                    "  [--way read|part|clear|behind|newest|library|parts|independent|multiview|post|matrices|chain|place|blit|resolve|passes|half|depths|\n"
                    "         compute|pick|background|gradient|placed|small|most]\n");
    exit(2);
}

void parse(int argc, char **argv)
{
    for (int i = 1; i + 1 < argc; i += 2) {
        const char *option = argv[i], *value = argv[i + 1];
        if (strcmp(option, "--picture") == 0)
            options.picture = value;
        else if (strcmp(option, "--way") == 0) {
            const int way = choice(value, ways, WAYS);
            if (way < 0)
                usage();
            options.way = (way_kind)way;
        } else if (!take_direction(&options.direction, option, value))
            usage();
    }
}
