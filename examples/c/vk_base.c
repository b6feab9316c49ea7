#include "vk_base.h"

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

bool base_good(VkResult result, const char *what)
{
    if (result != VK_SUCCESS)
        fprintf(stderr, "Vulkan call failed (%s): VkResult %d\n", what, (int)result);
    return result == VK_SUCCESS;
}

static bool open_device(base *b, bool multiview)
{
    uint32_t count = 1, families = 16;
    VkQueueFamilyProperties family[16];
    VkResult found = vkEnumeratePhysicalDevices(b->instance, &count, &b->physical_device);
    if ((found != VK_SUCCESS && found != VK_INCOMPLETE) || count == 0) {
        fprintf(stderr, "no Vulkan device was found\n");
        return false;
    }
    vkGetPhysicalDeviceQueueFamilyProperties(b->physical_device, &families, family);
    for (b->queue_family = 0; b->queue_family < families; b->queue_family++) {
        VkBool32 shows = VK_TRUE;
        if (b->surface != VK_NULL_HANDLE)
            vkGetPhysicalDeviceSurfaceSupportKHR(b->physical_device, b->queue_family, b->surface, &shows);
        if ((family[b->queue_family].queueFlags & VK_QUEUE_GRAPHICS_BIT) && shows)
            break;
    }
    const float priority = 1.0f;
    const char *swapchain = VK_KHR_SWAPCHAIN_EXTENSION_NAME;
    VkPhysicalDeviceMultiviewFeatures features = {.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_MULTIVIEW_FEATURES,
                                                  .multiview = VK_TRUE};
    VkDeviceQueueCreateInfo queue = {.sType = VK_STRUCTURE_TYPE_DEVICE_QUEUE_CREATE_INFO,
                                     .queueFamilyIndex = b->queue_family,
                                     .queueCount = 1,
                                     .pQueuePriorities = &priority};
    VkDeviceCreateInfo device = {.sType = VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO,
                                 .pNext = multiview ? &features : NULL,
                                 .queueCreateInfoCount = 1,
                                 .pQueueCreateInfos = &queue,
                                 .enabledExtensionCount = b->window != NULL,
                                 .ppEnabledExtensionNames = &swapchain};
    if (b->queue_family == families || !base_good(vkCreateDevice(b->physical_device, &device, NULL, &b->device), "a device"))
        return false;
    vkGetDeviceQueue(b->device, b->queue_family, 0, &b->queue);
    return true;
}

bool base_make_view(base *b, VkImage image, VkFormat format, uint32_t first, uint32_t layers, VkImageView *view)
{
    VkImageViewCreateInfo info = {.sType = VK_STRUCTURE_TYPE_IMAGE_VIEW_CREATE_INFO,
                                  .image = image,
                                  .viewType = layers > 0 ? VK_IMAGE_VIEW_TYPE_2D_ARRAY : VK_IMAGE_VIEW_TYPE_2D,
                                  .format = format,
                                  .subresourceRange = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 1, first, layers > 0 ? layers : 1}};
    return base_good(vkCreateImageView(b->device, &info, NULL, view), "a view");
}

static bool allocate(base *b, const VkMemoryRequirements *needs, VkMemoryPropertyFlags wanted, VkDeviceMemory *memory)
{
    VkPhysicalDeviceMemoryProperties has;
    vkGetPhysicalDeviceMemoryProperties(b->physical_device, &has);
    uint32_t type = 0;
    while (type < has.memoryTypeCount &&
           !((needs->memoryTypeBits >> type & 1) && (has.memoryTypes[type].propertyFlags & wanted) == wanted))
        type++;
    VkMemoryAllocateInfo info = {.sType = VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO,
                                 .allocationSize = needs->size,
                                 .memoryTypeIndex = type};
    return type < has.memoryTypeCount && base_good(vkAllocateMemory(b->device, &info, NULL, memory), "memory");
}

bool base_make_image(base *b, VkFormat format, uint32_t width, uint32_t height, uint32_t layers,
                     VkImageUsageFlags usage, base_image *made)
{
    VkImageCreateInfo info = {.sType = VK_STRUCTURE_TYPE_IMAGE_CREATE_INFO,
                              .imageType = VK_IMAGE_TYPE_2D,
                              .format = format,
                              .extent = {width, height, 1},
                              .mipLevels = 1,
                              .arrayLayers = layers > 0 ? layers : 1,
                              .samples = VK_SAMPLE_COUNT_1_BIT,
                              .usage = usage};
    VkMemoryRequirements needs;
    if (!base_good(vkCreateImage(b->device, &info, NULL, &made->image), "an image"))
        return false;
    vkGetImageMemoryRequirements(b->device, made->image, &needs);
    return allocate(b, &needs, 0, &made->memory) &&
           base_good(vkBindImageMemory(b->device, made->image, made->memory, 0), "memory of an image") &&
           base_make_view(b, made->image, format, 0, layers, &made->view);
}

