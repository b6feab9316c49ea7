/*
 * The direction test's cube is drawn to images that a later pass reads (--mode). The pass reads by
 * the place of a fragment on the screen (fetch, divided, given), or in a function that gets the
 * image (handed), or its commands are submitted in another order than they are recorded in (late).
 * It reads the colour in two images and the depth (deferred), or the colour and the depth (depths;
 * volume: in another draw of the cube), also after a pass that draws only depth (prepass). Images
 * of half or twice the window's size are sampled (half, double, double_depths), fetched from
 * (half_fetch, double_fetch), blitted (half_blit, double_blit), or made smaller by another pass
 * (chain) or by a blit from an image that no shader reads (blit_half).
 *
 * Other modes have matrices of the camera in a block: a sky as a triangle over the window (sky,
 * sky_rows, sky_inverted, sky_columns, sky_apart, sky_forced, sky_vertices), the cube's colours
 * computed from its depth (light, light_back), and the cube where only fragments remain that are at
 * the place that they compute (place).
 */
#include "direction.h"
#include "frames.h"
#include "pipelines.h"

/* Compiled by glslangValidator. */
#include "cube_frag.h"
#include "cube_push.h"
#include "later_deferred.h"
#include "later_depths.h"
#include "later_direction.h"
#include "later_divided.h"
#include "later_fetch.h"
#include "later_given.h"
#include "later_handed.h"
#include "later_light.h"
#include "later_light_back.h"
#include "later_parts.h"
#include "later_place.h"
#include "later_sampled.h"
#include "later_scaled.h"
#include "later_sky.h"
#include "later_sky_apart.h"
#include "later_sky_columns.h"
#include "later_sky_forced.h"
#include "later_sky_inverted.h"
#include "later_sky_rows.h"
#include "later_vertices.h"
#include "later_volume.h"
#include "screen_vert.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef struct {
    const char *name;
    shader_words shader; /* fragment shader of the last pass; without words: a blit */
    int halves;          /* size of the images in halves of the window's size; 0: the window's size */
    bool parts;          /* the colour is in two images */
    bool depths;         /* the last pass reads the depth */
    bool depth_first;    /* after a pass for the depth alone */
    bool chain;          /* with a pass to an image of the window's size */
    bool blit_half;      /* with a blit to an image of half that size */
    bool alone;          /* there is only the last pass */
    bool vertices;       /* vertices of the last pass have directions */
    bool cube;           /* the last pass draws the cube */
    bool late;           /* the commands that run first are recorded last */
} mode;

static const mode modes[] = {
    {.name = "fetch", .shader = SHADER(later_fetch)},
    {.name = "late", .shader = SHADER(later_fetch), .late = true},
    {.name = "divided", .shader = SHADER(later_divided)},
    {.name = "given", .shader = SHADER(later_given)},
    {.name = "handed", .shader = SHADER(later_handed)},
    {.name = "deferred", .shader = SHADER(later_deferred), .parts = true, .depths = true},
    {.name = "depths", .shader = SHADER(later_depths), .depths = true},
    {.name = "volume", .shader = SHADER(later_volume), .depths = true, .cube = true},
    {.name = "prepass", .shader = SHADER(later_depths), .depths = true, .depth_first = true},
    {.name = "half", .shader = SHADER(later_sampled), .halves = 1},
    {.name = "double", .shader = SHADER(later_sampled), .halves = 4},
    {.name = "half_fetch", .shader = SHADER(later_scaled), .halves = 1},
    {.name = "double_fetch", .shader = SHADER(later_scaled), .halves = 4},
    {.name = "half_blit", .halves = 1},
    {.name = "double_blit", .halves = 4},
    {.name = "blit_half", .shader = SHADER(later_sampled), .blit_half = true},
    {.name = "chain", .shader = SHADER(later_sampled), .halves = 4, .chain = true},
    {.name = "sky", .shader = SHADER(later_sky), .alone = true},
    {.name = "sky_rows", .shader = SHADER(later_sky_rows), .alone = true},
    {.name = "sky_inverted", .shader = SHADER(later_sky_inverted), .alone = true},
    {.name = "sky_columns", .shader = SHADER(later_sky_columns), .alone = true},
    {.name = "sky_apart", .shader = SHADER(later_sky_apart), .alone = true},
    {.name = "sky_forced", .shader = SHADER(later_sky_forced), .alone = true},
    {.name = "sky_vertices", .shader = SHADER(later_direction), .alone = true, .vertices = true},
    {.name = "light", .shader = SHADER(later_light), .depths = true},
    {.name = "light_back", .shader = SHADER(later_light_back), .depths = true},
    {.name = "place", .shader = SHADER(later_place), .alone = true, .cube = true},
    {.name = "double_depths", .shader = SHADER(later_depths), .halves = 4, .depths = true},
};
enum { MODES = sizeof modes / sizeof *modes };

