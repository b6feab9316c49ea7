/*
 * A Vulkan program whose own shader projects to the output, with the C interface:
 * vk_project [--method METHOD] [--views atlas|layers|images] [options of the direction test]
 *
 * Draws the cells of the direction cube into views as the interface says. Its shader has the
 * library's functions in its text. Cupola corrects the views into the window. Exits with 1 if an
 * answer was wrong.
 */
#include "direction.h"
#include "frames.h"
#include "pipelines.h"

#include "cube_frag.h"

#include <cupola_vk.h>

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/*
 * SLICE is the distance between the vectors of two views: the largest alignment that a device may
 * require.
 */
enum { MOST_VIEWS = 16, SLICE = 256, SET = 1, BINDING = 2, VERTICES = 6 * 6 * 64 * 64 };

static direction_options direction = DIRECTION_DEFAULTS;
static const char *method = "vertex";
static uint32_t arrangement = CUPOLA_VK_ATLAS;
static bool good = true;

static vulkan_window w;
static cupola_vk *dome;
static uint32_t view_count, image_count;
static cupola_vk_view views[MOST_VIEWS];
static cupola_vk_source sources[MOST_VIEWS];
static VkImageView layers[MOST_VIEWS];
static picture depths[MOST_VIEWS];
static VkDescriptorSetLayout layouts[SET + 1];
static VkDescriptorPool pool;
static VkDescriptorSet set;
static VkPipelineLayout layout;
static linked_pipeline pipeline;
static block vectors;

static void check(bool right, const char *what)
{
    char detail[512] = "";
    if (right)
        return;
    good = false;
    cupola_last_error(detail, sizeof detail, NULL);
    fprintf(stderr, "wrong: %s (last error: %s)\n", what, detail);
}

#define CHECK(condition) check(condition, #condition)

static void *read_file(const char *path, size_t *size)
{
    FILE *file = fopen(path, "rb");
    if (file == NULL || fseek(file, 0, SEEK_END) != 0) {
        perror(path);
        exit(1);
    }
    *size = (size_t)ftell(file);
    rewind(file);
    char *bytes = calloc(*size + 1, 1);
    if (bytes == NULL || fread(bytes, 1, *size, file) != *size)
        exit(1);
    fclose(file);
    return bytes;
}

/* Compiles the cube's shader with the library's functions inserted after its first line. */
static shader_words make_shader(void)
{
    size_t length = 0, size;
    CHECK(cupola_vk_projection_source(SET, BINDING, NULL, 0, &length) == CUPOLA_OK && length > 0);
    char *functions = malloc(length + 1), *given = read_file(SOURCES "/cube.vert", &size);
    if (functions == NULL)
        abort();
    CHECK(cupola_vk_projection_source(SET, BINDING, functions, length + 1, NULL) == CUPOLA_OK);
    const char *behind = strchr(given, '\n') + 1;
    FILE *file = fopen("project.vert", "w");
    if (file == NULL)
        abort();
    fprintf(file, "%.*s%s%s", (int)(behind - given), given, functions, behind);
    fclose(file);
    free(functions);
    free(given);
    CHECK(system("glslangValidator --quiet -V -DCELLS -DPROJECTING -o project.spv project.vert >&2") == 0);
    shader_words made;
    made.words = read_file("project.spv", &made.size);
    return made;
}

