/*
 * The direction test with Vulkan. Options choose how a pass begins (--pass), where the matrix is (--matrix), whether
 * command buffers are recorded once or in each frame (--once), samples, sRGB, an upside-down viewport, secondary command
 * buffers, indirect draws, flat drawing before or after the cube, other sizes while the program runs, small parts
 * (--cells), other shader stages (--stage), and depth in a separate pass (--depth).
 */
#include "../common/waiting.h"
#include "cube_pass.h"
#include "depth_pass.h"
#include "frames.h"
#include "matrix_kinds.h"
#include "memory.h"
#include "options.h"
#include "pipelines.h"

/* Compiled from cube.vert and cube.frag by glslangValidator. */
#include "cells_block.h"
#include "cells_push.h"
#include "cube_address.h"
#include "cube_address_block.h"
#include "cube_address_sum.h"
#include "cube_array.h"
#include "cube_block.h"
#include "cube_clip.h"
#include "cube_columns.h"
#include "cube_frag.h"
#include "cube_instance.h"
#include "cube_instance_columns.h"
#include "cube_place.h"
#include "cube_push.h"
#include "cube_row_vector.h"
#include "cube_rows.h"
#include "stage_geom.h"
#include "stage_tesc.h"
#include "stage_tese.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

static vulkan_window w;
static picture depth, samples;
static depth_pass first;
static VkRenderPass pass;
static VkDescriptorSetLayout set_layout, pushed_layout;
static VkDescriptorPool descriptors;
static VkDescriptorSet sets[MOST_IMAGES];
static VkPipelineLayout layout, plain_layout;
static linked_pipeline pipeline, plain_pipeline;
static VkFramebuffer framebuffers[MOST_IMAGES];
static VkCommandBuffer commands[MOST_IMAGES], inner[MOST_IMAGES];
static frame_objects objects;
static block blocks[MOST_IMAGES], staging[MOST_IMAGES], indirect;

enum { CELL_COUNT = 6 * 64 * 64 };
/* Whether descriptors are pushed. The device must support it. */
static bool pushes(void)
{
    return options.matrix == MATRIX_PUSHED_SET && w.has.push_descriptor;
}

