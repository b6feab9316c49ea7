/*
 * The direction test's cube is drawn with inverted colours to an image. Compute shaders make the
 * window's picture from it (--mode):
 *   sampled      one dispatch samples the image
 *   stored       one dispatch loads from it
 *   same         one dispatch writes to it
 *   depths       the dispatch reads its depth, too
 *   pushed       the size is in push constants
 *   descriptors  the descriptors are pushed
 *   indirect     an indirect dispatch
 *   chain        three dispatches, one after the other
 *   half         with an image of half the size
 *   levels       with two levels of one image
 *   history      with the picture of the frame before
 *   exposure     with numbers of the whole picture in a buffer
 *   light        with a matrix of the camera
 *   places       with values of each place in a buffer; then there is no picture for each view
 * The result is drawn to the window. Or more is drawn to it first (drawn), or it is blitted (blit)
 * or copied (copy), or it is the window's image itself (written).
 */
#include "direction.h"
#include "frames.h"
#include "pipelines.h"

/* Compiled by glslangValidator. */
#include "computed_any.h"
#include "computed_blended.h"
#include "computed_copied.h"
#include "computed_count.h"
#include "computed_depths.h"
#include "computed_expose.h"
#include "computed_halve.h"
#include "computed_inverted.h"
#include "computed_join.h"
#include "computed_judge.h"
#include "computed_light.h"
#include "computed_mixed.h"
#include "computed_places.h"
#include "computed_pushed.h"
#include "computed_same.h"
#include "computed_stored.h"
#include "computed_swapped.h"
#include "computed_values.h"
#include "cube_inverted.h"
#include "cube_push.h"
#include "screen_frag.h"
#include "screen_vert.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { MOST_STEPS = 3, IMAGES = 6, SCENE = 0, FIRST = 1, SECOND = 2, HALF = 3, LEVEL = 4, NEXT_LEVEL = 5, WINDOW = 6 };
typedef enum { DRAW, LOAD, BLIT, COPY, WRITE } way_kind;

/*
 * A dispatch: the image that it reads, another image that it reads, and the image that it writes.
 */
typedef struct {
    shader_words shader;
    int from, beside, to;
    bool single; /* a single work group */
} step;

typedef struct {
    const char *name;
    step steps[MOST_STEPS];
    int shown;
    way_kind way;
    bool indirect;
} mode;

static const mode modes[] = {
    {"sampled", {{SHADER(computed_inverted), SCENE, 0, FIRST, false}}, FIRST, DRAW, false},
    {"stored", {{SHADER(computed_stored), SCENE, 0, FIRST, false}}, FIRST, DRAW, false},
    {"same", {{SHADER(computed_same), SCENE, 0, FIRST, false}}, SCENE, DRAW, false},
    {"depths", {{SHADER(computed_depths), SCENE, 0, FIRST, false}}, FIRST, DRAW, false},
    {"pushed", {{SHADER(computed_pushed), SCENE, 0, FIRST, false}}, FIRST, DRAW, false},
    {"descriptors", {{SHADER(computed_inverted), SCENE, 0, FIRST, false}}, FIRST, DRAW, false},
    {"indirect", {{SHADER(computed_inverted), SCENE, 0, FIRST, false}}, FIRST, DRAW, true},
    {"chain",
     {{SHADER(computed_inverted), SCENE, 0, FIRST, false},
      {SHADER(computed_inverted), FIRST, 0, SECOND, false},
      {SHADER(computed_inverted), SECOND, 0, FIRST, false}},
     FIRST, DRAW, false},
    {"half",
     {{SHADER(computed_halve), SCENE, 0, HALF, false}, {SHADER(computed_join), SCENE, HALF, FIRST, false}}, FIRST, DRAW, false},
    {"levels",
     {{SHADER(computed_inverted), SCENE, 0, LEVEL, false},
      {SHADER(computed_halve), LEVEL, 0, NEXT_LEVEL, false},
      {SHADER(computed_mixed), LEVEL, NEXT_LEVEL, FIRST, false}},
     FIRST, DRAW, false},
    {"history",
     {{SHADER(computed_blended), SCENE, SECOND, FIRST, false}, {SHADER(computed_copied), FIRST, 0, SECOND, false}},
     FIRST, DRAW, false},
    {"exposure",
     {{SHADER(computed_count), SCENE, 0, FIRST, false},
      {SHADER(computed_judge), SCENE, 0, FIRST, true},
      {SHADER(computed_expose), SCENE, 0, FIRST, false}},
     FIRST, DRAW, false},
    {"light", {{SHADER(computed_light), SCENE, 0, FIRST, false}}, FIRST, DRAW, false},
    {"drawn", {{SHADER(computed_inverted), SCENE, 0, FIRST, false}}, FIRST, LOAD, false},
    {"blit", {{SHADER(computed_inverted), SCENE, 0, FIRST, false}}, FIRST, BLIT, false},
    {"copy", {{SHADER(computed_swapped), SCENE, 0, FIRST, false}}, FIRST, COPY, false},
    {"written", {{SHADER(computed_any), SCENE, 0, WINDOW, false}}, FIRST, WRITE, false},
    {"places",
     {{SHADER(computed_places), SCENE, 0, FIRST, false}, {SHADER(computed_values), SCENE, 0, FIRST, false}}, FIRST, DRAW, false},
};
enum { MODES = sizeof modes / sizeof *modes, MOST_SETS = MOST_STEPS * MOST_IMAGES };

