/* A pass that clears or draws depth before the pass that draws colours. */
#ifndef APPS_VULKAN_DEPTH_PASS_H
#define APPS_VULKAN_DEPTH_PASS_H

#include "pipelines.h"

typedef struct {
    VkRenderPass pass; /* null: dynamic rendering */
    VkFramebuffer framebuffer;
    linked_pipeline pipeline;
    VkImageView view;
    VkExtent2D extent;
} depth_pass;

/* Creates the pass. `description` is that of the other pass's pipeline. */
depth_pass make_depth_pass(const vulkan_window *w, VkImageView view, const pipeline_description *description);
void free_depth_pass(const vulkan_window *w, depth_pass *made);

/* After this pass the depth is in VK_IMAGE_LAYOUT_DEPTH_STENCIL_ATTACHMENT_OPTIMAL. */
void begin_depth_pass(const depth_pass *made, VkCommandBuffer buffer);
void end_depth_pass(const depth_pass *made, VkCommandBuffer buffer);

#endif