static void make_layout(void)
{
    const bool dynamic = options.matrix == MATRIX_DYNAMIC_BLOCK;
    const VkDescriptorType kind =
        dynamic ? VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER_DYNAMIC : VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER;
    const VkDescriptorSetLayoutBinding binding = {0, kind, 1, VK_SHADER_STAGE_VERTEX_BIT, NULL};
    VkDescriptorSetLayoutCreateInfo set = {
        .sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO, .bindingCount = 1, .pBindings = &binding};
    expect(vkCreateDescriptorSetLayout(w.device, &set, NULL, &set_layout), "vkCreateDescriptorSetLayout");
    set.flags = VK_DESCRIPTOR_SET_LAYOUT_CREATE_PUSH_DESCRIPTOR_BIT_KHR;
    if (pushes())
        expect(vkCreateDescriptorSetLayout(w.device, &set, NULL, &pushed_layout), "vkCreateDescriptorSetLayout");
    const VkDescriptorPoolSize size = {kind, MOST_IMAGES};
    const VkDescriptorPoolCreateInfo info = {.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO,
                                             .maxSets = MOST_IMAGES,
                                             .poolSizeCount = 1,
                                             .pPoolSizes = &size};
    expect(vkCreateDescriptorPool(w.device, &info, NULL, &descriptors), "vkCreateDescriptorPool");
    const VkPushConstantRange range = {VK_SHADER_STAGE_VERTEX_BIT, 0, sizeof(matrix4)};
    const bool push = has_push();
    VkPipelineLayoutCreateInfo pipeline_layout = {.sType = VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO,
                                                        .setLayoutCount = push ? 0 : 1,
                                                        .pSetLayouts = pushes() ? &pushed_layout : &set_layout,
                                                        .pushConstantRangeCount = push ? 1 : 0,
                                                        .pPushConstantRanges = &range};
    expect(vkCreatePipelineLayout(w.device, &pipeline_layout, NULL, &layout), "vkCreatePipelineLayout");
    pipeline_layout.setLayoutCount = 0;
    pipeline_layout.pushConstantRangeCount = 1;
    if (pushes())
        expect(vkCreatePipelineLayout(w.device, &pipeline_layout, NULL, &plain_layout), "vkCreatePipelineLayout");
    const bool copied = copies();
    const VkBufferUsageFlags usage = VK_BUFFER_USAGE_TRANSFER_DST_BIT |
                                     (has_attribute() ? VK_BUFFER_USAGE_VERTEX_BUFFER_BIT : VK_BUFFER_USAGE_UNIFORM_BUFFER_BIT) |
                                     (has_address() ? VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT : 0);
    for (uint32_t i = 0; i < MOST_IMAGES; i++) {
        blocks[i] = make_block(&w, block_size(), usage, !copied);
        staging[i] = make_block(&w, block_size(), VK_BUFFER_USAGE_TRANSFER_SRC_BIT, true);
        if (has_attribute())
            continue;
        const VkDescriptorSetAllocateInfo allocate = {.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_ALLOCATE_INFO,
                                                      .descriptorPool = descriptors,
                                                      .descriptorSetCount = 1,
                                                      .pSetLayouts = &set_layout};
        expect(vkAllocateDescriptorSets(w.device, &allocate, &sets[i]), "vkAllocateDescriptorSets");
        const VkDescriptorBufferInfo buffer = {blocks[i].buffer, dynamic ? 0 : SLICE, sizeof(matrix4)};
        const VkWriteDescriptorSet write = {.sType = VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET,
                                            .dstSet = sets[i],
                                            .descriptorCount = 1,
                                            .descriptorType = kind,
                                            .pBufferInfo = &buffer};
        vkUpdateDescriptorSets(w.device, 1, &write, 0, NULL);
    }
}

static VkViewport viewport(void)
{
    const float width = (float)w.extent.width, height = (float)w.extent.height;
    return options.flip ? (VkViewport){0, height, width, -height, 0, 1} : (VkViewport){0, 0, width, height, 0, 1};
}

static void make_cube_pipeline(void)
{
    const VkViewport window = viewport();
    const bool push = has_push(), cells = options.cells != CELLS_NONE;
    const shader_words whole = push ? SHADER(cube_push) : SHADER(cube_block);
    const shader_words parts = push ? SHADER(cells_push) : SHADER(cells_block);
    const shader_words one = options.columns ? SHADER(cube_columns) : cells ? parts : whole;
    const shader_words address = options.matrix == MATRIX_ADDRESS       ? SHADER(cube_address)
                                 : options.matrix == MATRIX_ADDRESS_SUM ? SHADER(cube_address_sum)
                                                                        : SHADER(cube_address_block);
    const shader_words attribute = options.columns ? SHADER(cube_instance_columns) : SHADER(cube_instance);
    const shader_words any = has_address() ? address : has_attribute() ? attribute : one;
    const shader_words arrays[] = {any, SHADER(cube_array), SHADER(cube_rows), SHADER(cube_row_vector)};
    const shader_words fragments[] = {SHADER(cube_frag), SHADER(cube_clip), SHADER(cube_place)};
    pipeline_description description = {.vertex = arrays[options.array],
                                        .fragment = fragments[options.clip + 2 * options.place],
                                        .layout = layout,
                                        .input = matrix_input(),
                                        .pass = pass,
                                        .color = w.format,
                                        .depth = DEPTH_FORMAT,
                                        .samples = (VkSampleCountFlagBits)options.samples,
                                        .deep = true,
                                        .points = options.cells == CELLS_POINTS,
                                        .viewport = options.fixed ? &window : NULL};
    if (options.stage == STAGE_GEOMETRY)
        description.geometry = SHADER(stage_geom);
    if (options.stage == STAGE_TESSELLATION) {
        description.control = SHADER(stage_tesc);
        description.evaluation = SHADER(stage_tese);
    }
    pipeline = make_pipeline(&w, &description);
    if (options.depth != DEPTH_TOGETHER)
        first = make_depth_pass(&w, depth.view, &description);
    if (pushes()) {
        description.vertex = SHADER(cube_push);
        description.layout = plain_layout;
        plain_pipeline = make_pipeline(&w, &description);
    }
}

