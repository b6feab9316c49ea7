/*
 * Queries that count small cubes beside the direction test's cube, whose picture they do not
 * change, because they write nothing. The small cubes are in front of the cube's wall (ahead),
 * behind the wall (hidden), beside the program's field of view (beside), and flat (flat). With
 * --spans queries span all passes, one of which is small and not part of the scene. At the end the
 * program writes each result to the file --counts, as it reads it from the pool and as a command
 * copies it. It reports results whose forms contradict each other.
 * --condition N: the cube is drawn if the copied result N of the last frame is more than 0.
 */
#include "direction.h"
#include "frames.h"
#include "pipelines.h"

/* Compiled by glslangValidator. */
#include "cube_frag.h"
#include "cube_push.h"

#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { AHEAD, HIDDEN, BESIDE, FLAT, NOTHING, BOTH, SAMPLES };
static const char *const names[SAMPLES] = {"ahead", "hidden", "beside", "flat", "nothing", "both"};

enum { STATISTICS = 5, SLICE = 64 };
static const char *const statistics_names[STATISTICS] = {"vertices", "primitives", "vertex_runs", "clipping",
                                                         "fragments"};

static struct {
    direction_options direction;
    bool spans, secondary;
    int condition;
    const char *counts;
} options = {.direction = DIRECTION_DEFAULTS, .condition = -1};

static vulkan_window w;
static picture depth, small;
static VkPipelineLayout layout;
static linked_pipeline cube, silent;
static frame_objects objects;
static VkCommandBuffer commands, inner;
static VkQueryPool samples, statistics;
static block copied, copied_narrow, conditions;

static const VkImageLayout NEW = VK_IMAGE_LAYOUT_UNDEFINED, COLOR = VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL;

static void usage(void)
{
    fprintf(stderr, "usage: vk_queries " DIRECTION_USAGE " [--spans yes] [--secondary yes] [--condition N]"
                    " [--counts FILE]\n");
    exit(2);
}

static void parse(int argc, char **argv)
{
    for (int i = 1; i + 1 < argc; i += 2) {
        const char *option = argv[i], *value = argv[i + 1];
        if (strcmp(option, "--spans") == 0)
            options.spans = true;
        else if (strcmp(option, "--secondary") == 0)
            options.secondary = true;
        else if (strcmp(option, "--condition") == 0)
            options.condition = atoi(value);
        else if (strcmp(option, "--counts") == 0)
            options.counts = value;
        else if (!take_direction(&options.direction, option, value))
            usage();
    }
}

static VkQueryPool make_pool(VkQueryType type, uint32_t count, VkQueryPipelineStatisticFlags bits)
{
    const VkQueryPoolCreateInfo info = {.sType = VK_STRUCTURE_TYPE_QUERY_POOL_CREATE_INFO,
                                        .queryType = type,
                                        .queryCount = count,
                                        .pipelineStatistics = bits};
    VkQueryPool made;
    expect(vkCreateQueryPool(w.device, &info, NULL, &made), "vkCreateQueryPool");
    return made;
}

