/*
 * The direction test's cube as a toolkit shows it: drawn to an image, which is shown in a part of
 * the window between widgets, an orange background and a green menu (--way). The image is blitted
 * there (blit) or copied (copy), or it is sampled by a rectangle whose place its vertices have
 * (drawn) or the viewport (viewport). Or it is shown in a small part of the window (small, and
 * small-blit). --resizes changes the size of the window and of the image, and back, that many times.
 * --picture writes the image's pixels, which the program then copies to memory in each frame, and
 * --window those of the window.
 */
#include "direction.h"
#include "frames.h"
#include "pipelines.h"

/* Compiled by glslangValidator. */
#include "cube_frag.h"
#include "cube_push.h"
#include "panes_plain.h"
#include "panes_shown.h"
#include "panes_vert.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* A number that 8 bits hold. Half lies between two, and which of them llvmpipe takes differs from frame to frame. */
#define MIDDLE (128.0f / 255.0f)

typedef enum { BLIT, COPY, DRAWN, VIEWPORT, SMALL, SMALL_BLIT, WAYS } way_kind;
static const char *const ways[WAYS] = {"blit", "copy", "drawn", "viewport", "small", "small-blit"};

static struct {
    direction_options direction;
    way_kind way;
    int resizes;
    const char *picture, *window;
} options = {.direction = DIRECTION_DEFAULTS};

typedef struct {
    float borders[4], colour[4];
} rectangle;

static vulkan_window w;
static VkExtent2D size; /* of the image */
static VkRect2D part;   /* of the window that shows it */
static picture depth, scene;
static VkSampler sampler;
static VkDescriptorSetLayout set_layout;
static VkDescriptorPool descriptors;
static VkDescriptorSet set;
static VkPipelineLayout cube_layout, plain_layout, shown_layout;
static linked_pipeline cube, mark, plain, shown;
static frame_objects objects;
static VkCommandBuffer commands;
static block read_back;

static void parse(int argc, char **argv)
{
    for (int i = 1; i + 1 < argc; i += 2) {
        const int way = strcmp(argv[i], "--way") == 0 ? choice(argv[i + 1], ways, WAYS) : -1;
        if (way >= 0)
            options.way = (way_kind)way;
        else if (strcmp(argv[i], "--resizes") == 0)
            options.resizes = atoi(argv[i + 1]);
        else if (strcmp(argv[i], "--picture") == 0)
            options.picture = argv[i + 1];
        else if (strcmp(argv[i], "--window") == 0)
            options.window = argv[i + 1];
        else if (!take_direction(&options.direction, argv[i], argv[i + 1])) {
            fprintf(stderr, "usage: vk_panes " DIRECTION_USAGE " [--resizes N] [--picture FILE.ppm] [--window FILE.ppm]\n"
                    "  [--way blit|copy|drawn|viewport|small|small-blit]\n");
            exit(2);
        }
    }
}

static bool copies(void)
{
    return options.way == BLIT || options.way == COPY || options.way == SMALL_BLIT;
}

static void make_layouts(void)
{
    make_one_descriptor(&w, VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER, &set_layout, &descriptors, &set);
    const VkSamplerCreateInfo filter = {.sType = VK_STRUCTURE_TYPE_SAMPLER_CREATE_INFO,
                                        .magFilter = VK_FILTER_LINEAR,
                                        .minFilter = VK_FILTER_LINEAR,
                                        .addressModeU = VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_EDGE,
                                        .addressModeV = VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_EDGE};
    expect(vkCreateSampler(w.device, &filter, NULL, &sampler), "vkCreateSampler");
    VkPushConstantRange range = {VK_SHADER_STAGE_VERTEX_BIT, 0, sizeof(matrix4)};
    VkPipelineLayoutCreateInfo info = {.sType = VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO,
                                       .pushConstantRangeCount = 1,
                                       .pPushConstantRanges = &range};
    expect(vkCreatePipelineLayout(w.device, &info, NULL, &cube_layout), "vkCreatePipelineLayout");
    range.size = sizeof(rectangle);
    expect(vkCreatePipelineLayout(w.device, &info, NULL, &plain_layout), "vkCreatePipelineLayout");
    info.setLayoutCount = 1;
    info.pSetLayouts = &set_layout;
    expect(vkCreatePipelineLayout(w.device, &info, NULL, &shown_layout), "vkCreatePipelineLayout");
}