static void make_framebuffers(void)
{
    const VkSampleCountFlagBits count = (VkSampleCountFlagBits)options.samples;
    depth = make_picture(&w, DEPTH_FORMAT, w.extent, count,
                         VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT |
                             (options.depth == DEPTH_READABLE ? VK_IMAGE_USAGE_SAMPLED_BIT : 0));
    if (multisampled())
        samples = make_picture(&w, w.format, w.extent, count, VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT);
    if (options.pass == PASS_DYNAMIC)
        return;
    const VkFormat deep = DEPTH_FORMAT;
    const VkFramebufferAttachmentImageInfo color = {.sType = VK_STRUCTURE_TYPE_FRAMEBUFFER_ATTACHMENT_IMAGE_INFO,
                                                    .usage = VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT | w.usage,
                                                    .width = w.extent.width,
                                                    .height = w.extent.height,
                                                    .layerCount = 1,
                                                    .viewFormatCount = 1,
                                                    .pViewFormats = &w.format};
    VkFramebufferAttachmentImageInfo later[3] = {color, color, color};
    later[1].usage = VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT;
    later[1].pViewFormats = &deep;
    if (multisampled())
        later[0].usage = VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT;
    const uint32_t number = multisampled() ? 3 : 2;
    const VkFramebufferAttachmentsCreateInfo imageless = {.sType = VK_STRUCTURE_TYPE_FRAMEBUFFER_ATTACHMENTS_CREATE_INFO,
                                                          .attachmentImageInfoCount = number,
                                                          .pAttachmentImageInfos = later};
    for (uint32_t i = 0; i < w.count; i++) {
        const VkImageView views[] = {multisampled() ? samples.view : w.views[i], depth.view, w.views[i]};
        const bool without = options.pass == PASS_IMAGELESS;
        const VkFramebufferCreateInfo info = {.sType = VK_STRUCTURE_TYPE_FRAMEBUFFER_CREATE_INFO,
                                              .pNext = without ? &imageless : NULL,
                                              .flags = without ? VK_FRAMEBUFFER_CREATE_IMAGELESS_BIT : 0,
                                              .renderPass = pass,
                                              .attachmentCount = number,
                                              .pAttachments = without ? NULL : views,
                                              .width = w.extent.width,
                                              .height = w.extent.height,
                                              .layers = 1};
        expect(vkCreateFramebuffer(w.device, &info, NULL, &framebuffers[i]), "vkCreateFramebuffer");
    }
}

static void free_framebuffers(void)
{
    for (uint32_t i = 0; i < MOST_IMAGES; i++) {
        vkDestroyFramebuffer(w.device, framebuffers[i], NULL);
        framebuffers[i] = VK_NULL_HANDLE;
    }
    free_picture(&w, &depth);
    if (multisampled())
        free_picture(&w, &samples);
}

/* Matrix of a square: a small one in the middle, or a background. */
static matrix4 flat_matrix(void)
{
    const float half = options.flat == 2 ? 1.0f : 0.25f;
    return (matrix4){{half, 0, 0, 0, 0, half, 0, 0, 0, 0, 0, 0, 0, 0, options.flat == 2 ? 1.0f : 0.0f, 1}};
}

