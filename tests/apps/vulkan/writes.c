/*
 * The direction test's cube. Its shaders count vertices and fragments in a buffer and an image.
 * --answers FILE: writes the counts there, a name and a number in each line. --flat: the cube is
 * drawn without perspective. --libraries N: the pipeline is linked from libraries. --again: a new
 * swapchain is made after the pipeline.
 */
#include "direction.h"
#include "frames.h"
#include "pipelines.h"

/* Compiled by glslangValidator. */
#include "writes_frag.h"
#include "writes_vert.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { VERTICES = 36, SIDE = 4 };

typedef struct {
    uint32_t vertices, fragments, places[VERTICES];
} counters;

static struct {
    direction_options direction;
    const char *answers;
    bool flat, again;
    uint32_t libraries;
} options = {.direction = DIRECTION_DEFAULTS};

static vulkan_window w;
static VkDescriptorSetLayout set_layout;
static VkDescriptorPool pool;
static VkDescriptorSet set;
static VkPipelineLayout layout;
static linked_pipeline cube;
static block counts, texels;
static picture sums;
static frame_objects objects;
static VkCommandBuffer commands;
static bool begun;

static void usage(void)
{
    fprintf(stderr, "usage: vk_writes " DIRECTION_USAGE " [--answers FILE] [--flat] [--again] [--libraries N]\n");
    exit(2);
}

static void parse(int argc, char **argv)
{
    for (int i = 1; i < argc; i++) {
        const char *option = argv[i];
        if (strcmp(option, "--flat") == 0)
            options.flat = true;
        else if (strcmp(option, "--again") == 0)
            options.again = true;
        else if (i + 1 == argc)
            usage();
        else if (strcmp(option, "--answers") == 0)
            options.answers = argv[++i];
        else if (strcmp(option, "--libraries") == 0)
            options.libraries = (uint32_t)atoi(argv[++i]);
        else if (!take_direction(&options.direction, option, argv[++i]))
            usage();
    }
}

static void make_set(void)
{
    const VkShaderStageFlags all = VK_SHADER_STAGE_VERTEX_BIT | VK_SHADER_STAGE_FRAGMENT_BIT;
    const VkDescriptorSetLayoutBinding bindings[] = {{0, VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, 1, all, NULL},
                                                     {1, VK_DESCRIPTOR_TYPE_STORAGE_IMAGE, 1, all, NULL}};
    const VkDescriptorSetLayoutCreateInfo info = {.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO,
                                                  .bindingCount = 2,
                                                  .pBindings = bindings};
    expect(vkCreateDescriptorSetLayout(w.device, &info, NULL, &set_layout), "vkCreateDescriptorSetLayout");
    const VkDescriptorPoolSize sizes[] = {{VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, 1}, {VK_DESCRIPTOR_TYPE_STORAGE_IMAGE, 1}};
    const VkDescriptorPoolCreateInfo of_pool = {.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO,
                                                .maxSets = 1,
                                                .poolSizeCount = 2,
                                                .pPoolSizes = sizes};
    expect(vkCreateDescriptorPool(w.device, &of_pool, NULL, &pool), "vkCreateDescriptorPool");
    const VkDescriptorSetAllocateInfo of_set = {.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_ALLOCATE_INFO,
                                                .descriptorPool = pool,
                                                .descriptorSetCount = 1,
                                                .pSetLayouts = &set_layout};
    expect(vkAllocateDescriptorSets(w.device, &of_set, &set), "vkAllocateDescriptorSets");
    const VkDescriptorBufferInfo buffer = {counts.buffer, 0, VK_WHOLE_SIZE};
    const VkDescriptorImageInfo image = {.imageView = sums.view, .imageLayout = VK_IMAGE_LAYOUT_GENERAL};
    const VkWriteDescriptorSet writes[] = {{.sType = VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET,
                                            .dstSet = set,
                                            .dstBinding = 0,
                                            .descriptorCount = 1,
                                            .descriptorType = VK_DESCRIPTOR_TYPE_STORAGE_BUFFER,
                                            .pBufferInfo = &buffer},
                                           {.sType = VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET,
                                            .dstSet = set,
                                            .dstBinding = 1,
                                            .descriptorCount = 1,
                                            .descriptorType = VK_DESCRIPTOR_TYPE_STORAGE_IMAGE,
                                            .pImageInfo = &image}};
    vkUpdateDescriptorSets(w.device, 2, writes, 0, NULL);
}