static void make_pipelines(void)
{
    pipeline_description parts = {.vertex = SHADER(cube_push),
                                  .fragment = SHADER(cube_frag),
                                  .layout = cube_layout,
                                  .color = w.format,
                                  .depth = DEPTH_FORMAT,
                                  .samples = VK_SAMPLE_COUNT_1_BIT,
                                  .deep = true};
    cube = make_pipeline(&w, &parts);
    parts.deep = false;
    parts.vertex = SHADER(panes_vert);
    parts.fragment = SHADER(panes_plain);
    parts.layout = plain_layout;
    mark = make_pipeline(&w, &parts);
    parts.depth = VK_FORMAT_UNDEFINED;
    plain = make_pipeline(&w, &parts);
    parts.fragment = SHADER(panes_shown);
    parts.layout = shown_layout;
    shown = make_pipeline(&w, &parts);
}

/* Makes the image, and what depends on its size. */
static void make_pictures(void)
{
    const uint32_t width = w.extent.width, height = w.extent.height;
    const bool small = options.way == SMALL || options.way == SMALL_BLIT;
    size = (VkExtent2D){width * 7 / 8, height * 3 / 4};
    part = (VkRect2D){{(int32_t)(width - size.width), (int32_t)(height / 8)}, size};
    if (small)
        part = (VkRect2D){{0, 0}, {size.width / 2, size.height / 2}};
    scene = make_picture(&w, w.format, size, VK_SAMPLE_COUNT_1_BIT,
                         VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT | VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_TRANSFER_SRC_BIT |
                             VK_IMAGE_USAGE_TRANSFER_DST_BIT);
    depth = make_picture(&w, DEPTH_FORMAT, size, VK_SAMPLE_COUNT_1_BIT, VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT);
    read_back = make_block(&w, 4 * width * height, VK_BUFFER_USAGE_TRANSFER_DST_BIT, true);
    const VkDescriptorImageInfo image = {sampler, scene.view, VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL};
    const VkWriteDescriptorSet write = {.sType = VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET,
                                        .dstSet = set,
                                        .descriptorCount = 1,
                                        .descriptorType = VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER,
                                        .pImageInfo = &image};
    vkUpdateDescriptorSets(w.device, 1, &write, 0, NULL);
}

static void free_pictures(void)
{
    free_picture(&w, &scene);
    free_picture(&w, &depth);
    free_block(&w, &read_back);
}

/* Gives the window another size, or its first one again. */
static void resize(bool other)
{
    const uint32_t width = options.direction.width, height = options.direction.height;
    expect(vkDeviceWaitIdle(w.device), "vkDeviceWaitIdle");
    window_ask_size(&w, other ? width * 5 / 4 : width, other ? height * 3 / 4 : height);
    window_make_swapchain(&w);
    free_pictures();
    make_pictures();
}

static void open_all(void)
{
    window_open(&w, options.direction.x, options.direction.y, options.direction.width, options.direction.height, false, false,
                VK_IMAGE_USAGE_TRANSFER_DST_BIT | (options.window != NULL ? VK_IMAGE_USAGE_TRANSFER_SRC_BIT : 0));
    make_layouts();
    make_pictures();
    make_pipelines();
    objects = make_frame_objects(&w);
    make_commands(&w, &objects, VK_COMMAND_BUFFER_LEVEL_PRIMARY, 1, &commands);
}

static const VkImageLayout NEW = VK_IMAGE_LAYOUT_UNDEFINED, COLOR = VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL;
static const VkImageLayout DEEP = VK_IMAGE_LAYOUT_DEPTH_ATTACHMENT_OPTIMAL, READ_FROM = VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL;
static const VkImageLayout SAMPLED = VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL, WRITTEN = VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL;
static const VkImageLayout SHOWN = VK_IMAGE_LAYOUT_PRESENT_SRC_KHR;
static const VkClearValue grey = {.color = {.float32 = {0.25f, 0.25f, 0.25f, 1.0f}}}, far = {.depthStencil = {1.0f, 0}};

static void move(VkImage image, VkImageLayout from, VkImageLayout to)
{
    change_layout(commands, image, image == depth.image ? VK_IMAGE_ASPECT_DEPTH_BIT : VK_IMAGE_ASPECT_COLOR_BIT, from, to);
}

