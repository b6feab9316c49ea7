/*
 * Reads pictures of frame_index from its standard input, with four bytes per pixel. Writes the
 * number that is painted into each picture, and the time at which the last byte was read (monotonic
 * clock, nanoseconds).
 *
 * usage: index_reader WIDTH HEIGHT [MILLISECONDS THAT EACH PICTURE TAKES]
 */
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

enum { BITS = 24 };

int main(int argc, char **argv)
{
    const size_t width = argc > 2 ? strtoul(argv[1], NULL, 10) : 0, height = argc > 2 ? strtoul(argv[2], NULL, 10) : 0;
    const long slow = argc > 3 ? atol(argv[3]) : 0;
    unsigned char *picture = malloc(width * height * 4 + 1);
    if (!picture || width < BITS || !height)
        return 2;
    while (fread(picture, 4 * width, height, stdin) == height) {
        struct timespec now, pause = {slow / 1000, slow % 1000 * 1000000};
        int number = 0;
        clock_gettime(CLOCK_MONOTONIC, &now);
        for (size_t column = 0; column < BITS; column++) {
            const size_t middle = (2 * column + 1) * width / (2 * BITS);
            number = number << 1 | (picture[4 * (height / 2 * width + middle)] > 127);
        }
        printf("%d %lld\n", number, (long long)now.tv_sec * 1000000000 + now.tv_nsec);
        fflush(stdout);
        nanosleep(&pause, NULL);
    }
    free(picture);
    return 0;
}
