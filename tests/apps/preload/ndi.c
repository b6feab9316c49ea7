/*
 * Plays the library of NDI. Programs load it as libndi.so.6 or libndi.so.5. It appends the calls
 * to the file in NDI_CALLS, one per line, and the pixels of all pictures to NDI_CALLS.pixels. The
 * function that NDI_FAILS names fails: "initialize" or "create".
 */
#include <inttypes.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef struct {
    const char *name, *groups;
    bool clock_video, clock_audio;
} send_create;

typedef struct {
    int width, height;
    uint32_t four_cc;
    int rate_numerator, rate_denominator;
    float aspect;
    int format;
    int64_t timecode;
    uint8_t *data;
    int stride;
    const char *metadata;
    int64_t timestamp;
} video_frame;

/* What send_create returns. */
static int instance;

static void note(const char *format, ...)
{
    const char *name = getenv("NDI_CALLS");
    FILE *file = name ? fopen(name, "a") : NULL;
    va_list arguments;
    if (!file)
        return;
    va_start(arguments, format);
    vfprintf(file, format, arguments);
    va_end(arguments);
    fclose(file);
}

static bool fails(const char *function)
{
    const char *name = getenv("NDI_FAILS");
    return name && strcmp(name, function) == 0;
}

bool NDIlib_initialize(void)
{
    note("initialize\n");
    return !fails("initialize");
}

void NDIlib_destroy(void)
{
    note("destroy\n");
}

void *NDIlib_send_create(const send_create *settings)
{
    note("create %s %s %d %d\n", settings->name, settings->groups ? settings->groups : "-", settings->clock_video,
         settings->clock_audio);
    return fails("create") ? NULL : &instance;
}

#ifndef INCOMPLETE
void NDIlib_send_destroy(void *sender)
{
    note("send_destroy %d\n", sender == &instance);
}
#endif

void NDIlib_send_send_video_v2(void *sender, const video_frame *frame)
{
    const char *name = getenv("NDI_CALLS");
    char pixels[4096];
    FILE *file;
    note("frame %d %dx%d %.4s %d %d/%d %g %d %" PRId64 " %d\n", sender == &instance, frame->width, frame->height,
         (const char *)&frame->four_cc, frame->stride, frame->rate_numerator, frame->rate_denominator, frame->aspect,
         frame->format, frame->timecode, frame->metadata != NULL);
    if (!name || snprintf(pixels, sizeof pixels, "%s.pixels", name) >= (int)sizeof pixels)
        return;
    file = fopen(pixels, "ab");
    if (!file)
        return;
    fwrite(frame->data, (size_t)frame->stride, (size_t)frame->height, file);
    fclose(file);
}

int NDIlib_send_get_no_connections(void *sender, uint32_t milliseconds)
{
    note("connections %d %u\n", sender == &instance, (unsigned)milliseconds);
    return 2;
}