/* Pushes the address of a matrix. With MATRIX_ADDRESS_SUM the shader adds the last number. */
static void push_address(VkCommandBuffer buffer, uint32_t index, uint32_t offset)
{
    const uint32_t more = options.matrix == MATRIX_ADDRESS_SUM ? 16 : 0;
    const VkDeviceAddress address = address_of_matrix(&w, &blocks[index], offset) - more;
    const uint32_t numbers[] = {0, 0, (uint32_t)address, (uint32_t)(address >> 32), more};
    vkCmdPushConstants(buffer, layout, VK_SHADER_STAGE_VERTEX_BIT, 0, sizeof numbers, numbers);
}

static void fill_block(uint32_t index)
{
    const matrix4 scene = direction_matrix(&options.direction, w.extent, options.flip), flat = flat_matrix();
    char *bytes = copies() ? staging[index].bytes : blocks[index].bytes;
    const size_t behind = has_address() ? AFTER_ADDRESS : 0;
    memcpy(bytes + SLICE + behind, &scene, sizeof scene);
    memcpy(bytes + 2 * SLICE + behind, &flat, sizeof flat);
    for (uint32_t slice = 1; has_address() && slice < 3; slice++) {
        const VkDeviceAddress address = address_of_matrix(&w, &blocks[index], slice * SLICE);
        memcpy(bytes + slice * SLICE, &address, sizeof address);
    }
}

static void push_block(VkCommandBuffer buffer, uint32_t index, uint32_t offset)
{
    PFN_vkCmdPushDescriptorSetKHR push =
        (PFN_vkCmdPushDescriptorSetKHR)vkGetDeviceProcAddr(w.device, "vkCmdPushDescriptorSetKHR");
    const VkDescriptorBufferInfo info = {blocks[index].buffer, offset, sizeof(matrix4)};
    const VkWriteDescriptorSet write = {.sType = VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET,
                                        .descriptorCount = 1,
                                        .descriptorType = VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER,
                                        .pBufferInfo = &info};
    push(buffer, VK_PIPELINE_BIND_POINT_GRAPHICS, layout, 0, 1, &write);
}

/* Number of the draw among those of a frame. */
static int draw_number;

static void draw_one(VkCommandBuffer buffer, uint32_t index, bool flat)
{
    matrix4 matrix = flat ? flat_matrix() : direction_matrix(&options.direction, w.extent, options.flip);
    for (int i = 0; i < 16; i++)
        matrix.m[i] *= 1.0f + (float)draw_number / 1048576.0f;
    if (options.array >= ARRAY_ROWS)
        matrix = matrix_transposed(matrix);
    const uint32_t offset = flat ? 2 * SLICE : SLICE;
    const VkDeviceSize first_matrix = of_instances() ? 0 : offset;
    const uint32_t first_instance = of_instances() ? offset / SLICE : 0;
    if (options.matrix == MATRIX_PUSH)
        vkCmdPushConstants(buffer, layout, VK_SHADER_STAGE_VERTEX_BIT, 0, sizeof matrix, &matrix);
    else if (pushes())
        push_block(buffer, index, offset);
    else if (has_push())
        push_address(buffer, index, offset);
    else if (has_attribute())
        vkCmdBindVertexBuffers(buffer, 1, 1, &blocks[index].buffer, &first_matrix);
    else
        vkCmdBindDescriptorSets(buffer, VK_PIPELINE_BIND_POINT_GRAPHICS, layout, 0, 1, &sets[index],
                                options.matrix == MATRIX_DYNAMIC_BLOCK ? 1 : 0, &offset);
    if (options.indirect)
        vkCmdDrawIndirect(buffer, indirect.buffer, 0, 1, sizeof(VkDrawIndirectCommand));
    else if (options.cells == CELLS_NONE)
        vkCmdDraw(buffer, 36, 1, 0, first_instance);
    else if (options.cells == CELLS_BEHIND)
        vkCmdDraw(buffer, 6 * CELL_COUNT, 2, 0, 1); /* the ball, then the larger cube behind it */
    else
        vkCmdDraw(buffer, (options.cells == CELLS_POINTS ? 1 : 6) * CELL_COUNT, 1, 0, (uint32_t)options.cells - CELLS_TRIANGLES);
}

