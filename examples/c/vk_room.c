#include "vk_room.h"

/* Compiled from room.vert and room.frag by glslangValidator. */
#include "room_frag.h"
#include "room_layers_vert.h"
#include "room_vert.h"

#include <math.h>
#include <stddef.h>
#include <string.h>

/*
 * Each wall of the cube [-1, 1]^3 is made of tiles, two triangles each. The tiles are small, because Mesa's lavapipe
 * (at least 22.3) draws clipped triangles into the wrong one of several views. With small tiles only the views'
 * borders suffer.
 */
enum { TILES = 16, CORNERS = 6 * TILES * TILES * 6 };

static void make_corners(float corners[CORNERS][3])
{
    static const int order[6][2] = {{0, 0}, {1, 0}, {1, 1}, {0, 0}, {1, 1}, {0, 1}};
    for (int i = 0; i < CORNERS; i++) {
        const int tile = i / 6 % (TILES * TILES), wall = i / 6 / (TILES * TILES), axis = wall / 2;
        const int column = tile % TILES + order[i % 6][0], row = tile / TILES + order[i % 6][1];
        corners[i][axis] = wall % 2 == 0 ? -1.0f : 1.0f;
        corners[i][(axis + 1) % 3] = 2.0f * (float)column / TILES - 1.0f;
        corners[i][(axis + 2) % 3] = 2.0f * (float)row / TILES - 1.0f;
    }
}

static VkShaderModule module_of(base *b, const uint32_t *words, size_t size)
{
    VkShaderModuleCreateInfo info = {
        .sType = VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO, .codeSize = size, .pCode = words};
    VkShaderModule module = VK_NULL_HANDLE;
    base_good(vkCreateShaderModule(b->device, &info, NULL, &module), "a shader");
    return module;
}

/* Makes the uniform buffer with the cameras of all views. */
static bool make_cameras(base *b, uint32_t view_count, const matrix cameras[], room *made)
{
    VkDescriptorPoolSize size = {VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER, 1};
    VkDescriptorPoolCreateInfo pool = {.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO,
                                       .maxSets = 1,
                                       .poolSizeCount = 1,
                                       .pPoolSizes = &size};
    if (!base_good(vkCreateDescriptorPool(b->device, &pool, NULL, &made->pool), "descriptors"))
        return false;
    VkDescriptorSetAllocateInfo allocate = {.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_ALLOCATE_INFO,
                                            .descriptorPool = made->pool,
                                            .descriptorSetCount = 1,
                                            .pSetLayouts = &made->set_layout};
    matrix all[ROOM_MOST_VIEWS] = {{{0}}};
    memcpy(all, cameras, view_count * sizeof(matrix));
    if (!base_good(vkAllocateDescriptorSets(b->device, &allocate, &made->set), "descriptors") ||
        !base_make_buffer(b, VK_BUFFER_USAGE_UNIFORM_BUFFER_BIT, all, sizeof all, &made->cameras, &made->cameras_memory))
        return false;
    VkDescriptorBufferInfo buffer = {made->cameras, 0, sizeof all};
    VkWriteDescriptorSet write = {.sType = VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET,
                                  .dstSet = made->set,
                                  .descriptorCount = 1,
                                  .descriptorType = VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER,
                                  .pBufferInfo = &buffer};
    vkUpdateDescriptorSets(b->device, 1, &write, 0, NULL);
    return true;
}