static void set_window(VkRect2D area)
{
    const VkViewport viewport = {
        (float)area.offset.x, (float)area.offset.y, (float)area.extent.width, (float)area.extent.height, 0, 1};
    vkCmdSetViewport(commands, 0, 1, &viewport);
    vkCmdSetScissor(commands, 0, 1, &area);
}

static void begin(VkImageView color, bool deep, bool clears, VkExtent2D area)
{
    const VkAttachmentLoadOp load = clears ? VK_ATTACHMENT_LOAD_OP_CLEAR : VK_ATTACHMENT_LOAD_OP_LOAD;
    const VkRenderingAttachmentInfo colors = {.sType = VK_STRUCTURE_TYPE_RENDERING_ATTACHMENT_INFO,
                                              .imageView = color,
                                              .imageLayout = COLOR,
                                              .loadOp = load,
                                              .storeOp = VK_ATTACHMENT_STORE_OP_STORE,
                                              .clearValue = grey};
    const VkRenderingAttachmentInfo depths = {.sType = VK_STRUCTURE_TYPE_RENDERING_ATTACHMENT_INFO,
                                              .imageView = depth.view,
                                              .imageLayout = DEEP,
                                              .loadOp = load,
                                              .storeOp = VK_ATTACHMENT_STORE_OP_DONT_CARE,
                                              .clearValue = far};
    const VkRenderingInfo info = {.sType = VK_STRUCTURE_TYPE_RENDERING_INFO,
                                  .renderArea = {{0, 0}, area},
                                  .layerCount = 1,
                                  .colorAttachmentCount = 1,
                                  .pColorAttachments = &colors,
                                  .pDepthAttachment = deep ? &depths : NULL};
    vkCmdBeginRendering(commands, &info);
    set_window((VkRect2D){{0, 0}, area});
}

static void draw(const linked_pipeline *by, VkPipelineLayout layout, rectangle drawn)
{
    vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, by->whole);
    if (layout == shown_layout)
        vkCmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, layout, 0, 1, &set, 0, NULL);
    vkCmdPushConstants(commands, layout, VK_SHADER_STAGE_VERTEX_BIT, 0, sizeof drawn, &drawn);
    vkCmdDraw(commands, 6, 1, 0, 0);
}

static void read_pixels(VkImage image, VkExtent2D area)
{
    const VkBufferImageCopy region = {.imageSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, 1},
                                      .imageExtent = {area.width, area.height, 1}};
    vkCmdCopyImageToBuffer(commands, image, READ_FROM, read_back.buffer, 1, &region);
}

/* Draws the cube into the image, and a white square over it without perspective. */
static void record_scene(void)
{
    const matrix4 matrix = direction_matrix(&options.direction, size, false);
    move(scene.image, NEW, COLOR);
    move(depth.image, NEW, DEEP);
    begin(scene.view, true, true, size);
    vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, cube.whole);
    vkCmdPushConstants(commands, cube_layout, VK_SHADER_STAGE_VERTEX_BIT, 0, sizeof matrix, &matrix);
    vkCmdDraw(commands, 36, 1, 0, 0);
    draw(&mark, plain_layout, (rectangle){{-0.8f, 0.5f, -0.5f, 0.8f}, {1.0f, 1.0f, 1.0f, 1.0f}});
    vkCmdEndRendering(commands);
    move(scene.image, COLOR, READ_FROM);
    if (options.picture != NULL)
        read_pixels(scene.image, size);
    if (!copies())
        move(scene.image, READ_FROM, SAMPLED);
}

/* Copies the image to the part of the window, between two passes. */
static void copy_scene(VkImage image, VkImageView view)
{
    const VkImageSubresourceLayers layer = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, 1};
    const int32_t left = part.offset.x, top = part.offset.y;
    const VkOffset3D end = {left + (int32_t)part.extent.width, top + (int32_t)part.extent.height, 1};
    vkCmdEndRendering(commands);
    move(image, COLOR, WRITTEN);
    if (options.way == COPY) {
        const VkImageCopy region = {layer, {0, 0, 0}, layer, {left, top, 0}, {size.width, size.height, 1}};
        vkCmdCopyImage(commands, scene.image, READ_FROM, image, WRITTEN, 1, &region);
    } else {
        const VkImageBlit region = {layer, {{0, 0, 0}, {(int32_t)size.width, (int32_t)size.height, 1}}, layer, {{left, top, 0}, end}};
        vkCmdBlitImage(commands, scene.image, READ_FROM, image, WRITTEN, 1, &region, VK_FILTER_NEAREST);
    }
    move(image, WRITTEN, COLOR);
    begin(view, false, false, w.extent);
}

