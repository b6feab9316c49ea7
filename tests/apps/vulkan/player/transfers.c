#include "player.h"

#include <string.h>

/*
 * Begins a command on images outside of passes. The command writes to the second image. The
 * window's image gets its layout.
 */
static bool begin(slot_image *a, slot_image *b)
{
    slot_image *const both[] = {a, b};
    if (it.pass.is_under_way || (it.is_followed && b == &it.images[WINDOW]))
        return false;
    for (int i = 0; i < 2; i++) {
        if (both[i] != &it.images[WINDOW])
            continue;
        if (!need_window())
            return false;
        if (!it.has_content) {
            const VkClearColorValue color = {{0.0f, 0.25f, 0.5f, 1.0f}};
            const VkImageSubresourceRange all = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 1, 0, 1};
            image_layout(it.commands, both[i], VK_IMAGE_LAYOUT_UNDEFINED, VK_IMAGE_LAYOUT_GENERAL);
            vkCmdClearColorImage(it.commands, both[i]->image, VK_IMAGE_LAYOUT_GENERAL, &color, 1, &all);
        } else if (it.window_layout != VK_IMAGE_LAYOUT_GENERAL) {
            image_layout(it.commands, both[i], it.window_layout, VK_IMAGE_LAYOUT_GENERAL);
        }
        window_cleared(VK_IMAGE_LAYOUT_GENERAL);
    }
    begin_recording();
    barrier_all(it.commands);
    return true;
}

static int end(void)
{
    barrier_all(it.commands);
    return 0;
}

/*
 * Layout of an image in a command: its own layout, or with the bit the layout that is meant for the
 * command.
 */
static VkImageLayout enter(const slot_image *image, VkImageLayout meant, int bits)
{
    if (!(bits & 8))
        return VK_IMAGE_LAYOUT_GENERAL;
    image_layout(it.commands, image, VK_IMAGE_LAYOUT_GENERAL, meant);
    return meant;
}

static void leave(const slot_image *image, VkImageLayout layout)
{
    if (layout != VK_IMAGE_LAYOUT_GENERAL)
        image_layout(it.commands, image, layout, VK_IMAGE_LAYOUT_GENERAL);
}

static uint32_t level_of(const slot_image *image, int bits)
{
    return (uint32_t)(bits >> 4 & 3) % image->kind->levels;
}

static uint32_t smaller(uint32_t a, uint32_t b)
{
    return a < b ? a : b;
}

static VkImageSubresourceLayers layers_of(const slot_image *image, uint32_t level)
{
    return (VkImageSubresourceLayers){image->kind->aspects, level, 0, 1};
}

/* from, to, bits */
int copy_images(const int *n)
{
    slot_image *const from = image_at(n[0]), *const to = image_at(n[1]);
    if (from == to || !begin(from, to))
        return SKIPPED;
    const image_kind *const a = from->kind, *const b = to->kind;
    const bool fits = a->samples == b->samples && a->aspects == b->aspects &&
                      (is_color(from) ? a->texel == b->texel : a->format == b->format);
    if (!fits)
        return end() + SKIPPED;
    const uint32_t from_level = level_of(from, n[2]), to_level = level_of(to, n[2] >> 2);
    VkExtent3D size = {smaller(a->width >> from_level, b->width >> to_level),
                       smaller(a->height >> from_level, b->height >> to_level), 1};
    VkOffset3D at = {0, 0, 0};
    /* Not all devices can copy a part of depths. */
    if ((n[2] & 1) && is_color(from)) {
        size.width /= 2;
        size.height /= 2;
        at = (VkOffset3D){(int32_t)size.width / 2, 1, 0};
    }
    const VkImageCopy region = {layers_of(from, from_level), at, layers_of(to, to_level), at, size};
    const VkImageLayout from_layout = enter(from, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, n[2]);
    const VkImageLayout to_layout = enter(to, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, n[2]);
    vkCmdCopyImage(it.commands, from->image, from_layout, to->image, to_layout, 1, &region);
    leave(from, from_layout);
    leave(to, to_layout);
    return end();
}