static direction_options options = DIRECTION_DEFAULTS;
static const mode *chosen = &modes[0];
static vulkan_window w;
static picture images[IMAGES], depth;
static VkSampler sampler;
static VkDescriptorSetLayout set_layout, screen_set_layout;
static VkDescriptorPool descriptors;
static VkDescriptorSet sets[MOST_STEPS][MOST_IMAGES], screen_set;
static VkPipelineLayout cube_layout, screen_layout, layout;
static VkPipeline steps[MOST_STEPS];
static linked_pipeline cube, screen;
static frame_objects objects;
static VkCommandBuffer commands;
static block camera, numbers, groups;

static const VkFormat FORMAT = VK_FORMAT_R8G8B8A8_UNORM;
static const VkImageLayout NEW = VK_IMAGE_LAYOUT_UNDEFINED, COLOR = VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL,
                           DEEP = VK_IMAGE_LAYOUT_DEPTH_ATTACHMENT_OPTIMAL, SHOWN = VK_IMAGE_LAYOUT_PRESENT_SRC_KHR,
                           SAMPLED = VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL, GENERAL = VK_IMAGE_LAYOUT_GENERAL,
                           WRITTEN = VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, READ = VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL;
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
            fprintf(stderr, "usage: vk_computed " DIRECTION_USAGE " [--mode NAME]\n");
            exit(2);
        }
    }
}

static bool is(const char *name)
{
    return strcmp(chosen->name, name) == 0;
}

/* Whether the scene's image is loaded from or stored to. */
static bool scene_is_stored(void)
{
    return is("stored") || is("same");
}

static VkExtent2D size_of(int image)
{
    return image == HALF || image == NEXT_LEVEL ? (VkExtent2D){w.extent.width / 2, w.extent.height / 2} : w.extent;
}

/* Creates two levels of one image. */
static void make_levels(VkImageUsageFlags usage)
{
    const VkImageCreateInfo info = {.sType = VK_STRUCTURE_TYPE_IMAGE_CREATE_INFO,
                                    .imageType = VK_IMAGE_TYPE_2D,
                                    .format = FORMAT,
                                    .extent = {w.extent.width, w.extent.height, 1},
                                    .mipLevels = 2,
                                    .arrayLayers = 1,
                                    .samples = VK_SAMPLE_COUNT_1_BIT,
                                    .usage = usage};
    VkImage image;
    expect(vkCreateImage(w.device, &info, NULL, &image), "vkCreateImage");
    images[LEVEL].image = image;
    images[LEVEL].memory = image_memory(&w, image);
    for (uint32_t level = 0; level < 2; level++) {
        const VkImageViewCreateInfo view = {.sType = VK_STRUCTURE_TYPE_IMAGE_VIEW_CREATE_INFO,
                                            .image = image,
                                            .viewType = VK_IMAGE_VIEW_TYPE_2D,
                                            .format = FORMAT,
                                            .subresourceRange = {OF_COLOR, level, 1, 0, 1}};
        expect(vkCreateImageView(w.device, &view, NULL, &images[LEVEL + level].view), "vkCreateImageView");
    }
}