static direction_options options = DIRECTION_DEFAULTS;
static const mode *chosen = &modes[0];
static vulkan_window w;
static VkExtent2D size, between_size;
static picture colors[2], depth, between;
static VkSampler sampler;
static VkDescriptorSetLayout set_layout;
static VkDescriptorPool descriptors;
static VkDescriptorSet sets[2];
static VkPipelineLayout layout;
static linked_pipeline cube, early, screen, copy;
static frame_objects objects;
static VkCommandBuffer commands, late;
static block camera;

static const VkImageLayout NEW = VK_IMAGE_LAYOUT_UNDEFINED, COLOR = VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL,
                           DEEP = VK_IMAGE_LAYOUT_DEPTH_ATTACHMENT_OPTIMAL, SHOWN = VK_IMAGE_LAYOUT_PRESENT_SRC_KHR,
                           SAMPLED = VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL, WRITTEN = VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL,
                           READ = VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL;
static const VkImageAspectFlags OF_COLOR = VK_IMAGE_ASPECT_COLOR_BIT, OF_DEPTH = VK_IMAGE_ASPECT_DEPTH_BIT;

static void parse(int argc, char **argv)
{
    for (int i = 1; i + 1 < argc; i += 2) {
        bool known = strcmp(argv[i], "--mode") != 0 && take_direction(&options, argv[i], argv[i + 1]);
        for (int m = 0; m < MODES && strcmp(argv[i], "--mode") == 0; m++)
            if (strcmp(argv[i + 1], modes[m].name) == 0) {
                chosen = &modes[m];
                known = true;
            }
        if (!known) {
            fprintf(stderr, "usage: vk_later_passes " DIRECTION_USAGE " [--mode NAME]\n");
            exit(2);
        }
    }
}

static void make_pictures(void)
{
    const int halves = chosen->halves == 0 ? 2 : chosen->halves;
    size = (VkExtent2D){w.extent.width * (uint32_t)halves / 2, w.extent.height * (uint32_t)halves / 2};
    between_size = chosen->blit_half ? (VkExtent2D){w.extent.width / 2, w.extent.height / 2} : w.extent;
    const VkImageUsageFlags copied = VK_IMAGE_USAGE_TRANSFER_SRC_BIT, seen = VK_IMAGE_USAGE_SAMPLED_BIT;
    const VkImageUsageFlags drawn = VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT;
    const VkSampleCountFlagBits one = VK_SAMPLE_COUNT_1_BIT;
    for (int i = 0; i < 2; i++)
        colors[i] = make_picture(&w, w.format, size, one, drawn | copied | (chosen->blit_half ? 0 : seen));
    between = make_picture(&w, w.format, between_size, one, drawn | VK_IMAGE_USAGE_TRANSFER_DST_BIT | seen);
    depth = make_picture(&w, DEPTH_FORMAT, size, one, VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT | VK_IMAGE_USAGE_SAMPLED_BIT);
}

