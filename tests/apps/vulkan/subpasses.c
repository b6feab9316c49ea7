/*
 * The direction test's cube in a render pass of two subpasses (--way). With `input` the first
 * subpass draws the cube off screen. The second reads it at the same pixel and shows it by a
 * triangle over the whole window. With `second` the first draws only off screen, and the second
 * draws the cube to the window.
 */
#include "direction.h"
#include "frames.h"
#include "pipelines.h"

/* Compiled by glslangValidator. */
#include "cube_frag.h"
#include "cube_push.h"
#include "input_frag.h"
#include "screen_vert.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static struct {
    direction_options direction;
    bool input;
} options = {.direction = DIRECTION_DEFAULTS};

static vulkan_window w;
static picture depth, scene;
static VkRenderPass pass;
static VkFramebuffer framebuffers[MOST_IMAGES];
static VkDescriptorSetLayout set_layout;
static VkDescriptorPool descriptors;
static VkDescriptorSet set;
static VkPipelineLayout cube_layout, show_layout;
static linked_pipeline cube, show;
static frame_objects objects;
static VkCommandBuffer commands;

static void parse(int argc, char **argv)
{
    for (int i = 1; i + 1 < argc; i += 2)
        if (strcmp(argv[i], "--way") == 0)
            options.input = strcmp(argv[i + 1], "input") == 0;
        else if (!take_direction(&options.direction, argv[i], argv[i + 1])) {
            fprintf(stderr, "usage: vk_subpasses " DIRECTION_USAGE " [--way input|second]\n");
            exit(2);
        }
}

static VkAttachmentDescription attachment(VkFormat format, VkImageLayout left)
{
    return (VkAttachmentDescription){.format = format,
                                     .samples = VK_SAMPLE_COUNT_1_BIT,
                                     .loadOp = VK_ATTACHMENT_LOAD_OP_CLEAR,
                                     .storeOp = VK_ATTACHMENT_STORE_OP_STORE,
                                     .stencilLoadOp = VK_ATTACHMENT_LOAD_OP_DONT_CARE,
                                     .stencilStoreOp = VK_ATTACHMENT_STORE_OP_DONT_CARE,
                                     .finalLayout = left};
}

static void make_pass(void)
{
    const VkImageLayout color = VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL, read = VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL;
    const VkImageLayout deep = VK_IMAGE_LAYOUT_DEPTH_STENCIL_ATTACHMENT_OPTIMAL;
    const VkAttachmentDescription all[] = {attachment(w.format, VK_IMAGE_LAYOUT_PRESENT_SRC_KHR),
                                           attachment(w.format, options.input ? read : color),
                                           attachment(DEPTH_FORMAT, deep)};
    const VkAttachmentReference window = {0, color}, drawn = {1, color}, depths = {2, deep}, shown = {1, read};
    const VkSubpassDescription subpasses[] = {
        {.colorAttachmentCount = 1, .pColorAttachments = &drawn, .pDepthStencilAttachment = options.input ? &depths : NULL},
        {.colorAttachmentCount = 1,
         .pColorAttachments = &window,
         .inputAttachmentCount = options.input ? 1 : 0,
         .pInputAttachments = &shown,
         .pDepthStencilAttachment = options.input ? NULL : &depths}};
    const VkPipelineStageFlags stages = VK_PIPELINE_STAGE_ALL_GRAPHICS_BIT;
    const VkAccessFlags access = VK_ACCESS_MEMORY_READ_BIT | VK_ACCESS_MEMORY_WRITE_BIT;
    const VkSubpassDependency between[] = {{VK_SUBPASS_EXTERNAL, 0, stages, stages, access, access, 0},
                                           {VK_SUBPASS_EXTERNAL, 1, stages, stages, access, access, 0},
                                           {0, 1, stages, stages, access, access, VK_DEPENDENCY_BY_REGION_BIT}};
    const VkRenderPassCreateInfo info = {.sType = VK_STRUCTURE_TYPE_RENDER_PASS_CREATE_INFO,
                                         .attachmentCount = 3,
                                         .pAttachments = all,
                                         .subpassCount = 2,
                                         .pSubpasses = subpasses,
                                         .dependencyCount = 3,
                                         .pDependencies = between};
    expect(vkCreateRenderPass(w.device, &info, NULL, &pass), "vkCreateRenderPass");
    for (uint32_t i = 0; i < w.count; i++) {
        const VkImageView views[] = {w.views[i], scene.view, depth.view};
        const VkFramebufferCreateInfo target = {.sType = VK_STRUCTURE_TYPE_FRAMEBUFFER_CREATE_INFO,
                                                .renderPass = pass,
                                                .attachmentCount = 3,
                                                .pAttachments = views,
                                                .width = w.extent.width,
                                                .height = w.extent.height,
                                                .layers = 1};
        expect(vkCreateFramebuffer(w.device, &target, NULL, &framebuffers[i]), "vkCreateFramebuffer");
    }
}