static void open_all(void)
{
    w.writes = true;
    window_open(&w, options.direction.x, options.direction.y, options.direction.width, options.direction.height, false,
                options.libraries != 0, 0);
    counts = make_block(&w, sizeof(counters), VK_BUFFER_USAGE_STORAGE_BUFFER_BIT, true);
    texels = make_block(&w, SIDE * SIDE * sizeof(uint32_t), VK_BUFFER_USAGE_TRANSFER_DST_BIT, true);
    memset(counts.bytes, 0, sizeof(counters));
    sums = make_picture(&w, VK_FORMAT_R32_UINT, (VkExtent2D){SIDE, SIDE}, VK_SAMPLE_COUNT_1_BIT,
                        VK_IMAGE_USAGE_STORAGE_BIT | VK_IMAGE_USAGE_TRANSFER_SRC_BIT | VK_IMAGE_USAGE_TRANSFER_DST_BIT);
    make_set();
    const VkPushConstantRange range = {VK_SHADER_STAGE_VERTEX_BIT, 0, sizeof(matrix4)};
    const VkPipelineLayoutCreateInfo info = {.sType = VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO,
                                             .setLayoutCount = 1,
                                             .pSetLayouts = &set_layout,
                                             .pushConstantRangeCount = 1,
                                             .pPushConstantRanges = &range};
    expect(vkCreatePipelineLayout(w.device, &info, NULL, &layout), "vkCreatePipelineLayout");
    const pipeline_description parts = {.vertex = SHADER(writes_vert),
                                        .fragment = SHADER(writes_frag),
                                        .layout = layout,
                                        .color = w.format,
                                        .samples = VK_SAMPLE_COUNT_1_BIT,
                                        .libraries = options.libraries};
    cube = make_pipeline(&w, &parts);
    if (options.again)
        window_make_swapchain(&w);
    objects = make_frame_objects(&w);
    make_commands(&w, &objects, VK_COMMAND_BUFFER_LEVEL_PRIMARY, 1, &commands);
}

static void draw_all(void)
{
    const matrix4 matrix =
        options.flat ? matrix_scale(0.25) : direction_matrix(&options.direction, w.extent, false);
    const VkViewport viewport = {0, 0, (float)w.extent.width, (float)w.extent.height, 0, 1};
    const VkRect2D scissor = {{0, 0}, w.extent};
    vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, cube.whole);
    vkCmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, layout, 0, 1, &set, 0, NULL);
    vkCmdSetViewport(commands, 0, 1, &viewport);
    vkCmdSetScissor(commands, 0, 1, &scissor);
    vkCmdPushConstants(commands, layout, VK_SHADER_STAGE_VERTEX_BIT, 0, sizeof matrix, &matrix);
    vkCmdDraw(commands, VERTICES, 1, 0, 0);
}

/* Clears the image before the first frame. */
static void clear_sums(void)
{
    const VkClearColorValue zero = {.uint32 = {0}};
    const VkImageSubresourceRange whole = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 1, 0, 1};
    change_layout(commands, sums.image, VK_IMAGE_ASPECT_COLOR_BIT, VK_IMAGE_LAYOUT_UNDEFINED, VK_IMAGE_LAYOUT_GENERAL);
    vkCmdClearColorImage(commands, sums.image, VK_IMAGE_LAYOUT_GENERAL, &zero, 1, &whole);
    begun = true;
}