static void make_pictures(void)
{
    const VkImageUsageFlags seen = VK_IMAGE_USAGE_SAMPLED_BIT, drawn = VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT,
                            stored = VK_IMAGE_USAGE_STORAGE_BIT, copied = VK_IMAGE_USAGE_TRANSFER_SRC_BIT;
    const VkImageUsageFlags counted = is("exposure") ? VK_IMAGE_USAGE_TRANSFER_DST_BIT : 0;
    for (int i = 0; i < LEVEL; i++) {
        const VkImageUsageFlags of_scene = drawn | seen | counted | (scene_is_stored() ? stored : 0);
        const VkImageUsageFlags of_result = stored | seen | copied | (chosen->way == LOAD ? drawn : 0);
        images[i] = make_picture(&w, FORMAT, size_of(i), VK_SAMPLE_COUNT_1_BIT, i == SCENE ? of_scene : of_result);
    }
    depth = make_picture(&w, DEPTH_FORMAT, w.extent, VK_SAMPLE_COUNT_1_BIT, VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT | seen);
    make_levels(seen | stored);
    const matrix4 back = matrix_inverse(direction_matrix(&options, w.extent, false));
    camera = make_block(&w, sizeof back, VK_BUFFER_USAGE_UNIFORM_BUFFER_BIT, true);
    memcpy(camera.bytes, &back, sizeof back);
    const VkDeviceSize all = 12 + 4 * w.extent.width * w.extent.height;
    numbers = make_block(&w, all, VK_BUFFER_USAGE_STORAGE_BUFFER_BIT, true);
    memset(numbers.bytes, 0, all);
    ((uint32_t *)numbers.bytes)[1] = pixels_to_the_left(&back, w.extent.width, w.extent.height);
    const uint32_t count[] = {(w.extent.width + 7) / 8, (w.extent.height + 7) / 8, 1};
    groups = make_block(&w, sizeof count, VK_BUFFER_USAGE_INDIRECT_BUFFER_BIT, true);
    memcpy(groups.bytes, count, sizeof count);
}

/* Whether descriptors are pushed. The device must support it. */
static bool pushes(void)
{
    return is("descriptors") && w.has.push_descriptor;
}

/* Writes a descriptor into a set, or pushes it if the set is null. */
static void write_descriptor(const VkWriteDescriptorSet *write)
{
    if (write->dstSet != VK_NULL_HANDLE) {
        vkUpdateDescriptorSets(w.device, 1, write, 0, NULL);
        return;
    }
    PFN_vkCmdPushDescriptorSetKHR push =
        (PFN_vkCmdPushDescriptorSetKHR)vkGetDeviceProcAddr(w.device, "vkCmdPushDescriptorSetKHR");
    push(commands, VK_PIPELINE_BIND_POINT_COMPUTE, layout, 0, 1, write);
}

static void describe(VkDescriptorSet set, uint32_t binding, VkDescriptorType kind, VkImageView view, VkImageLayout used)
{
    const VkDescriptorImageInfo image = {sampler, view, used};
    const VkWriteDescriptorSet write = {.sType = VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET,
                                        .dstSet = set,
                                        .dstBinding = binding,
                                        .descriptorCount = 1,
                                        .descriptorType = kind,
                                        .pImageInfo = &image};
    write_descriptor(&write);
}

static void describe_block(VkDescriptorSet set, uint32_t binding, VkDescriptorType kind, VkBuffer buffer)
{
    const VkDescriptorBufferInfo info = {buffer, 0, VK_WHOLE_SIZE};
    const VkWriteDescriptorSet write = {.sType = VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET,
                                        .dstSet = set,
                                        .dstBinding = binding,
                                        .descriptorCount = 1,
                                        .descriptorType = kind,
                                        .pBufferInfo = &info};
    write_descriptor(&write);
}

static VkDescriptorSet make_set(VkDescriptorSetLayout of)
{
    const VkDescriptorSetAllocateInfo allocate = {.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_ALLOCATE_INFO,
                                                  .descriptorPool = descriptors,
                                                  .descriptorSetCount = 1,
                                                  .pSetLayouts = &of};
    VkDescriptorSet set;
    expect(vkAllocateDescriptorSets(w.device, &allocate, &set), "vkAllocateDescriptorSets");
    return set;
}

