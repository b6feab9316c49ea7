/*
 * A room around the camera, drawn with Vulkan in the usual way: one perspective, one render pass, one loop.
 * `vk_dome.c` is the same program with Cupola; compare the two to see what a program has to add.
 *
 * Build: make -C examples/c vk_plain
 * Run:   vk_plain [--window] [--frames N] [--size WxH] [--yaw DEGREES] [--pitch DEGREES] [--picture FILE]
 */
#include "vk_base.h"
#include "vk_options.h"
#include "vk_room.h"

#include <stddef.h>

static VkFramebuffer framebuffers[MOST_IMAGES];

static void make_framebuffers(base *b, VkRenderPass pass)
{
    for (uint32_t i = 0; i < b->image_count; i++)
        framebuffers[i] = base_make_framebuffer(b, pass, b->views[i], b->width, b->height);
}

static void free_framebuffers(base *b)
{
    for (uint32_t i = 0; i < MOST_IMAGES; i++) {
        vkDestroyFramebuffer(b->device, framebuffers[i], NULL);
        framebuffers[i] = VK_NULL_HANDLE;
    }
}

static void draw(base *b, VkRenderPass pass, const room *scene, const options *o)
{
    VkCommandBuffer commands = b->commands[b->frame];
    const VkClearValue grey = {.color = {.float32 = {0.25f, 0.25f, 0.25f, 1.0f}}};
    VkRenderPassBeginInfo begin = {.sType = VK_STRUCTURE_TYPE_RENDER_PASS_BEGIN_INFO,
                                   .renderPass = pass,
                                   .framebuffer = framebuffers[b->image],
                                   .renderArea = {{0, 0}, {b->width, b->height}},
                                   .clearValueCount = 1,
                                   .pClearValues = &grey};
    const matrix view = matrix_camera(o->yaw, o->pitch);
    const matrix lens = matrix_perspective(o->fov, (double)b->width / b->height);
    const matrix camera = matrix_multiply(&lens, &view);
    vkCmdBeginRenderPass(commands, &begin, VK_SUBPASS_CONTENTS_INLINE);
    room_place(commands, 0, 0, (int)b->width, (int)b->height);
    room_draw(scene, commands, &camera);
    vkCmdEndRenderPass(commands);
}

int main(int argc, char **argv)
{
    options o;
    base b;
    room scene;
    if (!options_read(argc, argv, &o))
        return 2;
    if (!base_open(&b, o.window, (uint32_t)o.width, (uint32_t)o.height, false))
        return 1;
    VkRenderPass pass = base_make_render_pass(&b, BASE_FORMAT, b.shown_layout, 0);
    bool good = room_open(&b, pass, 0, NULL, &scene), changed;
    make_framebuffers(&b, pass);
    for (int frame = 0; good && (o.frames == 0 || frame < o.frames) && base_begin(&b, &changed); frame++) {
        if (changed) {
            free_framebuffers(&b);
            make_framebuffers(&b, pass);
        }
        draw(&b, pass, &scene, &o);
        good = base_end(&b);
    }
    good = good && (o.picture == NULL || base_save(&b, o.picture));
    base_finish(&b);
    free_framebuffers(&b);
    room_close(&b, &scene);
    vkDestroyRenderPass(b.device, pass, NULL);
    base_close(&b);
    return good ? 0 : 1;
}