void base_free_image(base *b, base_image *image)
{
    vkDestroyImageView(b->device, image->view, NULL);
    vkDestroyImage(b->device, image->image, NULL);
    vkFreeMemory(b->device, image->memory, NULL);
    *image = (base_image){VK_NULL_HANDLE, VK_NULL_HANDLE, VK_NULL_HANDLE};
}

bool base_make_buffer(base *b, VkBufferUsageFlags usage, const void *data, VkDeviceSize size, VkBuffer *buffer,
                      VkDeviceMemory *memory)
{
    VkBufferCreateInfo info = {.sType = VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO, .size = size, .usage = usage};
    VkMemoryRequirements needs;
    void *place;
    if (!base_good(vkCreateBuffer(b->device, &info, NULL, buffer), "a buffer"))
        return false;
    vkGetBufferMemoryRequirements(b->device, *buffer, &needs);
    if (!allocate(b, &needs, VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT, memory) ||
        !base_good(vkBindBufferMemory(b->device, *buffer, *memory, 0), "memory of a buffer"))
        return false;
    if (data == NULL)
        return true;
    if (!base_good(vkMapMemory(b->device, *memory, 0, size, 0, &place), "to map memory"))
        return false;
    memcpy(place, data, size);
    vkUnmapMemory(b->device, *memory);
    return true;
}

VkRenderPass base_make_render_pass(base *b, VkFormat format, VkImageLayout layout_after, uint32_t view_mask)
{
    VkAttachmentDescription color = {.format = format,
                                     .samples = VK_SAMPLE_COUNT_1_BIT,
                                     .loadOp = VK_ATTACHMENT_LOAD_OP_CLEAR,
                                     .storeOp = VK_ATTACHMENT_STORE_OP_STORE,
                                     .stencilLoadOp = VK_ATTACHMENT_LOAD_OP_DONT_CARE,
                                     .stencilStoreOp = VK_ATTACHMENT_STORE_OP_DONT_CARE,
                                     .initialLayout = VK_IMAGE_LAYOUT_UNDEFINED,
                                     .finalLayout = layout_after};
    VkAttachmentReference reference = {0, VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL};
    VkSubpassDescription subpass = {.pipelineBindPoint = VK_PIPELINE_BIND_POINT_GRAPHICS,
                                    .colorAttachmentCount = 1,
                                    .pColorAttachments = &reference};
    const VkPipelineStageFlags writes = VK_PIPELINE_STAGE_COLOR_ATTACHMENT_OUTPUT_BIT;
    const VkAccessFlags write = VK_ACCESS_COLOR_ATTACHMENT_WRITE_BIT;
    /* The pass runs after earlier writes and before later uses. */
    VkSubpassDependency order[] = {
        {VK_SUBPASS_EXTERNAL, 0, writes, writes, 0, write, 0},
        {0, VK_SUBPASS_EXTERNAL, writes, writes | b->after_stages, write, write | b->after_access, 0},
    };
    VkRenderPassMultiviewCreateInfo views = {.sType = VK_STRUCTURE_TYPE_RENDER_PASS_MULTIVIEW_CREATE_INFO,
                                             .subpassCount = 1,
                                             .pViewMasks = &view_mask};
    VkRenderPassCreateInfo info = {.sType = VK_STRUCTURE_TYPE_RENDER_PASS_CREATE_INFO,
                                   .pNext = view_mask != 0 ? &views : NULL,
                                   .attachmentCount = 1,
                                   .pAttachments = &color,
                                   .subpassCount = 1,
                                   .pSubpasses = &subpass,
                                   .dependencyCount = 2,
                                   .pDependencies = order};
    VkRenderPass pass = VK_NULL_HANDLE;
    base_good(vkCreateRenderPass(b->device, &info, NULL, &pass), "a render pass");
    return pass;
}

