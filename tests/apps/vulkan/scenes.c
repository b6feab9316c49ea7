/*
 * The direction test's cube on its way to the window (--way): drawn to it and read back (read), with a part that is drawn
 * or cleared by a pass of its own (part, clear), or drawn off screen and then shown by a triangle that samples it (post),
 * by two of them (chain), by place (place), by a blit (blit) or a resolve (resolve). Or with the newest of what there is to
 * present (newest), a pipeline that is linked (library), a pass with a mask of views (multiview). --picture writes what was
 * read.
 */
#include "../common/matrix.h"
#include "window.h"

/* Compiled by glslangValidator. */
#include "cube_frag.h"
#include "cube_push.h"
#include "screen_frag.h"
#include "screen_place.h"
#include "screen_vert.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef enum { READ, PART, CLEAR, NEWEST, LIBRARY, MULTIVIEW, POST, CHAIN, PLACE, BLIT, RESOLVE, PASSES, WAYS } way_kind;
static const char *const ways[WAYS] = {"read", "part", "clear", "newest", "library", "multiview",
                                       "post", "chain", "place", "blit", "resolve", "passes"};

static struct {
    double fov, yaw, pitch;
    int frames, x, y;
    uint32_t width, height;
    way_kind way;
    const char *shot, *picture;
} options = {.fov = 75.0, .frames = 3, .width = 256, .height = 256};

static vulkan_window w;
static picture depth, samples, scenes[2];
static VkDescriptorSetLayout set_layout;
static VkDescriptorPool descriptors;
static VkDescriptorSet sets[2];
static VkSampler sampler;
static VkRenderPass pass;
static VkFramebuffer framebuffer;
static VkPipelineLayout cube_layout, screen_layout;
static VkPipeline cube, screen, parts_of[2];
static VkCommandPool pool;
static VkCommandBuffer commands;
static VkSemaphore acquired, timeline;
static VkFence done;
static block read_back;

static void usage(void)
{
    fprintf(stderr, "usage: vk_scenes [--fov DEG] [--yaw DEG] [--pitch DEG] [--frames N] [--size WxH] [--at X,Y]\n"
                    "  [--way read|part|clear|newest|library|multiview|post|chain|place|blit|resolve|passes]\n"
                    "  [--shot FILE.ppm] [--picture FILE.ppm]\n");
    exit(2);
}

static void parse(int argc, char **argv)
{
    for (int i = 1; i + 1 < argc; i += 2) {
        const char *option = argv[i], *value = argv[i + 1];
        if (strcmp(option, "--fov") == 0)
            options.fov = atof(value);
        else if (strcmp(option, "--yaw") == 0)
            options.yaw = atof(value);
        else if (strcmp(option, "--pitch") == 0)
            options.pitch = atof(value);
        else if (strcmp(option, "--frames") == 0)
            options.frames = atoi(value);
        else if (strcmp(option, "--shot") == 0)
            options.shot = value;
        else if (strcmp(option, "--picture") == 0)
            options.picture = value;
        else if (strcmp(option, "--at") == 0 && sscanf(value, "%d,%d", &options.x, &options.y) == 2)
            continue;
        else if (strcmp(option, "--size") == 0 && sscanf(value, "%ux%u", &options.width, &options.height) == 2)
            continue;
        else if (strcmp(option, "--way") == 0) {
            options.way = READ;
            while (options.way < WAYS && strcmp(ways[options.way], value) != 0)
                options.way++;
            if (options.way == WAYS)
                usage();
        } else
            usage();
    }
}

static bool off_screen(void)
{
    return options.way >= POST;
}

static VkSampleCountFlagBits count(void)
{
    return options.way == RESOLVE ? VK_SAMPLE_COUNT_4_BIT : VK_SAMPLE_COUNT_1_BIT;
}

