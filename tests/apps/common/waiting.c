#include "waiting.h"

#include <stdio.h>
#include <stdlib.h>
#include <time.h>
#include <unistd.h>

bool frame_counts(void)
{
    static int waited;
    const char *folder = getenv("APP_WAIT");
    if (folder == NULL)
        return true;
    char file[4096];
    snprintf(file, sizeof file, "%s/end", folder);
    if (access(file, F_OK) == 0)
        return true;
    if (++waited == 10) {
        snprintf(file, sizeof file, "%s/begun", folder);
        FILE *begun = fopen(file, "w");
        if (begun != NULL)
            fclose(begun);
    }
    const struct timespec between = {.tv_nsec = 20000000};
    nanosleep(&between, NULL);
    return false;
}
