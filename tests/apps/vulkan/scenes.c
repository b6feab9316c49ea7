/*
 * The direction test's cube on its way to the window (--way). The cube is drawn to the window and
 * read back (read), or a separate pass draws or clears a part of the window (part, clear). Or the
 * cube is drawn off screen and shown by a triangle that samples it (post), whose shader has the
 * camera's matrix (matrices), by two triangles (chain), by place (place), by a blit (blit) or a
 * resolve (resolve), together with a smaller picture of it (half) or with its depths (depths), by a
 * compute shader (compute), while the program reads it and its depths (pick), or as one face before
 * a background that a triangle fills (background). Or a small cube is drawn before a background whose
 * colours depend on the place: off screen by an input (gradient) or by FragCoord (placed), or in the
 * window (behind). Or the cube is drawn to a part of the image, of 0.4 of its size (small) or 0.8
 * (most), which a triangle shows. Or with the newest ways to present (newest),
 * with pipelines that are linked (library, parts, and with independent sets: independent), or with
 * a pass with a view mask (multiview). --picture writes the pixels that were read, of the window or
 * of the off-screen image. A swapchain that is suboptimal or out of date is created again. The
 * images stay, as the window's size does.
 */
#include "../common/waiting.h"
#include "direction.h"
#include "frames.h"
#include "newest.h"
#include "pipelines.h"
#include "scenes_options.h"

/* Compiled by glslangValidator. */
#include "copy_comp.h"
#include "cube_frag.h"
#include "cube_push.h"
#include "screen_both.h"
#include "screen_filled.h"
#include "screen_frag.h"
#include "screen_gradient.h"
#include "screen_matrices.h"
#include "screen_most.h"
#include "screen_part_most.h"
#include "screen_part_small.h"
#include "screen_place.h"
#include "screen_placed.h"
#include "screen_small.h"
#include "screen_vert.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static vulkan_window w;
static picture depth, samples, scenes[2], small;
static VkDescriptorSetLayout set_layout, compute_set_layout;
static VkDescriptorPool descriptors;
static VkDescriptorSet sets[2], compute_set;
static VkSampler sampler;
static VkRenderPass pass;
static VkFramebuffer framebuffer;
static VkPipelineLayout cube_layout, screen_layout, compute_layout;
static linked_pipeline cube, screen, screen_of_both, background;
static VkPipeline compute;
static frame_objects objects;
static VkCommandBuffer commands;
static VkSemaphore timeline;
static block read_back, depths_back;

static bool off_screen(void)
{
    return options.way >= POST;
}

static bool has_gradient(void)
{
    return options.way == GRADIENT || options.way == PLACED || options.way == BEHIND;
}

/* Whether the pass that shows the scene samples another image, too. */
static bool both(void)
{
    return options.way == HALF || options.way == DEPTHS;
}

static VkSampleCountFlagBits count(void)
{
    return options.way == RESOLVE ? VK_SAMPLE_COUNT_4_BIT : VK_SAMPLE_COUNT_1_BIT;
}

/* Format of the off-screen image. Compute shaders can write few formats. */
static VkFormat scene_format(void)
{
    return options.way == COMPUTE ? VK_FORMAT_R8G8B8A8_UNORM : w.format;
}

static bool has_background(void)
{
    return options.way == BACKGROUND || has_gradient();
}