static void draw_scene(void)
{
    rectangle whole = {{-1.0f, -1.0f, 1.0f, 1.0f}, {0}};
    if (options.way == VIEWPORT)
        set_window(part);
    else {
        const float across = 2.0f / (float)w.extent.width, down = 2.0f / (float)w.extent.height;
        whole.borders[0] = (float)part.offset.x * across - 1.0f;
        whole.borders[1] = (float)part.offset.y * down - 1.0f;
        whole.borders[2] = whole.borders[0] + (float)part.extent.width * across;
        whole.borders[3] = whole.borders[1] + (float)part.extent.height * down;
    }
    draw(&shown, shown_layout, whole);
    set_window((VkRect2D){{0, 0}, w.extent});
}

static void record(uint32_t index)
{
    const VkCommandBufferBeginInfo info = {.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO};
    const VkImage image = w.images[index];
    expect(vkBeginCommandBuffer(commands, &info), "vkBeginCommandBuffer");
    record_scene();
    move(image, NEW, COLOR);
    begin(w.views[index], false, true, w.extent);
    draw(&plain, plain_layout, (rectangle){{-1.0f, -1.0f, 1.0f, 1.0f}, {1.0f, MIDDLE, 0.0f, 1.0f}});
    if (copies())
        copy_scene(image, w.views[index]);
    else
        draw_scene();
    draw(&plain, plain_layout, (rectangle){{-1.0f, -1.0f, 1.0f, -0.75f}, {0.0f, MIDDLE, 0.0f, 1.0f}});
    vkCmdEndRendering(commands);
    if (options.window != NULL) {
        move(image, COLOR, READ_FROM);
        read_pixels(image, w.extent);
    }
    move(image, options.window != NULL ? READ_FROM : COLOR, SHOWN);
    expect(vkEndCommandBuffer(commands), "vkEndCommandBuffer");
}

static void close_all(void)
{
    expect(vkDeviceWaitIdle(w.device), "vkDeviceWaitIdle");
    free_pipeline(&w, &cube);
    free_pipeline(&w, &mark);
    free_pipeline(&w, &plain);
    free_pipeline(&w, &shown);
    vkDestroyPipelineLayout(w.device, cube_layout, NULL);
    vkDestroyPipelineLayout(w.device, plain_layout, NULL);
    vkDestroyPipelineLayout(w.device, shown_layout, NULL);
    vkDestroyDescriptorPool(w.device, descriptors, NULL);
    vkDestroyDescriptorSetLayout(w.device, set_layout, NULL);
    vkDestroySampler(w.device, sampler, NULL);
    free_frame_objects(&w, &objects);
    free_pictures();
    window_close(&w);
}

static void write_picture(const char *path, VkExtent2D area)
{
    FILE *file = fopen(path, "wb");
    if (file == NULL) {
        fprintf(stderr, "cannot write %s\n", path);
        exit(1);
    }
    fprintf(file, "P6\n%u %u\n255\n", area.width, area.height);
    const unsigned char *bytes = read_back.bytes;
    for (uint32_t i = 0; i < area.width * area.height; i++, bytes += 4)
        fwrite((unsigned char[]){bytes[2], bytes[1], bytes[0]}, 1, 3, file);
    fclose(file);
}

int main(int argc, char **argv)
{
    parse(argc, argv);
    open_all();
    const int frames = options.direction.frames / (options.resizes + 1);
    for (int resized = 0; resized < options.resizes; resized++) {
        run_frames(&w, &objects, commands, frames, NULL, record);
        resize(resized % 2 == 0);
    }
    run_frames(&w, &objects, commands, frames, options.direction.shot, record);
    if (options.picture != NULL)
        write_picture(options.picture, size);
    if (options.window != NULL)
        write_picture(options.window, w.extent);
    close_all();
    return 0;
}