/* from, to, bits */
int blit_images(const int *n)
{
    slot_image *const from = image_at(n[0]), *const to = image_at(n[1]);
    if (from == to || !is_color(from) || !is_color(to))
        return SKIPPED;
    if (from->kind->samples != VK_SAMPLE_COUNT_1_BIT || to->kind->samples != VK_SAMPLE_COUNT_1_BIT || !begin(from, to))
        return SKIPPED;
    const uint32_t from_level = level_of(from, n[2]), to_level = level_of(to, n[2] >> 2);
    const int32_t w = (int32_t)(from->kind->width >> from_level), h = (int32_t)(from->kind->height >> from_level);
    const int32_t u = (int32_t)(to->kind->width >> to_level), v = (int32_t)(to->kind->height >> to_level);
    VkImageBlit region = {layers_of(from, from_level), {{0, 0, 0}, {w, h, 1}}, layers_of(to, to_level), {{0, 0, 0}, {u, v, 1}}};
    if (n[2] & 1)
        region.srcOffsets[1] = (VkOffset3D){w / 2, h / 2, 1};
    if (n[2] & 2)
        region.dstOffsets[0] = (VkOffset3D){u, 0, 0}, region.dstOffsets[1] = (VkOffset3D){0, v, 1};
    const VkImageLayout from_layout = enter(from, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, n[2]);
    const VkImageLayout to_layout = enter(to, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, n[2]);
    vkCmdBlitImage(it.commands, from->image, from_layout, to->image, to_layout, 1, &region,
                   n[2] & 4 ? VK_FILTER_LINEAR : VK_FILTER_NEAREST);
    leave(from, from_layout);
    leave(to, to_layout);
    return end();
}

/* from, to, bits */
int resolve_images(const int *n)
{
    slot_image *const from = image_at(n[0]), *const to = image_at(n[1]);
    if (from == to || from == &it.images[WINDOW] || from->kind->samples == VK_SAMPLE_COUNT_1_BIT || !is_color(from) ||
        !begin(from, to))
        return SKIPPED;
    if (to->kind->samples != VK_SAMPLE_COUNT_1_BIT || to->kind->format != from->kind->format)
        return end() + SKIPPED;
    VkImageResolve region = {
        layers_of(from, 0), {0, 0, 0}, layers_of(to, 0), {0, 0, 0},
        {smaller(from->kind->width, to->kind->width), smaller(from->kind->height, to->kind->height), 1}};
    if (n[2] & 1)
        region.extent.width /= 2;
    const VkImageLayout from_layout = enter(from, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, n[2]);
    const VkImageLayout to_layout = enter(to, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, n[2]);
    vkCmdResolveImage(it.commands, from->image, from_layout, to->image, to_layout, 1, &region);
    leave(from, from_layout);
    leave(to, to_layout);
    return end();
}

/* Region of a copy between the first level of an image and a buffer. */
static bool region_of(const slot_image *image, int bits, VkBufferImageCopy *region)
{
    const image_kind *kind = image->kind;
    VkExtent3D size = {kind->width, kind->height, 1};
    VkOffset3D at = {0, 0, 0};
    if (bits & 1) {
        size = (VkExtent3D){kind->width / 2, kind->height / 2, 1};
        at = (VkOffset3D){3, 2, 0};
    }
    const VkImageAspectFlags aspect = kind->aspects & ~(VkImageAspectFlags)VK_IMAGE_ASPECT_STENCIL_BIT;
    *region = (VkBufferImageCopy){.imageSubresource = {aspect, 0, 0, 1}, .imageOffset = at, .imageExtent = size};
    return kind->samples == VK_SAMPLE_COUNT_1_BIT && size.width * size.height * kind->texel <= BUFFER_SIZE;
}

/* image, buffer, bits */
int copy_to_buffer(const int *n)
{
    slot_image *const image = image_at(n[0]);
    VkBufferImageCopy region;
    if (!begin(image, NULL))
        return SKIPPED;
    if (!region_of(image, n[2], &region))
        return end() + SKIPPED;
    const VkImageLayout layout = enter(image, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, n[2]);
    vkCmdCopyImageToBuffer(it.commands, image->image, layout, it.buffers[2 + n[1] % 2].buffer, 1, &region);
    leave(image, layout);
    return end();
}