static void make_pipelines(void)
{
    const bool place = options.way == PLACE;
    pipeline_description cube_parts = {.vertex = SHADER(cube_push),
                                       .fragment = SHADER(cube_frag),
                                       .layout = cube_layout,
                                       .pass = pass,
                                       .color = off_screen() ? scene_format() : w.format,
                                       .depth = DEPTH_FORMAT,
                                       .view_mask = options.way == MULTIVIEW,
                                       .samples = count(),
                                       .deep = true};
    if (w.has.libraries)
        cube_parts.libraries = options.way == LIBRARY ? 2 : options.way == PARTS || options.way == INDEPENDENT ? 4 : 0;
    const bool matrices = options.way == MATRICES;
    pipeline_description screen_parts = {.vertex = matrices                  ? SHADER(screen_matrices)
                                                   : options.way == SMALL ? SHADER(screen_part_small)
                                                   : options.way == MOST  ? SHADER(screen_part_most)
                                                                          : SHADER(screen_vert),
                                         .fragment = place                         ? SHADER(screen_place)
                                                     : options.way == SMALL ? SHADER(screen_small)
                                                     : options.way == MOST  ? SHADER(screen_most)
                                                                            : SHADER(screen_frag),
                                         .layout = screen_layout,
                                         .color = w.format,
                                         .samples = VK_SAMPLE_COUNT_1_BIT};
    cube = make_pipeline(&w, &cube_parts);
    screen = make_pipeline(&w, &screen_parts);
    if (has_background()) {
        pipeline_description parts = screen_parts;
        parts.fragment = options.way == BACKGROUND ? SHADER(screen_filled)
                         : options.way == PLACED   ? SHADER(screen_placed)
                                                   : SHADER(screen_gradient);
        parts.layout = cube_layout;
        parts.color = cube_parts.color;
        parts.depth = DEPTH_FORMAT;
        background = make_pipeline(&w, &parts);
    }
    if (both()) {
        screen_parts.fragment = SHADER(screen_both);
        screen_of_both = make_pipeline(&w, &screen_parts);
    }
}

/*
 * A pass that leaves its image in the layout in which shaders sample it. The next pass begins only
 * when it has finished.
 */
static void make_pass(void)
{
    const VkAttachmentDescription all[] = {
        {0, w.format, VK_SAMPLE_COUNT_1_BIT, VK_ATTACHMENT_LOAD_OP_CLEAR, VK_ATTACHMENT_STORE_OP_STORE,
         VK_ATTACHMENT_LOAD_OP_DONT_CARE, VK_ATTACHMENT_STORE_OP_DONT_CARE, VK_IMAGE_LAYOUT_UNDEFINED,
         VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL},
        {0, DEPTH_FORMAT, VK_SAMPLE_COUNT_1_BIT, VK_ATTACHMENT_LOAD_OP_CLEAR, VK_ATTACHMENT_STORE_OP_DONT_CARE,
         VK_ATTACHMENT_LOAD_OP_DONT_CARE, VK_ATTACHMENT_STORE_OP_DONT_CARE, VK_IMAGE_LAYOUT_UNDEFINED,
         VK_IMAGE_LAYOUT_DEPTH_STENCIL_ATTACHMENT_OPTIMAL}};
    const VkAttachmentReference color = {0, VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL};
    const VkAttachmentReference deep = {1, VK_IMAGE_LAYOUT_DEPTH_STENCIL_ATTACHMENT_OPTIMAL};
    const VkSubpassDescription subpass = {
        .colorAttachmentCount = 1, .pColorAttachments = &color, .pDepthStencilAttachment = &deep};
    const VkPipelineStageFlags stages = VK_PIPELINE_STAGE_ALL_GRAPHICS_BIT;
    const VkAccessFlags all_access = VK_ACCESS_MEMORY_READ_BIT | VK_ACCESS_MEMORY_WRITE_BIT;
    const VkSubpassDependency around[] = {{VK_SUBPASS_EXTERNAL, 0, stages, stages, all_access, all_access, 0},
                                          {0, VK_SUBPASS_EXTERNAL, stages, stages, all_access, all_access, 0}};
    const VkRenderPassCreateInfo info = {.sType = VK_STRUCTURE_TYPE_RENDER_PASS_CREATE_INFO,
                                         .attachmentCount = 2,
                                         .pAttachments = all,
                                         .subpassCount = 1,
                                         .pSubpasses = &subpass,
                                         .dependencyCount = 2,
                                         .pDependencies = around};
    expect(vkCreateRenderPass(w.device, &info, NULL, &pass), "vkCreateRenderPass");
    const VkImageView views[] = {scenes[0].view, depth.view};
    const VkFramebufferCreateInfo target = {.sType = VK_STRUCTURE_TYPE_FRAMEBUFFER_CREATE_INFO,
                                            .renderPass = pass,
                                            .attachmentCount = 2,
                                            .pAttachments = views,
                                            .width = w.extent.width,
                                            .height = w.extent.height,
                                            .layers = 1};
    expect(vkCreateFramebuffer(w.device, &target, NULL, &framebuffer), "vkCreateFramebuffer");
}

