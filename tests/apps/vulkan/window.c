#include "window.h"

#include "../common/x11.h"

#include <X11/Xutil.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

void expect(VkResult result, const char *what)
{
    if (result != VK_SUCCESS) {
        fprintf(stderr, "%s fails: VkResult %d\n", what, (int)result);
        exit(1);
    }
}

static void open_x11(vulkan_window *w, int x, int y, uint32_t width, uint32_t height)
{
    w->display = x11_open();
    w->window = XCreateSimpleWindow(w->display, DefaultRootWindow(w->display), x, y, width, height, 0, 0, 0);
    XSelectInput(w->display, w->window, StructureNotifyMask);
    x11_map(w->display, w->window);
}

static bool has_extension(const vulkan_window *w, const char *name)
{
    VkExtensionProperties all[512];
    uint32_t count = 512;
    vkEnumerateDeviceExtensionProperties(w->physical, NULL, &count, all);
    for (uint32_t i = 0; i < count; i++)
        if (strcmp(all[i].extensionName, name) == 0)
            return true;
    return false;
}

/* Adds those of the newest extensions that the device has to a list. */
static uint32_t add_newest(vulkan_window *w, const char **list, uint32_t count)
{
    const struct {
        const char *name;
        bool *has;
    } all[] = {{VK_KHR_SWAPCHAIN_MUTABLE_FORMAT_EXTENSION_NAME, &w->has.mutable_format},
               {VK_KHR_INCREMENTAL_PRESENT_EXTENSION_NAME, &w->has.incremental_present},
               {VK_KHR_PRESENT_ID_EXTENSION_NAME, &w->has.present_id},
               {VK_KHR_PRESENT_WAIT_EXTENSION_NAME, &w->has.present_wait},
               {VK_KHR_PUSH_DESCRIPTOR_EXTENSION_NAME, &w->has.push_descriptor},
               {VK_EXT_CONDITIONAL_RENDERING_EXTENSION_NAME, &w->has.conditional_rendering},
               {VK_EXT_PROVOKING_VERTEX_EXTENSION_NAME, &w->has.provoking_vertex},
               {VK_KHR_PIPELINE_LIBRARY_EXTENSION_NAME, &w->has.libraries},
               {VK_EXT_GRAPHICS_PIPELINE_LIBRARY_EXTENSION_NAME, &w->has.libraries}};
    for (size_t i = 0; i < sizeof all / sizeof all[0]; i++) {
        *all[i].has = has_extension(w, all[i].name);
        if (*all[i].has)
            list[count++] = all[i].name;
        else
            fprintf(stderr, "SKIP: the device has no %s\n", all[i].name);
    }
    return count;
}