static VkPipeline make_pipeline(VkPipelineLayout layout, const uint32_t *vertex, size_t vertex_size,
                                const uint32_t *fragment, size_t fragment_size, bool deep)
{
    const uint32_t *const words[] = {vertex, fragment};
    const size_t sizes[] = {vertex_size, fragment_size};
    const VkShaderStageFlagBits kinds[] = {VK_SHADER_STAGE_VERTEX_BIT, VK_SHADER_STAGE_FRAGMENT_BIT};
    VkPipelineShaderStageCreateInfo stages[2];
    for (int i = 0; i < 2; i++) {
        const VkShaderModuleCreateInfo info = {
            .sType = VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO, .codeSize = sizes[i], .pCode = words[i]};
        stages[i] = (VkPipelineShaderStageCreateInfo){.sType = VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO,
                                                      .stage = kinds[i],
                                                      .pName = "main"};
        expect(vkCreateShaderModule(w.device, &info, NULL, &stages[i].module), "vkCreateShaderModule");
    }
    const VkPipelineVertexInputStateCreateInfo input = {
        .sType = VK_STRUCTURE_TYPE_PIPELINE_VERTEX_INPUT_STATE_CREATE_INFO};
    const VkPipelineInputAssemblyStateCreateInfo assembly = {
        .sType = VK_STRUCTURE_TYPE_PIPELINE_INPUT_ASSEMBLY_STATE_CREATE_INFO,
        .topology = VK_PRIMITIVE_TOPOLOGY_TRIANGLE_LIST};
    const VkPipelineViewportStateCreateInfo windows = {
        .sType = VK_STRUCTURE_TYPE_PIPELINE_VIEWPORT_STATE_CREATE_INFO, .viewportCount = 1, .scissorCount = 1};
    const VkPipelineRasterizationStateCreateInfo raster = {
        .sType = VK_STRUCTURE_TYPE_PIPELINE_RASTERIZATION_STATE_CREATE_INFO, .lineWidth = 1.0f};
    const VkPipelineMultisampleStateCreateInfo multisample = {
        .sType = VK_STRUCTURE_TYPE_PIPELINE_MULTISAMPLE_STATE_CREATE_INFO,
        .rasterizationSamples = deep ? count() : VK_SAMPLE_COUNT_1_BIT};
    const VkPipelineDepthStencilStateCreateInfo depths = {
        .sType = VK_STRUCTURE_TYPE_PIPELINE_DEPTH_STENCIL_STATE_CREATE_INFO,
        .depthTestEnable = deep,
        .depthWriteEnable = deep,
        .depthCompareOp = VK_COMPARE_OP_LESS_OR_EQUAL};
    const VkPipelineColorBlendAttachmentState blend = {.colorWriteMask = 0xf};
    const VkPipelineColorBlendStateCreateInfo blends = {
        .sType = VK_STRUCTURE_TYPE_PIPELINE_COLOR_BLEND_STATE_CREATE_INFO, .attachmentCount = 1, .pAttachments = &blend};
    const VkDynamicState states[] = {VK_DYNAMIC_STATE_VIEWPORT, VK_DYNAMIC_STATE_SCISSOR};
    const VkPipelineDynamicStateCreateInfo dynamic = {
        .sType = VK_STRUCTURE_TYPE_PIPELINE_DYNAMIC_STATE_CREATE_INFO, .dynamicStateCount = 2, .pDynamicStates = states};
    const VkPipelineRenderingCreateInfo rendering = {
        .sType = VK_STRUCTURE_TYPE_PIPELINE_RENDERING_CREATE_INFO,
        .viewMask = options.way == MULTIVIEW,
        .colorAttachmentCount = 1,
        .pColorAttachmentFormats = &w.format,
        .depthAttachmentFormat = deep ? DEPTH_FORMAT : VK_FORMAT_UNDEFINED};
    const bool by_pass = deep && pass != VK_NULL_HANDLE;
    VkGraphicsPipelineLibraryCreateInfoEXT parts = {
        .sType = VK_STRUCTURE_TYPE_GRAPHICS_PIPELINE_LIBRARY_CREATE_INFO_EXT,
        .flags = VK_GRAPHICS_PIPELINE_LIBRARY_VERTEX_INPUT_INTERFACE_BIT_EXT |
                 VK_GRAPHICS_PIPELINE_LIBRARY_PRE_RASTERIZATION_SHADERS_BIT_EXT |
                 VK_GRAPHICS_PIPELINE_LIBRARY_FRAGMENT_SHADER_BIT_EXT};
    const bool linked = options.way == LIBRARY && w.has.libraries;
    const VkGraphicsPipelineCreateInfo info = {.sType = VK_STRUCTURE_TYPE_GRAPHICS_PIPELINE_CREATE_INFO,
                                               .pNext = by_pass ? NULL : linked ? (const void *)&parts : &rendering,
                                               .flags = linked ? VK_PIPELINE_CREATE_LIBRARY_BIT_KHR : 0,
                                               .stageCount = 2,
                                               .pStages = stages,
                                               .pVertexInputState = &input,
                                               .pInputAssemblyState = &assembly,
                                               .pViewportState = &windows,
                                               .pRasterizationState = &raster,
                                               .pMultisampleState = &multisample,
                                               .pDepthStencilState = &depths,
                                               .pColorBlendState = &blends,
                                               .pDynamicState = &dynamic,
                                               .layout = layout,
                                               .renderPass = by_pass ? pass : VK_NULL_HANDLE};
    VkPipeline made;
    expect(vkCreateGraphicsPipelines(w.device, VK_NULL_HANDLE, 1, &info, NULL, &made), "vkCreateGraphicsPipelines");
    for (int i = 0; i < 2; i++)
        vkDestroyShaderModule(w.device, stages[i].module, NULL);
    if (linked) {
        parts.pNext = (void *)&rendering;
        parts.flags = VK_GRAPHICS_PIPELINE_LIBRARY_FRAGMENT_OUTPUT_INTERFACE_BIT_EXT;
        const VkPipelineLibraryCreateInfoKHR library = {.sType = VK_STRUCTURE_TYPE_PIPELINE_LIBRARY_CREATE_INFO_KHR,
                                                        .pNext = &parts,
                                                        .libraryCount = 1,
                                                        .pLibraries = &made};
        const VkGraphicsPipelineCreateInfo whole = {.sType = VK_STRUCTURE_TYPE_GRAPHICS_PIPELINE_CREATE_INFO,
                                                    .pNext = &library,
                                                    .pMultisampleState = &multisample,
                                                    .pColorBlendState = &blends,
                                                    .layout = layout};
        parts_of[deep] = made;
        expect(vkCreateGraphicsPipelines(w.device, VK_NULL_HANDLE, 1, &whole, NULL, &made), "vkCreateGraphicsPipelines");
    }
    return made;
}