/* Draws a background after the push of the descriptors and before the cube, with a pipeline without sets. */
static void draw_between(VkCommandBuffer buffer, uint32_t index)
{
    const matrix4 flat = flat_matrix();
    push_block(buffer, index, SLICE);
    vkCmdBindPipeline(buffer, VK_PIPELINE_BIND_POINT_GRAPHICS, plain_pipeline.whole);
    vkCmdPushConstants(buffer, plain_layout, VK_SHADER_STAGE_VERTEX_BIT, 0, sizeof flat, &flat);
    vkCmdDraw(buffer, 36, 1, 0, 0);
    vkCmdBindPipeline(buffer, VK_PIPELINE_BIND_POINT_GRAPHICS, pipeline.whole);
    vkCmdDraw(buffer, 36, 1, 0, 0);
}

static void bind(VkCommandBuffer buffer, VkPipeline bound)
{
    const VkViewport window = viewport();
    const VkRect2D scissor = {{0, 0}, w.extent};
    vkCmdBindPipeline(buffer, VK_PIPELINE_BIND_POINT_GRAPHICS, bound);
    if (!options.fixed) {
        vkCmdSetViewport(buffer, 0, 1, &window);
        vkCmdSetScissor(buffer, 0, 1, &scissor);
    }
}

/* Draws the depth of the cube in a separate pass if the options ask for it. */
static void draw_depth(VkCommandBuffer buffer, uint32_t index)
{
    if (options.depth == DEPTH_TOGETHER)
        return;
    begin_depth_pass(&first, buffer);
    if (options.depth != DEPTH_CLEARED) {
        bind(buffer, first.pipeline.whole);
        for (draw_number = 0; draw_number < options.draws; draw_number++)
            draw_one(buffer, index, false);
    }
    end_depth_pass(&first, buffer);
}

static void draw(VkCommandBuffer buffer, uint32_t index)
{
    bind(buffer, pipeline.whole);
    if (options.flat == 2 && pushes()) {
        draw_between(buffer, index);
        return;
    }
    if (options.flat == 2)
        draw_one(buffer, index, true);
    for (draw_number = 0; draw_number < options.draws; draw_number++)
        draw_one(buffer, index, options.flat == 3);
    if (options.flat == 1)
        draw_one(buffer, index, true);
}

static const VkClearValue grey = {.color = {.float32 = {0.25f, 0.25f, 0.25f, 1.0f}}};
static const VkClearValue far = {.depthStencil = {1.0f, 0}};