static void make_pictures(void)
{
    const VkImageUsageFlags shown = VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT | VK_IMAGE_USAGE_SAMPLED_BIT;
    const VkImageUsageFlags copied = VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT | VK_IMAGE_USAGE_TRANSFER_SRC_BIT;
    const VkImageUsageFlags read = options.way == DEPTHS ? VK_IMAGE_USAGE_SAMPLED_BIT
                                   : options.way == PICK ? VK_IMAGE_USAGE_TRANSFER_SRC_BIT
                                                         : 0;
    const VkImageUsageFlags stored = options.way == COMPUTE ? VK_IMAGE_USAGE_STORAGE_BIT : 0;
    const VkExtent2D half = {w.extent.width / 2, w.extent.height / 2};
    depth = make_picture(&w, DEPTH_FORMAT, w.extent, count(), VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT | read);
    samples = make_picture(&w, w.format, w.extent, VK_SAMPLE_COUNT_4_BIT, copied);
    small = make_picture(&w, w.format, half, VK_SAMPLE_COUNT_1_BIT, shown);
    for (int i = 0; i < 2; i++)
        scenes[i] = make_picture(&w, scene_format(), w.extent, VK_SAMPLE_COUNT_1_BIT, shown | copied | stored);
    if (options.way == PASSES)
        make_pass();
    read_back = make_block(&w, 4 * w.extent.width * w.extent.height, VK_BUFFER_USAGE_TRANSFER_DST_BIT, true);
    depths_back = make_block(&w, 4 * w.extent.width * w.extent.height, VK_BUFFER_USAGE_TRANSFER_DST_BIT, true);
}

static void describe(VkDescriptorSet set, uint32_t binding, VkDescriptorType kind, VkImageView view, VkImageLayout layout)
{
    const VkDescriptorImageInfo image = {sampler, view, layout};
    const VkWriteDescriptorSet write = {.sType = VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET,
                                        .dstSet = set,
                                        .dstBinding = binding,
                                        .descriptorCount = 1,
                                        .descriptorType = kind,
                                        .pImageInfo = &image};
    vkUpdateDescriptorSets(w.device, 1, &write, 0, NULL);
}