/* A pass that leaves its picture as shaders sample it, which is believed before the next one begins. */
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
    depth = make_picture(&w, DEPTH_FORMAT, count(), VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT);
    samples = make_picture(&w, w.format, VK_SAMPLE_COUNT_4_BIT, copied);
    for (int i = 0; i < 2; i++)
        scenes[i] = make_picture(&w, w.format, VK_SAMPLE_COUNT_1_BIT, shown | copied);
    if (options.way == PASSES)
        make_pass();
    read_back = make_block(&w, 4 * w.extent.width * w.extent.height, VK_BUFFER_USAGE_TRANSFER_DST_BIT, true);
}

static void make_layouts(void)
{
    const VkDescriptorSetLayoutBinding binding = {0, VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER, 1,
                                                  VK_SHADER_STAGE_FRAGMENT_BIT, NULL};
    const VkDescriptorSetLayoutCreateInfo set = {
        .sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO, .bindingCount = 1, .pBindings = &binding};
    expect(vkCreateDescriptorSetLayout(w.device, &set, NULL, &set_layout), "vkCreateDescriptorSetLayout");
    const VkDescriptorPoolSize size = {VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER, 2};
    const VkDescriptorPoolCreateInfo info = {
        .sType = VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO, .maxSets = 2, .poolSizeCount = 1, .pPoolSizes = &size};
    expect(vkCreateDescriptorPool(w.device, &info, NULL, &descriptors), "vkCreateDescriptorPool");
    const VkSamplerCreateInfo filter = {.sType = VK_STRUCTURE_TYPE_SAMPLER_CREATE_INFO,
                                        .magFilter = VK_FILTER_LINEAR,
                                        .minFilter = VK_FILTER_LINEAR,
                                        .addressModeU = VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_EDGE,
                                        .addressModeV = VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_EDGE};
    expect(vkCreateSampler(w.device, &filter, NULL, &sampler), "vkCreateSampler");
    for (int i = 0; i < 2; i++) {
        const VkDescriptorSetAllocateInfo allocate = {.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_ALLOCATE_INFO,
                                                      .descriptorPool = descriptors,
                                                      .descriptorSetCount = 1,
                                                      .pSetLayouts = &set_layout};
        expect(vkAllocateDescriptorSets(w.device, &allocate, &sets[i]), "vkAllocateDescriptorSets");
        const VkDescriptorImageInfo image = {sampler, scenes[i].view, VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL};
        const VkWriteDescriptorSet write = {.sType = VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET,
                                            .dstSet = sets[i],
                                            .descriptorCount = 1,
                                            .descriptorType = VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER,
                                            .pImageInfo = &image};
        vkUpdateDescriptorSets(w.device, 1, &write, 0, NULL);
    }
    const VkPushConstantRange range = {VK_SHADER_STAGE_VERTEX_BIT, 0, sizeof(matrix4)};
    VkPipelineLayoutCreateInfo layout = {.sType = VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO,
                                         .pushConstantRangeCount = 1,
                                         .pPushConstantRanges = &range};
    expect(vkCreatePipelineLayout(w.device, &layout, NULL, &cube_layout), "vkCreatePipelineLayout");
    layout.pushConstantRangeCount = 0;
    layout.setLayoutCount = 1;
    layout.pSetLayouts = &set_layout;
    expect(vkCreatePipelineLayout(w.device, &layout, NULL, &screen_layout), "vkCreatePipelineLayout");
}

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
static const VkImageLayout SHOWN = VK_IMAGE_LAYOUT_PRESENT_SRC_KHR;
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