static void record_dynamic(VkCommandBuffer buffer, uint32_t index)
{
    const VkImageLayout color = VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL;
    change_layout(buffer, w.images[index], VK_IMAGE_ASPECT_COLOR_BIT, VK_IMAGE_LAYOUT_UNDEFINED, color);
    if (multisampled())
        change_layout(buffer, samples.image, VK_IMAGE_ASPECT_COLOR_BIT, VK_IMAGE_LAYOUT_UNDEFINED, color);
    change_layout(buffer, depth.image, VK_IMAGE_ASPECT_DEPTH_BIT, VK_IMAGE_LAYOUT_UNDEFINED,
                  VK_IMAGE_LAYOUT_DEPTH_STENCIL_ATTACHMENT_OPTIMAL);
    draw_depth(buffer, index);
    const VkRenderingAttachmentInfo colors = {.sType = VK_STRUCTURE_TYPE_RENDERING_ATTACHMENT_INFO,
                                              .imageView = multisampled() ? samples.view : w.views[index],
                                              .imageLayout = color,
                                              .resolveMode = multisampled() ? VK_RESOLVE_MODE_AVERAGE_BIT : VK_RESOLVE_MODE_NONE,
                                              .resolveImageView = multisampled() ? w.views[index] : VK_NULL_HANDLE,
                                              .resolveImageLayout = color,
                                              .loadOp = VK_ATTACHMENT_LOAD_OP_CLEAR,
                                              .storeOp = VK_ATTACHMENT_STORE_OP_STORE,
                                              .clearValue = grey};
    const VkRenderingAttachmentInfo deep = {.sType = VK_STRUCTURE_TYPE_RENDERING_ATTACHMENT_INFO,
                                            .imageView = depth.view,
                                            .imageLayout = VK_IMAGE_LAYOUT_DEPTH_STENCIL_ATTACHMENT_OPTIMAL,
                                            .loadOp = options.depth == DEPTH_TOGETHER ? VK_ATTACHMENT_LOAD_OP_CLEAR
                                                                                      : VK_ATTACHMENT_LOAD_OP_LOAD,
                                            .clearValue = far};
    const VkRenderingInfo info = {.sType = VK_STRUCTURE_TYPE_RENDERING_INFO,
                                  .flags = options.secondary ? VK_RENDERING_CONTENTS_SECONDARY_COMMAND_BUFFERS_BIT : 0,
                                  .renderArea = {{0, 0}, w.extent},
                                  .layerCount = 1,
                                  .colorAttachmentCount = 1,
                                  .pColorAttachments = &colors,
                                  .pDepthAttachment = &deep};
    vkCmdBeginRendering(buffer, &info);
    if (options.secondary)
        vkCmdExecuteCommands(buffer, 1, &inner[index]);
    else
        draw(buffer, index);
    vkCmdEndRendering(buffer);
    change_layout(buffer, w.images[index], VK_IMAGE_ASPECT_COLOR_BIT, color, VK_IMAGE_LAYOUT_PRESENT_SRC_KHR);
}

static void record_pass(VkCommandBuffer buffer, uint32_t index)
{
    const VkClearValue clears[] = {grey, far, grey};
    const VkImageView views[] = {multisampled() ? samples.view : w.views[index], depth.view, w.views[index]};
    const VkRenderPassAttachmentBeginInfo given = {.sType = VK_STRUCTURE_TYPE_RENDER_PASS_ATTACHMENT_BEGIN_INFO,
                                                   .attachmentCount = multisampled() ? 3 : 2,
                                                   .pAttachments = views};
    const VkRenderPassBeginInfo begin = {.sType = VK_STRUCTURE_TYPE_RENDER_PASS_BEGIN_INFO,
                                         .pNext = options.pass == PASS_IMAGELESS ? &given : NULL,
                                         .renderPass = pass,
                                         .framebuffer = framebuffers[index],
                                         .renderArea = {{0, 0}, w.extent},
                                         .clearValueCount = 3,
                                         .pClearValues = clears};
    const VkSubpassContents contents =
        options.secondary ? VK_SUBPASS_CONTENTS_SECONDARY_COMMAND_BUFFERS : VK_SUBPASS_CONTENTS_INLINE;
    const VkSubpassBeginInfo subpass = {.sType = VK_STRUCTURE_TYPE_SUBPASS_BEGIN_INFO, .contents = contents};
    const VkSubpassEndInfo end = {.sType = VK_STRUCTURE_TYPE_SUBPASS_END_INFO};
    draw_depth(buffer, index);
    if (options.pass == PASS_2)
        vkCmdBeginRenderPass2(buffer, &begin, &subpass);
    else
        vkCmdBeginRenderPass(buffer, &begin, contents);
    if (options.secondary)
        vkCmdExecuteCommands(buffer, 1, &inner[index]);
    else
        draw(buffer, index);
    if (options.pass == PASS_2)
        vkCmdEndRenderPass2(buffer, &end);
    else
        vkCmdEndRenderPass(buffer);
}