static const VkDescriptorType seen = VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER, stored = VK_DESCRIPTOR_TYPE_STORAGE_IMAGE,
                              shared = VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, uniform = VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER;

static void make_layouts(void)
{
    const VkDescriptorType kinds[] = {seen, stored, seen, seen, stored, shared, uniform};
    VkDescriptorSetLayoutBinding bindings[7];
    for (uint32_t i = 0; i < 7; i++)
        bindings[i] = (VkDescriptorSetLayoutBinding){i, kinds[i], 1, VK_SHADER_STAGE_COMPUTE_BIT, NULL};
    const VkDescriptorSetLayoutBinding of_screen = {0, seen, 1, VK_SHADER_STAGE_FRAGMENT_BIT, NULL};
    VkDescriptorSetLayoutCreateInfo set = {
        .sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO, .bindingCount = 7, .pBindings = bindings};
    set.flags = pushes() ? VK_DESCRIPTOR_SET_LAYOUT_CREATE_PUSH_DESCRIPTOR_BIT_KHR : 0;
    expect(vkCreateDescriptorSetLayout(w.device, &set, NULL, &set_layout), "vkCreateDescriptorSetLayout");
    set.flags = 0;
    set.bindingCount = 1;
    set.pBindings = &of_screen;
    expect(vkCreateDescriptorSetLayout(w.device, &set, NULL, &screen_set_layout), "vkCreateDescriptorSetLayout");
    const VkDescriptorPoolSize sizes[] = {
        {seen, 3 * MOST_SETS + 1}, {stored, 2 * MOST_SETS}, {shared, MOST_SETS}, {uniform, MOST_SETS}};
    const VkDescriptorPoolCreateInfo pool = {.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO,
                                             .maxSets = MOST_SETS + 1,
                                             .poolSizeCount = 4,
                                             .pPoolSizes = sizes};
    expect(vkCreateDescriptorPool(w.device, &pool, NULL, &descriptors), "vkCreateDescriptorPool");
    /* Devices need not be able to filter depths. */
    const VkFilter smooth = is("half") ? VK_FILTER_LINEAR : VK_FILTER_NEAREST;
    const VkSamplerCreateInfo filter = {.sType = VK_STRUCTURE_TYPE_SAMPLER_CREATE_INFO,
                                        .magFilter = smooth,
                                        .minFilter = smooth,
                                        .addressModeU = VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_EDGE,
                                        .addressModeV = VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_EDGE};
    expect(vkCreateSampler(w.device, &filter, NULL, &sampler), "vkCreateSampler");
    const VkPushConstantRange of_matrix = {VK_SHADER_STAGE_VERTEX_BIT, 0, sizeof(matrix4)};
    const VkPushConstantRange of_size = {VK_SHADER_STAGE_COMPUTE_BIT, 0, 2 * sizeof(float)};
    VkPipelineLayoutCreateInfo info = {.sType = VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO,
                                       .pushConstantRangeCount = 1,
                                       .pPushConstantRanges = &of_matrix};
    expect(vkCreatePipelineLayout(w.device, &info, NULL, &cube_layout), "vkCreatePipelineLayout");
    info.setLayoutCount = 1;
    info.pSetLayouts = &screen_set_layout;
    info.pushConstantRangeCount = 0;
    expect(vkCreatePipelineLayout(w.device, &info, NULL, &screen_layout), "vkCreatePipelineLayout");
    info.pSetLayouts = &set_layout;
    info.pushConstantRangeCount = 1;
    info.pPushConstantRanges = &of_size;
    expect(vkCreatePipelineLayout(w.device, &info, NULL, &layout), "vkCreatePipelineLayout");
}

/* Fills the descriptors of a step for the window's image `index`. */
static void fill_set(VkDescriptorSet set, const step *of, uint32_t index)
{
    const bool is_stored = of->from == SCENE && scene_is_stored();
    describe(set, 0, seen, images[of->from].view, is_stored || of->from == LEVEL ? GENERAL : SAMPLED);
    describe(set, 1, stored, of->to == WINDOW ? w.views[index] : images[of->to].view, GENERAL);
    describe(set, 2, seen, depth.view, SAMPLED);
    const bool beside_stored = of->beside == NEXT_LEVEL || (of->beside == SCENE && scene_is_stored());
    describe(set, 3, seen, images[of->beside].view, beside_stored ? GENERAL : SAMPLED);
    if (is_stored)
        describe(set, 4, stored, images[SCENE].view, GENERAL);
    describe_block(set, 5, shared, numbers.buffer);
    describe_block(set, 6, uniform, camera.buffer);
}

