/* Graphics pipelines: triangles or points without vertex buffers, as a whole or linked from libraries. */
#ifndef APPS_VULKAN_PIPELINES_H
#define APPS_VULKAN_PIPELINES_H

#include "window.h"

typedef struct {
    const uint32_t *words;
    size_t size;
} shader_words;

/* The words of a header that glslangValidator made. */
#define SHADER(name) ((shader_words){name, sizeof name})

enum { MOST_LIBRARIES = 4 };

typedef struct {
    shader_words vertex, fragment;
    shader_words geometry;                /* without words: none */
    shader_words control, evaluation;     /* of a tessellation of triangles, likewise; not in libraries */
    VkPipelineLayout layout;
    VkRenderPass pass; /* null: for dynamic rendering, with these attachments */
    uint32_t subpass;
    VkFormat color, second, depth; /* `second`: of another colour, if there is one */
    bool colorless;             /* the pass has no colour */
    uint32_t view_mask;
    VkSampleCountFlagBits samples;
    bool deep;                  /* tested by depth */
    bool silent;                /* writes nothing */
    bool points;                /* draws points, not triangles */
    const VkPrimitiveTopology *topology; /* draws these; null: triangles, patches of them, or points */
    bool last;                  /* the last vertex of a primitive is the provoking one */
    bool topology_by_commands;  /* commands set which of its class are drawn */
    const VkViewport *viewport; /* null: set by commands, as the scissor is */
    uint32_t libraries;         /* 0: one pipeline; 2: outputs apart; 4: each part apart */
} pipeline_description;

/* A pipeline, and the libraries that it is linked from. */
typedef struct {
    VkPipeline whole, libraries[MOST_LIBRARIES];
} linked_pipeline;

linked_pipeline make_pipeline(const vulkan_window *w, const pipeline_description *description);
void free_pipeline(const vulkan_window *w, linked_pipeline *pipeline);

#endif