VkFramebuffer base_make_framebuffer(base *b, VkRenderPass pass, VkImageView view, uint32_t width, uint32_t height)
{
    VkFramebufferCreateInfo info = {.sType = VK_STRUCTURE_TYPE_FRAMEBUFFER_CREATE_INFO,
                                    .renderPass = pass,
                                    .attachmentCount = 1,
                                    .pAttachments = &view,
                                    .width = width,
                                    .height = height,
                                    .layers = 1};
    VkFramebuffer framebuffer = VK_NULL_HANDLE;
    base_good(vkCreateFramebuffer(b->device, &info, NULL, &framebuffer), "a framebuffer");
    return framebuffer;
}

static void free_swapchain(base *b)
{
    for (uint32_t i = 0; i < b->image_count; i++) {
        vkDestroyImageView(b->device, b->views[i], NULL);
        vkDestroySemaphore(b->device, b->drawn[i], NULL);
    }
    b->image_count = 0;
}

static bool make_swapchain(base *b)
{
    int width, height;
    glfwGetFramebufferSize(b->window, &width, &height);
    VkSurfaceCapabilitiesKHR can;
    if (width == 0 || height == 0 ||
        !base_good(vkGetPhysicalDeviceSurfaceCapabilitiesKHR(b->physical_device, b->surface, &can), "the window"))
        return false;
    b->width = can.currentExtent.width != UINT32_MAX ? can.currentExtent.width : (uint32_t)width;
    b->height = can.currentExtent.height != UINT32_MAX ? can.currentExtent.height : (uint32_t)height;
    VkSwapchainKHR old = b->swapchain;
    VkSwapchainCreateInfoKHR info = {.sType = VK_STRUCTURE_TYPE_SWAPCHAIN_CREATE_INFO_KHR,
                                     .surface = b->surface,
                                     .minImageCount = can.minImageCount,
                                     .imageFormat = BASE_FORMAT,
                                     .imageColorSpace = VK_COLOR_SPACE_SRGB_NONLINEAR_KHR,
                                     .imageExtent = {b->width, b->height},
                                     .imageArrayLayers = 1,
                                     .imageUsage = VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT,
                                     .preTransform = can.currentTransform,
                                     .compositeAlpha = VK_COMPOSITE_ALPHA_OPAQUE_BIT_KHR,
                                     .presentMode = VK_PRESENT_MODE_FIFO_KHR,
                                     .clipped = VK_TRUE,
                                     .oldSwapchain = old};
    if (!base_good(vkCreateSwapchainKHR(b->device, &info, NULL, &b->swapchain), "a swapchain"))
        return false;
    vkDestroySwapchainKHR(b->device, old, NULL);
    uint32_t count = MOST_IMAGES;
    if (!base_good(vkGetSwapchainImagesKHR(b->device, b->swapchain, &count, b->images), "the swapchain's images"))
        return false;
    VkSemaphoreCreateInfo semaphore = {.sType = VK_STRUCTURE_TYPE_SEMAPHORE_CREATE_INFO};
    for (; b->image_count < count; b->image_count++) {
        uint32_t i = b->image_count;
        if (!base_make_view(b, b->images[i], BASE_FORMAT, 0, 0, &b->views[i]) ||
            !base_good(vkCreateSemaphore(b->device, &semaphore, NULL, &b->drawn[i]), "a semaphore"))
            return false;
    }
    return true;
}

/* Opens the program's picture. */
static bool open_picture(base *b)
{
    if (b->window != NULL) {
        b->shown_layout = VK_IMAGE_LAYOUT_PRESENT_SRC_KHR; /* a semaphore orders later uses */
        return make_swapchain(b);
    }
    b->shown_layout = VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL;
    b->after_stages = VK_PIPELINE_STAGE_TRANSFER_BIT;
    b->after_access = VK_ACCESS_TRANSFER_READ_BIT;
    if (!base_make_image(b, BASE_FORMAT, b->width, b->height, 0,
                         VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT | VK_IMAGE_USAGE_TRANSFER_SRC_BIT, &b->picture))
        return false;
    b->images[0] = b->picture.image;
    b->views[0] = b->picture.view;
    b->image_count = 1;
    return true;
}