static void record(uint32_t index)
{
    const VkImageLayout color = VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL;
    const VkCommandBufferBeginInfo begin = {.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO};
    const VkRenderingAttachmentInfo colors = {.sType = VK_STRUCTURE_TYPE_RENDERING_ATTACHMENT_INFO,
                                              .imageView = w.views[index],
                                              .imageLayout = color,
                                              .loadOp = VK_ATTACHMENT_LOAD_OP_CLEAR,
                                              .storeOp = VK_ATTACHMENT_STORE_OP_STORE,
                                              .clearValue = {.color = {.float32 = {0.25f, 0.25f, 0.25f, 1.0f}}}};
    const VkRenderingInfo info = {.sType = VK_STRUCTURE_TYPE_RENDERING_INFO,
                                  .renderArea = {{0, 0}, w.extent},
                                  .layerCount = 1,
                                  .colorAttachmentCount = 1,
                                  .pColorAttachments = &colors};
    const VkBufferImageCopy all = {.imageSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, 1},
                                   .imageExtent = {SIDE, SIDE, 1}};
    expect(vkBeginCommandBuffer(commands, &begin), "vkBeginCommandBuffer");
    if (!begun)
        clear_sums();
    change_layout(commands, sums.image, VK_IMAGE_ASPECT_COLOR_BIT, VK_IMAGE_LAYOUT_GENERAL, VK_IMAGE_LAYOUT_GENERAL);
    change_layout(commands, w.images[index], VK_IMAGE_ASPECT_COLOR_BIT, VK_IMAGE_LAYOUT_UNDEFINED, color);
    vkCmdBeginRendering(commands, &info);
    draw_all();
    vkCmdEndRendering(commands);
    change_layout(commands, sums.image, VK_IMAGE_ASPECT_COLOR_BIT, VK_IMAGE_LAYOUT_GENERAL, VK_IMAGE_LAYOUT_GENERAL);
    vkCmdCopyImageToBuffer(commands, sums.image, VK_IMAGE_LAYOUT_GENERAL, texels.buffer, 1, &all);
    change_layout(commands, w.images[index], VK_IMAGE_ASPECT_COLOR_BIT, color, VK_IMAGE_LAYOUT_PRESENT_SRC_KHR);
    expect(vkEndCommandBuffer(commands), "vkEndCommandBuffer");
}

static void write_answers(void)
{
    const counters *all = counts.bytes;
    const uint32_t *image = texels.bytes;
    uint32_t least = UINT32_MAX, most = 0;
    for (int i = 0; i < VERTICES; i++) {
        least = all->places[i] < least ? all->places[i] : least;
        most = all->places[i] > most ? all->places[i] : most;
    }
    FILE *to = fopen(options.answers, "w");
    if (to == NULL) {
        fprintf(stderr, "cannot write %s\n", options.answers);
        exit(1);
    }
    fprintf(to, "vertices %u\nfragments %u\nleast %u\nmost %u\nsums %u\nstored %u\n", all->vertices, all->fragments,
            least, most, image[2 * SIDE + 1], image[2 * SIDE + 2]);
    fclose(to);
}

int main(int argc, char **argv)
{
    parse(argc, argv);
    open_all();
    run_frames(&w, &objects, commands, options.direction.frames, options.direction.shot, record);
    expect(vkDeviceWaitIdle(w.device), "vkDeviceWaitIdle");
    if (options.answers != NULL)
        write_answers();
    free_pipeline(&w, &cube);
    free_picture(&w, &sums);
    free_block(&w, &texels);
    free_block(&w, &counts);
    vkDestroyPipelineLayout(w.device, layout, NULL);
    vkDestroyDescriptorPool(w.device, pool, NULL);
    vkDestroyDescriptorSetLayout(w.device, set_layout, NULL);
    free_frame_objects(&w, &objects);
    window_close(&w);
    return 0;
}