static void open_device(vulkan_window *w, bool newest)
{
    const char *const extensions[] = {VK_KHR_SURFACE_EXTENSION_NAME, VK_KHR_XLIB_SURFACE_EXTENSION_NAME};
    const VkApplicationInfo application = {.sType = VK_STRUCTURE_TYPE_APPLICATION_INFO, .apiVersion = VK_API_VERSION_1_3};
    const VkInstanceCreateInfo instance = {.sType = VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO,
                                           .pApplicationInfo = &application,
                                           .enabledExtensionCount = 2,
                                           .ppEnabledExtensionNames = extensions};
    expect(vkCreateInstance(&instance, NULL, &w->instance), "vkCreateInstance");
    uint32_t count = 1;
    VkResult found = vkEnumeratePhysicalDevices(w->instance, &count, &w->physical);
    if (count == 0 || (found != VK_SUCCESS && found != VK_INCOMPLETE)) {
        fprintf(stderr, "there is no Vulkan device\n");
        exit(1);
    }
    const VkXlibSurfaceCreateInfoKHR surface = {
        .sType = VK_STRUCTURE_TYPE_XLIB_SURFACE_CREATE_INFO_KHR, .dpy = w->display, .window = w->window};
    expect(vkCreateXlibSurfaceKHR(w->instance, &surface, NULL, &w->surface), "vkCreateXlibSurfaceKHR");
    VkQueueFamilyProperties families[16];
    uint32_t family_count = 16;
    vkGetPhysicalDeviceQueueFamilyProperties(w->physical, &family_count, families);
    for (w->family = 0; w->family < family_count; w->family++) {
        VkBool32 presents = VK_FALSE;
        expect(vkGetPhysicalDeviceSurfaceSupportKHR(w->physical, w->family, w->surface, &presents), "surface support");
        if (presents && (families[w->family].queueFlags & VK_QUEUE_GRAPHICS_BIT))
            break;
    }
    const float priority = 1.0f;
    const VkDeviceQueueCreateInfo queue = {.sType = VK_STRUCTURE_TYPE_DEVICE_QUEUE_CREATE_INFO,
                                           .queueFamilyIndex = w->family,
                                           .queueCount = 1,
                                           .pQueuePriorities = &priority};
    const char *extensions_of_device[16] = {VK_KHR_SWAPCHAIN_EXTENSION_NAME};
    const uint32_t extension_count = newest ? add_newest(w, extensions_of_device, 1) : 1;
    VkPhysicalDevicePresentWaitFeaturesKHR waits = {
        .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PRESENT_WAIT_FEATURES_KHR, .presentWait = VK_TRUE};
    VkPhysicalDevicePresentIdFeaturesKHR ids = {.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PRESENT_ID_FEATURES_KHR,
                                                .pNext = w->has.present_wait ? &waits : NULL,
                                                .presentId = VK_TRUE};
    VkPhysicalDeviceConditionalRenderingFeaturesEXT conditions = {
        .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_CONDITIONAL_RENDERING_FEATURES_EXT,
        .pNext = w->has.present_id ? &ids : NULL,
        .conditionalRendering = VK_TRUE};
    VkPhysicalDeviceGraphicsPipelineLibraryFeaturesEXT libraries = {
        .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_GRAPHICS_PIPELINE_LIBRARY_FEATURES_EXT,
        .pNext = w->has.conditional_rendering ? (void *)&conditions : conditions.pNext,
        .graphicsPipelineLibrary = VK_TRUE};
    VkPhysicalDeviceProvokingVertexFeaturesEXT provoking = {
        .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROVOKING_VERTEX_FEATURES_EXT,
        .pNext = w->has.libraries ? (void *)&libraries : libraries.pNext,
        .provokingVertexLast = VK_TRUE};
    VkPhysicalDeviceFeatures there;
    vkGetPhysicalDeviceFeatures(w->physical, &there);
    VkPhysicalDeviceFeatures2 features2 = {.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_FEATURES_2,
                                           .pNext = w->has.provoking_vertex ? (void *)&provoking : provoking.pNext,
                                           .features = {.occlusionQueryPrecise = newest,
                                                        .pipelineStatisticsQuery = newest,
                                                        .geometryShader = w->stages && there.geometryShader,
                                                        .vertexPipelineStoresAndAtomics = w->writes,
                                                        .fragmentStoresAndAtomics = w->writes,
                                                        .shaderStorageImageWriteWithoutFormat =
                                                            there.shaderStorageImageWriteWithoutFormat,
                                                        .shaderClipDistance = there.shaderClipDistance,
                                                        .shaderCullDistance = there.shaderCullDistance,
                                                        .tessellationShader = w->stages && there.tessellationShader}};
    VkPhysicalDeviceVulkan11Features features11 = {.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_1_FEATURES,
                                                   .pNext = newest ? (void *)&features2 : features2.pNext,
                                                   .multiview = newest};
    VkPhysicalDeviceVulkan12Features features12 = {.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_2_FEATURES,
                                                   .pNext = &features11,
                                                   .imagelessFramebuffer = VK_TRUE,
                                                   .bufferDeviceAddress = w->addresses,
                                                   .timelineSemaphore = newest};
    const VkPhysicalDeviceVulkan13Features features = {.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_3_FEATURES,
                                                       .pNext = &features12,
                                                       .dynamicRendering = VK_TRUE,
                                                       .synchronization2 = VK_TRUE};
    const VkDeviceCreateInfo device = {.sType = VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO,
                                       .pNext = &features,
                                       .queueCreateInfoCount = 1,
                                       .pQueueCreateInfos = &queue,
                                       .enabledExtensionCount = extension_count,
                                       .ppEnabledExtensionNames = extensions_of_device,
                                       .pEnabledFeatures = newest ? NULL : &features2.features};
    expect(vkCreateDevice(w->physical, &device, NULL, &w->device), "vkCreateDevice");
    vkGetDeviceQueue(w->device, w->family, 0, &w->queue);
}