bool base_open(base *b, bool window, uint32_t width, uint32_t height, bool multiview)
{
    *b = (base){.width = width, .height = height};
    VkApplicationInfo application = {.sType = VK_STRUCTURE_TYPE_APPLICATION_INFO, .apiVersion = VK_API_VERSION_1_1};
    VkInstanceCreateInfo instance = {.sType = VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO, .pApplicationInfo = &application};
    if (window) {
        if (!glfwInit() || !glfwVulkanSupported()) {
            fprintf(stderr, "GLFW cannot open windows for Vulkan on this system\n");
            return false;
        }
        glfwWindowHint(GLFW_CLIENT_API, GLFW_NO_API);
        b->window = glfwCreateWindow((int)width, (int)height, "room", NULL, NULL);
        instance.ppEnabledExtensionNames = glfwGetRequiredInstanceExtensions(&instance.enabledExtensionCount);
    }
    if ((window && b->window == NULL) || !base_good(vkCreateInstance(&instance, NULL, &b->instance), "an instance") ||
        (window && !base_good(glfwCreateWindowSurface(b->instance, b->window, NULL, &b->surface), "a surface")) ||
        !open_device(b, multiview) || !open_picture(b))
        return false;
    VkCommandPoolCreateInfo pool = {.sType = VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO,
                                    .flags = VK_COMMAND_POOL_CREATE_RESET_COMMAND_BUFFER_BIT,
                                    .queueFamilyIndex = b->queue_family};
    if (!base_good(vkCreateCommandPool(b->device, &pool, NULL, &b->pool), "a command pool"))
        return false;
    VkCommandBufferAllocateInfo buffers = {.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO,
                                           .commandPool = b->pool,
                                           .commandBufferCount = FRAMES_IN_FLIGHT};
    VkFenceCreateInfo fence = {.sType = VK_STRUCTURE_TYPE_FENCE_CREATE_INFO, .flags = VK_FENCE_CREATE_SIGNALED_BIT};
    VkSemaphoreCreateInfo semaphore = {.sType = VK_STRUCTURE_TYPE_SEMAPHORE_CREATE_INFO};
    bool good = base_good(vkAllocateCommandBuffers(b->device, &buffers, b->commands), "command buffers");
    for (int i = 0; good && i < FRAMES_IN_FLIGHT; i++)
        good = base_good(vkCreateFence(b->device, &fence, NULL, &b->done[i]), "a fence") &&
               base_good(vkCreateSemaphore(b->device, &semaphore, NULL, &b->acquired[i]), "a semaphore");
    return good;
}

bool base_begin(base *b, bool *changed)
{
    *changed = false;
    vkWaitForFences(b->device, 1, &b->done[b->frame], VK_TRUE, UINT64_MAX);
    if (b->window != NULL) {
        glfwPollEvents();
        if (glfwWindowShouldClose(b->window))
            return false;
        VkResult got = VK_ERROR_OUT_OF_DATE_KHR;
        while ((got = vkAcquireNextImageKHR(b->device, b->swapchain, UINT64_MAX, b->acquired[b->frame], VK_NULL_HANDLE,
                                            &b->image)) == VK_ERROR_OUT_OF_DATE_KHR) {
            vkDeviceWaitIdle(b->device);
            free_swapchain(b);
            if (!make_swapchain(b))
                return false;
            *changed = true;
        }
        if (got != VK_SUBOPTIMAL_KHR && !base_good(got, "an image of the swapchain"))
            return false;
    }
    VkCommandBufferBeginInfo begin = {.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO,
                                      .flags = VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT};
    return base_good(vkBeginCommandBuffer(b->commands[b->frame], &begin), "to record");
}

bool base_end(base *b)
{
    const VkPipelineStageFlags stage = VK_PIPELINE_STAGE_COLOR_ATTACHMENT_OUTPUT_BIT;
    VkSubmitInfo submit = {.sType = VK_STRUCTURE_TYPE_SUBMIT_INFO,
                           .waitSemaphoreCount = b->window != NULL,
                           .pWaitSemaphores = &b->acquired[b->frame],
                           .pWaitDstStageMask = &stage,
                           .commandBufferCount = 1,
                           .pCommandBuffers = &b->commands[b->frame],
                           .signalSemaphoreCount = b->window != NULL,
                           .pSignalSemaphores = &b->drawn[b->image]};
    if (!base_good(vkEndCommandBuffer(b->commands[b->frame]), "to end recording") ||
        !base_good(vkResetFences(b->device, 1, &b->done[b->frame]), "a fence") ||
        !base_good(vkQueueSubmit(b->queue, 1, &submit, b->done[b->frame]), "to submit"))
        return false;
    if (b->window != NULL) {
        VkPresentInfoKHR present = {.sType = VK_STRUCTURE_TYPE_PRESENT_INFO_KHR,
                                    .waitSemaphoreCount = 1,
                                    .pWaitSemaphores = &b->drawn[b->image],
                                    .swapchainCount = 1,
                                    .pSwapchains = &b->swapchain,
                                    .pImageIndices = &b->image};
        VkResult shown = vkQueuePresentKHR(b->queue, &present);
        /* The next acquire handles another size. */
        if (shown != VK_SUBOPTIMAL_KHR && shown != VK_ERROR_OUT_OF_DATE_KHR && !base_good(shown, "to present"))
            return false;
    }
    b->frame = (b->frame + 1) % FRAMES_IN_FLIGHT;
    return true;
}

