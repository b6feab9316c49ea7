/*
 * The direction test's cube. Its vertex shader passes values of many types to the fragment shader
 * (handed.vert). It is drawn as lists, strips and fans of triangles, or as lines, which are the
 * edges and a diagonal of each face. --by-commands: commands set the topology. --last: the last
 * vertex is the provoking one. --number: the fragment shader reads the primitive's number. --clip:
 * a part is clipped by a distance. --cull: the vertex shader sets a cull distance with which
 * nothing is culled.
 */
#include "direction.h"
#include "frames.h"
#include "pipelines.h"

/* Compiled by glslangValidator. */
#include "handed_clip.h"
#include "handed_cull.h"
#include "handed_frag.h"
#include "handed_number.h"
#include "handed_vert.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { SHAPES = 5, FACES = 6 };
static const char *const shapes[SHAPES] = {"list", "strip", "fan", "lines", "line-strip"};
static const VkPrimitiveTopology topologies[SHAPES] = {
    VK_PRIMITIVE_TOPOLOGY_TRIANGLE_LIST, VK_PRIMITIVE_TOPOLOGY_TRIANGLE_STRIP, VK_PRIMITIVE_TOPOLOGY_TRIANGLE_FAN,
    VK_PRIMITIVE_TOPOLOGY_LINE_LIST, VK_PRIMITIVE_TOPOLOGY_LINE_STRIP};
/* Number of vertices of a face, by shape. */
static const uint32_t counts[SHAPES] = {6, 4, 4, 10, 6};

static struct {
    direction_options direction;
    int shape;
    bool by_commands, last, number, clip, cull;
} options = {.direction = DIRECTION_DEFAULTS};

static vulkan_window w;
static VkPipelineLayout layout;
static linked_pipeline cube;
static frame_objects objects;
static VkCommandBuffer commands;

static void usage(void)
{
    fprintf(stderr, "usage: vk_handed " DIRECTION_USAGE " [--shape list|strip|fan|lines|line-strip] [--by-commands] [--last]"
                    " [--number] [--clip] [--cull]\n");
    exit(2);
}

static void parse(int argc, char **argv)
{
    for (int i = 1; i < argc; i++) {
        const char *option = argv[i];
        if (strcmp(option, "--by-commands") == 0)
            options.by_commands = true;
        else if (strcmp(option, "--last") == 0)
            options.last = true;
        else if (strcmp(option, "--number") == 0)
            options.number = true;
        else if (strcmp(option, "--clip") == 0)
            options.clip = true;
        else if (strcmp(option, "--cull") == 0)
            options.cull = true;
        else if (i + 1 == argc)
            usage();
        else if (strcmp(option, "--shape") == 0)
            options.shape = choice(argv[++i], shapes, SHAPES);
        else if (!take_direction(&options.direction, option, argv[++i]))
            usage();
    }
    if (options.shape < 0)
        usage();
}

static void open_all(void)
{
    w.stages = options.number;
    window_open(&w, options.direction.x, options.direction.y, options.direction.width, options.direction.height, false,
                options.last || options.by_commands, 0);
    const VkPushConstantRange range = {VK_SHADER_STAGE_VERTEX_BIT, 0, sizeof(matrix4) + 2 * sizeof(uint32_t)};
    const VkPipelineLayoutCreateInfo info = {.sType = VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO,
                                             .pushConstantRangeCount = 1,
                                             .pPushConstantRanges = &range};
    expect(vkCreatePipelineLayout(w.device, &info, NULL, &layout), "vkCreatePipelineLayout");
    /* If commands set the topology, the pipeline has another topology of the same class. */
    const int given = !options.by_commands ? options.shape : options.shape < 3 ? 0 : 3;
    const pipeline_description parts = {.vertex = options.clip   ? SHADER(handed_clip)
                                                  : options.cull ? SHADER(handed_cull)
                                                                 : SHADER(handed_vert),
                                        .fragment = options.number ? SHADER(handed_number) : SHADER(handed_frag),
                                        .layout = layout,
                                        .color = w.format,
                                        .samples = VK_SAMPLE_COUNT_1_BIT,
                                        .topology = &topologies[given],
                                        .last = options.last,
                                        .topology_by_commands = options.by_commands};
    cube = make_pipeline(&w, &parts);
    objects = make_frame_objects(&w);
    make_commands(&w, &objects, VK_COMMAND_BUFFER_LEVEL_PRIMARY, 1, &commands);
}

static void draw_all(void)
{
    const struct {
        matrix4 matrix;
        uint32_t shape, last;
    } constants = {direction_matrix(&options.direction, w.extent, false), (uint32_t)options.shape, options.last};
    const VkViewport viewport = {0, 0, (float)w.extent.width, (float)w.extent.height, 0, 1};
    const VkRect2D scissor = {{0, 0}, w.extent};
    vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, cube.whole);
    vkCmdSetViewport(commands, 0, 1, &viewport);
    vkCmdSetScissor(commands, 0, 1, &scissor);
    if (options.by_commands)
        vkCmdSetPrimitiveTopology(commands, topologies[options.shape]);
    vkCmdPushConstants(commands, layout, VK_SHADER_STAGE_VERTEX_BIT, 0, sizeof constants, &constants);
    const uint32_t count = counts[options.shape];
    const VkPrimitiveTopology topology = topologies[options.shape];
    if (topology == VK_PRIMITIVE_TOPOLOGY_TRIANGLE_LIST || topology == VK_PRIMITIVE_TOPOLOGY_LINE_LIST)
        vkCmdDraw(commands, FACES * count, 1, 0, 0);
    else
        for (uint32_t face = 0; face < FACES; face++)
            vkCmdDraw(commands, count, 1, face * count, 0);
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
    expect(vkBeginCommandBuffer(commands, &begin), "vkBeginCommandBuffer");
    change_layout(commands, w.images[index], VK_IMAGE_ASPECT_COLOR_BIT, VK_IMAGE_LAYOUT_UNDEFINED, color);
    vkCmdBeginRendering(commands, &info);
    draw_all();
    vkCmdEndRendering(commands);
    change_layout(commands, w.images[index], VK_IMAGE_ASPECT_COLOR_BIT, color, VK_IMAGE_LAYOUT_PRESENT_SRC_KHR);
    expect(vkEndCommandBuffer(commands), "vkEndCommandBuffer");
}

int main(int argc, char **argv)
{
    parse(argc, argv);
    open_all();
    run_frames(&w, &objects, commands, options.direction.frames, options.direction.shot, record);
    expect(vkDeviceWaitIdle(w.device), "vkDeviceWaitIdle");
    free_pipeline(&w, &cube);
    vkDestroyPipelineLayout(w.device, layout, NULL);
    free_frame_objects(&w, &objects);
    window_close(&w);
    return 0;
}