void window_open(vulkan_window *w, int x, int y, uint32_t width, uint32_t height, bool srgb, bool newest,
                 VkImageUsageFlags usage)
{
    const bool stages = w->stages, immediate = w->immediate, addresses = w->addresses, writes = w->writes;
    memset(w, 0, sizeof *w);
    w->stages = stages;
    w->writes = writes;
    w->addresses = addresses;
    w->immediate = immediate;
    open_x11(w, x, y, width, height);
    open_device(w, newest);
    w->format = srgb ? VK_FORMAT_B8G8R8A8_SRGB : VK_FORMAT_B8G8R8A8_UNORM;
    w->usage = usage;
    window_make_swapchain(w);
}

void window_ask_size(vulkan_window *w, uint32_t width, uint32_t height)
{
    x11_resize(w->display, w->window, (int)width, (int)height);
}

static void free_views(vulkan_window *w)
{
    for (uint32_t i = 0; i < w->count; i++) {
        vkDestroyImageView(w->device, w->views[i], NULL);
        vkDestroySemaphore(w->device, w->drawn[i], NULL);
    }
}

void window_make_swapchain(vulkan_window *w)
{
    VkSurfaceCapabilitiesKHR can;
    expect(vkGetPhysicalDeviceSurfaceCapabilitiesKHR(w->physical, w->surface, &can), "surface capabilities");
    w->extent = can.currentExtent;
    VkSwapchainKHR old = w->swapchain;
    const VkFormat formats[] = {VK_FORMAT_B8G8R8A8_UNORM, VK_FORMAT_B8G8R8A8_SRGB};
    const VkImageFormatListCreateInfo list = {
        .sType = VK_STRUCTURE_TYPE_IMAGE_FORMAT_LIST_CREATE_INFO, .viewFormatCount = 2, .pViewFormats = formats};
    const VkSwapchainCreateInfoKHR info = {.sType = VK_STRUCTURE_TYPE_SWAPCHAIN_CREATE_INFO_KHR,
                                           .pNext = w->has.mutable_format ? &list : NULL,
                                           .flags = w->has.mutable_format ? VK_SWAPCHAIN_CREATE_MUTABLE_FORMAT_BIT_KHR : 0,
                                           .surface = w->surface,
                                           .minImageCount = can.minImageCount,
                                           .imageFormat = w->format,
                                           .imageColorSpace = VK_COLOR_SPACE_SRGB_NONLINEAR_KHR,
                                           .imageExtent = w->extent,
                                           .imageArrayLayers = 1,
                                           .imageUsage = VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT | w->usage,
                                           .preTransform = VK_SURFACE_TRANSFORM_IDENTITY_BIT_KHR,
                                           .compositeAlpha = VK_COMPOSITE_ALPHA_OPAQUE_BIT_KHR,
                                           .presentMode = w->immediate ? VK_PRESENT_MODE_IMMEDIATE_KHR : VK_PRESENT_MODE_FIFO_KHR,
                                           .clipped = VK_TRUE,
                                           .oldSwapchain = old};
    expect(vkCreateSwapchainKHR(w->device, &info, NULL, &w->swapchain), "vkCreateSwapchainKHR");
    if (old != VK_NULL_HANDLE) {
        expect(vkDeviceWaitIdle(w->device), "vkDeviceWaitIdle");
        free_views(w);
        vkDestroySwapchainKHR(w->device, old, NULL);
    }
    w->count = MOST_IMAGES;
    expect(vkGetSwapchainImagesKHR(w->device, w->swapchain, &w->count, w->images), "vkGetSwapchainImagesKHR");
    for (uint32_t i = 0; i < w->count; i++) {
        const VkImageViewCreateInfo view = {.sType = VK_STRUCTURE_TYPE_IMAGE_VIEW_CREATE_INFO,
                                            .image = w->images[i],
                                            .viewType = VK_IMAGE_VIEW_TYPE_2D,
                                            .format = w->format,
                                            .subresourceRange = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 1, 0, 1}};
        const VkSemaphoreCreateInfo semaphore = {.sType = VK_STRUCTURE_TYPE_SEMAPHORE_CREATE_INFO};
        expect(vkCreateImageView(w->device, &view, NULL, &w->views[i]), "vkCreateImageView");
        expect(vkCreateSemaphore(w->device, &semaphore, NULL, &w->drawn[i]), "vkCreateSemaphore");
    }
}

