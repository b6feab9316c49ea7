#include "player.h"

#include "scene_block.h"
#include "scene_comp.h"
#include "scene_input.h"
#include "scene_picture.h"
#include "scene_place.h"
#include "scene_pushed.h"
#include "scene_screen.h"
#include "scene_shade.h"

#include <stdlib.h>

enum { MOST_PIPELINES = 512, MOST_KEPT = 8192, NO_BLEND = 0, OVER, ADDED };

typedef struct {
    const uint32_t *words;
    size_t size;
} words;

#define WORDS(name) {name, sizeof name}

static const struct {
    words vertex, fragment;
    VkPrimitiveTopology topology;
    int blend;
    bool tests_depth, writes_depth, culls, has_input, samples;
} rows[] = {
    {WORDS(scene_pushed), WORDS(scene_shade), VK_PRIMITIVE_TOPOLOGY_TRIANGLE_LIST, NO_BLEND, true, true, false, false, false},
    {WORDS(scene_block), WORDS(scene_shade), VK_PRIMITIVE_TOPOLOGY_TRIANGLE_LIST, NO_BLEND, true, true, true, false, false},
    {WORDS(scene_screen), WORDS(scene_picture), VK_PRIMITIVE_TOPOLOGY_TRIANGLE_LIST, NO_BLEND, false, false, false, false, true},
    {WORDS(scene_input), WORDS(scene_shade), VK_PRIMITIVE_TOPOLOGY_TRIANGLE_STRIP, NO_BLEND, true, false, false, true, false},
    {WORDS(scene_pushed), WORDS(scene_picture), VK_PRIMITIVE_TOPOLOGY_TRIANGLE_LIST, OVER, true, true, false, false, true},
    {WORDS(scene_screen), WORDS(scene_shade), VK_PRIMITIVE_TOPOLOGY_TRIANGLE_LIST, OVER, false, false, false, false, false},
    {WORDS(scene_block), WORDS(scene_place), VK_PRIMITIVE_TOPOLOGY_TRIANGLE_FAN, NO_BLEND, false, false, false, false, false},
    {WORDS(scene_input), WORDS(scene_picture), VK_PRIMITIVE_TOPOLOGY_TRIANGLE_LIST, ADDED, false, false, false, true, true},
    {WORDS(scene_pushed), WORDS(scene_shade), VK_PRIMITIVE_TOPOLOGY_POINT_LIST, NO_BLEND, true, true, false, false, false},
    {WORDS(scene_block), WORDS(scene_shade), VK_PRIMITIVE_TOPOLOGY_LINE_STRIP, NO_BLEND, false, false, false, false, false},
    {WORDS(scene_screen), WORDS(scene_place), VK_PRIMITIVE_TOPOLOGY_TRIANGLE_LIST, ADDED, true, true, false, false, false},
    {WORDS(scene_pushed), WORDS(scene_shade), VK_PRIMITIVE_TOPOLOGY_TRIANGLE_LIST, OVER, true, false, true, false, false},
};
enum { ROWS = sizeof rows / sizeof rows[0] };

/* Properties that must be the same in a pipeline and in its pass. */
typedef struct {
    int row;
    bool is_dynamic, resolves;
    VkFormat color, second, depth;
    VkSampleCountFlagBits samples;
    VkPipeline pipeline;
} made;

static made pipelines[MOST_PIPELINES];
static int pipeline_count;
static VkPipeline compute;
static VkRenderPass passes[MOST_KEPT];
static VkFramebuffer framebuffers[MOST_KEPT];
static int pass_count, framebuffer_count;

static void no_room(void)
{
    expect(VK_ERROR_TOO_MANY_OBJECTS, "an episode with more objects");
}

VkRenderPass keep_pass(VkRenderPass pass)
{
    if (pass_count == MOST_KEPT)
        no_room();
    return passes[pass_count++] = pass;
}

VkFramebuffer keep_framebuffer(VkFramebuffer framebuffer)
{
    if (framebuffer_count == MOST_KEPT)
        no_room();
    return framebuffers[framebuffer_count++] = framebuffer;
}

bool pipeline_samples(int number)
{
    return rows[number % ROWS].samples;
}

bool pipeline_has_input(int number)
{
    return rows[number % ROWS].has_input;
}

static VkShaderModule module_of(const uint32_t *text, size_t size)
{
    const VkShaderModuleCreateInfo info = {
        .sType = VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO, .codeSize = size, .pCode = text};
    VkShaderModule module;
    expect(vkCreateShaderModule(it.w.device, &info, NULL, &module), "vkCreateShaderModule");
    return module;
}

