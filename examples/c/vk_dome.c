/*
 * The room of `vk_plain.c` on a dome. What Cupola adds is marked.
 *
 * Build: make -C examples/c CUPOLA=../../target/release vk_dome
 * Run:   vk_dome [--rig RIG] [--views atlas|layers|images] [--own-images] [--one-by-one] [options of vk_plain]
 *
 * --views gives the layout of the views in memory. atlas: tiles of one image, drawn one after another, each with its
 * own viewport (the simplest). layers: layers of one image, all drawn at once by multiview. images: one image for each
 * view. --one-by-one: layers are drawn one after another, without multiview. --own-images: the program makes these
 * images, not Cupola.
 */
#include "vk_base.h"
#include "vk_options.h"
#include "vk_room.h"

#include <cupola_vk.h> /* Cupola */

#include <stddef.h>
#include <stdio.h>
#include <string.h>

enum { MOST_VIEWS = 32 };

/* Cupola: the dome, its views, and the images to which they are drawn. */
typedef struct {
    cupola_vk *cupola;
    uint32_t arrangement, view_count, image_count;
    bool at_once; /* all views in one pass */
    cupola_vk_view views[MOST_VIEWS];
    matrix cameras[MOST_VIEWS];
    cupola_vk_source sources[FRAMES_IN_FLIGHT][MOST_VIEWS];
    VkImageView layers[FRAMES_IN_FLIGHT][MOST_VIEWS]; /* for views that are drawn one by one */
    VkFramebuffer framebuffers[FRAMES_IN_FLIGHT][MOST_VIEWS];
    base_image own[FRAMES_IN_FLIGHT][MOST_VIEWS];
} dome;

/* Cupola: prints the error, if there is one. */
static bool good(cupola_status status)
{
    char detail[512];
    if (status == CUPOLA_OK)
        return true;
    cupola_last_error(detail, sizeof detail, NULL);
    fprintf(stderr, "Cupola: %s\n", detail);
    return false;
}

/* Cupola */
static bool open_dome(base *b, const options *o, dome *d)
{
    cupola_rig *rig = NULL;
    *d = (dome){.arrangement = strcmp(o->views, "layers") == 0   ? CUPOLA_VK_LAYERS
                               : strcmp(o->views, "images") == 0 ? CUPOLA_VK_IMAGES
                                                                 : CUPOLA_VK_ATLAS};
    d->at_once = d->arrangement == CUPOLA_VK_LAYERS && !o->one_by_one;
    cupola_vk_options wanted = {.struct_size = sizeof wanted,
                                .get_instance_proc_addr = vkGetInstanceProcAddr,
                                .instance = b->instance,
                                .physical_device = b->physical_device,
                                .device = b->device,
                                .queue_family = b->queue_family,
                                .frames_in_flight = FRAMES_IN_FLIGHT,
                                .width = b->width,
                                .height = b->height,
                                .target_format = BASE_FORMAT,
                                .view_format = o->own_images ? VK_FORMAT_UNDEFINED : BASE_FORMAT,
                                .arrangement = d->arrangement};
    bool opened = good(cupola_rig_load(o->rig, &rig)) && good(cupola_vk_create(rig, &wanted, &d->cupola));
    cupola_rig_free(rig);
    return opened;
}

/* Cupola: makes an image of the program for views. */
static bool make_source(base *b, dome *d, uint32_t frame, uint32_t index, cupola_vk_source *source)
{
    uint32_t width, height, layers;
    base_image *image = &d->own[frame][index];
    if (!good(cupola_vk_image_size(d->cupola, index, &width, &height, &layers)) ||
        !base_make_image(b, BASE_FORMAT, width, height, d->arrangement == CUPOLA_VK_LAYERS ? layers : 0,
                         VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT | VK_IMAGE_USAGE_SAMPLED_BIT, image))
        return false;
    *source = (cupola_vk_source){.struct_size = sizeof *source,
                                 .image = image->image,
                                 .view = image->view,
                                 .format = BASE_FORMAT,
                                 .width = width,
                                 .height = height,
                                 .layout = VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL,
                                 .stages = VK_PIPELINE_STAGE_COLOR_ATTACHMENT_OUTPUT_BIT,
                                 .access = VK_ACCESS_COLOR_ATTACHMENT_WRITE_BIT};
    return true;
}

/* Cupola: returns the number of render passes in which the views are drawn. */
static uint32_t pass_count(const dome *d)
{
    return d->arrangement == CUPOLA_VK_LAYERS && !d->at_once ? d->view_count : d->image_count;
}

/* Cupola: gets the views, prepares the images to which they are drawn, and names the images of the window as targets of
 * the correction. */