static void make_layouts(void)
{
    const VkDescriptorType seen = VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER;
    const VkDescriptorType of_camera = VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER;
    VkDescriptorSetLayoutBinding bindings[4] = {[3] = {3, of_camera, 1, VK_SHADER_STAGE_ALL_GRAPHICS, NULL}};
    for (uint32_t i = 0; i < 3; i++)
        bindings[i] = (VkDescriptorSetLayoutBinding){i, seen, 1, VK_SHADER_STAGE_FRAGMENT_BIT, NULL};
    const VkDescriptorSetLayoutCreateInfo set = {
        .sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO, .bindingCount = 4, .pBindings = bindings};
    expect(vkCreateDescriptorSetLayout(w.device, &set, NULL, &set_layout), "vkCreateDescriptorSetLayout");
    const VkDescriptorPoolSize sizes[] = {{seen, 6}, {of_camera, 2}};
    const VkDescriptorPoolCreateInfo pool = {
        .sType = VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO, .maxSets = 2, .poolSizeCount = 2, .pPoolSizes = sizes};
    expect(vkCreateDescriptorPool(w.device, &pool, NULL, &descriptors), "vkCreateDescriptorPool");
    /* Devices need not be able to filter depths. */
    const VkFilter smooth = chosen->depths || (chosen->halves == 0 && !chosen->blit_half) ? VK_FILTER_NEAREST : VK_FILTER_LINEAR;
    const VkSamplerCreateInfo filter = {.sType = VK_STRUCTURE_TYPE_SAMPLER_CREATE_INFO,
                                        .magFilter = smooth,
                                        .minFilter = smooth,
                                        .addressModeU = VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_EDGE,
                                        .addressModeV = VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_EDGE};
    expect(vkCreateSampler(w.device, &filter, NULL, &sampler), "vkCreateSampler");
    const VkDescriptorSetLayout both[] = {set_layout, set_layout};
    const VkDescriptorSetAllocateInfo allocate = {.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_ALLOCATE_INFO,
                                                  .descriptorPool = descriptors,
                                                  .descriptorSetCount = 2,
                                                  .pSetLayouts = both};
    expect(vkAllocateDescriptorSets(w.device, &allocate, sets), "vkAllocateDescriptorSets");
    for (int s = 0; s < 2; s++) {
        const VkImageView first = s == 0 && !chosen->blit_half ? colors[0].view : between.view;
        const VkDescriptorImageInfo images[] = {{sampler, first, SAMPLED},
                                                {sampler, chosen->parts ? colors[1].view : first, SAMPLED},
                                                {sampler, chosen->depths ? depth.view : first, SAMPLED}};
        const VkDescriptorBufferInfo buffer = {camera.buffer, 0, VK_WHOLE_SIZE};
        const VkWriteDescriptorSet write[] = {{.sType = VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET,
                                               .dstSet = sets[s],
                                               .descriptorCount = 3,
                                               .descriptorType = seen,
                                               .pImageInfo = images},
                                              {.sType = VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET,
                                               .dstSet = sets[s],
                                               .dstBinding = 3,
                                               .descriptorCount = 1,
                                               .descriptorType = of_camera,
                                               .pBufferInfo = &buffer}};
        vkUpdateDescriptorSets(w.device, 2, write, 0, NULL);
    }
    const VkPushConstantRange ranges[] = {{VK_SHADER_STAGE_VERTEX_BIT, 0, sizeof(matrix4)},
                                          {VK_SHADER_STAGE_FRAGMENT_BIT, sizeof(matrix4), 2 * sizeof(float)}};
    const VkPipelineLayoutCreateInfo info = {.sType = VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO,
                                             .setLayoutCount = 1,
                                             .pSetLayouts = &set_layout,
                                             .pushConstantRangeCount = 2,
                                             .pPushConstantRanges = ranges};
    expect(vkCreatePipelineLayout(w.device, &info, NULL, &layout), "vkCreatePipelineLayout");
}

static void make_pipelines(void)
{
    pipeline_description description = {.vertex = SHADER(cube_push),
                                        .fragment = chosen->parts ? SHADER(later_parts) : SHADER(cube_frag),
                                        .layout = layout,
                                        .color = w.format,
                                        .second = chosen->parts ? w.format : VK_FORMAT_UNDEFINED,
                                        .depth = DEPTH_FORMAT,
                                        .samples = VK_SAMPLE_COUNT_1_BIT,
                                        .deep = true};
    cube = make_pipeline(&w, &description);
    description.colorless = true;
    early = make_pipeline(&w, &description);
    pipeline_description flat = {.vertex = chosen->cube       ? SHADER(cube_push)
                                           : chosen->vertices ? SHADER(later_vertices)
                                                              : SHADER(screen_vert),
                                 .fragment = chosen->shader,
                                 .layout = layout,
                                 .color = w.format,
                                 .samples = VK_SAMPLE_COUNT_1_BIT};
    if (flat.fragment.words != NULL)
        screen = make_pipeline(&w, &flat);
    flat.vertex = SHADER(screen_vert);
    flat.fragment = SHADER(later_sampled);
    copy = make_pipeline(&w, &flat);
}