/* Creates a set for each step. A step that writes the window gets one for each of its images. */
static void make_sets(void)
{
    screen_set = make_set(screen_set_layout);
    describe(screen_set, 0, seen, images[chosen->shown].view, SAMPLED);
    for (int s = 0; s < MOST_STEPS && chosen->steps[s].shader.words != NULL && !pushes(); s++)
        for (uint32_t i = 0; i < (chosen->steps[s].to == WINDOW ? w.count : 1); i++) {
            sets[s][i] = make_set(set_layout);
            fill_set(sets[s][i], &chosen->steps[s], i);
        }
}

static VkPipeline make_step(shader_words shader)
{
    const VkShaderModuleCreateInfo words = {
        .sType = VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO, .codeSize = shader.size, .pCode = shader.words};
    VkComputePipelineCreateInfo info = {.sType = VK_STRUCTURE_TYPE_COMPUTE_PIPELINE_CREATE_INFO,
                                        .stage = {.sType = VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO,
                                                  .stage = VK_SHADER_STAGE_COMPUTE_BIT,
                                                  .pName = "main"},
                                        .layout = layout};
    VkPipeline made;
    expect(vkCreateShaderModule(w.device, &words, NULL, &info.stage.module), "vkCreateShaderModule");
    expect(vkCreateComputePipelines(w.device, VK_NULL_HANDLE, 1, &info, NULL, &made), "vkCreateComputePipelines");
    vkDestroyShaderModule(w.device, info.stage.module, NULL);
    return made;
}

static void make_pipelines(void)
{
    const pipeline_description of_cube = {.vertex = SHADER(cube_push),
                                          .fragment = SHADER(cube_inverted),
                                          .layout = cube_layout,
                                          .color = FORMAT,
                                          .depth = DEPTH_FORMAT,
                                          .samples = VK_SAMPLE_COUNT_1_BIT,
                                          .deep = true};
    cube = make_pipeline(&w, &of_cube);
    const pipeline_description of_screen = {.vertex = SHADER(screen_vert),
                                            .fragment = SHADER(screen_frag),
                                            .layout = screen_layout,
                                            .color = w.format,
                                            .samples = VK_SAMPLE_COUNT_1_BIT};
    screen = make_pipeline(&w, &of_screen);
    for (int s = 0; s < MOST_STEPS && chosen->steps[s].shader.words != NULL; s++)
        steps[s] = make_step(chosen->steps[s].shader);
}

/* Begins a pass to an image, and to the depth if `deep` is set. */
static void begin(VkImageView view, bool deep, VkAttachmentLoadOp load)
{
    const VkRenderingAttachmentInfo color = {.sType = VK_STRUCTURE_TYPE_RENDERING_ATTACHMENT_INFO,
                                             .imageView = view,
                                             .imageLayout = COLOR,
                                             .loadOp = load,
                                             .storeOp = VK_ATTACHMENT_STORE_OP_STORE};
    const VkRenderingAttachmentInfo of_depth = {.sType = VK_STRUCTURE_TYPE_RENDERING_ATTACHMENT_INFO,
                                                .imageView = depth.view,
                                                .imageLayout = DEEP,
                                                .loadOp = VK_ATTACHMENT_LOAD_OP_CLEAR,
                                                .storeOp = VK_ATTACHMENT_STORE_OP_STORE,
                                                .clearValue = {.depthStencil = {1.0f, 0}}};
    const VkRenderingInfo info = {.sType = VK_STRUCTURE_TYPE_RENDERING_INFO,
                                  .renderArea = {{0, 0}, w.extent},
                                  .layerCount = 1,
                                  .colorAttachmentCount = 1,
                                  .pColorAttachments = &color,
                                  .pDepthAttachment = deep ? &of_depth : NULL};
    vkCmdBeginRendering(commands, &info);
    const VkViewport viewport = {0, 0, (float)w.extent.width, (float)w.extent.height, 0, 1};
    const VkRect2D scissor = {{0, 0}, w.extent};
    vkCmdSetViewport(commands, 0, 1, &viewport);
    vkCmdSetScissor(commands, 0, 1, &scissor);
}

