/* A pass that clears depth, or draws it, before the pass that draws colours. */
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

/* `description` is that of the pipeline of the other pass. */
depth_pass make_depth_pass(const vulkan_window *w, VkImageView view, const pipeline_description *description);
void free_depth_pass(const vulkan_window *w, depth_pass *made);

/* The depth is in VK_IMAGE_LAYOUT_DEPTH_STENCIL_ATTACHMENT_OPTIMAL behind it. */
void begin_depth_pass(const depth_pass *made, VkCommandBuffer buffer);
void end_depth_pass(const depth_pass *made, VkCommandBuffer buffer);

#endif
