/* The scene of the Vulkan examples: a room around the camera whose walls are coloured by position. */
#ifndef VK_ROOM_H
#define VK_ROOM_H

#include "vk_base.h"

/* Column-major, as in shaders. */
typedef struct {
    float m[16];
} matrix;

enum { ROOM_MOST_VIEWS = 6 };

#define ROOM_NEAR 0.25
#define ROOM_FAR 100.0

typedef struct {
    VkDescriptorSetLayout set_layout;
    VkPipelineLayout layout;
    VkPipeline pipeline;
    VkBuffer corners, cameras;
    VkDeviceMemory corners_memory, cameras_memory;
    VkDescriptorPool pool;
    VkDescriptorSet set;
} room;

/* Makes the room for a render pass. `view_count` > 0: the pass draws this number of layers at once (multiview), each
 * with its own camera. */
bool room_open(base *b, VkRenderPass pass, uint32_t view_count, const matrix cameras[], room *made);
void room_close(base *b, room *r);

/* Draws the room with `camera` (world -> clip space). NULL: with the cameras that were given to room_open. */
void room_draw(const room *r, VkCommandBuffer commands, const matrix *camera);

/* Sets viewport and scissor. */
void room_place(VkCommandBuffer commands, int x, int y, int width, int height);

/* a * b: b is applied first. */
matrix matrix_multiply(const matrix *a, const matrix *b);

/* World -> eye for a camera in the middle that is turned right by `yaw`, then up by `pitch`, degrees. */
matrix matrix_camera(double yaw, double pitch);

/* A perspective in Vulkan's clip space (y down, depth 0 to 1) with a vertical field of view in degrees. */
matrix matrix_perspective(double fov, double aspect);

#endif