static void record_cube(void)
{
    change_layout(commands, images[SCENE].image, OF_COLOR, NEW, COLOR);
    change_layout(commands, depth.image, OF_DEPTH, NEW, DEEP);
    begin(images[SCENE].view, true, VK_ATTACHMENT_LOAD_OP_CLEAR);
    /*
     * At first the camera has another direction. Numbers that remain from those frames are wrong.
     */
    static int frame;
    direction_options now = options;
    now.yaw += is("exposure") && frame++ < 3 ? 100.0 : 0.0;
    const matrix4 matrix = direction_matrix(&now, w.extent, false);
    vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, cube.whole);
    vkCmdPushConstants(commands, cube_layout, VK_SHADER_STAGE_VERTEX_BIT, 0, sizeof matrix, &matrix);
    vkCmdDraw(commands, 36, 1, 0, 0);
    vkCmdEndRendering(commands);
    change_layout(commands, images[SCENE].image, OF_COLOR, COLOR, scene_is_stored() ? GENERAL : SAMPLED);
    change_layout(commands, depth.image, OF_DEPTH, DEEP, SAMPLED);
}

/* Prepares images that are read in a frame before they are written. */
static void prepare(void)
{
    static bool again;
    const VkImageMemoryBarrier levels = {.sType = VK_STRUCTURE_TYPE_IMAGE_MEMORY_BARRIER,
                                         .dstAccessMask = VK_ACCESS_SHADER_READ_BIT | VK_ACCESS_SHADER_WRITE_BIT,
                                         .oldLayout = NEW,
                                         .newLayout = GENERAL,
                                         .srcQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED,
                                         .dstQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED,
                                         .image = images[LEVEL].image,
                                         .subresourceRange = {OF_COLOR, 0, 2, 0, 1}};
    const VkPipelineStageFlags all = VK_PIPELINE_STAGE_ALL_COMMANDS_BIT;
    vkCmdPipelineBarrier(commands, all, all, 0, 0, NULL, 0, NULL, 1, &levels);
    if (!again)
        change_layout(commands, images[SECOND].image, OF_COLOR, NEW, SAMPLED);
    again = true;
}

static void record_steps(uint32_t index)
{
    const float extent[] = {(float)w.extent.width, (float)w.extent.height};
    const VkPipelineStageFlags computing = VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT;
    const VkMemoryBarrier written = {.sType = VK_STRUCTURE_TYPE_MEMORY_BARRIER,
                                     .srcAccessMask = VK_ACCESS_SHADER_WRITE_BIT,
                                     .dstAccessMask = VK_ACCESS_SHADER_READ_BIT | VK_ACCESS_SHADER_WRITE_BIT};
    for (int s = 0; s < MOST_STEPS && steps[s] != VK_NULL_HANDLE; s++) {
        const step *of = &chosen->steps[s];
        const VkImage to = of->to == WINDOW ? w.images[index] : images[of->to == NEXT_LEVEL ? LEVEL : of->to].image;
        const VkExtent2D size = size_of(of->to);
        const bool level = of->to == LEVEL || of->to == NEXT_LEVEL;
        if (!level)
            change_layout(commands, to, OF_COLOR, NEW, GENERAL);
        vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_COMPUTE, steps[s]);
        const VkDescriptorSet *set = &sets[s][of->to == WINDOW ? index : 0];
        if (pushes())
            fill_set(VK_NULL_HANDLE, of, index);
        else
            vkCmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_COMPUTE, layout, 0, 1, set, 0, NULL);
        vkCmdPushConstants(commands, layout, VK_SHADER_STAGE_COMPUTE_BIT, 0, sizeof extent, extent);
        if (chosen->indirect)
            vkCmdDispatchIndirect(commands, groups.buffer, 0);
        else
            vkCmdDispatch(commands, of->single ? 1 : (size.width + 7) / 8, of->single ? 1 : (size.height + 7) / 8, 1);
        vkCmdPipelineBarrier(commands, computing, computing, 0, 1, &written, 0, NULL, 0, NULL);
        if (!level)
            change_layout(commands, to, OF_COLOR, GENERAL, of->to == WINDOW ? SHOWN : SAMPLED);
    }
}