static bool make_pipeline(base *b, VkRenderPass pass, bool layered, room *made)
{
    VkShaderModule vertex = layered ? module_of(b, room_layers_vert, sizeof room_layers_vert)
                                    : module_of(b, room_vert, sizeof room_vert);
    VkShaderModule fragment = module_of(b, room_frag, sizeof room_frag);
    VkPipelineShaderStageCreateInfo stages[] = {
        {.sType = VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO,
         .stage = VK_SHADER_STAGE_VERTEX_BIT,
         .module = vertex,
         .pName = "main"},
        {.sType = VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO,
         .stage = VK_SHADER_STAGE_FRAGMENT_BIT,
         .module = fragment,
         .pName = "main"},
    };
    VkVertexInputBindingDescription binding = {0, 3 * sizeof(float), VK_VERTEX_INPUT_RATE_VERTEX};
    VkVertexInputAttributeDescription attribute = {0, 0, VK_FORMAT_R32G32B32_SFLOAT, 0};
    VkPipelineVertexInputStateCreateInfo input = {.sType = VK_STRUCTURE_TYPE_PIPELINE_VERTEX_INPUT_STATE_CREATE_INFO,
                                                  .vertexBindingDescriptionCount = 1,
                                                  .pVertexBindingDescriptions = &binding,
                                                  .vertexAttributeDescriptionCount = 1,
                                                  .pVertexAttributeDescriptions = &attribute};
    VkPipelineInputAssemblyStateCreateInfo assembly = {
        .sType = VK_STRUCTURE_TYPE_PIPELINE_INPUT_ASSEMBLY_STATE_CREATE_INFO,
        .topology = VK_PRIMITIVE_TOPOLOGY_TRIANGLE_LIST};
    VkPipelineViewportStateCreateInfo viewport = {
        .sType = VK_STRUCTURE_TYPE_PIPELINE_VIEWPORT_STATE_CREATE_INFO, .viewportCount = 1, .scissorCount = 1};
    VkPipelineRasterizationStateCreateInfo raster = {
        .sType = VK_STRUCTURE_TYPE_PIPELINE_RASTERIZATION_STATE_CREATE_INFO, .lineWidth = 1.0f};
    VkPipelineMultisampleStateCreateInfo samples = {.sType = VK_STRUCTURE_TYPE_PIPELINE_MULTISAMPLE_STATE_CREATE_INFO,
                                                    .rasterizationSamples = VK_SAMPLE_COUNT_1_BIT};
    VkPipelineColorBlendAttachmentState all = {.colorWriteMask = 0xf};
    VkPipelineColorBlendStateCreateInfo blend = {.sType = VK_STRUCTURE_TYPE_PIPELINE_COLOR_BLEND_STATE_CREATE_INFO,
                                                 .attachmentCount = 1,
                                                 .pAttachments = &all};
    const VkDynamicState states[] = {VK_DYNAMIC_STATE_VIEWPORT, VK_DYNAMIC_STATE_SCISSOR};
    VkPipelineDynamicStateCreateInfo dynamic = {.sType = VK_STRUCTURE_TYPE_PIPELINE_DYNAMIC_STATE_CREATE_INFO,
                                                .dynamicStateCount = 2,
                                                .pDynamicStates = states};
    VkGraphicsPipelineCreateInfo info = {.sType = VK_STRUCTURE_TYPE_GRAPHICS_PIPELINE_CREATE_INFO,
                                         .stageCount = 2,
                                         .pStages = stages,
                                         .pVertexInputState = &input,
                                         .pInputAssemblyState = &assembly,
                                         .pViewportState = &viewport,
                                         .pRasterizationState = &raster,
                                         .pMultisampleState = &samples,
                                         .pColorBlendState = &blend,
                                         .pDynamicState = &dynamic,
                                         .layout = made->layout,
                                         .renderPass = pass};
    VkResult result = vkCreateGraphicsPipelines(b->device, VK_NULL_HANDLE, 1, &info, NULL, &made->pipeline);
    vkDestroyShaderModule(b->device, vertex, NULL);
    vkDestroyShaderModule(b->device, fragment, NULL);
    return base_good(result, "a pipeline");
}

