/*
 * Graphics pipelines that draw triangles or points without vertex buffers, as a whole or linked
 * from libraries.
 */
#ifndef APPS_VULKAN_PIPELINES_H
#define APPS_VULKAN_PIPELINES_H

#include "window.h"

typedef struct {
    const uint32_t *words;
    size_t size;
} shader_words;

/* Words of a header that glslangValidator generated. */
#define SHADER(name) ((shader_words){name, sizeof name})

enum { MOST_LIBRARIES = 4 };

typedef struct {
    shader_words vertex, fragment;
    shader_words geometry;                /* no words: no geometry shader */
    shader_words control, evaluation;     /* tessellation of triangles, likewise; not in libraries */
    VkPipelineLayout layout;
    VkRenderPass pass; /* null: dynamic rendering with these formats */
    uint32_t subpass;
    VkFormat color, second, depth; /* `second`: format of the second colour, if there is one */
    bool colorless;             /* the pass has no colour */
    uint32_t view_mask;
    VkSampleCountFlagBits samples;
    bool deep;                  /* depth test is on */
    bool silent;                /* writes nothing */
    bool points;                /* draws points instead of triangles */
    const VkPrimitiveTopology *topology; /* topology; null: triangles, patches of triangles, or points */
    const VkPipelineVertexInputStateCreateInfo *input; /* null: no vertex buffers */
    bool last;                  /* the last vertex of a primitive is the provoking one */
    bool topology_by_commands;  /* commands set the topology within its class */
    const VkViewport *viewport; /* null: set by commands, and so is the scissor */
    uint32_t libraries;         /* 0: one pipeline; 2: outputs separate; 4: each part separate */
} pipeline_description;

/* A pipeline and the libraries from which it is linked. */
typedef struct {
    VkPipeline whole, libraries[MOST_LIBRARIES];
} linked_pipeline;

linked_pipeline make_pipeline(const vulkan_window *w, const pipeline_description *description);
void free_pipeline(const vulkan_window *w, linked_pipeline *pipeline);

#endif