/* Begins a pass to `count` images, and to the depth with the load operation `load`. */
static void begin(uint32_t count, const VkImageView *views, VkExtent2D extent, const VkAttachmentLoadOp *load)
{
    VkRenderingAttachmentInfo all[3] = {{.sType = VK_STRUCTURE_TYPE_RENDERING_ATTACHMENT_INFO}};
    for (uint32_t i = 0; i < count; i++)
        all[i] = (VkRenderingAttachmentInfo){.sType = VK_STRUCTURE_TYPE_RENDERING_ATTACHMENT_INFO,
                                             .imageView = views[i],
                                             .imageLayout = COLOR,
                                             .loadOp = VK_ATTACHMENT_LOAD_OP_CLEAR,
                                             .storeOp = VK_ATTACHMENT_STORE_OP_STORE,
                                             .clearValue = {.color = {.float32 = {0.25f, 0.25f, 0.25f, 1.0f}}}};
    const VkRenderingAttachmentInfo deep = {.sType = VK_STRUCTURE_TYPE_RENDERING_ATTACHMENT_INFO,
                                            .imageView = depth.view,
                                            .imageLayout = DEEP,
                                            .loadOp = load != NULL ? *load : VK_ATTACHMENT_LOAD_OP_LOAD,
                                            .storeOp = VK_ATTACHMENT_STORE_OP_STORE,
                                            .clearValue = {.depthStencil = {1.0f, 0}}};
    const VkRenderingInfo info = {.sType = VK_STRUCTURE_TYPE_RENDERING_INFO,
                                  .renderArea = {{0, 0}, extent},
                                  .layerCount = 1,
                                  .colorAttachmentCount = count,
                                  .pColorAttachments = all,
                                  .pDepthAttachment = load != NULL ? &deep : NULL};
    vkCmdBeginRendering(commands, &info);
    const VkViewport viewport = {0, 0, (float)extent.width, (float)extent.height, 0, 1};
    const VkRect2D scissor = {{0, 0}, extent};
    vkCmdSetViewport(commands, 0, 1, &viewport);
    vkCmdSetScissor(commands, 0, 1, &scissor);
}

static void draw_cube(const linked_pipeline *by)
{
    const matrix4 matrix = direction_matrix(&options, w.extent, false);
    vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, by->whole);
    vkCmdPushConstants(commands, layout, VK_SHADER_STAGE_VERTEX_BIT, 0, sizeof matrix, &matrix);
    vkCmdDraw(commands, 36, 1, 0, 0);
    vkCmdEndRendering(commands);
}

static void draw_screen(const linked_pipeline *by, VkDescriptorSet set, VkImage image, VkImageView view)
{
    const float extent[] = {(float)w.extent.width, (float)w.extent.height};
    change_layout(commands, image, OF_COLOR, NEW, COLOR);
    begin(1, &view, w.extent, NULL);
    vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, by->whole);
    vkCmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, layout, 0, 1, &set, 0, NULL);
    vkCmdPushConstants(commands, layout, VK_SHADER_STAGE_FRAGMENT_BIT, sizeof(matrix4), sizeof extent, extent);
    const matrix4 matrix = direction_matrix(&options, w.extent, false);
    vkCmdPushConstants(commands, layout, VK_SHADER_STAGE_VERTEX_BIT, 0, sizeof matrix, &matrix);
    vkCmdDraw(commands, chosen->cube ? 36 : 3, 1, 0, 0);
    vkCmdEndRendering(commands);
}

/* Writes the block of all shaders with matrices of the camera: a colour, matrices. */
static void fill_camera(void)
{
    const matrix4 all = direction_matrix(&options, w.extent, false), back = matrix_inverse(all);
    const matrix4 lamp = matrix_multiply(matrix_perspective(40.0, 1.0, 0.5, 50.0), matrix_camera(40.0, -20.0));
    const matrix4 view = matrix_camera(options.yaw, options.pitch);
    const matrix4 projection = matrix_multiply(all, matrix_inverse(matrix_multiply(view, matrix_scale(10.0))));
    const struct {
        float tint[4];
        matrix4 inverse_all, all, lamp, inverse_rows, several[2], inverse_projection, inverse_view;
    } values = {{1, 1, 1, 1}, back, all, lamp, matrix_transposed(back), {lamp, all}, matrix_inverse(projection), matrix_inverse(view)};
    camera = make_block(&w, sizeof values, VK_BUFFER_USAGE_UNIFORM_BUFFER_BIT, true);
    memcpy(camera.bytes, &values, sizeof values);
}

/* Blits the scene to an image and leaves the image in a layout. */
static void blit(VkImage to, VkExtent2D to_size, VkImageLayout left)
{
    const VkImageSubresourceLayers layer = {OF_COLOR, 0, 0, 1};
    const VkImageBlit region = {layer, {{0, 0, 0}, {(int)size.width, (int)size.height, 1}},
                                layer, {{0, 0, 0}, {(int)to_size.width, (int)to_size.height, 1}}};
    change_layout(commands, to, OF_COLOR, NEW, WRITTEN);
    vkCmdBlitImage(commands, colors[0].image, READ, to, WRITTEN, 1, &region, VK_FILTER_LINEAR);
    change_layout(commands, to, OF_COLOR, WRITTEN, left);
}