static void open_all(void)
{
    window_open(&w, options.direction.x, options.direction.y, options.direction.width, options.direction.height, false, true,
                0);
    const VkExtent2D little = {32, 32};
    depth = make_picture(&w, DEPTH_FORMAT, w.extent, VK_SAMPLE_COUNT_1_BIT, VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT);
    small = make_picture(&w, w.format, little, VK_SAMPLE_COUNT_1_BIT, VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT);
    const VkPushConstantRange range = {VK_SHADER_STAGE_VERTEX_BIT, 0, sizeof(matrix4)};
    const VkPipelineLayoutCreateInfo info = {.sType = VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO,
                                             .pushConstantRangeCount = 1,
                                             .pPushConstantRanges = &range};
    expect(vkCreatePipelineLayout(w.device, &info, NULL, &layout), "vkCreatePipelineLayout");
    pipeline_description parts = {.vertex = SHADER(cube_push),
                                  .fragment = SHADER(cube_frag),
                                  .layout = layout,
                                  .color = w.format,
                                  .depth = DEPTH_FORMAT,
                                  .samples = VK_SAMPLE_COUNT_1_BIT,
                                  .deep = true};
    cube = make_pipeline(&w, &parts);
    parts.silent = true;
    silent = make_pipeline(&w, &parts);
    samples = make_pool(VK_QUERY_TYPE_OCCLUSION, SAMPLES + 1, 0);
    statistics = make_pool(VK_QUERY_TYPE_PIPELINE_STATISTICS, 2,
                           VK_QUERY_PIPELINE_STATISTIC_INPUT_ASSEMBLY_VERTICES_BIT |
                               VK_QUERY_PIPELINE_STATISTIC_INPUT_ASSEMBLY_PRIMITIVES_BIT |
                               VK_QUERY_PIPELINE_STATISTIC_VERTEX_SHADER_INVOCATIONS_BIT |
                               VK_QUERY_PIPELINE_STATISTIC_CLIPPING_INVOCATIONS_BIT |
                               VK_QUERY_PIPELINE_STATISTIC_FRAGMENT_SHADER_INVOCATIONS_BIT);
    copied = make_block(&w, SLICE * (SAMPLES + 1), VK_BUFFER_USAGE_TRANSFER_DST_BIT, true);
    copied_narrow = make_block(&w, 4 * SAMPLES, VK_BUFFER_USAGE_TRANSFER_DST_BIT, true);
    conditions = make_block(&w, 4 * SAMPLES,
                            VK_BUFFER_USAGE_TRANSFER_DST_BIT | VK_BUFFER_USAGE_CONDITIONAL_RENDERING_BIT_EXT, true);
    memset(copied.bytes, 0, SLICE * (SAMPLES + 1));
    memset(conditions.bytes, 0, 4 * SAMPLES);
    objects = make_frame_objects(&w);
    make_commands(&w, &objects, VK_COMMAND_BUFFER_LEVEL_PRIMARY, 1, &commands);
    make_commands(&w, &objects, VK_COMMAND_BUFFER_LEVEL_SECONDARY, 1, &inner);
}

static void draw(VkCommandBuffer buffer, const linked_pipeline *by, matrix4 matrix, VkExtent2D size)
{
    const VkViewport viewport = {0, 0, (float)size.width, (float)size.height, 0, 1};
    const VkRect2D scissor = {{0, 0}, size};
    vkCmdBindPipeline(buffer, VK_PIPELINE_BIND_POINT_GRAPHICS, by->whole);
    vkCmdSetViewport(buffer, 0, 1, &viewport);
    vkCmdSetScissor(buffer, 0, 1, &scissor);
    vkCmdPushConstants(buffer, layout, VK_SHADER_STAGE_VERTEX_BIT, 0, sizeof matrix, &matrix);
    vkCmdDraw(buffer, 36, 1, 0, 0);
}

/*
 * An unturned cube at this distance, displaced upwards by `up`. The height of its nearest face is a
 * third of the picture's height.
 */
static matrix4 small_cube(double distance, double up)
{
    const direction_options lens = {.fov = options.direction.fov};
    /* Removes the scale of the direction test's cube. */
    const matrix4 projection = matrix_multiply(direction_matrix(&lens, w.extent, false), matrix_scale(0.1));
    /* Cotangent of half the opening. In clip space y points down. */
    const double part = 1.0 / (3.0 * -projection.m[5]), half = distance * part / (1.0 + part);
    return matrix_multiply(matrix_multiply(projection, matrix_camera(0.0, -up)),
                           matrix_multiply(matrix_translate(0.0, 0.0, -distance), matrix_scale(half)));
}

static void count(VkCommandBuffer buffer, int which, matrix4 matrix)
{
    vkCmdBeginQuery(buffer, samples, (uint32_t)which, VK_QUERY_CONTROL_PRECISE_BIT);
    draw(buffer, &silent, matrix, w.extent);
    vkCmdEndQuery(buffer, samples, (uint32_t)which);
}