static bool connect(base *b, const options *o, VkRenderPass pass, dome *d)
{
    const matrix view = matrix_camera(o->yaw, o->pitch);
    cupola_vk_source given[FRAMES_IN_FLIGHT * MOST_VIEWS];
    cupola_vk_target targets[MOST_IMAGES];
    uint32_t count = 0;
    if (!good(cupola_vk_view_count(d->cupola, &d->view_count)) ||
        !good(cupola_vk_image_count(d->cupola, &d->image_count)) || d->view_count > MOST_VIEWS)
        return false;
    for (uint32_t i = 0; i < d->view_count; i++) {
        d->views[i].struct_size = sizeof d->views[i];
        if (!good(cupola_vk_get_view(d->cupola, i, ROOM_NEAR, ROOM_FAR, &d->views[i])))
            return false;
        matrix lens;
        memcpy(lens.m, d->views[i].projection_matrix, sizeof lens.m);
        d->cameras[i] = matrix_multiply(&lens, &view);
    }
    for (uint32_t frame = 0; frame < FRAMES_IN_FLIGHT; frame++) {
        for (uint32_t i = 0; i < d->image_count; i++) {
            cupola_vk_source *source = &d->sources[frame][i];
            source->struct_size = sizeof *source;
            if (o->own_images ? !make_source(b, d, frame, i, source)
                              : !good(cupola_vk_get_source(d->cupola, frame, i, source)))
                return false;
            given[count++] = *source;
        }
        for (uint32_t i = 0; i < pass_count(d); i++) {
            const bool layer = d->arrangement == CUPOLA_VK_LAYERS && !d->at_once;
            const cupola_vk_source *source = &d->sources[frame][layer ? 0 : i];
            if (layer && !base_make_view(b, source->image, source->format, i, 0, &d->layers[frame][i]))
                return false;
            d->framebuffers[frame][i] = base_make_framebuffer(b, pass, layer ? d->layers[frame][i] : source->view,
                                                              source->width, source->height);
        }
    }
    for (uint32_t i = 0; i < b->image_count; i++) {
        targets[i] = (cupola_vk_target){.struct_size = sizeof targets[i],
                                        .image = b->images[i],
                                        .view = b->views[i],
                                        .width = b->width,
                                        .height = b->height,
                                        .initial_layout = VK_IMAGE_LAYOUT_UNDEFINED,
                                        .final_layout = b->shown_layout,
                                        .before_stages = VK_PIPELINE_STAGE_COLOR_ATTACHMENT_OUTPUT_BIT,
                                        .before_access = VK_ACCESS_COLOR_ATTACHMENT_WRITE_BIT,
                                        .after_stages = b->after_stages,
                                        .after_access = b->after_access};
    }
    return (!o->own_images || good(cupola_vk_set_sources(d->cupola, count, given))) &&
           good(cupola_vk_set_targets(d->cupola, b->image_count, targets));
}

/* Cupola */
static void disconnect(base *b, dome *d)
{
    for (uint32_t frame = 0; frame < FRAMES_IN_FLIGHT; frame++) {
        for (uint32_t i = 0; i < MOST_VIEWS; i++) {
            vkDestroyFramebuffer(b->device, d->framebuffers[frame][i], NULL);
            d->framebuffers[frame][i] = VK_NULL_HANDLE;
            vkDestroyImageView(b->device, d->layers[frame][i], NULL);
            d->layers[frame][i] = VK_NULL_HANDLE;
            base_free_image(b, &d->own[frame][i]);
        }
    }
}

/* Draws as the plain program does, but for each view; then records the correction. */
static bool draw(base *b, VkRenderPass pass, const room *scene, const dome *d)
{
    VkCommandBuffer commands = b->commands[b->frame];
    const VkClearValue grey = {.color = {.float32 = {0.25f, 0.25f, 0.25f, 1.0f}}};
    for (uint32_t part = 0; part < pass_count(d); part++) {
        const cupola_vk_source *source = &d->sources[b->frame][d->arrangement == CUPOLA_VK_LAYERS ? 0 : part];
        VkRenderPassBeginInfo begin = {.sType = VK_STRUCTURE_TYPE_RENDER_PASS_BEGIN_INFO,
                                       .renderPass = pass,
                                       .framebuffer = d->framebuffers[b->frame][part],
                                       .renderArea = {{0, 0}, {source->width, source->height}},
                                       .clearValueCount = 1,
                                       .pClearValues = &grey};
        vkCmdBeginRenderPass(commands, &begin, VK_SUBPASS_CONTENTS_INLINE);
        for (uint32_t i = 0; i < (d->at_once ? 1 : d->view_count); i++) {
            const cupola_vk_view *view = &d->views[i];
            if (view->image + view->layer != part)
                continue;
            room_place(commands, view->x, view->y, view->width, view->height);
            room_draw(scene, commands, d->at_once ? NULL : &d->cameras[i]);
        }
        vkCmdEndRenderPass(commands);
    }
    return good(cupola_vk_record(d->cupola, commands, b->frame, b->image, 0, 0));
}

int main(int argc, char **argv)
{
    options o;
    base b;
    room scene = {.pool = VK_NULL_HANDLE};
    dome d = {.cupola = NULL};
    if (!options_read(argc, argv, &o))
        return 2;
    const bool at_once = strcmp(o.views, "layers") == 0 && !o.one_by_one;
    if (!base_open(&b, o.window, (uint32_t)o.width, (uint32_t)o.height, at_once))
        return 1;
    VkRenderPass pass = VK_NULL_HANDLE;
    bool going = open_dome(&b, &o, &d) && good(cupola_vk_view_count(d.cupola, &d.view_count)), changed;
    if (going && at_once && d.view_count > ROOM_MOST_VIEWS) {
        fprintf(stderr, "%u views are more than this example can draw at once\n", (unsigned)d.view_count);
        going = false;
    }
    if (going) {
        pass = base_make_render_pass(&b, BASE_FORMAT, VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL,
                                     at_once ? (1u << d.view_count) - 1 : 0);
        going = connect(&b, &o, pass, &d) && room_open(&b, pass, at_once ? d.view_count : 0, d.cameras, &scene);
    }
    for (int frame = 0; going && (o.frames == 0 || frame < o.frames) && base_begin(&b, &changed); frame++) {
        if (changed) {
            disconnect(&b, &d);
            going = good(cupola_vk_resize(d.cupola, b.width, b.height)) && connect(&b, &o, pass, &d);
        }
        going = going && draw(&b, pass, &scene, &d) && base_end(&b);
    }
    going = going && (o.picture == NULL || base_save(&b, o.picture));
    base_finish(&b);
    disconnect(&b, &d);
    cupola_vk_destroy(d.cupola); /* Cupola */
    room_close(&b, &scene);
    vkDestroyRenderPass(b.device, pass, NULL);
    base_close(&b);
    return going ? 0 : 1;
}