static void open_dome(void)
{
    char text[256];
    cupola_rig *rig = NULL;
    const cupola_vk_options options = {.struct_size = sizeof options,
                                       .get_instance_proc_addr = vkGetInstanceProcAddr,
                                       .instance = w.instance,
                                       .physical_device = w.physical,
                                       .device = w.device,
                                       .queue_family = w.family,
                                       .frames_in_flight = 1,
                                       .width = w.extent.width,
                                       .height = w.extent.height,
                                       .target_format = w.format,
                                       .view_format = w.format,
                                       .arrangement = arrangement};
    snprintf(text, sizeof text, "[dome]\ntilt = 90.0\n[[output]]\nkind = \"domemaster\"\nmethod = \"%s\"\n", method);
    CHECK(cupola_rig_parse(text, "", &rig) == CUPOLA_OK);
    CHECK(cupola_vk_create_projecting(NULL, &options, &dome) == CUPOLA_INVALID_ARGUMENT);
    CHECK(cupola_vk_create_projecting(rig, &options, &dome) == CUPOLA_OK);
    cupola_rig_free(rig);
    if (dome == NULL)
        exit(1);
    CHECK(cupola_vk_view_count(dome, &view_count) == CUPOLA_OK && view_count <= MOST_VIEWS);
    CHECK((strcmp(method, "fragment") == 0) == (view_count > 1));
    CHECK(cupola_vk_image_count(dome, &image_count) == CUPOLA_OK);
    for (uint32_t i = 0; i < image_count; i++) {
        sources[i].struct_size = sizeof sources[i];
        CHECK(cupola_vk_get_source(dome, 0, i, &sources[i]) == CUPOLA_OK);
    }
    cupola_vk_target targets[MOST_IMAGES];
    for (uint32_t i = 0; i < w.count; i++)
        targets[i] = (cupola_vk_target){.struct_size = sizeof targets[i],
                                        .image = w.images[i],
                                        .view = w.views[i],
                                        .width = w.extent.width,
                                        .height = w.extent.height,
                                        .initial_layout = VK_IMAGE_LAYOUT_UNDEFINED,
                                        .final_layout = VK_IMAGE_LAYOUT_PRESENT_SRC_KHR,
                                        .before_stages = VK_PIPELINE_STAGE_ALL_COMMANDS_BIT};
    CHECK(cupola_vk_set_targets(dome, w.count, targets) == CUPOLA_OK);
}

/* Creates the images to which views are drawn, and a depth for them. */
static void make_pictures(void)
{
    for (uint32_t i = 0; i < view_count; i++) {
        const cupola_vk_source *source = &sources[views[i].image];
        const VkImageViewCreateInfo info = {.sType = VK_STRUCTURE_TYPE_IMAGE_VIEW_CREATE_INFO,
                                            .image = source->image,
                                            .viewType = VK_IMAGE_VIEW_TYPE_2D,
                                            .format = source->format,
                                            .subresourceRange = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 1, views[i].layer, 1}};
        expect(vkCreateImageView(w.device, &info, NULL, &layers[i]), "vkCreateImageView");
        depths[i] = make_picture(&w, DEPTH_FORMAT, (VkExtent2D){source->width, source->height}, VK_SAMPLE_COUNT_1_BIT,
                                 VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT);
    }
}

static void make_sets(void)
{
    const VkDescriptorType kind = VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER_DYNAMIC;
    const VkDescriptorSetLayoutBinding binding = {BINDING, kind, 1, VK_SHADER_STAGE_VERTEX_BIT, NULL};
    for (uint32_t i = 0; i <= SET; i++) {
        const VkDescriptorSetLayoutCreateInfo info = {.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO,
                                                      .bindingCount = i == SET ? 1 : 0,
                                                      .pBindings = &binding};
        expect(vkCreateDescriptorSetLayout(w.device, &info, NULL, &layouts[i]), "vkCreateDescriptorSetLayout");
    }
    const VkPushConstantRange range = {VK_SHADER_STAGE_VERTEX_BIT, 0, sizeof(matrix4)};
    const VkPipelineLayoutCreateInfo all = {.sType = VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO,
                                            .setLayoutCount = SET + 1,
                                            .pSetLayouts = layouts,
                                            .pushConstantRangeCount = 1,
                                            .pPushConstantRanges = &range};
    expect(vkCreatePipelineLayout(w.device, &all, NULL, &layout), "vkCreatePipelineLayout");
    const VkDescriptorPoolSize size = {kind, 1};
    const VkDescriptorPoolCreateInfo info = {
        .sType = VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO, .maxSets = 1, .poolSizeCount = 1, .pPoolSizes = &size};
    expect(vkCreateDescriptorPool(w.device, &info, NULL, &pool), "vkCreateDescriptorPool");
    const VkDescriptorSetAllocateInfo allocate = {.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_ALLOCATE_INFO,
                                                  .descriptorPool = pool,
                                                  .descriptorSetCount = 1,
                                                  .pSetLayouts = &layouts[SET]};
    expect(vkAllocateDescriptorSets(w.device, &allocate, &set), "vkAllocateDescriptorSets");
    const VkDescriptorBufferInfo buffer = {vectors.buffer, 0, 32 * sizeof(float)};
    const VkWriteDescriptorSet write = {.sType = VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET,
                                        .dstSet = set,
                                        .dstBinding = BINDING,
                                        .descriptorCount = 1,
                                        .descriptorType = kind,
                                        .pBufferInfo = &buffer};
    vkUpdateDescriptorSets(w.device, 1, &write, 0, NULL);
}