static VkPipelineShaderStageCreateInfo stage_of(VkShaderStageFlagBits stage, const uint32_t *text, size_t size)
{
    return (VkPipelineShaderStageCreateInfo){.sType = VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO,
                                             .stage = stage,
                                             .module = module_of(text, size),
                                             .pName = "main"};
}

static VkPipelineColorBlendAttachmentState blend_of(int row)
{
    const bool added = rows[row].blend == ADDED;
    return (VkPipelineColorBlendAttachmentState){
        .blendEnable = rows[row].blend != NO_BLEND,
        .srcColorBlendFactor = added ? VK_BLEND_FACTOR_ONE : VK_BLEND_FACTOR_SRC_ALPHA,
        .dstColorBlendFactor = added ? VK_BLEND_FACTOR_ONE : VK_BLEND_FACTOR_ONE_MINUS_SRC_ALPHA,
        .srcAlphaBlendFactor = VK_BLEND_FACTOR_ONE,
        .dstAlphaBlendFactor = VK_BLEND_FACTOR_ONE_MINUS_SRC_ALPHA,
        .colorWriteMask = 0xf};
}

static VkPipeline create(const made *wanted)
{
    const int row = wanted->row;
    const VkPipelineShaderStageCreateInfo stages[] = {
        stage_of(VK_SHADER_STAGE_VERTEX_BIT, rows[row].vertex.words, rows[row].vertex.size),
        stage_of(VK_SHADER_STAGE_FRAGMENT_BIT, rows[row].fragment.words, rows[row].fragment.size)};
    const VkVertexInputBindingDescription binding = {0, 16, VK_VERTEX_INPUT_RATE_VERTEX};
    const VkVertexInputAttributeDescription attribute = {0, 0, VK_FORMAT_R32G32B32A32_SFLOAT, 0};
    const VkPipelineVertexInputStateCreateInfo input = {
        .sType = VK_STRUCTURE_TYPE_PIPELINE_VERTEX_INPUT_STATE_CREATE_INFO,
        .vertexBindingDescriptionCount = rows[row].has_input,
        .pVertexBindingDescriptions = &binding,
        .vertexAttributeDescriptionCount = rows[row].has_input,
        .pVertexAttributeDescriptions = &attribute};
    const VkPipelineInputAssemblyStateCreateInfo assembly = {
        .sType = VK_STRUCTURE_TYPE_PIPELINE_INPUT_ASSEMBLY_STATE_CREATE_INFO, .topology = rows[row].topology};
    const VkPipelineViewportStateCreateInfo viewports = {
        .sType = VK_STRUCTURE_TYPE_PIPELINE_VIEWPORT_STATE_CREATE_INFO, .viewportCount = 1, .scissorCount = 1};
    const VkPipelineRasterizationStateCreateInfo raster = {
        .sType = VK_STRUCTURE_TYPE_PIPELINE_RASTERIZATION_STATE_CREATE_INFO,
        .cullMode = rows[row].culls ? VK_CULL_MODE_BACK_BIT : VK_CULL_MODE_NONE,
        .lineWidth = 1.0f};
    const VkPipelineMultisampleStateCreateInfo multisample = {
        .sType = VK_STRUCTURE_TYPE_PIPELINE_MULTISAMPLE_STATE_CREATE_INFO, .rasterizationSamples = wanted->samples};
    const VkPipelineDepthStencilStateCreateInfo depths = {
        .sType = VK_STRUCTURE_TYPE_PIPELINE_DEPTH_STENCIL_STATE_CREATE_INFO,
        .depthTestEnable = rows[row].tests_depth,
        .depthWriteEnable = rows[row].writes_depth,
        .depthCompareOp = VK_COMPARE_OP_LESS_OR_EQUAL};
    const VkPipelineColorBlendAttachmentState blends[] = {blend_of(row), blend_of(row)};
    const uint32_t colors = wanted->second != VK_FORMAT_UNDEFINED ? 2 : 1;
    const VkPipelineColorBlendStateCreateInfo blend = {
        .sType = VK_STRUCTURE_TYPE_PIPELINE_COLOR_BLEND_STATE_CREATE_INFO, .attachmentCount = colors, .pAttachments = blends};
    const VkDynamicState states[] = {VK_DYNAMIC_STATE_VIEWPORT, VK_DYNAMIC_STATE_SCISSOR};
    const VkPipelineDynamicStateCreateInfo dynamic = {
        .sType = VK_STRUCTURE_TYPE_PIPELINE_DYNAMIC_STATE_CREATE_INFO, .dynamicStateCount = 2, .pDynamicStates = states};
    const VkFormat formats[] = {wanted->color, wanted->second};
    const VkPipelineRenderingCreateInfo rendering = {
        .sType = VK_STRUCTURE_TYPE_PIPELINE_RENDERING_CREATE_INFO,
        .colorAttachmentCount = colors,
        .pColorAttachmentFormats = formats,
        .depthAttachmentFormat = wanted->depth,
        .stencilAttachmentFormat = wanted->depth == VK_FORMAT_D32_SFLOAT_S8_UINT ? wanted->depth : VK_FORMAT_UNDEFINED};
    const VkGraphicsPipelineCreateInfo info = {.sType = VK_STRUCTURE_TYPE_GRAPHICS_PIPELINE_CREATE_INFO,
                                               .pNext = wanted->is_dynamic ? &rendering : NULL,
                                               .stageCount = 2,
                                               .pStages = stages,
                                               .pVertexInputState = &input,
                                               .pInputAssemblyState = &assembly,
                                               .pViewportState = &viewports,
                                               .pRasterizationState = &raster,
                                               .pMultisampleState = &multisample,
                                               .pDepthStencilState = &depths,
                                               .pColorBlendState = &blend,
                                               .pDynamicState = &dynamic,
                                               .layout = it.layout,
                                               .renderPass = wanted->is_dynamic ? VK_NULL_HANDLE : it.pass.pass};
    VkPipeline pipeline = VK_NULL_HANDLE;
    check(vkCreateGraphicsPipelines(it.w.device, VK_NULL_HANDLE, 1, &info, NULL, &pipeline));
    vkDestroyShaderModule(it.w.device, stages[0].module, NULL);
    vkDestroyShaderModule(it.w.device, stages[1].module, NULL);
    return pipeline;
}

