/* Parts that every Vulkan program needs: a device, a window or a picture off screen, and frames. */
#ifndef VK_BASE_H
#define VK_BASE_H

#include <vulkan/vulkan.h>

#include <stdbool.h>

enum { FRAMES_IN_FLIGHT = 2, MOST_IMAGES = 8 };

/* An image that the program creates. */
typedef struct {
    VkImage image;
    VkDeviceMemory memory;
    VkImageView view;
} base_image;

typedef struct {
    VkInstance instance;
    VkPhysicalDevice physical_device;
    VkDevice device;
    uint32_t queue_family;
    VkQueue queue;
    VkCommandPool pool;

    /* The program's picture: a swapchain's images, or one image off screen. */
    struct GLFWwindow *window; /* NULL: off screen */
    VkSurfaceKHR surface;
    VkSwapchainKHR swapchain;
    uint32_t width, height;
    uint32_t image_count;
    VkImage images[MOST_IMAGES];
    VkImageView views[MOST_IMAGES];
    base_image picture;         /* off screen */
    VkImageLayout shown_layout; /* layout of an image after drawing */
    VkPipelineStageFlags after_stages;
    VkAccessFlags after_access;

    /* Frames in flight. */
    VkCommandBuffer commands[FRAMES_IN_FLIGHT];
    VkFence done[FRAMES_IN_FLIGHT];
    VkSemaphore acquired[FRAMES_IN_FLIGHT], drawn[MOST_IMAGES];
    uint32_t frame, image;
} base;

/* Format of the program's picture. */
#define BASE_FORMAT VK_FORMAT_B8G8R8A8_UNORM

/* Opens a device, with multiview on request, and a window or a picture off screen. Prints a message and returns false
 * if that fails. */
bool base_open(base *b, bool window, uint32_t width, uint32_t height, bool multiview);

/* Waits for a free frame and an image, and begins the command buffer `commands[frame]`. `*changed` is true if the
 * window has another size now: then the images are new ones. False: the program should end. */
bool base_begin(base *b, bool *changed);

/* Ends the command buffer, submits it, and presents the image. */
bool base_end(base *b);

/* Makes an image with one level, and a view of it: 2D, or for `layers` > 0 a 2D array. */
bool base_make_image(base *b, VkFormat format, uint32_t width, uint32_t height, uint32_t layers,
                     VkImageUsageFlags usage, base_image *made);
void base_free_image(base *b, base_image *image);

/* Makes a view of an image: 2D of layer `first`, or for `layers` > 0 a 2D array from there. */
bool base_make_view(base *b, VkImage image, VkFormat format, uint32_t first, uint32_t layers, VkImageView *view);

/* Makes a buffer that the processor writes, and fills it. */
bool base_make_buffer(base *b, VkBufferUsageFlags usage, const void *data, VkDeviceSize size, VkBuffer *buffer,
                      VkDeviceMemory *memory);

/* Makes a render pass that clears and stores one colour. `view_mask`: layers drawn at once (multiview), or 0. */
VkRenderPass base_make_render_pass(base *b, VkFormat format, VkImageLayout layout_after, uint32_t view_mask);
VkFramebuffer base_make_framebuffer(base *b, VkRenderPass pass, VkImageView view, uint32_t width, uint32_t height);

/* Writes the picture off screen as a binary PPM. */
bool base_save(base *b, const char *path);

/* Waits until the device is idle. */
void base_finish(base *b);
void base_close(base *b);

/* Returns true for success; otherwise prints what failed. */
bool base_good(VkResult result, const char *what);

#endif