static void make_layouts(void)
{
    const VkDescriptorType seen = VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER, written = VK_DESCRIPTOR_TYPE_STORAGE_IMAGE;
    const VkImageLayout sampled = VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL;
    const VkShaderStageFlags fragment = VK_SHADER_STAGE_FRAGMENT_BIT, computing = VK_SHADER_STAGE_COMPUTE_BIT;
    const VkDescriptorSetLayoutBinding bindings[] = {{0, seen, 1, fragment, NULL}, {1, seen, 1, fragment, NULL}};
    const VkDescriptorSetLayoutBinding for_compute[] = {{0, seen, 1, computing, NULL}, {1, written, 1, computing, NULL}};
    VkDescriptorSetLayoutCreateInfo set = {.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO,
                                           .bindingCount = both() ? 2 : 1,
                                           .pBindings = bindings};
    expect(vkCreateDescriptorSetLayout(w.device, &set, NULL, &set_layout), "vkCreateDescriptorSetLayout");
    set.bindingCount = 2;
    set.pBindings = for_compute;
    expect(vkCreateDescriptorSetLayout(w.device, &set, NULL, &compute_set_layout), "vkCreateDescriptorSetLayout");
    const VkDescriptorPoolSize sizes[] = {{seen, 5}, {written, 1}};
    const VkDescriptorPoolCreateInfo info = {
        .sType = VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO, .maxSets = 3, .poolSizeCount = 2, .pPoolSizes = sizes};
    expect(vkCreateDescriptorPool(w.device, &info, NULL, &descriptors), "vkCreateDescriptorPool");
    /* Devices need not be able to filter depths. */
    const VkFilter smooth = options.way == DEPTHS ? VK_FILTER_NEAREST : VK_FILTER_LINEAR;
    const VkSamplerCreateInfo filter = {.sType = VK_STRUCTURE_TYPE_SAMPLER_CREATE_INFO,
                                        .magFilter = smooth,
                                        .minFilter = smooth,
                                        .addressModeU = VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_EDGE,
                                        .addressModeV = VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_EDGE};
    expect(vkCreateSampler(w.device, &filter, NULL, &sampler), "vkCreateSampler");
    VkDescriptorSet all[3];
    const VkDescriptorSetLayout layouts[] = {set_layout, set_layout, compute_set_layout};
    const VkDescriptorSetAllocateInfo allocate = {.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_ALLOCATE_INFO,
                                                  .descriptorPool = descriptors,
                                                  .descriptorSetCount = 3,
                                                  .pSetLayouts = layouts};
    expect(vkAllocateDescriptorSets(w.device, &allocate, all), "vkAllocateDescriptorSets");
    sets[0] = all[0];
    sets[1] = all[1];
    compute_set = all[2];
    for (int i = 0; i < 2; i++)
        describe(sets[i], 0, seen, scenes[both() ? 0 : i].view, sampled);
    if (both()) {
        describe(sets[0], 1, seen, options.way == HALF ? small.view : depth.view, sampled);
        describe(sets[1], 1, seen, scenes[0].view, sampled);
    }
    if (options.way == COMPUTE) {
        describe(compute_set, 0, seen, scenes[0].view, sampled);
        describe(compute_set, 1, written, scenes[1].view, VK_IMAGE_LAYOUT_GENERAL);
    }
    const VkPushConstantRange range = {VK_SHADER_STAGE_VERTEX_BIT, 0, sizeof(matrix4)};
    const bool independent = options.way == INDEPENDENT && w.has.libraries;
    VkPipelineLayoutCreateInfo layout = {.sType = VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO,
                                         .flags = independent ? VK_PIPELINE_LAYOUT_CREATE_INDEPENDENT_SETS_BIT_EXT : 0,
                                         .pushConstantRangeCount = 1,
                                         .pPushConstantRanges = &range};
    expect(vkCreatePipelineLayout(w.device, &layout, NULL, &cube_layout), "vkCreatePipelineLayout");
    layout.flags = 0;
    layout.pushConstantRangeCount = options.way == MATRICES;
    layout.setLayoutCount = 1;
    layout.pSetLayouts = &set_layout;
    expect(vkCreatePipelineLayout(w.device, &layout, NULL, &screen_layout), "vkCreatePipelineLayout");
    layout.pushConstantRangeCount = 0;
    layout.pSetLayouts = &compute_set_layout;
    expect(vkCreatePipelineLayout(w.device, &layout, NULL, &compute_layout), "vkCreatePipelineLayout");
}

static void make_compute(void)
{
    const VkShaderModuleCreateInfo words = {
        .sType = VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO, .codeSize = sizeof copy_comp, .pCode = copy_comp};
    VkComputePipelineCreateInfo info = {.sType = VK_STRUCTURE_TYPE_COMPUTE_PIPELINE_CREATE_INFO,
                                        .stage = {.sType = VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO,
                                                  .stage = VK_SHADER_STAGE_COMPUTE_BIT,
                                                  .pName = "main"},
                                        .layout = compute_layout};
    expect(vkCreateShaderModule(w.device, &words, NULL, &info.stage.module), "vkCreateShaderModule");
    expect(vkCreateComputePipelines(w.device, VK_NULL_HANDLE, 1, &info, NULL, &compute), "vkCreateComputePipelines");
    vkDestroyShaderModule(w.device, info.stage.module, NULL);
}