/* Pipeline of a row of the table for the current pass. */
VkPipeline pipeline_of_pass(int number)
{
    const pass_state *p = &it.pass;
    made wanted = {.row = number % ROWS,
                   .is_dynamic = p->is_dynamic,
                   .resolves = p->resolve != NULL && !p->is_dynamic,
                   .color = p->color->kind->format,
                   .second = p->second != NULL ? p->second->kind->format : VK_FORMAT_UNDEFINED,
                   .depth = p->depth != NULL ? p->depth->kind->format : VK_FORMAT_UNDEFINED,
                   .samples = p->color->kind->samples};
    for (int i = 0; i < pipeline_count; i++) {
        const made *m = &pipelines[i];
        if (m->row == wanted.row && m->is_dynamic == wanted.is_dynamic && m->resolves == wanted.resolves &&
            m->color == wanted.color && m->second == wanted.second && m->depth == wanted.depth && m->samples == wanted.samples)
            return m->pipeline;
    }
    if (pipeline_count == MOST_PIPELINES)
        no_room();
    wanted.pipeline = create(&wanted);
    pipelines[pipeline_count++] = wanted;
    return wanted.pipeline;
}

VkPipeline pipeline_of_compute(void)
{
    if (compute != VK_NULL_HANDLE)
        return compute;
    const VkComputePipelineCreateInfo info = {.sType = VK_STRUCTURE_TYPE_COMPUTE_PIPELINE_CREATE_INFO,
                                              .stage = stage_of(VK_SHADER_STAGE_COMPUTE_BIT, scene_comp, sizeof scene_comp),
                                              .layout = it.layout};
    check(vkCreateComputePipelines(it.w.device, VK_NULL_HANDLE, 1, &info, NULL, &compute));
    vkDestroyShaderModule(it.w.device, info.stage.module, NULL);
    return compute;
}

void pipelines_free(void)
{
    for (int i = 0; i < pipeline_count; i++)
        vkDestroyPipeline(it.w.device, pipelines[i].pipeline, NULL);
    vkDestroyPipeline(it.w.device, compute, NULL);
    for (int i = 0; i < framebuffer_count; i++)
        vkDestroyFramebuffer(it.w.device, framebuffers[i], NULL);
    for (int i = 0; i < pass_count; i++)
        vkDestroyRenderPass(it.w.device, passes[i], NULL);
    pipeline_count = pass_count = framebuffer_count = 0;
    compute = VK_NULL_HANDLE;
}