static void show(VkImage image, VkImageView view)
{
    const picture *from = &images[chosen->shown];
    if (chosen->way == LOAD) {
        change_layout(commands, from->image, OF_COLOR, SAMPLED, COLOR);
        begin(from->view, false, VK_ATTACHMENT_LOAD_OP_LOAD);
        vkCmdEndRendering(commands);
        change_layout(commands, from->image, OF_COLOR, COLOR, SAMPLED);
    }
    if (chosen->way == BLIT || chosen->way == COPY) {
        const VkImageSubresourceLayers layer = {OF_COLOR, 0, 0, 1};
        const VkOffset3D last = {(int)w.extent.width, (int)w.extent.height, 1};
        const VkImageBlit all = {layer, {{0, 0, 0}, last}, layer, {{0, 0, 0}, last}};
        const VkImageCopy region = {layer, {0, 0, 0}, layer, {0, 0, 0}, {w.extent.width, w.extent.height, 1}};
        change_layout(commands, from->image, OF_COLOR, SAMPLED, READ);
        change_layout(commands, image, OF_COLOR, NEW, WRITTEN);
        if (chosen->way == BLIT)
            vkCmdBlitImage(commands, from->image, READ, image, WRITTEN, 1, &all, VK_FILTER_NEAREST);
        else
            vkCmdCopyImage(commands, from->image, READ, image, WRITTEN, 1, &region);
        change_layout(commands, image, OF_COLOR, WRITTEN, SHOWN);
        return;
    }
    change_layout(commands, image, OF_COLOR, NEW, COLOR);
    begin(view, false, VK_ATTACHMENT_LOAD_OP_DONT_CARE);
    vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, screen.whole);
    vkCmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, screen_layout, 0, 1, &screen_set, 0, NULL);
    vkCmdDraw(commands, 3, 1, 0, 0);
    vkCmdEndRendering(commands);
    change_layout(commands, image, OF_COLOR, COLOR, SHOWN);
}

static void record(uint32_t index)
{
    const VkCommandBufferBeginInfo info = {.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO};
    expect(vkBeginCommandBuffer(commands, &info), "vkBeginCommandBuffer");
    record_cube();
    prepare();
    record_steps(index);
    if (scene_is_stored())
        change_layout(commands, images[SCENE].image, OF_COLOR, GENERAL, SAMPLED);
    if (chosen->way != WRITE)
        show(w.images[index], w.views[index]);
    expect(vkEndCommandBuffer(commands), "vkEndCommandBuffer");
}

int main(int argc, char **argv)
{
    parse(argc, argv);
    const VkImageUsageFlags usage = chosen->way == WRITE ? VK_IMAGE_USAGE_STORAGE_BIT : VK_IMAGE_USAGE_TRANSFER_DST_BIT;
    window_open(&w, options.x, options.y, options.width, options.height, false, is("descriptors"), usage);
    make_pictures();
    make_layouts();
    make_sets();
    make_pipelines();
    objects = make_frame_objects(&w);
    make_commands(&w, &objects, VK_COMMAND_BUFFER_LEVEL_PRIMARY, 1, &commands);
    run_frames(&w, &objects, commands, options.frames, options.shot, record);
    expect(vkDeviceWaitIdle(w.device), "vkDeviceWaitIdle");
    for (int s = 0; s < MOST_STEPS; s++)
        vkDestroyPipeline(w.device, steps[s], NULL);
    free_pipeline(&w, &cube);
    free_pipeline(&w, &screen);
    const VkPipelineLayout layouts[] = {cube_layout, screen_layout, layout};
    for (int i = 0; i < 3; i++)
        vkDestroyPipelineLayout(w.device, layouts[i], NULL);
    vkDestroyDescriptorPool(w.device, descriptors, NULL);
    vkDestroyDescriptorSetLayout(w.device, set_layout, NULL);
    vkDestroyDescriptorSetLayout(w.device, screen_set_layout, NULL);
    vkDestroySampler(w.device, sampler, NULL);
    free_frame_objects(&w, &objects);
    vkDestroyImageView(w.device, images[NEXT_LEVEL].view, NULL);
    for (int i = 0; i <= LEVEL; i++)
        free_picture(&w, &images[i]);
    free_picture(&w, &depth);
    free_block(&w, &camera);
    free_block(&w, &numbers);
    free_block(&w, &groups);
    window_close(&w);
    return 0;
}