/*
 * image, buffer, bits. Depths are not copied, because numbers in a buffer may be outside of their
 * range.
 */
int copy_from_buffer(const int *n)
{
    slot_image *const image = image_at(n[0]);
    VkBufferImageCopy region;
    if (!begin(image, image))
        return SKIPPED;
    if (!is_color(image) || image->kind->texel != 4 || !region_of(image, n[2], &region))
        return end() + SKIPPED;
    const VkImageLayout layout = enter(image, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, n[2]);
    vkCmdCopyBufferToImage(it.commands, it.buffers[2 + n[1] % 2].buffer, image->image, layout, 1, &region);
    leave(image, layout);
    return end();
}

/* from, to, place: copies a matrix to the place of another matrix or anywhere */
int copy_buffers(const int *n)
{
    const int from = n[0] % BUFFERS, to = from < 2 ? n[1] % BUFFERS : 2 + n[1] % 2;
    const VkDeviceSize last = VERTICES / MATRIX_STEP - 1;
    const VkBufferCopy region = {(VkDeviceSize)n[2] % last * MATRIX_STEP, (VkDeviceSize)(n[2] / 7) % last * MATRIX_STEP, 64};
    if (it.pass.is_under_way || from == to)
        return SKIPPED;
    begin_recording();
    barrier_all(it.commands);
    vkCmdCopyBuffer(it.commands, it.buffers[from].buffer, it.buffers[to].buffer, 1, &region);
    return end();
}

/* buffer, value, place */
int fill_buffer(const int *n)
{
    if (it.pass.is_under_way)
        return SKIPPED;
    begin_recording();
    barrier_all(it.commands);
    vkCmdFillBuffer(it.commands, it.buffers[2 + n[0] % 2].buffer, (VkDeviceSize)(n[2] % 16) * 512, 256, (uint32_t)n[1]);
    return end();
}

/* buffer, matrix, place */
int update_buffer(const int *n)
{
    unsigned char bytes[64];
    if (it.pass.is_under_way)
        return SKIPPED;
    begin_recording();
    barrier_all(it.commands);
    matrix_write(bytes, n[1]);
    vkCmdUpdateBuffer(it.commands, it.buffers[n[0] % BUFFERS].buffer, (VkDeviceSize)(n[2] % 32) * MATRIX_STEP, sizeof bytes, bytes);
    return end();
}

/* image, value, bits */
int clear_image(const int *n)
{
    static const float levels[] = {0, 0.25f, 0.75f, 1};
    slot_image *const image = image_at(n[0]);
    const VkClearColorValue color = {{levels[n[1] & 3], levels[n[1] >> 2 & 3], levels[n[1] >> 4 & 3], levels[n[1] >> 6 & 3]}};
    const VkClearDepthStencilValue depth = {levels[n[1] & 3], 1};
    if (!begin(image, image))
        return SKIPPED;
    const VkImageSubresourceRange all = {image->kind->aspects, level_of(image, n[2]), VK_REMAINING_MIP_LEVELS, 0, 1};
    const VkImageLayout layout = enter(image, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, n[2]);
    if (is_color(image))
        vkCmdClearColorImage(it.commands, image->image, layout, &color, 1, &all);
    else
        vkCmdClearDepthStencilImage(it.commands, image->image, layout, &depth, 1, &all);
    leave(image, layout);
    return end();
}

/* Makes the smaller levels of an image, each from the level before. */
int make_levels(const int *n)
{
    slot_image *const image = image_at(n[0]);
    if (!begin(image, image))
        return SKIPPED;
    for (uint32_t level = 1; level < image->kind->levels; level++) {
        const int32_t w = (int32_t)(image->kind->width >> level), h = (int32_t)(image->kind->height >> level);
        const VkImageBlit region = {layers_of(image, level - 1), {{0, 0, 0}, {2 * w, 2 * h, 1}}, layers_of(image, level), {{0, 0, 0}, {w, h, 1}}};
        vkCmdBlitImage(it.commands, image->image, VK_IMAGE_LAYOUT_GENERAL, image->image, VK_IMAGE_LAYOUT_GENERAL, 1, &region,
                       VK_FILTER_LINEAR);
        barrier_all(it.commands);
    }
    return end();
}