static void draw_all(VkCommandBuffer buffer)
{
    const matrix4 flat = {{0.25f, 0, 0, 0, 0, 0.25f, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1}};
    PFN_vkCmdBeginConditionalRenderingEXT begin_condition =
        (PFN_vkCmdBeginConditionalRenderingEXT)vkGetDeviceProcAddr(w.device, "vkCmdBeginConditionalRenderingEXT");
    PFN_vkCmdEndConditionalRenderingEXT end_condition =
        (PFN_vkCmdEndConditionalRenderingEXT)vkGetDeviceProcAddr(w.device, "vkCmdEndConditionalRenderingEXT");
    const bool conditional = options.condition >= 0 && w.has.conditional_rendering;
    const VkConditionalRenderingBeginInfoEXT condition = {.sType = VK_STRUCTURE_TYPE_CONDITIONAL_RENDERING_BEGIN_INFO_EXT,
                                                          .buffer = conditions.buffer,
                                                          .offset = 4 * (VkDeviceSize)(conditional ? options.condition : 0)};
    if (conditional)
        begin_condition(buffer, &condition);
    draw(buffer, &cube, direction_matrix(&options.direction, w.extent, false), w.extent);
    if (conditional)
        end_condition(buffer);
    if (!options.spans)
        vkCmdBeginQuery(buffer, statistics, 0, 0);
    count(buffer, AHEAD, small_cube(4.0, 0.0));
    count(buffer, HIDDEN, small_cube(60.0, 0.0));
    count(buffer, BESIDE, small_cube(4.0, 65.0));
    count(buffer, FLAT, flat);
    if (!options.spans)
        vkCmdEndQuery(buffer, statistics, 0);
    vkCmdBeginQuery(buffer, samples, NOTHING, VK_QUERY_CONTROL_PRECISE_BIT);
    vkCmdEndQuery(buffer, samples, NOTHING);
    vkCmdBeginQuery(buffer, samples, BOTH, VK_QUERY_CONTROL_PRECISE_BIT);
    draw(buffer, &silent, small_cube(4.0, 0.0), w.extent);
    draw(buffer, &silent, small_cube(60.0, 0.0), w.extent);
    vkCmdEndQuery(buffer, samples, BOTH);
}

static void record_inner(void)
{
    const VkCommandBufferInheritanceRenderingInfo rendering = {
        .sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_INHERITANCE_RENDERING_INFO,
        .colorAttachmentCount = 1,
        .pColorAttachmentFormats = &w.format,
        .depthAttachmentFormat = DEPTH_FORMAT,
        .rasterizationSamples = VK_SAMPLE_COUNT_1_BIT};
    const VkCommandBufferInheritanceInfo inheritance = {.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_INHERITANCE_INFO,
                                                        .pNext = &rendering};
    const VkCommandBufferBeginInfo begin = {.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO,
                                            .flags = VK_COMMAND_BUFFER_USAGE_RENDER_PASS_CONTINUE_BIT,
                                            .pInheritanceInfo = &inheritance};
    expect(vkBeginCommandBuffer(inner, &begin), "vkBeginCommandBuffer");
    draw_all(inner);
    expect(vkEndCommandBuffer(inner), "vkEndCommandBuffer");
}

static void pass(VkImageView color, VkExtent2D size, VkRenderingFlags flags)
{
    const VkRenderingAttachmentInfo colors = {.sType = VK_STRUCTURE_TYPE_RENDERING_ATTACHMENT_INFO,
                                              .imageView = color,
                                              .imageLayout = COLOR,
                                              .loadOp = VK_ATTACHMENT_LOAD_OP_CLEAR,
                                              .storeOp = VK_ATTACHMENT_STORE_OP_STORE,
                                              .clearValue = {.color = {.float32 = {0.25f, 0.25f, 0.25f, 1.0f}}}};
    const VkRenderingAttachmentInfo depths = {.sType = VK_STRUCTURE_TYPE_RENDERING_ATTACHMENT_INFO,
                                              .imageView = depth.view,
                                              .imageLayout = VK_IMAGE_LAYOUT_DEPTH_ATTACHMENT_OPTIMAL,
                                              .loadOp = VK_ATTACHMENT_LOAD_OP_CLEAR,
                                              .clearValue = {.depthStencil = {1.0f, 0}}};
    const VkRenderingInfo info = {.sType = VK_STRUCTURE_TYPE_RENDERING_INFO,
                                  .flags = flags,
                                  .renderArea = {{0, 0}, size},
                                  .layerCount = 1,
                                  .colorAttachmentCount = 1,
                                  .pColorAttachments = &colors,
                                  .pDepthAttachment = &depths};
    vkCmdBeginRendering(commands, &info);
}