static matrix4 scene_matrix(void)
{
    const double aspect = (double)w.extent.width / w.extent.height;
    matrix4 camera = matrix_multiply(matrix_camera(options.yaw, options.pitch), matrix_scale(10.0));
    matrix4 all = matrix_multiply(matrix_perspective(options.fov, aspect, 0.25, 100.0), camera);
    /* From OpenGL's clip space: y points down, and depth begins at 0. */
    for (float *c = all.m; c < all.m + 16; c += 4) {
        c[1] = -c[1];
        c[2] = 0.5f * (c[2] + c[3]);
    }
    return all;
}

static void set_window(void)
{
    const VkViewport viewport = {0, 0, (float)w.extent.width, (float)w.extent.height, 0, 1};
    const VkRect2D scissor = {{0, 0}, w.extent};
    vkCmdSetViewport(commands, 0, 1, &viewport);
    vkCmdSetScissor(commands, 0, 1, &scissor);
}

static void draw_cube(matrix4 matrix)
{
    vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, cube);
    set_window();
    vkCmdPushConstants(commands, cube_layout, VK_SHADER_STAGE_VERTEX_BIT, 0, sizeof matrix, &matrix);
    vkCmdDraw(commands, 36, 1, 0, 0);
}

static void draw_screen(VkDescriptorSet set)
{
    vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, screen);
    set_window();
    vkCmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, screen_layout, 0, 1, &set, 0, NULL);
    vkCmdDraw(commands, 3, 1, 0, 0);
}