/* Uses the older call. vk_cube uses the newer one. */
static void barrier(VkImage image, VkImageLayout from, VkImageLayout to)
{
    const bool deep = image == depth.image;
    const VkImageMemoryBarrier change = {
        .sType = VK_STRUCTURE_TYPE_IMAGE_MEMORY_BARRIER,
        .srcAccessMask = VK_ACCESS_MEMORY_WRITE_BIT,
        .dstAccessMask = VK_ACCESS_MEMORY_WRITE_BIT | VK_ACCESS_MEMORY_READ_BIT,
        .oldLayout = from,
        .newLayout = to,
        .srcQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED,
        .dstQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED,
        .image = image,
        .subresourceRange = {deep ? VK_IMAGE_ASPECT_DEPTH_BIT : VK_IMAGE_ASPECT_COLOR_BIT, 0, 1, 0, 1}};
    const VkPipelineStageFlags all = VK_PIPELINE_STAGE_ALL_COMMANDS_BIT;
    vkCmdPipelineBarrier(commands, all, all, 0, 0, NULL, 0, NULL, 1, &change);
}

static const VkImageLayout NEW = VK_IMAGE_LAYOUT_UNDEFINED, COLOR = VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL;
static const VkImageLayout DEEP = VK_IMAGE_LAYOUT_DEPTH_ATTACHMENT_OPTIMAL, READ_FROM = VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL;
static const VkImageLayout SAMPLED = VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL, WRITTEN = VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL;
static const VkImageLayout SHOWN = VK_IMAGE_LAYOUT_PRESENT_SRC_KHR, GENERAL = VK_IMAGE_LAYOUT_GENERAL;
static const VkClearValue grey = {.color = {.float32 = {0.25f, 0.25f, 0.25f, 1.0f}}}, far = {.depthStencil = {1.0f, 0}};

static void begin(VkImageView color, bool deep, VkAttachmentLoadOp load, VkRect2D area)
{
    const VkRenderingAttachmentInfo colors = {.sType = VK_STRUCTURE_TYPE_RENDERING_ATTACHMENT_INFO,
                                              .imageView = color,
                                              .imageLayout = COLOR,
                                              .loadOp = load,
                                              .storeOp = VK_ATTACHMENT_STORE_OP_STORE,
                                              .clearValue = grey};
    const VkRenderingAttachmentInfo depths = {.sType = VK_STRUCTURE_TYPE_RENDERING_ATTACHMENT_INFO,
                                              .imageView = depth.view,
                                              .imageLayout = DEEP,
                                              .loadOp = load,
                                              .storeOp = VK_ATTACHMENT_STORE_OP_STORE,
                                              .clearValue = far};
    const VkRenderingInfo info = {.sType = VK_STRUCTURE_TYPE_RENDERING_INFO,
                                  .renderArea = area,
                                  .layerCount = 1,
                                  .viewMask = options.way == MULTIVIEW,
                                  .colorAttachmentCount = 1,
                                  .pColorAttachments = &colors,
                                  .pDepthAttachment = deep ? &depths : NULL};
    vkCmdBeginRendering(commands, &info);
}

static void set_window(VkExtent2D size)
{
    const VkViewport viewport = {0, 0, (float)size.width, (float)size.height, 0, 1};
    const VkRect2D scissor = {{0, 0}, size};
    vkCmdSetViewport(commands, 0, 1, &viewport);
    vkCmdSetScissor(commands, 0, 1, &scissor);
}

/* The part of the picture that the cube is drawn to. */
static VkExtent2D part(void)
{
    const uint32_t tenths = options.way == SMALL ? 4 : options.way == MOST ? 8 : 10;
    return (VkExtent2D){w.extent.width * tenths / 10, w.extent.height * tenths / 10};
}