void window_close(vulkan_window *w)
{
    free_views(w);
    vkDestroySwapchainKHR(w->device, w->swapchain, NULL);
    vkDestroyDevice(w->device, NULL);
    vkDestroySurfaceKHR(w->instance, w->surface, NULL);
    vkDestroyInstance(w->instance, NULL);
    XDestroyWindow(w->display, w->window);
    XCloseDisplay(w->display);
}

/* Whether a picture has arrived: it is not black and is the same as the one before. */
static bool has_arrived(XImage *before, XImage *shot)
{
    bool black = true, same = before != NULL;
    for (int y = 0; y < shot->height; y++)
        for (int x = 0; x < shot->width; x++) {
            const unsigned long pixel = XGetPixel(shot, x, y) & 0xffffff;
            black = black && pixel == 0;
            same = same && pixel == (XGetPixel(before, x, y) & 0xffffff);
        }
    return same && !black;
}

/*
 * A presented picture reaches the window a little later and part by part. Nothing reports its
 * arrival, so the window is read repeatedly.
 */
static XImage *wait_for_picture(const vulkan_window *w)
{
    const struct timespec moment = {0, 20000000};
    XImage *before = NULL;
    for (int tries = 0;; tries++) {
        XSync(w->display, False);
        XImage *shot =
            XGetImage(w->display, w->window, 0, 0, w->extent.width, w->extent.height, AllPlanes, ZPixmap);
        const bool arrived = shot == NULL || tries == 500 || has_arrived(before, shot);
        if (before != NULL)
            XDestroyImage(before);
        if (arrived)
            return shot;
        before = shot;
        nanosleep(&moment, NULL);
    }
}

void window_shot(const vulkan_window *w, const char *path)
{
    expect(vkDeviceWaitIdle(w->device), "vkDeviceWaitIdle");
    XImage *shot = wait_for_picture(w);
    FILE *file = shot != NULL ? fopen(path, "wb") : NULL;
    if (file == NULL) {
        fprintf(stderr, "cannot write %s\n", path);
        exit(1);
    }
    fprintf(file, "P6\n%d %d\n255\n", shot->width, shot->height);
    for (int y = 0; y < shot->height; y++) {
        for (int x = 0; x < shot->width; x++) {
            unsigned long pixel = XGetPixel(shot, x, y);
            fputc((int)(pixel >> 16 & 0xff), file);
            fputc((int)(pixel >> 8 & 0xff), file);
            fputc((int)(pixel & 0xff), file);
        }
    }
    fclose(file);
    XDestroyImage(shot);
}

static VkDeviceMemory allocate(const vulkan_window *w, const VkMemoryRequirements *needs, VkMemoryPropertyFlags wanted,
                               bool addressed)
{
    const VkMemoryAllocateFlagsInfo flags = {.sType = VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_FLAGS_INFO,
                                             .flags = VK_MEMORY_ALLOCATE_DEVICE_ADDRESS_BIT};
    VkPhysicalDeviceMemoryProperties kinds;
    vkGetPhysicalDeviceMemoryProperties(w->physical, &kinds);
    uint32_t kind = 0;
    while (kind + 1 < kinds.memoryTypeCount && ((needs->memoryTypeBits >> kind & 1) == 0 ||
                                                (kinds.memoryTypes[kind].propertyFlags & wanted) != wanted))
        kind++;
    const VkMemoryAllocateInfo info = {
        .sType = VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO,
        .pNext = addressed ? &flags : NULL,
        .allocationSize = needs->size, .memoryTypeIndex = kind};
    VkDeviceMemory memory;
    expect(vkAllocateMemory(w->device, &info, NULL, &memory), "vkAllocateMemory");
    return memory;
}

VkDeviceMemory image_memory(const vulkan_window *w, VkImage image)
{
    VkMemoryRequirements needs;
    vkGetImageMemoryRequirements(w->device, image, &needs);
    const VkDeviceMemory memory = allocate(w, &needs, VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT, false);
    expect(vkBindImageMemory(w->device, image, memory, 0), "vkBindImageMemory");
    return memory;
}