/* Records the contents of a pass. They do not contain the image that is drawn to. */
static void record_inner(uint32_t index)
{
    const VkCommandBufferInheritanceRenderingInfo rendering = {
        .sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_INHERITANCE_RENDERING_INFO,
        .colorAttachmentCount = 1,
        .pColorAttachmentFormats = &w.format,
        .depthAttachmentFormat = DEPTH_FORMAT,
        .rasterizationSamples = (VkSampleCountFlagBits)options.samples};
    const VkCommandBufferInheritanceInfo inheritance = {.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_INHERITANCE_INFO,
                                                        .pNext = options.pass == PASS_DYNAMIC ? &rendering : NULL,
                                                        .renderPass = pass,
                                                        .framebuffer = options.pass == PASS_1 ? framebuffers[index] : VK_NULL_HANDLE};
    const VkCommandBufferBeginInfo begin = {.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO,
                                            .flags = VK_COMMAND_BUFFER_USAGE_RENDER_PASS_CONTINUE_BIT,
                                            .pInheritanceInfo = &inheritance};
    expect(vkBeginCommandBuffer(inner[index], &begin), "vkBeginCommandBuffer");
    draw(inner[index], index);
    expect(vkEndCommandBuffer(inner[index]), "vkEndCommandBuffer");
}

static void record(uint32_t index)
{
    VkCommandBuffer buffer = commands[index];
    const VkCommandBufferBeginInfo begin = {.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO};
    if (options.secondary)
        record_inner(index);
    expect(vkBeginCommandBuffer(buffer, &begin), "vkBeginCommandBuffer");
    if (copies()) {
        const VkBufferCopy region = {0, 0, block_size()};
        const VkMemoryBarrier copied = {.sType = VK_STRUCTURE_TYPE_MEMORY_BARRIER,
                                        .srcAccessMask = VK_ACCESS_TRANSFER_WRITE_BIT,
                                        .dstAccessMask = VK_ACCESS_UNIFORM_READ_BIT | VK_ACCESS_VERTEX_ATTRIBUTE_READ_BIT};
        const VkPipelineStageFlags readers = VK_PIPELINE_STAGE_VERTEX_INPUT_BIT | VK_PIPELINE_STAGE_VERTEX_SHADER_BIT;
        const uint32_t *words = (const uint32_t *)staging[index].bytes;
        if (options.matrix != MATRIX_FILLED)
            vkCmdCopyBuffer(buffer, staging[index].buffer, blocks[index].buffer, 1, &region);
        for (uint32_t at = 0; options.matrix == MATRIX_FILLED && at < block_size(); at += 4)
            vkCmdFillBuffer(buffer, blocks[index].buffer, at, 4, words[at / 4]);
        vkCmdPipelineBarrier(buffer, VK_PIPELINE_STAGE_TRANSFER_BIT, readers, 0, 1, &copied, 0, NULL, 0, NULL);
    }
    if (options.pass == PASS_DYNAMIC)
        record_dynamic(buffer, index);
    else
        record_pass(buffer, index);
    if (options.copy_window) {
        /* Copies the window onto itself, so that the program reads the window. */
        const VkImageLayout general = VK_IMAGE_LAYOUT_GENERAL, shown = VK_IMAGE_LAYOUT_PRESENT_SRC_KHR;
        const VkImageSubresourceLayers layer = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, 1};
        const VkImageCopy region = {layer, {0, 0, 0}, layer, {8, 8, 0}, {4, 4, 1}};
        change_layout(buffer, w.images[index], VK_IMAGE_ASPECT_COLOR_BIT, shown, general);
        vkCmdCopyImage(buffer, w.images[index], general, w.images[index], general, 1, &region);
        change_layout(buffer, w.images[index], VK_IMAGE_ASPECT_COLOR_BIT, general, shown);
    }
    expect(vkEndCommandBuffer(buffer), "vkEndCommandBuffer");
}