/* A pass that is not part of the scene. */
static void record_small(void)
{
    const VkExtent2D little = {32, 32};
    change_layout(commands, small.image, VK_IMAGE_ASPECT_COLOR_BIT, NEW, COLOR);
    change_layout(commands, depth.image, VK_IMAGE_ASPECT_DEPTH_BIT, NEW, VK_IMAGE_LAYOUT_DEPTH_ATTACHMENT_OPTIMAL);
    pass(small.view, little, 0);
    draw(commands, &cube, direction_matrix(&options.direction, little, false), little);
    vkCmdEndRendering(commands);
}

static void record_copies(void)
{
    const VkQueryResultFlags wide = VK_QUERY_RESULT_64_BIT | VK_QUERY_RESULT_WAIT_BIT;
    vkCmdCopyQueryPoolResults(commands, samples, 0, SAMPLES, copied.buffer, 0, SLICE,
                              wide | VK_QUERY_RESULT_WITH_AVAILABILITY_BIT);
    vkCmdCopyQueryPoolResults(commands, statistics, 0, 1, copied.buffer, SLICE * SAMPLES, SLICE, wide);
    vkCmdCopyQueryPoolResults(commands, samples, 0, SAMPLES, copied_narrow.buffer, 0, 4, VK_QUERY_RESULT_WAIT_BIT);
    vkCmdCopyQueryPoolResults(commands, samples, 0, SAMPLES, conditions.buffer, 0, 4, VK_QUERY_RESULT_WAIT_BIT);
    const VkMemoryBarrier2 done = {.sType = VK_STRUCTURE_TYPE_MEMORY_BARRIER_2,
                                   .srcStageMask = VK_PIPELINE_STAGE_2_COPY_BIT,
                                   .srcAccessMask = VK_ACCESS_2_TRANSFER_WRITE_BIT,
                                   .dstStageMask = VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT | VK_PIPELINE_STAGE_2_HOST_BIT,
                                   .dstAccessMask = VK_ACCESS_2_MEMORY_READ_BIT | VK_ACCESS_2_HOST_READ_BIT};
    const VkDependencyInfo info = {
        .sType = VK_STRUCTURE_TYPE_DEPENDENCY_INFO, .memoryBarrierCount = 1, .pMemoryBarriers = &done};
    vkCmdPipelineBarrier2(commands, &info);
}

static void record(uint32_t index)
{
    const VkCommandBufferBeginInfo begin = {.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO};
    if (options.secondary)
        record_inner();
    expect(vkBeginCommandBuffer(commands, &begin), "vkBeginCommandBuffer");
    vkCmdResetQueryPool(commands, samples, 0, SAMPLES + 1);
    vkCmdResetQueryPool(commands, statistics, 0, 2);
    if (options.spans)
        vkCmdBeginQuery(commands, statistics, 0, 0);
    record_small();
    change_layout(commands, w.images[index], VK_IMAGE_ASPECT_COLOR_BIT, NEW, COLOR);
    change_layout(commands, depth.image, VK_IMAGE_ASPECT_DEPTH_BIT, NEW, VK_IMAGE_LAYOUT_DEPTH_ATTACHMENT_OPTIMAL);
    pass(w.views[index], w.extent, options.secondary ? VK_RENDERING_CONTENTS_SECONDARY_COMMAND_BUFFERS_BIT : 0);
    if (options.secondary)
        vkCmdExecuteCommands(commands, 1, &inner);
    else
        draw_all(commands);
    vkCmdEndRendering(commands);
    if (options.spans)
        vkCmdEndQuery(commands, statistics, 0);
    record_copies();
    change_layout(commands, w.images[index], VK_IMAGE_ASPECT_COLOR_BIT, COLOR, VK_IMAGE_LAYOUT_PRESENT_SRC_KHR);
    expect(vkEndCommandBuffer(commands), "vkEndCommandBuffer");
}