static void draw_cube(matrix4 matrix)
{
    vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, cube.whole);
    set_window(part());
    vkCmdPushConstants(commands, cube_layout, VK_SHADER_STAGE_VERTEX_BIT, 0, sizeof matrix, &matrix);
    vkCmdDraw(commands, options.way == BACKGROUND ? 6 : 36, 1, 0, 0);
}

static void draw_screen(const linked_pipeline *by, VkDescriptorSet set, VkExtent2D size)
{
    vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, by->whole);
    set_window(size);
    vkCmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, screen_layout, 0, 1, &set, 0, NULL);
    if (options.way == MATRICES) {
        const matrix4 matrix = direction_matrix(&options.direction, w.extent, false);
        vkCmdPushConstants(commands, screen_layout, VK_SHADER_STAGE_VERTEX_BIT, 0, sizeof matrix, &matrix);
    }
    vkCmdDraw(commands, 3, 1, 0, 0);
}

/* Draws the cube in a pass that clears, to the window or off screen. */
static void record_cube(picture *target, VkImage image, VkImageView view)
{
    const VkRect2D whole = {{0, 0}, w.extent};
    if (options.way == PASSES) {
        const VkClearValue clears[] = {grey, far};
        const VkRenderPassBeginInfo info = {.sType = VK_STRUCTURE_TYPE_RENDER_PASS_BEGIN_INFO,
                                            .renderPass = pass,
                                            .framebuffer = framebuffer,
                                            .renderArea = whole,
                                            .clearValueCount = 2,
                                            .pClearValues = clears};
        vkCmdBeginRenderPass(commands, &info, VK_SUBPASS_CONTENTS_INLINE);
        draw_cube(direction_matrix(&options.direction, w.extent, false));
        vkCmdEndRenderPass(commands);
        return;
    }
    barrier(target != NULL ? target->image : image, NEW, COLOR);
    barrier(depth.image, NEW, DEEP);
    begin(target != NULL ? target->view : view, true, VK_ATTACHMENT_LOAD_OP_CLEAR, whole);
    if (has_background()) {
        vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, background.whole);
        set_window(w.extent);
        vkCmdDraw(commands, 3, 1, 0, 0);
    }
    matrix4 matrix = direction_matrix(&options.direction, w.extent, false);
    if (has_gradient())
        matrix = matrix_multiply(matrix, matrix_translate(0.0, 0.0, -10.0));
    draw_cube(matrix);
    vkCmdEndRendering(commands);
}

static void show(const linked_pipeline *by, VkDescriptorSet set, VkImage image, VkImageView view, VkExtent2D size)
{
    barrier(image, NEW, COLOR);
    begin(view, false, VK_ATTACHMENT_LOAD_OP_DONT_CARE, (VkRect2D){{0, 0}, size});
    draw_screen(by, set, size);
    vkCmdEndRendering(commands);
}

/* Shaders show the off-screen image in the window. */
static void show_scene(VkImage image, VkImageView view)
{
    VkDescriptorSet set = sets[0];
    if (options.way != PASSES)
        barrier(scenes[0].image, COLOR, SAMPLED);
    if (options.way == CHAIN) {
        show(&screen, set, scenes[1].image, scenes[1].view, w.extent);
        barrier(scenes[1].image, COLOR, SAMPLED);
        set = sets[1];
    } else if (options.way == HALF) {
        const VkExtent2D half = {w.extent.width / 2, w.extent.height / 2};
        show(&screen, sets[1], small.image, small.view, half);
        barrier(small.image, COLOR, SAMPLED);
    } else if (options.way == DEPTHS) {
        barrier(depth.image, DEEP, SAMPLED);
    } else if (options.way == COMPUTE) {
        barrier(scenes[1].image, NEW, GENERAL);
        vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_COMPUTE, compute);
        vkCmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_COMPUTE, compute_layout, 0, 1, &compute_set, 0, NULL);
        vkCmdDispatch(commands, (w.extent.width + 7) / 8, (w.extent.height + 7) / 8, 1);
        barrier(scenes[1].image, GENERAL, SAMPLED);
        set = sets[1];
    }
    show(both() ? &screen_of_both : &screen, set, image, view, w.extent);
}