void base_finish(base *b)
{
    vkDeviceWaitIdle(b->device);
}

/* Writes four bytes for each pixel, blue first, as a PPM. */
static bool write_ppm(const char *path, uint32_t width, uint32_t height, const unsigned char *bgra)
{
    FILE *file = fopen(path, "wb");
    if (file == NULL) {
        perror(path);
        return false;
    }
    fprintf(file, "P6\n%u %u\n255\n", (unsigned)width, (unsigned)height);
    for (size_t i = 0; i < (size_t)width * height; i++) {
        const unsigned char rgb[3] = {bgra[4 * i + 2], bgra[4 * i + 1], bgra[4 * i]};
        fwrite(rgb, 1, 3, file);
    }
    return fclose(file) == 0;
}

bool base_save(base *b, const char *path)
{
    VkDeviceSize size = (VkDeviceSize)b->width * b->height * 4;
    VkBuffer buffer = VK_NULL_HANDLE;
    VkDeviceMemory memory = VK_NULL_HANDLE;
    VkCommandBuffer commands = b->commands[b->frame];
    VkCommandBufferBeginInfo begin = {.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO};
    VkBufferImageCopy all = {.imageSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, 1},
                             .imageExtent = {b->width, b->height, 1}};
    VkMemoryBarrier seen = {.sType = VK_STRUCTURE_TYPE_MEMORY_BARRIER,
                            .srcAccessMask = VK_ACCESS_TRANSFER_WRITE_BIT,
                            .dstAccessMask = VK_ACCESS_HOST_READ_BIT};
    VkSubmitInfo submit = {.sType = VK_STRUCTURE_TYPE_SUBMIT_INFO, .commandBufferCount = 1, .pCommandBuffers = &commands};
    void *pixels;
    base_finish(b);
    bool good = base_make_buffer(b, VK_BUFFER_USAGE_TRANSFER_DST_BIT, NULL, size, &buffer, &memory) &&
                base_good(vkBeginCommandBuffer(commands, &begin), "to record");
    if (good) {
        vkCmdCopyImageToBuffer(commands, b->images[0], b->shown_layout, buffer, 1, &all);
        vkCmdPipelineBarrier(commands, VK_PIPELINE_STAGE_TRANSFER_BIT, VK_PIPELINE_STAGE_HOST_BIT, 0, 1, &seen, 0, NULL,
                             0, NULL);
        good = base_good(vkEndCommandBuffer(commands), "to end recording") &&
               base_good(vkQueueSubmit(b->queue, 1, &submit, VK_NULL_HANDLE), "to submit");
        base_finish(b);
    }
    if (good && base_good(vkMapMemory(b->device, memory, 0, size, 0, &pixels), "to map memory")) {
        good = write_ppm(path, b->width, b->height, pixels);
        vkUnmapMemory(b->device, memory);
    }
    vkDestroyBuffer(b->device, buffer, NULL);
    vkFreeMemory(b->device, memory, NULL);
    return good;
}

void base_close(base *b)
{
    if (b->device != VK_NULL_HANDLE) {
        base_finish(b);
        for (int i = 0; i < FRAMES_IN_FLIGHT; i++) {
            vkDestroyFence(b->device, b->done[i], NULL);
            vkDestroySemaphore(b->device, b->acquired[i], NULL);
        }
        vkDestroyCommandPool(b->device, b->pool, NULL);
        if (b->window != NULL)
            free_swapchain(b);
        else
            base_free_image(b, &b->picture);
        if (b->window != NULL)
            vkDestroySwapchainKHR(b->device, b->swapchain, NULL);
        vkDestroyDevice(b->device, NULL);
    }
    if (b->surface != VK_NULL_HANDLE)
        vkDestroySurfaceKHR(b->instance, b->surface, NULL);
    if (b->instance != VK_NULL_HANDLE)
        vkDestroyInstance(b->instance, NULL);
    if (b->window != NULL) {
        glfwDestroyWindow(b->window);
        glfwTerminate();
    }
}