/* The cube in a pass that clears: to the window, or off screen. */
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
        draw_cube(scene_matrix());
        vkCmdEndRenderPass(commands);
        return;
    }
    barrier(target != NULL ? target->image : image, NEW, COLOR);
    barrier(depth.image, NEW, DEEP);
    begin(target != NULL ? target->view : view, true, VK_ATTACHMENT_LOAD_OP_CLEAR, whole);
    draw_cube(scene_matrix());
    vkCmdEndRendering(commands);
}

static void show(VkDescriptorSet set, VkImage image, VkImageView view)
{
    barrier(image, NEW, COLOR);
    begin(view, false, VK_ATTACHMENT_LOAD_OP_DONT_CARE, (VkRect2D){{0, 0}, w.extent});
    draw_screen(set);
    vkCmdEndRendering(commands);
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
    VkImageLayout left = COLOR;
    if (options.way == PART || options.way == CLEAR) {
        begin(view, true, options.way == PART ? VK_ATTACHMENT_LOAD_OP_LOAD : VK_ATTACHMENT_LOAD_OP_CLEAR, part);
        if (options.way == PART)
            draw_cube((matrix4){{0.125f, 0, 0, 0, 0, 0.125f, 0, 0, 0, 0, 0, 0, -0.625f, -0.625f, 0, 1}});
        vkCmdEndRendering(commands);
    } else if (options.way == READ) {
        const VkBufferImageCopy region = {.imageSubresource = layer, .imageExtent = size};
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
        if (options.way != PASSES)
            barrier(scenes[0].image, COLOR, SAMPLED);
        if (options.way == CHAIN) {
            show(sets[0], scenes[1].image, scenes[1].view);
            barrier(scenes[1].image, COLOR, SAMPLED);
        }
        show(sets[options.way == CHAIN], image, view);
    }
    barrier(image, left, SHOWN);
    expect(vkEndCommandBuffer(commands), "vkEndCommandBuffer");
}

/* Submits by the newer call, waits for a timeline, says what changed in the window, and which frame it is. */
static void end_newest_frame(uint32_t index, uint64_t number)
{
    const VkSemaphoreSubmitInfo before = {.sType = VK_STRUCTURE_TYPE_SEMAPHORE_SUBMIT_INFO,
                                          .semaphore = acquired,
                                          .stageMask = VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT};
    VkSemaphoreSubmitInfo after[] = {before, before};
    after[0].semaphore = w.drawn[index];
    after[1].semaphore = timeline;
    after[1].value = number;
    const VkCommandBufferSubmitInfo buffer = {.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_SUBMIT_INFO,
                                              .commandBuffer = commands};
    const VkSubmitInfo2 work = {.sType = VK_STRUCTURE_TYPE_SUBMIT_INFO_2,
                                .waitSemaphoreInfoCount = 1,
                                .pWaitSemaphoreInfos = &before,
                                .commandBufferInfoCount = 1,
                                .pCommandBufferInfos = &buffer,
                                .signalSemaphoreInfoCount = 2,
                                .pSignalSemaphoreInfos = after};
    expect(vkQueueSubmit2(w.queue, 1, &work, VK_NULL_HANDLE), "vkQueueSubmit2");
    const VkRectLayerKHR all = {{0, 0}, w.extent, 0};
    const VkPresentRegionKHR region = {1, &all};
    const VkPresentRegionsKHR regions = {
        .sType = VK_STRUCTURE_TYPE_PRESENT_REGIONS_KHR, .swapchainCount = 1, .pRegions = &region};
    const VkPresentIdKHR id = {.sType = VK_STRUCTURE_TYPE_PRESENT_ID_KHR,
                               .pNext = w.has.incremental_present ? &regions : NULL,
                               .swapchainCount = 1,
                               .pPresentIds = &number};
    const VkPresentInfoKHR present = {.sType = VK_STRUCTURE_TYPE_PRESENT_INFO_KHR,
                                      .pNext = w.has.present_id ? &id : id.pNext,
                                      .waitSemaphoreCount = 1,
                                      .pWaitSemaphores = &w.drawn[index],
                                      .swapchainCount = 1,
                                      .pSwapchains = &w.swapchain,
                                      .pImageIndices = &index};
    expect(vkQueuePresentKHR(w.queue, &present), "vkQueuePresentKHR");
    const VkSemaphoreWaitInfo wait = {
        .sType = VK_STRUCTURE_TYPE_SEMAPHORE_WAIT_INFO, .semaphoreCount = 1, .pSemaphores = &timeline, .pValues = &number};
    expect(vkWaitSemaphores(w.device, &wait, UINT64_MAX), "vkWaitSemaphores");
    PFN_vkWaitForPresentKHR shown = (PFN_vkWaitForPresentKHR)vkGetDeviceProcAddr(w.device, "vkWaitForPresentKHR");
    if (w.has.present_wait && shown != NULL)
        expect(shown(w.device, w.swapchain, number, UINT64_MAX), "vkWaitForPresentKHR");
}