picture make_picture(const vulkan_window *w, VkFormat format, VkExtent2D size, VkSampleCountFlagBits samples,
                     VkImageUsageFlags usage)
{
    picture p;
    const bool depth = format == DEPTH_FORMAT;
    const VkImageCreateInfo info = {.sType = VK_STRUCTURE_TYPE_IMAGE_CREATE_INFO,
                                    .imageType = VK_IMAGE_TYPE_2D,
                                    .format = format,
                                    .extent = {size.width, size.height, 1},
                                    .mipLevels = 1,
                                    .arrayLayers = 1,
                                    .samples = samples,
                                    .usage = usage};
    expect(vkCreateImage(w->device, &info, NULL, &p.image), "vkCreateImage");
    p.memory = image_memory(w, p.image);
    const VkImageAspectFlags aspect = depth ? VK_IMAGE_ASPECT_DEPTH_BIT : VK_IMAGE_ASPECT_COLOR_BIT;
    const VkImageViewCreateInfo view = {.sType = VK_STRUCTURE_TYPE_IMAGE_VIEW_CREATE_INFO,
                                        .image = p.image,
                                        .viewType = VK_IMAGE_VIEW_TYPE_2D,
                                        .format = format,
                                        .subresourceRange = {aspect, 0, 1, 0, 1}};
    expect(vkCreateImageView(w->device, &view, NULL, &p.view), "vkCreateImageView");
    return p;
}

void free_picture(const vulkan_window *w, picture *p)
{
    vkDestroyImageView(w->device, p->view, NULL);
    vkDestroyImage(w->device, p->image, NULL);
    vkFreeMemory(w->device, p->memory, NULL);
}

block make_block(const vulkan_window *w, VkDeviceSize size, VkBufferUsageFlags usage, bool of_host)
{
    block b = {VK_NULL_HANDLE, VK_NULL_HANDLE, NULL};
    const VkBufferCreateInfo info = {.sType = VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO, .size = size, .usage = usage};
    expect(vkCreateBuffer(w->device, &info, NULL, &b.buffer), "vkCreateBuffer");
    VkMemoryRequirements needs;
    vkGetBufferMemoryRequirements(w->device, b.buffer, &needs);
    const VkMemoryPropertyFlags host = VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT;
    b.memory = allocate(w, &needs, of_host ? host : VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT,
                        (usage & VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT) != 0);
    expect(vkBindBufferMemory(w->device, b.buffer, b.memory, 0), "vkBindBufferMemory");
    if (of_host)
        expect(vkMapMemory(w->device, b.memory, 0, VK_WHOLE_SIZE, 0, &b.bytes), "vkMapMemory");
    return b;
}

void free_block(const vulkan_window *w, block *b)
{
    vkDestroyBuffer(w->device, b->buffer, NULL);
    vkFreeMemory(w->device, b->memory, NULL);
}

void make_one_descriptor(const vulkan_window *w, VkDescriptorType kind, VkDescriptorSetLayout *layout,
                         VkDescriptorPool *pool, VkDescriptorSet *set)
{
    const VkDescriptorSetLayoutBinding binding = {0, kind, 1, VK_SHADER_STAGE_FRAGMENT_BIT, NULL};
    const VkDescriptorSetLayoutCreateInfo of_set = {
        .sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO, .bindingCount = 1, .pBindings = &binding};
    expect(vkCreateDescriptorSetLayout(w->device, &of_set, NULL, layout), "vkCreateDescriptorSetLayout");
    const VkDescriptorPoolSize count = {kind, 1};
    const VkDescriptorPoolCreateInfo of_pool = {
        .sType = VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO, .maxSets = 1, .poolSizeCount = 1, .pPoolSizes = &count};
    expect(vkCreateDescriptorPool(w->device, &of_pool, NULL, pool), "vkCreateDescriptorPool");
    const VkDescriptorSetAllocateInfo allocate = {.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_ALLOCATE_INFO,
                                                  .descriptorPool = *pool,
                                                  .descriptorSetCount = 1,
                                                  .pSetLayouts = layout};
    expect(vkAllocateDescriptorSets(w->device, &allocate, set), "vkAllocateDescriptorSets");
}