/* Everything that depends on the window's size. */
static void follow_size(void)
{
    make_framebuffers();
    make_cube_pipeline();
    for (uint32_t i = 0; i < w.count && options.once; i++)
        record(i);
}

/* A new swapchain, and everything that depends on its size. */
static void follow_window(void)
{
    expect(vkDeviceWaitIdle(w.device), "vkDeviceWaitIdle");
    free_framebuffers();
    free_pipeline(&w, &pipeline);
    free_pipeline(&w, &plain_pipeline);
    free_depth_pass(&w, &first);
    window_make_swapchain(&w);
    follow_size();
}

static void frame(void)
{
    const uint32_t index = next_image(&w, &objects);
    fill_block(index);
    if (!options.once)
        record(index);
    if (!end_frame(&w, &objects, commands[index], index) && options.follow)
        follow_window();
}

static void open_all(void)
{
    w.addresses = has_address();
    w.stages = options.stage != STAGE_VERTEX;
    window_open(&w, options.direction.x, options.direction.y, options.direction.width, options.direction.height, options.srgb,
                options.matrix == MATRIX_PUSHED_SET,
                options.copy_window ? VK_IMAGE_USAGE_TRANSFER_SRC_BIT | VK_IMAGE_USAGE_TRANSFER_DST_BIT : 0);
    if (options.pass != PASS_DYNAMIC)
        pass = make_pass(&w);
    make_layout();
    indirect = make_block(&w, sizeof(VkDrawIndirectCommand), VK_BUFFER_USAGE_INDIRECT_BUFFER_BIT, true);
    *(VkDrawIndirectCommand *)indirect.bytes = (VkDrawIndirectCommand){36, 1, 0, 0};
    objects = make_frame_objects(&w);
    make_commands(&w, &objects, VK_COMMAND_BUFFER_LEVEL_PRIMARY, MOST_IMAGES, commands);
    make_commands(&w, &objects, VK_COMMAND_BUFFER_LEVEL_SECONDARY, MOST_IMAGES, inner);
    follow_size();
}

static void close_all(void)
{
    expect(vkDeviceWaitIdle(w.device), "vkDeviceWaitIdle");
    free_framebuffers();
    free_pipeline(&w, &pipeline);
    free_pipeline(&w, &plain_pipeline);
    free_depth_pass(&w, &first);
    vkDestroyPipelineLayout(w.device, layout, NULL);
    vkDestroyPipelineLayout(w.device, plain_layout, NULL);
    vkDestroyDescriptorPool(w.device, descriptors, NULL);
    vkDestroyDescriptorSetLayout(w.device, set_layout, NULL);
    vkDestroyDescriptorSetLayout(w.device, pushed_layout, NULL);
    vkDestroyRenderPass(w.device, pass, NULL);
    free_frame_objects(&w, &objects);
    for (uint32_t i = 0; i < MOST_IMAGES; i++) {
        free_block(&w, &blocks[i]);
        free_block(&w, &staging[i]);
    }
    free_block(&w, &indirect);
    window_close(&w);
}

int main(int argc, char **argv)
{
    parse(argc, argv);
    open_all();
    for (int number = 0; options.direction.frames == 0 || number < options.direction.frames; number += frame_counts()) {
        if (options.resizes > 0 && number > 0 && number % (options.direction.frames / (options.resizes + 1)) == 0) {
            const uint32_t odd = (uint32_t)(number % 2 == 0 ? 0 : 31);
            expect(vkDeviceWaitIdle(w.device), "vkDeviceWaitIdle");
            window_ask_size(&w, options.direction.width + odd + (uint32_t)(number % 7), options.direction.height + odd);
            follow_window();
            if (options.memory != NULL)
                write_memory(options.memory, getpid());
        }
        frame();
    }
    if (options.direction.shot != NULL)
        window_shot(&w, options.direction.shot);
    close_all();
    return 0;
}
