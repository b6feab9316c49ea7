#include "pipelines.h"

enum { MOST_STAGES = 5 };

static VkShaderModule shader(const vulkan_window *w, shader_words words)
{
    const VkShaderModuleCreateInfo info = {
        .sType = VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO, .codeSize = words.size, .pCode = words.words};
    VkShaderModule module;
    expect(vkCreateShaderModule(w->device, &info, NULL, &module), "vkCreateShaderModule");
    return module;
}

static VkPipeline create(const vulkan_window *w, const VkGraphicsPipelineCreateInfo *info)
{
    VkPipeline made;
    expect(vkCreateGraphicsPipelines(w->device, VK_NULL_HANDLE, 1, info, NULL, &made), "vkCreateGraphicsPipelines");
    return made;
}

/* A library with these parts of a pipeline. States of other parts are ignored. */
static VkPipeline create_library(const vulkan_window *w, VkGraphicsPipelineCreateInfo info,
                                 VkGraphicsPipelineLibraryFlagsEXT parts)
{
    const bool vertex = (parts & VK_GRAPHICS_PIPELINE_LIBRARY_PRE_RASTERIZATION_SHADERS_BIT_EXT) != 0;
    const bool fragment = (parts & VK_GRAPHICS_PIPELINE_LIBRARY_FRAGMENT_SHADER_BIT_EXT) != 0;
    const bool output = (parts & VK_GRAPHICS_PIPELINE_LIBRARY_FRAGMENT_OUTPUT_INTERFACE_BIT_EXT) != 0;
    /* Without a view mask the attachments matter only for the output. */
    const VkGraphicsPipelineLibraryCreateInfoEXT library = {
        .sType = VK_STRUCTURE_TYPE_GRAPHICS_PIPELINE_LIBRARY_CREATE_INFO_EXT,
        .pNext = output ? (void *)info.pNext : NULL,
        .flags = parts};
    info.pNext = &library;
    info.flags |= VK_PIPELINE_CREATE_LIBRARY_BIT_KHR;
    info.pStages += vertex ? 0 : 1;
    info.stageCount = (uint32_t)vertex + (uint32_t)fragment;
    return create(w, &info);
}

static linked_pipeline link_pipeline(const vulkan_window *w, const VkGraphicsPipelineCreateInfo *info, uint32_t count)
{
    const VkGraphicsPipelineLibraryFlagsEXT input = VK_GRAPHICS_PIPELINE_LIBRARY_VERTEX_INPUT_INTERFACE_BIT_EXT;
    const VkGraphicsPipelineLibraryFlagsEXT vertex = VK_GRAPHICS_PIPELINE_LIBRARY_PRE_RASTERIZATION_SHADERS_BIT_EXT;
    const VkGraphicsPipelineLibraryFlagsEXT fragment = VK_GRAPHICS_PIPELINE_LIBRARY_FRAGMENT_SHADER_BIT_EXT;
    const VkGraphicsPipelineLibraryFlagsEXT output = VK_GRAPHICS_PIPELINE_LIBRARY_FRAGMENT_OUTPUT_INTERFACE_BIT_EXT;
    const VkGraphicsPipelineLibraryFlagsEXT apart[] = {input, vertex, fragment, output};
    const VkGraphicsPipelineLibraryFlagsEXT shaders_and_output[] = {input | vertex | fragment, output};
    linked_pipeline made = {.whole = VK_NULL_HANDLE};
    for (uint32_t i = 0; i < count; i++)
        made.libraries[i] = create_library(w, *info, count == 2 ? shaders_and_output[i] : apart[i]);
    const VkPipelineLibraryCreateInfoKHR libraries = {.sType = VK_STRUCTURE_TYPE_PIPELINE_LIBRARY_CREATE_INFO_KHR,
                                                      .libraryCount = count,
                                                      .pLibraries = made.libraries};
    const VkGraphicsPipelineCreateInfo whole = {
        .sType = VK_STRUCTURE_TYPE_GRAPHICS_PIPELINE_CREATE_INFO, .pNext = &libraries, .layout = info->layout};
    made.whole = create(w, &whole);
    return made;
}