bool room_open(base *b, VkRenderPass pass, uint32_t view_count, const matrix cameras[], room *made)
{
    static float corners[CORNERS][3];
    make_corners(corners);
    *made = (room){.pool = VK_NULL_HANDLE};
    VkDescriptorSetLayoutBinding binding = {0, VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER, 1, VK_SHADER_STAGE_VERTEX_BIT, NULL};
    VkDescriptorSetLayoutCreateInfo set = {
        .sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO, .bindingCount = 1, .pBindings = &binding};
    VkPushConstantRange range = {VK_SHADER_STAGE_VERTEX_BIT, 0, sizeof(matrix)};
    if (!base_good(vkCreateDescriptorSetLayout(b->device, &set, NULL, &made->set_layout), "a layout"))
        return false;
    VkPipelineLayoutCreateInfo layout = {.sType = VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO,
                                         .setLayoutCount = 1,
                                         .pSetLayouts = &made->set_layout,
                                         .pushConstantRangeCount = 1,
                                         .pPushConstantRanges = &range};
    return base_good(vkCreatePipelineLayout(b->device, &layout, NULL, &made->layout), "a layout") &&
           make_pipeline(b, pass, view_count > 0, made) &&
           base_make_buffer(b, VK_BUFFER_USAGE_VERTEX_BUFFER_BIT, corners, sizeof corners, &made->corners,
                            &made->corners_memory) &&
           (view_count == 0 || make_cameras(b, view_count, cameras, made));
}

void room_close(base *b, room *r)
{
    vkDestroyBuffer(b->device, r->corners, NULL);
    vkFreeMemory(b->device, r->corners_memory, NULL);
    vkDestroyBuffer(b->device, r->cameras, NULL);
    vkFreeMemory(b->device, r->cameras_memory, NULL);
    vkDestroyDescriptorPool(b->device, r->pool, NULL);
    vkDestroyPipeline(b->device, r->pipeline, NULL);
    vkDestroyPipelineLayout(b->device, r->layout, NULL);
    vkDestroyDescriptorSetLayout(b->device, r->set_layout, NULL);
}

void room_place(VkCommandBuffer commands, int x, int y, int width, int height)
{
    VkViewport viewport = {(float)x, (float)y, (float)width, (float)height, 0.0f, 1.0f};
    VkRect2D scissor = {{x, y}, {(uint32_t)width, (uint32_t)height}};
    vkCmdSetViewport(commands, 0, 1, &viewport);
    vkCmdSetScissor(commands, 0, 1, &scissor);
}

void room_draw(const room *r, VkCommandBuffer commands, const matrix *camera)
{
    const VkDeviceSize start = 0;
    vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, r->pipeline);
    vkCmdBindVertexBuffers(commands, 0, 1, &r->corners, &start);
    if (camera != NULL)
        vkCmdPushConstants(commands, r->layout, VK_SHADER_STAGE_VERTEX_BIT, 0, sizeof *camera, camera);
    else
        vkCmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, r->layout, 0, 1, &r->set, 0, NULL);
    vkCmdDraw(commands, CORNERS, 1, 0, 0);
}

matrix matrix_multiply(const matrix *a, const matrix *b)
{
    matrix product;
    for (int i = 0; i < 16; i++) {
        double sum = 0.0;
        for (int k = 0; k < 4; k++)
            sum += (double)a->m[4 * k + i % 4] * (double)b->m[4 * (i / 4) + k];
        product.m[i] = (float)sum;
    }
    return product;
}

static double radians(double degrees)
{
    return degrees * 3.14159265358979323846 / 180.0;
}

matrix matrix_camera(double yaw, double pitch)
{
    const double sy = sin(radians(yaw)), cy = cos(radians(yaw)), sp = sin(radians(pitch)), cp = cos(radians(pitch));
    /* Rows are the camera's axes in the world. */
    const double rows[3][3] = {{cy, 0.0, sy}, {-sp * sy, cp, sp * cy}, {-cp * sy, -sp, cp * cy}};
    matrix camera = {{0}};
    for (int row = 0; row < 3; row++) {
        for (int column = 0; column < 3; column++)
            camera.m[4 * column + row] = (float)rows[row][column];
    }
    camera.m[15] = 1.0f;
    return camera;
}

matrix matrix_perspective(double fov, double aspect)
{
    const double top = tan(0.5 * radians(fov));
    matrix lens = {{0}};
    lens.m[0] = (float)(1.0 / (top * aspect));
    lens.m[5] = (float)(-1.0 / top);
    lens.m[10] = (float)(ROOM_FAR / (ROOM_NEAR - ROOM_FAR));
    lens.m[11] = -1.0f;
    lens.m[14] = (float)(ROOM_NEAR * ROOM_FAR / (ROOM_NEAR - ROOM_FAR));
    return lens;
}
