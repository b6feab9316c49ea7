/* The end of a frame with the newest ways to submit and to present. */
#ifndef APPS_VULKAN_NEWEST_H
#define APPS_VULKAN_NEWEST_H

#include "window.h"

typedef struct {
    VkCommandBuffer commands;
    VkSemaphore acquired, timeline;
} frame_parts;

/*
 * Submits by the newer call and waits for a timeline semaphore. Presents with the changed area of
 * the window and the number of the frame.
 */
void end_newest_frame(const vulkan_window *w, const frame_parts *parts, uint32_t index, uint64_t number);

#endif
