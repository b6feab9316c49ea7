#include "player.h"

#include <string.h>

static const VkShaderStageFlags all_stages =
    VK_SHADER_STAGE_VERTEX_BIT | VK_SHADER_STAGE_FRAGMENT_BIT | VK_SHADER_STAGE_COMPUTE_BIT;

int draw_pipeline(const int *n)
{
    if (!it.pass.is_under_way)
        return SKIPPED;
    const VkPipeline pipeline = pipeline_of_pass(n[0]);
    if (pipeline == VK_NULL_HANDLE)
        return SKIPPED;
    it.pass.pipeline = n[0];
    vkCmdBindPipeline(it.commands, VK_PIPELINE_BIND_POINT_GRAPHICS, pipeline);
    return 0;
}

static void bind_set(VkPipelineBindPoint point, int set, int matrix)
{
    const uint32_t offset = (uint32_t)(matrix % (VERTICES / MATRIX_STEP)) * MATRIX_STEP;
    vkCmdBindDescriptorSets(it.commands, point, it.layout, 0, 1, &it.sets[set], 1, &offset);
}

/* set, matrix */
int draw_set(const int *n)
{
    if (!it.pass.is_under_way)
        return SKIPPED;
    it.draw.set = n[0] % SETS;
    bind_set(VK_PIPELINE_BIND_POINT_GRAPHICS, it.draw.set, n[1]);
    return 0;
}

/* matrix, tint */
int draw_push(const int *n)
{
    float constants[20];
    begin_recording();
    matrix_write(constants, n[0]);
    for (int i = 0; i < 4; i++)
        constants[16 + i] = (n[1] >> i & 1) ? 0.5f : 1.0f;
    vkCmdPushConstants(it.commands, it.layout, all_stages, 0, sizeof constants, constants);
    it.draw.constants = true;
    return 0;
}

int draw_viewport(const int *n)
{
    if (!it.pass.is_under_way)
        return SKIPPED;
    const float width = (float)it.pass.extent.width, height = (float)it.pass.extent.height;
    const VkViewport all[] = {{0, 0, width, height, 0, 1},
                              {0, 0, width, height, 0, 1},
                              {0, height, width, -height, 0, 1},
                              {0, 0, 16, height, 0, 1},
                              {-8, 4, width, 16, 0, 0.5f},
                              {8, 8, 8, 8, 0.5f, 1}};
    vkCmdSetViewport(it.commands, 0, 1, &all[n[0] % 6]);
    if (!it.draw.viewport) {
        it.draw.viewport = true;
        draw_scissor((const int[]){0});
    }
    return 0;
}

int draw_scissor(const int *n)
{
    if (!it.pass.is_under_way)
        return SKIPPED;
    const VkRect2D all[] = {{{0, 0}, {4096, 4096}}, {{0, 0}, {4096, 4096}}, {{8, 4}, {16, 8}}, {{0, 0}, {20, 40}}, {{0, 0}, {0, 0}}};
    vkCmdSetScissor(it.commands, 0, 1, &all[n[0] % 5]);
    if (!it.draw.viewport) {
        it.draw.viewport = true;
        draw_viewport((const int[]){0});
    }
    return 0;
}

/* buffer, first */
int draw_vertices(const int *n)
{
    if (!it.pass.is_under_way)
        return SKIPPED;
    const VkDeviceSize offset = VERTICES + 16 * (VkDeviceSize)(n[1] % 64);
    vkCmdBindVertexBuffers(it.commands, 0, 1, &it.buffers[n[0] % 2].buffer, &offset);
    it.draw.vertices = true;
    return 0;
}

static bool is_target(int number)
{
    const slot_image *image = &it.images[number];
    return image == it.pass.color || image == it.pass.second || image == it.pass.depth || image == it.pass.resolve;
}

/* Sets the state that was not set. Returns whether a draw is allowed. */
static bool can_draw(void)
{
    static const int nothing[2];
    if (!it.pass.is_under_way || it.pass.pipeline < 0)
        return false;
    if (!it.draw.viewport)
        draw_viewport(nothing);
    if (it.draw.set < 0)
        draw_set(nothing);
    if (!it.draw.constants)
        draw_push(nothing);
    if (!it.draw.vertices)
        draw_vertices(nothing);
    return !pipeline_samples(it.pass.pipeline) || !is_target(it.set_image[it.draw.set]);
}

/* vertices, instances, first vertex */
int draw(const int *n)
{
    const uint32_t first = (uint32_t)n[2] % CUBE;
    if (!can_draw())
        return SKIPPED;
    vkCmdDraw(it.commands, (uint32_t)n[0] % (CUBE - first + 1), 1 + (uint32_t)n[1] % 2, first, 0);
    return 0;
}

/* indices, first index, type */
int draw_indexed(const int *n)
{
    if (!can_draw())
        return SKIPPED;
    const bool wide = n[2] & 1;
    vkCmdBindIndexBuffer(it.commands, it.indices.buffer, wide ? 1024 : 0, wide ? VK_INDEX_TYPE_UINT32 : VK_INDEX_TYPE_UINT16);
    vkCmdDrawIndexed(it.commands, (uint32_t)n[0] % 64, 1, (uint32_t)n[1] % 64, 0, 0);
    return 0;
}

/* place of the numbers, whether indices are used */
int draw_indirect(const int *n)
{
    const VkDeviceSize place = 32 * (VkDeviceSize)(n[0] % 63);
    if (!can_draw())
        return SKIPPED;
    if (n[1] & 1) {
        vkCmdBindIndexBuffer(it.commands, it.indices.buffer, 0, VK_INDEX_TYPE_UINT16);
        vkCmdDrawIndexedIndirect(it.commands, it.indirect.buffer, place, 1, 32);
    } else {
        vkCmdDrawIndirect(it.commands, it.indirect.buffer, place, 1, 32);
    }
    return 0;
}

/* set, tint */
int dispatch(const int *n)
{
    const int set = n[0] % SETS;
    if (it.pass.is_under_way || it.set_image[set] == it.set_result[set])
        return SKIPPED;
    begin_recording();
    const VkPipeline pipeline = pipeline_of_compute();
    if (pipeline == VK_NULL_HANDLE)
        return SKIPPED;
    draw_push((const int[]){0, n[1]});
    vkCmdBindPipeline(it.commands, VK_PIPELINE_BIND_POINT_COMPUTE, pipeline);
    bind_set(VK_PIPELINE_BIND_POINT_COMPUTE, set, 0);
    barrier_all(it.commands);
    vkCmdDispatch(it.commands, 8, 6, 1);
    barrier_all(it.commands);
    return 0;
}
