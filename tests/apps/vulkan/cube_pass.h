/* The render pass of the cube. */
#ifndef APPS_VULKAN_CUBE_PASS_H
#define APPS_VULKAN_CUBE_PASS_H

#include "window.h"

/* Whether the colour has several samples, and is resolved. */
bool multisampled(void);

/* Makes the pass that the options ask for. */
VkRenderPass make_pass(const vulkan_window *w);

#endif