static void frame(uint64_t number)
{
    uint32_t index;
    expect(vkAcquireNextImageKHR(w.device, w.swapchain, UINT64_MAX, acquired, VK_NULL_HANDLE, &index), "acquire");
    record(index);
    if (options.way == NEWEST) {
        end_newest_frame(index, number);
        return;
    }
    const VkPipelineStageFlags stage = VK_PIPELINE_STAGE_ALL_COMMANDS_BIT;
    const VkSubmitInfo work = {.sType = VK_STRUCTURE_TYPE_SUBMIT_INFO,
                               .waitSemaphoreCount = 1,
                               .pWaitSemaphores = &acquired,
                               .pWaitDstStageMask = &stage,
                               .commandBufferCount = 1,
                               .pCommandBuffers = &commands,
                               .signalSemaphoreCount = 1,
                               .pSignalSemaphores = &w.drawn[index]};
    expect(vkQueueSubmit(w.queue, 1, &work, done), "vkQueueSubmit");
    const VkPresentInfoKHR present = {.sType = VK_STRUCTURE_TYPE_PRESENT_INFO_KHR,
                                      .waitSemaphoreCount = 1,
                                      .pWaitSemaphores = &w.drawn[index],
                                      .swapchainCount = 1,
                                      .pSwapchains = &w.swapchain,
                                      .pImageIndices = &index};
    expect(vkQueuePresentKHR(w.queue, &present), "vkQueuePresentKHR");
    expect(vkWaitForFences(w.device, 1, &done, VK_TRUE, UINT64_MAX), "vkWaitForFences");
    expect(vkResetFences(w.device, 1, &done), "vkResetFences");
}

static void write_picture(const char *path)
{
    FILE *file = fopen(path, "wb");
    if (file == NULL) {
        fprintf(stderr, "cannot write %s\n", path);
        exit(1);
    }
    fprintf(file, "P6\n%u %u\n255\n", w.extent.width, w.extent.height);
    const unsigned char *bytes = read_back.bytes;
    for (uint32_t i = 0; i < w.extent.width * w.extent.height; i++, bytes += 4)
        fwrite((unsigned char[]){bytes[2], bytes[1], bytes[0]}, 1, 3, file);
    fclose(file);
}