static void make_layouts(void)
{
    make_one_descriptor(&w, VK_DESCRIPTOR_TYPE_INPUT_ATTACHMENT, &set_layout, &descriptors, &set);
    const VkDescriptorImageInfo image = {VK_NULL_HANDLE, scene.view, VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL};
    const VkWriteDescriptorSet write = {.sType = VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET,
                                        .dstSet = set,
                                        .descriptorCount = 1,
                                        .descriptorType = VK_DESCRIPTOR_TYPE_INPUT_ATTACHMENT,
                                        .pImageInfo = &image};
    vkUpdateDescriptorSets(w.device, options.input ? 1 : 0, &write, 0, NULL);
    const VkPushConstantRange range = {VK_SHADER_STAGE_VERTEX_BIT, 0, sizeof(matrix4)};
    VkPipelineLayoutCreateInfo info = {.sType = VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO,
                                       .pushConstantRangeCount = 1,
                                       .pPushConstantRanges = &range};
    expect(vkCreatePipelineLayout(w.device, &info, NULL, &cube_layout), "vkCreatePipelineLayout");
    info.pushConstantRangeCount = 0;
    info.setLayoutCount = 1;
    info.pSetLayouts = &set_layout;
    expect(vkCreatePipelineLayout(w.device, &info, NULL, &show_layout), "vkCreatePipelineLayout");
}

static void open_all(void)
{
    window_open(&w, options.direction.x, options.direction.y, options.direction.width, options.direction.height, false, false,
                0);
    const VkImageUsageFlags read = VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT | VK_IMAGE_USAGE_INPUT_ATTACHMENT_BIT;
    scene = make_picture(&w, w.format, w.extent, VK_SAMPLE_COUNT_1_BIT, read);
    depth = make_picture(&w, DEPTH_FORMAT, w.extent, VK_SAMPLE_COUNT_1_BIT, VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT);
    make_pass();
    make_layouts();
    const pipeline_description parts = {.vertex = SHADER(cube_push),
                                        .fragment = SHADER(cube_frag),
                                        .layout = cube_layout,
                                        .pass = pass,
                                        .subpass = options.input ? 0 : 1,
                                        .samples = VK_SAMPLE_COUNT_1_BIT,
                                        .deep = true};
    cube = make_pipeline(&w, &parts);
    const pipeline_description shows = {.vertex = SHADER(screen_vert),
                                        .fragment = SHADER(input_frag),
                                        .layout = show_layout,
                                        .pass = pass,
                                        .subpass = 1,
                                        .samples = VK_SAMPLE_COUNT_1_BIT};
    if (options.input)
        show = make_pipeline(&w, &shows);
    objects = make_frame_objects(&w);
    make_commands(&w, &objects, VK_COMMAND_BUFFER_LEVEL_PRIMARY, 1, &commands);
}

static void draw_cube(void)
{
    const matrix4 matrix = direction_matrix(&options.direction, w.extent, false);
    vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, cube.whole);
    vkCmdPushConstants(commands, cube_layout, VK_SHADER_STAGE_VERTEX_BIT, 0, sizeof matrix, &matrix);
    vkCmdDraw(commands, 36, 1, 0, 0);
}

static void record(uint32_t index)
{
    const VkCommandBufferBeginInfo info = {.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO};
    const VkClearValue grey = {.color = {.float32 = {0.25f, 0.25f, 0.25f, 1.0f}}}, far = {.depthStencil = {1.0f, 0}};
    const VkClearValue clears[] = {grey, grey, far};
    const VkRenderPassBeginInfo begin = {.sType = VK_STRUCTURE_TYPE_RENDER_PASS_BEGIN_INFO,
                                         .renderPass = pass,
                                         .framebuffer = framebuffers[index],
                                         .renderArea = {{0, 0}, w.extent},
                                         .clearValueCount = 3,
                                         .pClearValues = clears};
    const VkViewport viewport = {0, 0, (float)w.extent.width, (float)w.extent.height, 0, 1};
    const VkRect2D scissor = {{0, 0}, w.extent};
    expect(vkBeginCommandBuffer(commands, &info), "vkBeginCommandBuffer");
    vkCmdSetViewport(commands, 0, 1, &viewport);
    vkCmdSetScissor(commands, 0, 1, &scissor);
    vkCmdBeginRenderPass(commands, &begin, VK_SUBPASS_CONTENTS_INLINE);
    if (options.input)
        draw_cube();
    vkCmdNextSubpass(commands, VK_SUBPASS_CONTENTS_INLINE);
    if (options.input) {
        vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, show.whole);
        vkCmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, show_layout, 0, 1, &set, 0, NULL);
        vkCmdDraw(commands, 3, 1, 0, 0);
    } else
        draw_cube();
    vkCmdEndRenderPass(commands);
    expect(vkEndCommandBuffer(commands), "vkEndCommandBuffer");
}

static void close_all(void)
{
    expect(vkDeviceWaitIdle(w.device), "vkDeviceWaitIdle");
    for (uint32_t i = 0; i < w.count; i++)
        vkDestroyFramebuffer(w.device, framebuffers[i], NULL);
    free_pipeline(&w, &cube);
    free_pipeline(&w, &show);
    vkDestroyPipelineLayout(w.device, cube_layout, NULL);
    vkDestroyPipelineLayout(w.device, show_layout, NULL);
    vkDestroyDescriptorPool(w.device, descriptors, NULL);
    vkDestroyDescriptorSetLayout(w.device, set_layout, NULL);
    vkDestroyRenderPass(w.device, pass, NULL);
    free_frame_objects(&w, &objects);
    free_picture(&w, &scene);
    free_picture(&w, &depth);
    window_close(&w);
}

int main(int argc, char **argv)
{
    parse(argc, argv);
    open_all();
    run_frames(&w, &objects, commands, options.direction.frames, options.direction.shot, record);
    close_all();
    return 0;
}