static void record(uint32_t index)
{
    const VkImage image = w.images[index];
    const VkImageView view = w.views[index];
    const VkImageSubresourceLayers layer = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, 1};
    const int width = (int)w.extent.width, height = (int)w.extent.height;
    const VkExtent3D size = {w.extent.width, w.extent.height, 1};
    const VkRect2D part = {{width / 8, height / 8}, {w.extent.width / 8, w.extent.height / 8}};
    const VkCommandBufferBeginInfo info = {.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO};
    expect(vkBeginCommandBuffer(commands, &info), "vkBeginCommandBuffer");
    picture *target = off_screen() ? (options.way == RESOLVE ? &samples : &scenes[0]) : NULL;
    record_cube(target, image, view);
    const VkBufferImageCopy region = {.imageSubresource = layer, .imageExtent = size};
    VkImageLayout left = COLOR;
    if (options.way == PART || options.way == CLEAR) {
        begin(view, true, options.way == PART ? VK_ATTACHMENT_LOAD_OP_LOAD : VK_ATTACHMENT_LOAD_OP_CLEAR, part);
        if (options.way == PART)
            draw_cube((matrix4){{0.125f, 0, 0, 0, 0, 0.125f, 0, 0, 0, 0, 0, 0, -0.625f, -0.625f, 0, 1}});
        vkCmdEndRendering(commands);
    } else if (options.way == READ) {
        barrier(image, COLOR, READ_FROM);
        vkCmdCopyImageToBuffer(commands, image, READ_FROM, read_back.buffer, 1, &region);
        left = READ_FROM;
    } else if (options.way == BLIT || options.way == RESOLVE) {
        const VkImageBlit blit = {layer, {{0, 0, 0}, {width, height, 1}}, layer, {{0, 0, 0}, {width, height, 1}}};
        const VkImageResolve resolve = {layer, {0, 0, 0}, layer, {0, 0, 0}, size};
        barrier(target->image, COLOR, READ_FROM);
        barrier(image, NEW, WRITTEN);
        if (options.way == BLIT)
            vkCmdBlitImage(commands, target->image, READ_FROM, image, WRITTEN, 1, &blit, VK_FILTER_NEAREST);
        else
            vkCmdResolveImage(commands, target->image, READ_FROM, image, WRITTEN, 1, &resolve);
        left = WRITTEN;
    } else if (off_screen()) {
        show_scene(image, view);
        if (options.picture != NULL) {
            barrier(scenes[0].image, SAMPLED, READ_FROM);
            vkCmdCopyImageToBuffer(commands, scenes[0].image, READ_FROM, read_back.buffer, 1, &region);
        }
        if (options.way == PICK) {
            const VkBufferImageCopy deep = {.imageSubresource = {VK_IMAGE_ASPECT_DEPTH_BIT, 0, 0, 1}, .imageExtent = size};
            barrier(depth.image, DEEP, READ_FROM);
            vkCmdCopyImageToBuffer(commands, depth.image, READ_FROM, depths_back.buffer, 1, &deep);
        }
    }
    barrier(image, left, SHOWN);
    expect(vkEndCommandBuffer(commands), "vkEndCommandBuffer");
}

static void frame(uint64_t number)
{
    const uint32_t index = next_image(&w, &objects);
    record(index);
    if (options.way == NEWEST) {
        const frame_parts parts = {commands, objects.acquired, timeline};
        end_newest_frame(&w, &parts, index, number);
    } else if (!end_frame(&w, &objects, commands, index))
        window_make_swapchain(&w);
}

