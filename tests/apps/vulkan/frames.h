/* A frame: the window's next image, a command buffer, and its way to the window. */
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

/* The number of the image that is drawn next. */
uint32_t next_image(const vulkan_window *w, const frame_objects *objects);

/* Submits, presents, and waits until the commands are done. Whether the swapchain is as it should be. */
bool end_frame(const vulkan_window *w, const frame_objects *objects, VkCommandBuffer commands, uint32_t index);

/* Draws `count` frames with one command buffer, which `record` records for an image. With the path `shot` the window is
   written to it after the last frame. */
void run_frames(const vulkan_window *w, const frame_objects *objects, VkCommandBuffer commands, int count,
                const char *shot, void (*record)(uint32_t index));

/* Takes an image from one layout to another, after all that was recorded and before all that will be. */
void change_layout(VkCommandBuffer commands, VkImage image, VkImageAspectFlags aspect, VkImageLayout from,
                   VkImageLayout to);

#endif