static void open_all(void)
{
    const VkImageUsageFlags copied = VK_IMAGE_USAGE_TRANSFER_DST_BIT;
    window_open(&w, options.x, options.y, options.width, options.height, false,
                options.way == NEWEST || options.way == LIBRARY || options.way == MULTIVIEW,
                options.way == READ ? VK_IMAGE_USAGE_TRANSFER_SRC_BIT : off_screen() ? copied : 0);
    make_pictures();
    make_layouts();
    cube = make_pipeline(cube_layout, cube_push, sizeof cube_push, cube_frag, sizeof cube_frag, true);
    const bool place = options.way == PLACE;
    screen = make_pipeline(screen_layout, screen_vert, sizeof screen_vert, place ? screen_place : screen_frag,
                           place ? sizeof screen_place : sizeof screen_frag, false);
    const VkCommandPoolCreateInfo pool_info = {.sType = VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO,
                                               .flags = VK_COMMAND_POOL_CREATE_RESET_COMMAND_BUFFER_BIT,
                                               .queueFamilyIndex = w.family};
    expect(vkCreateCommandPool(w.device, &pool_info, NULL, &pool), "vkCreateCommandPool");
    const VkCommandBufferAllocateInfo buffers = {.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO,
                                                 .commandPool = pool,
                                                 .level = VK_COMMAND_BUFFER_LEVEL_PRIMARY,
                                                 .commandBufferCount = 1};
    expect(vkAllocateCommandBuffers(w.device, &buffers, &commands), "vkAllocateCommandBuffers");
    const VkSemaphoreCreateInfo semaphore = {.sType = VK_STRUCTURE_TYPE_SEMAPHORE_CREATE_INFO};
    const VkSemaphoreTypeCreateInfo counts = {.sType = VK_STRUCTURE_TYPE_SEMAPHORE_TYPE_CREATE_INFO,
                                              .semaphoreType = VK_SEMAPHORE_TYPE_TIMELINE};
    const VkSemaphoreCreateInfo counting = {.sType = VK_STRUCTURE_TYPE_SEMAPHORE_CREATE_INFO, .pNext = &counts};
    if (options.way == NEWEST)
        expect(vkCreateSemaphore(w.device, &counting, NULL, &timeline), "vkCreateSemaphore");
    const VkFenceCreateInfo fence = {.sType = VK_STRUCTURE_TYPE_FENCE_CREATE_INFO};
    expect(vkCreateSemaphore(w.device, &semaphore, NULL, &acquired), "vkCreateSemaphore");
    expect(vkCreateFence(w.device, &fence, NULL, &done), "vkCreateFence");
}

static void close_all(void)
{
    expect(vkDeviceWaitIdle(w.device), "vkDeviceWaitIdle");
    vkDestroyFramebuffer(w.device, framebuffer, NULL);
    vkDestroyRenderPass(w.device, pass, NULL);
    vkDestroyPipeline(w.device, cube, NULL);
    vkDestroyPipeline(w.device, screen, NULL);
    vkDestroyPipelineLayout(w.device, cube_layout, NULL);
    vkDestroyPipelineLayout(w.device, screen_layout, NULL);
    vkDestroyDescriptorPool(w.device, descriptors, NULL);
    vkDestroyDescriptorSetLayout(w.device, set_layout, NULL);
    vkDestroySampler(w.device, sampler, NULL);
    vkDestroyCommandPool(w.device, pool, NULL);
    vkDestroySemaphore(w.device, acquired, NULL);
    vkDestroySemaphore(w.device, timeline, NULL);
    vkDestroyFence(w.device, done, NULL);
    free_picture(&w, &depth);
    free_picture(&w, &samples);
    for (int i = 0; i < 2; i++) {
        vkDestroyPipeline(w.device, parts_of[i], NULL);
        free_picture(&w, &scenes[i]);
    }
    free_block(&w, &read_back);
    window_close(&w);
}

int main(int argc, char **argv)
{
    parse(argc, argv);
    open_all();
    for (int number = 0; number < options.frames; number++) {
        frame((uint64_t)number + 1);
        if (options.shot != NULL)
            window_shot(&w, options.shot);
    }
    if (options.picture != NULL)
        write_picture(options.picture);
    close_all();
    return 0;
}