/* Gets the views, and the shader's values for each. */
static void ask_views(void)
{
    const matrix4 matrix = direction_matrix(&direction, w.extent, false);
    matrix4 flat = matrix;
    float got[32];
    flat.m[3] = flat.m[7] = flat.m[11] = 0.0f;
    flat.m[15] = 1.0f;
    CHECK(cupola_vk_get_projection(dome, view_count, matrix.m, got) == CUPOLA_INVALID_ARGUMENT);
    CHECK(cupola_vk_get_projection(dome, 0, flat.m, got) == CUPOLA_INVALID_ARGUMENT);
    CHECK(cupola_vk_get_projection(dome, 0, NULL, got) == CUPOLA_INVALID_ARGUMENT);
    CHECK(cupola_vk_get_projection(dome, 0, matrix.m, NULL) == CUPOLA_INVALID_ARGUMENT);
    for (uint32_t i = 0; i < view_count; i++) {
        views[i].struct_size = sizeof views[i];
        CHECK(cupola_vk_get_view(dome, i, 0.25, 100.0, &views[i]) == CUPOLA_OK);
        CHECK(cupola_vk_get_projection(dome, i, matrix.m, got) == CUPOLA_OK);
        memcpy((char *)vectors.bytes + i * SLICE, got, sizeof got);
    }
}

static void draw_view(VkCommandBuffer buffer, uint32_t index)
{
    const cupola_vk_view *view = &views[index];
    const matrix4 matrix = direction_matrix(&direction, w.extent, false);
    const VkViewport viewport = {(float)view->x, (float)view->y, (float)view->width, (float)view->height, 0, 1};
    const VkRect2D area = {{view->x, view->y}, {(uint32_t)view->width, (uint32_t)view->height}};
    const VkRenderingAttachmentInfo color = {.sType = VK_STRUCTURE_TYPE_RENDERING_ATTACHMENT_INFO,
                                             .imageView = layers[index],
                                             .imageLayout = VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL,
                                             .loadOp = VK_ATTACHMENT_LOAD_OP_CLEAR,
                                             .storeOp = VK_ATTACHMENT_STORE_OP_STORE,
                                             .clearValue = {.color = {.float32 = {0.25f, 0.25f, 0.25f, 1.0f}}}};
    const VkRenderingAttachmentInfo deep = {.sType = VK_STRUCTURE_TYPE_RENDERING_ATTACHMENT_INFO,
                                            .imageView = depths[index].view,
                                            .imageLayout = VK_IMAGE_LAYOUT_DEPTH_ATTACHMENT_OPTIMAL,
                                            .loadOp = VK_ATTACHMENT_LOAD_OP_CLEAR,
                                            .clearValue = {.depthStencil = {1.0f, 0}}};
    const VkRenderingInfo info = {.sType = VK_STRUCTURE_TYPE_RENDERING_INFO,
                                  .renderArea = area,
                                  .layerCount = 1,
                                  .colorAttachmentCount = 1,
                                  .pColorAttachments = &color,
                                  .pDepthAttachment = &deep};
    const uint32_t offset = index * SLICE;
    change_layout(buffer, depths[index].image, VK_IMAGE_ASPECT_DEPTH_BIT, VK_IMAGE_LAYOUT_UNDEFINED,
                  VK_IMAGE_LAYOUT_DEPTH_ATTACHMENT_OPTIMAL);
    vkCmdBeginRendering(buffer, &info);
    vkCmdBindPipeline(buffer, VK_PIPELINE_BIND_POINT_GRAPHICS, pipeline.whole);
    vkCmdBindDescriptorSets(buffer, VK_PIPELINE_BIND_POINT_GRAPHICS, layout, SET, 1, &set, 1, &offset);
    vkCmdPushConstants(buffer, layout, VK_SHADER_STAGE_VERTEX_BIT, 0, sizeof matrix, &matrix);
    vkCmdSetViewport(buffer, 0, 1, &viewport);
    vkCmdSetScissor(buffer, 0, 1, &area);
    vkCmdDraw(buffer, VERTICES, 1, 0, 0);
    vkCmdEndRendering(buffer);
}