/* Writes the colours, and with `pick` the depths below them, as three of their bytes. */
static void write_picture(const char *path)
{
    FILE *file = fopen(path, "wb");
    if (file == NULL) {
        fprintf(stderr, "cannot write %s\n", path);
        exit(1);
    }
    const uint32_t pixels = w.extent.width * w.extent.height;
    fprintf(file, "P6\n%u %u\n255\n", w.extent.width, (options.way == PICK ? 2 : 1) * w.extent.height);
    const unsigned char *bytes = read_back.bytes;
    for (uint32_t i = 0; i < pixels; i++, bytes += 4)
        fwrite((unsigned char[]){bytes[2], bytes[1], bytes[0]}, 1, 3, file);
    bytes = depths_back.bytes;
    for (uint32_t i = 0; options.way == PICK && i < pixels; i++, bytes += 4)
        fwrite(bytes, 1, 3, file);
    fclose(file);
}

static void open_all(void)
{
    const VkImageUsageFlags copied =
        VK_IMAGE_USAGE_TRANSFER_DST_BIT |
        (options.picture != NULL && options.way != PICK ? VK_IMAGE_USAGE_TRANSFER_SRC_BIT : 0);
    const bool newest = options.way >= NEWEST && options.way <= MULTIVIEW;
    window_open(&w, options.direction.x, options.direction.y, options.direction.width, options.direction.height, false, newest,
                options.way == READ ? VK_IMAGE_USAGE_TRANSFER_SRC_BIT : off_screen() ? copied : 0);
    make_pictures();
    make_layouts();
    make_pipelines();
    make_compute();
    objects = make_frame_objects(&w);
    make_commands(&w, &objects, VK_COMMAND_BUFFER_LEVEL_PRIMARY, 1, &commands);
    const VkSemaphoreTypeCreateInfo counts = {.sType = VK_STRUCTURE_TYPE_SEMAPHORE_TYPE_CREATE_INFO,
                                              .semaphoreType = VK_SEMAPHORE_TYPE_TIMELINE};
    const VkSemaphoreCreateInfo counting = {.sType = VK_STRUCTURE_TYPE_SEMAPHORE_CREATE_INFO, .pNext = &counts};
    if (options.way == NEWEST)
        expect(vkCreateSemaphore(w.device, &counting, NULL, &timeline), "vkCreateSemaphore");
}

static void close_all(void)
{
    expect(vkDeviceWaitIdle(w.device), "vkDeviceWaitIdle");
    vkDestroyFramebuffer(w.device, framebuffer, NULL);
    vkDestroyRenderPass(w.device, pass, NULL);
    free_pipeline(&w, &cube);
    free_pipeline(&w, &screen);
    free_pipeline(&w, &screen_of_both);
    free_pipeline(&w, &background);
    vkDestroyPipeline(w.device, compute, NULL);
    vkDestroyPipelineLayout(w.device, cube_layout, NULL);
    vkDestroyPipelineLayout(w.device, screen_layout, NULL);
    vkDestroyPipelineLayout(w.device, compute_layout, NULL);
    vkDestroyDescriptorPool(w.device, descriptors, NULL);
    vkDestroyDescriptorSetLayout(w.device, set_layout, NULL);
    vkDestroyDescriptorSetLayout(w.device, compute_set_layout, NULL);
    vkDestroySampler(w.device, sampler, NULL);
    free_frame_objects(&w, &objects);
    vkDestroySemaphore(w.device, timeline, NULL);
    free_picture(&w, &depth);
    free_picture(&w, &samples);
    free_picture(&w, &small);
    for (int i = 0; i < 2; i++)
        free_picture(&w, &scenes[i]);
    free_block(&w, &read_back);
    free_block(&w, &depths_back);
    window_close(&w);
}

int main(int argc, char **argv)
{
    parse(argc, argv);
    open_all();
    uint64_t number = 0;
    for (int left = options.direction.frames; left > 0; left -= frame_counts())
        frame(++number);
    if (options.direction.shot != NULL)
        window_shot(&w, options.direction.shot);
    if (options.picture != NULL)
        write_picture(options.picture);
    close_all();
    return 0;
}
