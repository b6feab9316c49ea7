/*
 * The objects of an episode of random Vulkan calls, and the command buffer that is recorded.
 * Between commands every image is in VK_IMAGE_LAYOUT_GENERAL, except for the window's. A command
 * that is not allowed is left out.
 */
#ifndef APPS_VULKAN_PLAYER_H
#define APPS_VULKAN_PLAYER_H

#include "../frames.h"
#include "../window.h"

enum {
    SLOTS = 8,
    WINDOW = SLOTS, /* number of the window's image */
    DUMMY,          /* an image that always exists */
    OWN_DEPTH,      /* depth that is used only together with the window and not read */
    OWN_SAMPLES,    /* samples, likewise, that are resolved to the window */
    OWN_DEPTHS,     /* depth of several samples, likewise */
    ALL_IMAGES,
    BUFFERS = 4,    /* 0 and 1: matrices and vertices; the others: any copied data */
    SETS = 4,
    QUERIES = 4,
    SECONDARIES = 16,
    BUFFER_SIZE = 1 << 15,
    READ_SIZE = 1 << 17,
    MATRIX_STEP = 256, /* bytes between matrices in a buffer */
    VERTICES = 1 << 14, /* place of vertices in a buffer */
    CUBE = 36,
};

enum { SKIPPED = 0x5c1b };

typedef struct {
    VkFormat format;
    uint32_t width, height, levels;
    VkSampleCountFlagBits samples;
    VkImageAspectFlags aspects;
    VkImageUsageFlags usage;
    uint32_t texel; /* bytes per texel, if texels are copied */
} image_kind;

typedef struct {
    const image_kind *kind;
    VkImage image;
    VkDeviceMemory memory;
    VkImageView view;    /* view of the first level, to draw to */
    VkImageView sampled; /* view of one aspect */
} slot_image;

/* Data that is needed to submit a command buffer again. */
typedef struct {
    bool is_valid, uses_window, clears_window;
    uint32_t index;
    VkImageLayout window_layout, end_layout; /* layouts before and after the command buffer */
} recorded;

typedef struct {
    bool is_under_way, is_dynamic, is_secondary;
    slot_image *color, *second, *depth, *resolve;
    VkExtent2D extent;
    VkImageLayout color_layout, depth_layout, final_layout;
    VkRenderPass pass;
    int pipeline; /* -1: none is bound */
    bool query;
    uint32_t query_number;
} pass_state;

/* State that was set in the command buffer that draws. */
typedef struct {
    bool constants, viewport, vertices;
    int set; /* -1: none is bound */
} draw_state;

typedef struct {
    bool is_followed; /* commands that make a program flat under Cupola are left out (docs/compatibility.md) */
    vulkan_window w;
    frame_objects objects;
    slot_image images[ALL_IMAGES];
    image_kind window_kind;
    block buffers[BUFFERS], indices, indirect, read;
    VkSampler samplers[2];
    VkDescriptorSetLayout set_layout;
    VkPipelineLayout layout;
    VkDescriptorPool descriptors;
    VkDescriptorSet sets[SETS];
    int set_image[SETS], set_result[SETS]; /* images in the sets */
    VkQueryPool queries;
    bool query_is_used[QUERIES], query_is_done[QUERIES];
    VkCommandBuffer primary, own, secondaries[SECONDARIES];
    int secondary;
    /* The command buffer that is recorded, and the one that gets the commands of a pass. */
    bool is_recording;
    VkCommandBuffer commands;
    recorded now;
    pass_state pass;
    draw_state draw;
    /* The window's image of this frame. */
    bool is_acquired, is_waited_for, has_content, has_depth;
    uint32_t index;
    VkImageLayout window_layout;
    int ways; /* how barriers are recorded */
    VkResult code; /* last result that is no success */
} world;

extern world it;

/* objects.c */
void objects_open(bool is_followed);
void objects_close(void);
void image_make(int slot, int kind);
/*
 * Sets the image that is sampled and the one that is stored to. If one is not possible, another is
 * used.
 */
void set_write(int set, int image, int sampler, int result);
void matrix_write(void *to, int kind);
slot_image *image_at(int number);
bool is_color(const slot_image *image);
unsigned long long image_digest(int number);
unsigned long long buffers_digest(void);

/* recording.c */
void check(VkResult result);
void begin_recording(void);
void window_opened(void);
bool need_window(void);
void window_cleared(VkImageLayout layout);
void barrier_all(VkCommandBuffer commands);
void image_layout(VkCommandBuffer commands, const slot_image *image, VkImageLayout from, VkImageLayout to);
void submit(bool presents);
int submit_again(void);
int present(unsigned long long *digest);
int swapchain_make(int size);
void own_commands_begin(void);
void own_commands_end(void);

/* passes.c */
int pass_begin(const int *n);
int pass_end(void);
int pass_clear(const int *n);
int pass_query(const int *n);

/* draws.c */
int draw_pipeline(const int *n);
int draw_set(const int *n);
int draw_push(const int *n);
int draw_viewport(const int *n);
int draw_scissor(const int *n);
int draw_vertices(const int *n);
int draw(const int *n);
int draw_indexed(const int *n);
int draw_indirect(const int *n);
int dispatch(const int *n);

/* pipelines.c */
VkPipeline pipeline_of_pass(int number);
VkPipeline pipeline_of_compute(void);
bool pipeline_samples(int number);
bool pipeline_has_input(int number);
void pipelines_free(void);
/* The pass and the framebuffer are destroyed with the episode. */
VkRenderPass keep_pass(VkRenderPass pass);
VkFramebuffer keep_framebuffer(VkFramebuffer framebuffer);

/* transfers.c */
int copy_images(const int *n);
int blit_images(const int *n);
int resolve_images(const int *n);
int copy_to_buffer(const int *n);
int copy_from_buffer(const int *n);
int copy_buffers(const int *n);
int fill_buffer(const int *n);
int update_buffer(const int *n);
int clear_image(const int *n);
int make_levels(const int *n);

#endif
