/* A device, an X11 window and its swapchain. Failures end the program with a message. */
#ifndef APPS_VULKAN_WINDOW_H
#define APPS_VULKAN_WINDOW_H

#define VK_USE_PLATFORM_XLIB_KHR
#include <X11/Xlib.h>
#include <stdbool.h>
#include <stdint.h>
#include <vulkan/vulkan.h>

enum { MOST_IMAGES = 8 };
#define DEPTH_FORMAT VK_FORMAT_D32_SFLOAT

typedef struct {
    VkImage image;
    VkDeviceMemory memory;
    VkImageView view;
} picture;

typedef struct {
    VkBuffer buffer;
    VkDeviceMemory memory;
    void *bytes; /* address of the mapped memory, if it can be mapped */
} block;

/*
 * Extensions of the device. They are enabled if the program asks for the newest ones. That includes
 * all queries.
 */
typedef struct {
    bool mutable_format, incremental_present, present_id, present_wait, libraries, push_descriptor, conditional_rendering, provoking_vertex;
} window_extensions;

typedef struct {
    Display *display;
    Window window;
    VkInstance instance;
    VkPhysicalDevice physical;
    VkDevice device;
    VkQueue queue;
    uint32_t family;
    window_extensions has;
    bool stages; /* geometry and tessellation shaders are enabled; set it before the window is opened */
    bool writes; /* vertex and fragment shaders may write to buffers and images; set it before, too */
    bool addresses; /* addresses of buffers are enabled; set it before, too */
    bool immediate; /* pictures are shown at once, and vkQueuePresentKHR waits for that; set it before, too */
    VkSurfaceKHR surface;
    VkFormat format;
    VkImageUsageFlags usage; /* usage of the swapchain's images, besides drawing */
    VkSwapchainKHR swapchain;
    VkExtent2D extent;
    uint32_t count;
    VkImage images[MOST_IMAGES];
    VkImageView views[MOST_IMAGES];
    VkSemaphore drawn[MOST_IMAGES];
} vulkan_window;

/* Ends the program unless `result` is VK_SUCCESS. */
void expect(VkResult result, const char *what);

/*
 * Opens the device, the window and the swapchain, at a place on the screen. With `newest` it
 * enables those of `window_extensions` that the device has, and features at the end of a structure
 * chain.
 */
void window_open(vulkan_window *w, int x, int y, uint32_t width, uint32_t height, bool srgb, bool newest,
                 VkImageUsageFlags usage);

/* Asks for another size, and waits until the server has given it. */
void window_ask_size(vulkan_window *w, uint32_t width, uint32_t height);

/*
 * Creates a swapchain in the window's present size. An earlier swapchain is retired and destroyed.
 */
void window_make_swapchain(vulkan_window *w);

void window_close(vulkan_window *w);

/* Writes the picture that the X server shows in the window as a binary PPM file. */
void window_shot(const vulkan_window *w, const char *path);

/* Creates an image with a view. */
picture make_picture(const vulkan_window *w, VkFormat format, VkExtent2D size, VkSampleCountFlagBits samples,
                     VkImageUsageFlags usage);
/* Allocates memory of the device for an image. */
VkDeviceMemory image_memory(const vulkan_window *w, VkImage image);
void free_picture(const vulkan_window *w, picture *p);

/* Creates a buffer, in memory that the host writes or in the device's own memory. */
block make_block(const vulkan_window *w, VkDeviceSize size, VkBufferUsageFlags usage, bool of_host);
void free_block(const vulkan_window *w, block *b);

/* Makes a descriptor set with one descriptor, which fragment shaders read, its layout, and its pool. */
void make_one_descriptor(const vulkan_window *w, VkDescriptorType kind, VkDescriptorSetLayout *layout,
                         VkDescriptorPool *pool, VkDescriptorSet *set);

#endif
