/* A frame: the window's next image, a command buffer, and presenting the image. */
#ifndef APPS_VULKAN_FRAMES_H
#define APPS_VULKAN_FRAMES_H

#include "window.h"

typedef struct {
    VkCommandPool pool;
    VkSemaphore acquired;
    VkFence done;
} frame_objects;

frame_objects make_frame_objects(const vulkan_window *w);
void free_frame_objects(const vulkan_window *w, frame_objects *objects);

void make_commands(const vulkan_window *w, const frame_objects *objects, VkCommandBufferLevel level, uint32_t count,
                   VkCommandBuffer *made);

/* Number of the image that is drawn next. */
uint32_t next_image(const vulkan_window *w, const frame_objects *objects);

/*
 * Submits and presents the frame, and waits until the commands are done. Returns whether the
 * swapchain is still optimal.
 */
bool end_frame(const vulkan_window *w, const frame_objects *objects, VkCommandBuffer commands, uint32_t index);

/*
 * Draws `count` frames with one command buffer, which `record` records for each image. If `shot` is
 * given, the window is written to this file after the last frame.
 */
void run_frames(const vulkan_window *w, const frame_objects *objects, VkCommandBuffer commands, int count,
                const char *shot, void (*record)(uint32_t index));

/* Changes the layout of an image, after all recorded commands and before all following ones. */
void change_layout(VkCommandBuffer commands, VkImage image, VkImageAspectFlags aspect, VkImageLayout from,
                   VkImageLayout to);

#endif