/* Draws the images that the last pass reads. */
static void record_scene(void)
{
    const VkImageView views[] = {colors[0].view, colors[1].view};
    const uint32_t count = chosen->parts ? 2 : 1;
    VkAttachmentLoadOp load = VK_ATTACHMENT_LOAD_OP_CLEAR;
    change_layout(commands, depth.image, OF_DEPTH, NEW, DEEP);
    if (chosen->depth_first) {
        begin(0, NULL, size, &load);
        draw_cube(&early);
        change_layout(commands, depth.image, OF_DEPTH, DEEP, DEEP);
        load = VK_ATTACHMENT_LOAD_OP_LOAD;
    }
    for (uint32_t i = 0; i < count && !chosen->late; i++)
        change_layout(commands, colors[i].image, OF_COLOR, NEW, COLOR);
    begin(count, views, size, &load);
    draw_cube(&cube);
    const VkImageLayout left = chosen->blit_half || chosen->shader.words == NULL ? READ : SAMPLED;
    for (uint32_t i = 0; i < count; i++)
        change_layout(commands, colors[i].image, OF_COLOR, COLOR, left);
    if (chosen->depths)
        change_layout(commands, depth.image, OF_DEPTH, DEEP, SAMPLED);
    if (chosen->chain) {
        draw_screen(&copy, sets[0], between.image, between.view);
        change_layout(commands, between.image, OF_COLOR, COLOR, SAMPLED);
    }
    if (chosen->blit_half)
        blit(between.image, between_size, SAMPLED);
}

/* Submits the commands that the other commands need first. */
static void submit_late(const VkCommandBufferBeginInfo *info)
{
    static bool again;
    const VkSubmitInfo work = {.sType = VK_STRUCTURE_TYPE_SUBMIT_INFO, .commandBufferCount = 1, .pCommandBuffers = &late};
    expect(vkBeginCommandBuffer(late, info), "vkBeginCommandBuffer");
    change_layout(late, colors[0].image, OF_COLOR, again ? SAMPLED : NEW, COLOR);
    again = true;
    expect(vkEndCommandBuffer(late), "vkEndCommandBuffer");
    expect(vkQueueSubmit(w.queue, 1, &work, VK_NULL_HANDLE), "vkQueueSubmit");
}

static void record(uint32_t index)
{
    const VkCommandBufferBeginInfo info = {.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO};
    expect(vkBeginCommandBuffer(commands, &info), "vkBeginCommandBuffer");
    if (!chosen->alone)
        record_scene();
    if (chosen->shader.words != NULL)
        draw_screen(&screen, sets[chosen->chain], w.images[index], w.views[index]);
    else
        blit(w.images[index], w.extent, COLOR);
    change_layout(commands, w.images[index], OF_COLOR, COLOR, SHOWN);
    expect(vkEndCommandBuffer(commands), "vkEndCommandBuffer");
    if (chosen->late)
        submit_late(&info);
}

int main(int argc, char **argv)
{
    parse(argc, argv);
    window_open(&w, options.x, options.y, options.width, options.height, false, false, VK_IMAGE_USAGE_TRANSFER_DST_BIT);
    make_pictures();
    fill_camera();
    make_layouts();
    make_pipelines();
    objects = make_frame_objects(&w);
    make_commands(&w, &objects, VK_COMMAND_BUFFER_LEVEL_PRIMARY, 1, &commands);
    make_commands(&w, &objects, VK_COMMAND_BUFFER_LEVEL_PRIMARY, 1, &late);
    run_frames(&w, &objects, commands, options.frames, options.shot, record);
    expect(vkDeviceWaitIdle(w.device), "vkDeviceWaitIdle");
    linked_pipeline *const all[] = {&cube, &early, &screen, &copy};
    for (int i = 0; i < 4; i++)
        free_pipeline(&w, all[i]);
    vkDestroyPipelineLayout(w.device, layout, NULL);
    vkDestroyDescriptorPool(w.device, descriptors, NULL);
    vkDestroyDescriptorSetLayout(w.device, set_layout, NULL);
    vkDestroySampler(w.device, sampler, NULL);
    free_frame_objects(&w, &objects);
    picture *const pictures[] = {&colors[0], &colors[1], &depth, &between};
    for (int i = 0; i < 4; i++)
        free_picture(&w, pictures[i]);
    free_block(&w, &camera);
    window_close(&w);
    return 0;
}