linked_pipeline make_pipeline(const vulkan_window *w, const pipeline_description *description)
{
    const bool patches = description->control.words != NULL;
    /* create_library expects the vertex stage first and the fragment stage second. */
    const struct {
        VkShaderStageFlagBits stage;
        shader_words words;
    } given[MOST_STAGES] = {{VK_SHADER_STAGE_VERTEX_BIT, description->vertex},
                            {VK_SHADER_STAGE_FRAGMENT_BIT, description->fragment},
                            {VK_SHADER_STAGE_GEOMETRY_BIT, description->geometry},
                            {VK_SHADER_STAGE_TESSELLATION_CONTROL_BIT, description->control},
                            {VK_SHADER_STAGE_TESSELLATION_EVALUATION_BIT, description->evaluation}};
    VkPipelineShaderStageCreateInfo stages[MOST_STAGES];
    uint32_t count = 0;
    for (int i = 0; i < MOST_STAGES; i++)
        if (given[i].words.words != NULL)
            stages[count++] = (VkPipelineShaderStageCreateInfo){.sType = VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO,
                                                                .stage = given[i].stage,
                                                                .module = shader(w, given[i].words),
                                                                .pName = "main"};
    const VkPipelineVertexInputStateCreateInfo input = {
        .sType = VK_STRUCTURE_TYPE_PIPELINE_VERTEX_INPUT_STATE_CREATE_INFO};
    const VkPipelineInputAssemblyStateCreateInfo assembly = {
        .sType = VK_STRUCTURE_TYPE_PIPELINE_INPUT_ASSEMBLY_STATE_CREATE_INFO,
        .topology = description->topology != NULL ? *description->topology
                    : description->points ? VK_PRIMITIVE_TOPOLOGY_POINT_LIST
                    : patches           ? VK_PRIMITIVE_TOPOLOGY_PATCH_LIST
                                        : VK_PRIMITIVE_TOPOLOGY_TRIANGLE_LIST};
    const VkPipelineTessellationStateCreateInfo tessellation = {
        .sType = VK_STRUCTURE_TYPE_PIPELINE_TESSELLATION_STATE_CREATE_INFO, .patchControlPoints = 3};
    const VkRect2D scissor = {{0, 0}, w->extent};
    const VkPipelineViewportStateCreateInfo windows = {.sType = VK_STRUCTURE_TYPE_PIPELINE_VIEWPORT_STATE_CREATE_INFO,
                                                       .viewportCount = 1,
                                                       .pViewports = description->viewport,
                                                       .scissorCount = 1,
                                                       .pScissors = &scissor};
    const VkPipelineRasterizationProvokingVertexStateCreateInfoEXT provoking = {
        .sType = VK_STRUCTURE_TYPE_PIPELINE_RASTERIZATION_PROVOKING_VERTEX_STATE_CREATE_INFO_EXT,
        .provokingVertexMode = VK_PROVOKING_VERTEX_MODE_LAST_VERTEX_EXT};
    const VkPipelineRasterizationStateCreateInfo raster = {
        .sType = VK_STRUCTURE_TYPE_PIPELINE_RASTERIZATION_STATE_CREATE_INFO,
        .pNext = description->last ? &provoking : NULL,
        .lineWidth = 1.0f};
    const VkPipelineMultisampleStateCreateInfo multisample = {
        .sType = VK_STRUCTURE_TYPE_PIPELINE_MULTISAMPLE_STATE_CREATE_INFO, .rasterizationSamples = description->samples};
    const VkPipelineDepthStencilStateCreateInfo depths = {
        .sType = VK_STRUCTURE_TYPE_PIPELINE_DEPTH_STENCIL_STATE_CREATE_INFO,
        .depthTestEnable = description->deep,
        .depthWriteEnable = description->deep && !description->silent,
        .depthCompareOp = VK_COMPARE_OP_LESS_OR_EQUAL};
    const uint32_t colors = description->colorless ? 0 : description->second == VK_FORMAT_UNDEFINED ? 1 : 2;
    const VkFormat formats[] = {description->color, description->second};
    const VkPipelineColorBlendAttachmentState blend = {.colorWriteMask = description->silent ? 0 : 0xf};
    const VkPipelineColorBlendAttachmentState all_blends[] = {blend, blend};
    const VkPipelineColorBlendStateCreateInfo blends = {
        .sType = VK_STRUCTURE_TYPE_PIPELINE_COLOR_BLEND_STATE_CREATE_INFO, .attachmentCount = colors, .pAttachments = all_blends};
    const VkDynamicState states[] = {VK_DYNAMIC_STATE_VIEWPORT, VK_DYNAMIC_STATE_SCISSOR,
                                     VK_DYNAMIC_STATE_PRIMITIVE_TOPOLOGY};
    const VkPipelineDynamicStateCreateInfo dynamic = {.sType = VK_STRUCTURE_TYPE_PIPELINE_DYNAMIC_STATE_CREATE_INFO,
                                                      .dynamicStateCount = description->topology_by_commands ? 3 : 2,
                                                      .pDynamicStates = states};
    const VkPipelineRenderingCreateInfo rendering = {.sType = VK_STRUCTURE_TYPE_PIPELINE_RENDERING_CREATE_INFO,
                                                     .viewMask = description->view_mask,
                                                     .colorAttachmentCount = colors,
                                                     .pColorAttachmentFormats = formats,
                                                     .depthAttachmentFormat = description->depth};
    const VkGraphicsPipelineCreateInfo info = {.sType = VK_STRUCTURE_TYPE_GRAPHICS_PIPELINE_CREATE_INFO,
                                               .pNext = description->pass == VK_NULL_HANDLE ? &rendering : NULL,
                                               .stageCount = count,
                                               .pStages = stages,
                                               .pVertexInputState = description->input != NULL ? description->input : &input,
                                               .pInputAssemblyState = &assembly,
                                               .pTessellationState = patches ? &tessellation : NULL,
                                               .pViewportState = &windows,
                                               .pRasterizationState = &raster,
                                               .pMultisampleState = &multisample,
                                               .pDepthStencilState = &depths,
                                               .pColorBlendState = &blends,
                                               .pDynamicState = description->viewport == NULL ? &dynamic : NULL,
                                               .layout = description->layout,
                                               .renderPass = description->pass,
                                               .subpass = description->subpass};
    const linked_pipeline made = description->libraries > 0 ? link_pipeline(w, &info, description->libraries)
                                                            : (linked_pipeline){.whole = create(w, &info)};
    for (uint32_t i = 0; i < count; i++)
        vkDestroyShaderModule(w->device, stages[i].module, NULL);
    return made;
}

void free_pipeline(const vulkan_window *w, linked_pipeline *pipeline)
{
    vkDestroyPipeline(w->device, pipeline->whole, NULL);
    for (int i = 0; i < MOST_LIBRARIES; i++)
        vkDestroyPipeline(w->device, pipeline->libraries[i], NULL);
    *pipeline = (linked_pipeline){.whole = VK_NULL_HANDLE};
}
