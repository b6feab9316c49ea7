/* A frame's end by the newest ways to submit and to present. */
#ifndef APPS_VULKAN_NEWEST_H
#define APPS_VULKAN_NEWEST_H

#include "window.h"

typedef struct {
    VkCommandBuffer commands;
    VkSemaphore acquired, timeline;
} frame_parts;

/* Submits by the newer call, waits for a timeline, says what changed in the window, and which frame it is. */
void end_newest_frame(const vulkan_window *w, const frame_parts *parts, uint32_t index, uint64_t number);

#endif