static void record(VkCommandBuffer buffer, uint32_t index)
{
    const VkCommandBufferBeginInfo begin = {.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO};
    expect(vkBeginCommandBuffer(buffer, &begin), "vkBeginCommandBuffer");
    for (uint32_t i = 0; i < image_count; i++) {
        const VkImageMemoryBarrier barrier = {
            .sType = VK_STRUCTURE_TYPE_IMAGE_MEMORY_BARRIER,
            .dstAccessMask = VK_ACCESS_COLOR_ATTACHMENT_WRITE_BIT,
            .newLayout = sources[i].layout,
            .image = sources[i].image,
            .subresourceRange = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 1, 0, VK_REMAINING_ARRAY_LAYERS}};
        vkCmdPipelineBarrier(buffer, VK_PIPELINE_STAGE_ALL_COMMANDS_BIT, VK_PIPELINE_STAGE_ALL_COMMANDS_BIT, 0, 0, NULL, 0,
                             NULL, 1, &barrier);
    }
    for (uint32_t i = 0; i < view_count; i++)
        draw_view(buffer, i);
    CHECK(cupola_vk_record(dome, buffer, 0, index, 0, 0) == CUPOLA_OK);
    expect(vkEndCommandBuffer(buffer), "vkEndCommandBuffer");
}

/* The frames so far are counted. Some of them are measured. */
static void ask_statistics(void)
{
    cupola_vk_statistics counts = {.struct_size = 0};
    CHECK(cupola_vk_get_statistics(dome, &counts) == CUPOLA_INVALID_ARGUMENT);
    counts.struct_size = sizeof counts;
    CHECK(cupola_vk_get_statistics(dome, NULL) == CUPOLA_INVALID_ARGUMENT);
    CHECK(cupola_vk_get_statistics(dome, &counts) == CUPOLA_OK);
    CHECK(counts.struct_size == sizeof counts && counts.frames == (uint64_t)direction.frames);
    CHECK(counts.measured_frames < counts.frames && counts.last_nanoseconds <= counts.nanoseconds);
    CHECK((counts.measured_frames > 0) == (counts.nanoseconds > 0));
}

static void parse(int argc, char **argv)
{
    static const char *const arrangements[] = {"atlas", "layers", "images"};
    for (int i = 1; i + 1 < argc; i += 2) {
        const char *option = argv[i], *value = argv[i + 1];
        if (strcmp(option, "--method") == 0)
            method = value;
        else if (strcmp(option, "--views") == 0)
            arrangement = (uint32_t)choice(value, arrangements, 3);
        else if (!take_direction(&direction, option, value)) {
            fprintf(stderr, "usage: vk_project [--method METHOD] [--views atlas|layers|images] " DIRECTION_USAGE "\n");
            exit(2);
        }
    }
}

int main(int argc, char **argv)
{
    parse(argc, argv);
    window_open(&w, direction.x, direction.y, direction.width, direction.height, false, false, 0);
    open_dome();
    vectors = make_block(&w, MOST_VIEWS * SLICE, VK_BUFFER_USAGE_UNIFORM_BUFFER_BIT, true);
    ask_views();
    make_pictures();
    make_sets();
    const pipeline_description description = {.vertex = make_shader(),
                                              .fragment = SHADER(cube_frag),
                                              .layout = layout,
                                              .color = w.format,
                                              .depth = DEPTH_FORMAT,
                                              .samples = VK_SAMPLE_COUNT_1_BIT,
                                              .deep = true};
    pipeline = make_pipeline(&w, &description);
    frame_objects objects = make_frame_objects(&w);
    VkCommandBuffer commands[MOST_IMAGES];
    make_commands(&w, &objects, VK_COMMAND_BUFFER_LEVEL_PRIMARY, MOST_IMAGES, commands);
    for (int number = 0; number < direction.frames; number++) {
        const uint32_t index = next_image(&w, &objects);
        record(commands[index], index);
        end_frame(&w, &objects, commands[index], index);
    }
    if (direction.shot != NULL)
        window_shot(&w, direction.shot);
    expect(vkDeviceWaitIdle(w.device), "vkDeviceWaitIdle");
    ask_statistics();
    CHECK(cupola_vk_destroy(dome) == CUPOLA_OK);
    free_pipeline(&w, &pipeline);
    free((void *)description.vertex.words);
    free_frame_objects(&w, &objects);
    free_block(&w, &vectors);
    vkDestroyPipelineLayout(w.device, layout, NULL);
    vkDestroyDescriptorPool(w.device, pool, NULL);
    for (uint32_t i = 0; i <= SET; i++)
        vkDestroyDescriptorSetLayout(w.device, layouts[i], NULL);
    for (uint32_t i = 0; i < view_count; i++) {
        vkDestroyImageView(w.device, layers[i], NULL);
        free_picture(&w, &depths[i]);
    }
    window_close(&w);
    return good ? 0 : 1;
}