static void insist(bool right, const char *what)
{
    if (!right) {
        fprintf(stderr, "wrong: %s\n", what);
        exit(1);
    }
}

/* Writes a line with the name of a result, as it was read and as it was copied. */
static void write_count(FILE *file, const char *name, uint64_t read, uint64_t copy)
{
    fprintf(file, "%s %" PRIu64 " %" PRIu64 "\n", name, read, copy);
}

static void write_counts(const char *path)
{
    FILE *file = fopen(path, "w");
    insist(file != NULL, "the file of the counts cannot be written");
    uint64_t wide[SAMPLES][2], numbers[STATISTICS];
    uint32_t narrow[SAMPLES], missing[3] = {77, 77, 77};
    const VkQueryResultFlags told = VK_QUERY_RESULT_64_BIT | VK_QUERY_RESULT_WITH_AVAILABILITY_BIT;
    expect(vkGetQueryPoolResults(w.device, samples, 0, SAMPLES, sizeof wide, wide, sizeof wide[0], told), "results");
    expect(vkGetQueryPoolResults(w.device, samples, 0, SAMPLES, sizeof narrow, narrow, 4, VK_QUERY_RESULT_WAIT_BIT), "results");
    expect(vkGetQueryPoolResults(w.device, statistics, 0, 1, sizeof numbers, numbers, sizeof numbers, VK_QUERY_RESULT_64_BIT),
           "results");
    const VkResult late = vkGetQueryPoolResults(w.device, samples, SAMPLES, 1, sizeof missing, missing, sizeof missing,
                                                VK_QUERY_RESULT_WITH_AVAILABILITY_BIT);
    insist(late == VK_NOT_READY && missing[1] == 0 && missing[2] == 77, "a query that never ran has a result");
    for (int i = 0; i < SAMPLES; i++) {
        const uint64_t *copy = (const uint64_t *)(const void *)((const char *)copied.bytes + SLICE * i);
        insist(wide[i][1] != 0 && copy[1] != 0, "a result is not available");
        insist(copy[2] == 0, "a copy writes beyond its result");
        insist(narrow[i] == wide[i][0], "32 and 64 bits are different results");
        insist(((const uint32_t *)copied_narrow.bytes)[i] == copy[0], "copies of 32 and 64 bits are different results");
        write_count(file, names[i], wide[i][0], copy[0]);
    }
    const uint64_t *copy = (const uint64_t *)(const void *)((const char *)copied.bytes + SLICE * SAMPLES);
    for (int i = 0; i < STATISTICS; i++)
        write_count(file, statistics_names[i], numbers[i], copy[i]);
    fclose(file);
}

static void close_all(void)
{
    expect(vkDeviceWaitIdle(w.device), "vkDeviceWaitIdle");
    vkDestroyQueryPool(w.device, samples, NULL);
    vkDestroyQueryPool(w.device, statistics, NULL);
    free_pipeline(&w, &cube);
    free_pipeline(&w, &silent);
    vkDestroyPipelineLayout(w.device, layout, NULL);
    free_frame_objects(&w, &objects);
    free_picture(&w, &depth);
    free_picture(&w, &small);
    free_block(&w, &copied);
    free_block(&w, &copied_narrow);
    free_block(&w, &conditions);
    window_close(&w);
}

int main(int argc, char **argv)
{
    parse(argc, argv);
    open_all();
    run_frames(&w, &objects, commands, options.direction.frames, options.direction.shot, record);
    if (options.counts != NULL)
        write_counts(options.counts);
    close_all();
    return 0;
}
