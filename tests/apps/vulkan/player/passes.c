#include "player.h"

#include <string.h>

/* Bits in a line that begins a pass. */
enum { DYNAMIC = 1, IN_SECONDARY = 2, A_PART = 4, CLEARS_COLOR = 8, CLEARS_DEPTH = 16, GENERAL_LAYOUT = 32, TO_PRESENT = 64, IN_SAMPLES = 128 };

static bool is_alike(const slot_image *a, const slot_image *b)
{
    return a->kind->width == b->kind->width && a->kind->height == b->kind->height && a->kind->samples == b->kind->samples;
}

/* Chooses the window as target, with depth and samples that no other command uses. */
static bool choose_window(int bits)
{
    pass_state *p = &it.pass;
    if (!need_window())
        return false;
    slot_image *const window = &it.images[WINDOW];
    p->extent = (VkExtent2D){window->kind->width, window->kind->height};
    const bool samples = (bits & IN_SAMPLES) != 0 && it.images[OWN_SAMPLES].kind->width == p->extent.width;
    p->color = samples ? &it.images[OWN_SAMPLES] : window;
    p->resolve = samples ? window : NULL;
    p->second = NULL;
    p->depth = samples ? &it.images[OWN_DEPTHS] : &it.images[OWN_DEPTH];
    if (!is_alike(p->depth, p->color))
        p->depth = NULL;
    return true;
}

/* Chooses the images that are drawn to. */
static bool choose_targets(const int *n)
{
    pass_state *p = &it.pass;
    if (n[0] % (SLOTS + 1) == WINDOW && it.is_followed)
        return choose_window(n[4]);
    slot_image *const color = image_at(n[0]), *const second = image_at(n[1]), *const depth = image_at(n[2]),
                     *const resolve = image_at(n[3]);
    if (n[0] % (SLOTS + 1) == WINDOW && !need_window())
        return false;
    if (!is_color(color))
        return false;
    p->color = color;
    p->second = n[1] % (SLOTS + 1) < SLOTS && second != color && is_color(second) && is_alike(second, color) ? second : NULL;
    p->depth = n[2] % (SLOTS + 1) < SLOTS && !is_color(depth) && is_alike(depth, color) ? depth : NULL;
    p->resolve = NULL;
    if (color->kind->samples != VK_SAMPLE_COUNT_1_BIT) {
        if (n[3] % (SLOTS + 1) == WINDOW && (it.is_followed || !need_window()))
            return false;
        if (resolve->kind->format == color->kind->format && resolve->kind->samples == VK_SAMPLE_COUNT_1_BIT &&
            resolve->kind->width == color->kind->width && resolve->kind->height == color->kind->height)
            p->resolve = resolve;
    }
    p->extent = (VkExtent2D){color->kind->width, color->kind->height};
    return true;
}

static bool is_window(const slot_image *image)
{
    return image == &it.images[WINDOW];
}

static VkImageLayout layout_before(const slot_image *image)
{
    if (!is_window(image))
        return VK_IMAGE_LAYOUT_GENERAL;
    return it.has_content ? it.window_layout : VK_IMAGE_LAYOUT_UNDEFINED;
}

static VkClearValue clear_value(const slot_image *image, int kind)
{
    static const float levels[] = {0, 0.25f, 0.5f, 1};
    VkClearValue value = {.color = {{levels[kind & 3], levels[kind >> 2 & 3], levels[kind >> 4 & 3], levels[kind >> 6 & 3]}}};
    if (!is_color(image))
        value.depthStencil = (VkClearDepthStencilValue){kind & 1 ? 1 : levels[kind >> 1 & 3], (uint32_t)kind & 7};
    return value;
}

enum { MOST_ATTACHMENTS = 4 };

typedef struct {
    uint32_t count;
    VkAttachmentDescription all[MOST_ATTACHMENTS];
    VkImageView views[MOST_ATTACHMENTS];
    VkClearValue clears[MOST_ATTACHMENTS];
    VkAttachmentReference colors[2], resolves[2], depth;
} attachments;

static VkAttachmentReference add(attachments *a, const slot_image *image, VkImageLayout layout, VkAttachmentLoadOp load,
                                 int clear)
{
    const VkAttachmentReference reference = {a->count, layout};
    a->clears[a->count] = clear_value(image, clear);
    a->views[a->count] = image->view;
    a->all[a->count++] = (VkAttachmentDescription){.format = image->kind->format,
                                                   .samples = image->kind->samples,
                                                   .loadOp = load,
                                                   .storeOp = VK_ATTACHMENT_STORE_OP_STORE,
                                                   .stencilLoadOp = is_color(image) ? VK_ATTACHMENT_LOAD_OP_DONT_CARE : load,
                                                   .stencilStoreOp = is_color(image) ? VK_ATTACHMENT_STORE_OP_DONT_CARE
                                                                                     : VK_ATTACHMENT_STORE_OP_STORE,
                                                   .initialLayout = layout_before(image),
                                                   .finalLayout = is_window(image) ? it.pass.final_layout
                                                                                   : VK_IMAGE_LAYOUT_GENERAL};
    return reference;
}

static VkAttachmentLoadOp load_op(bool clears)
{
    return clears ? VK_ATTACHMENT_LOAD_OP_CLEAR : VK_ATTACHMENT_LOAD_OP_LOAD;
}

static void begin_pass_object(const int *n, VkRect2D area)
{
    pass_state *p = &it.pass;
    attachments a = {.count = 0};
    const VkAttachmentReference none = {VK_ATTACHMENT_UNUSED, VK_IMAGE_LAYOUT_UNDEFINED};
    const bool clears = n[4] & CLEARS_COLOR;
    a.colors[0] = add(&a, p->color, p->color_layout, load_op(clears || layout_before(p->color) == VK_IMAGE_LAYOUT_UNDEFINED), n[5]);
    if (p->second != NULL)
        a.colors[1] = add(&a, p->second, p->color_layout, load_op(clears), n[5] + 1);
    a.resolves[1] = none;
    if (p->resolve != NULL)
        a.resolves[0] = add(&a, p->resolve, p->color_layout, VK_ATTACHMENT_LOAD_OP_DONT_CARE, 0);
    if (p->resolve != NULL && !is_window(p->resolve))
        a.all[a.count - 1].loadOp = VK_ATTACHMENT_LOAD_OP_LOAD;
    if (p->depth != NULL)
        a.depth = add(&a, p->depth, p->depth_layout, load_op(n[4] & CLEARS_DEPTH), n[5] + 2);
    const VkSubpassDescription subpass = {.pipelineBindPoint = VK_PIPELINE_BIND_POINT_GRAPHICS,
                                          .colorAttachmentCount = p->second != NULL ? 2 : 1,
                                          .pColorAttachments = a.colors,
                                          .pResolveAttachments = p->resolve != NULL ? a.resolves : NULL,
                                          .pDepthStencilAttachment = p->depth != NULL ? &a.depth : NULL};
    const VkSubpassDependency before = {.srcSubpass = VK_SUBPASS_EXTERNAL,
                                        .dstSubpass = 0,
                                        .srcStageMask = VK_PIPELINE_STAGE_ALL_GRAPHICS_BIT,
                                        .dstStageMask = VK_PIPELINE_STAGE_ALL_GRAPHICS_BIT,
                                        .srcAccessMask = VK_ACCESS_MEMORY_READ_BIT | VK_ACCESS_MEMORY_WRITE_BIT,
                                        .dstAccessMask = VK_ACCESS_MEMORY_READ_BIT | VK_ACCESS_MEMORY_WRITE_BIT};
    VkSubpassDependency both[] = {before, before};
    both[1].srcSubpass = 0;
    both[1].dstSubpass = VK_SUBPASS_EXTERNAL;
    const VkRenderPassCreateInfo info = {.sType = VK_STRUCTURE_TYPE_RENDER_PASS_CREATE_INFO,
                                         .attachmentCount = a.count,
                                         .pAttachments = a.all,
                                         .subpassCount = 1,
                                         .pSubpasses = &subpass,
                                         .dependencyCount = 2,
                                         .pDependencies = both};
    expect(vkCreateRenderPass(it.w.device, &info, NULL, &p->pass), "vkCreateRenderPass");
    keep_pass(p->pass);
    const VkFramebufferCreateInfo framebuffer = {.sType = VK_STRUCTURE_TYPE_FRAMEBUFFER_CREATE_INFO,
                                                 .renderPass = p->pass,
                                                 .attachmentCount = a.count,
                                                 .pAttachments = a.views,
                                                 .width = p->extent.width,
                                                 .height = p->extent.height,
                                                 .layers = 1};
    VkRenderPassBeginInfo begin = {.sType = VK_STRUCTURE_TYPE_RENDER_PASS_BEGIN_INFO,
                                   .renderPass = p->pass,
                                   .renderArea = area,
                                   .clearValueCount = a.count,
                                   .pClearValues = a.clears};
    expect(vkCreateFramebuffer(it.w.device, &framebuffer, NULL, &begin.framebuffer), "vkCreateFramebuffer");
    keep_framebuffer(begin.framebuffer);
    vkCmdBeginRenderPass(it.primary, &begin,
                         p->is_secondary ? VK_SUBPASS_CONTENTS_SECONDARY_COMMAND_BUFFERS : VK_SUBPASS_CONTENTS_INLINE);
}

static VkRenderingAttachmentInfo rendered(const slot_image *image, VkImageLayout layout, bool clears, int clear)
{
    return (VkRenderingAttachmentInfo){.sType = VK_STRUCTURE_TYPE_RENDERING_ATTACHMENT_INFO,
                                       .imageView = image->view,
                                       .imageLayout = layout,
                                       .loadOp = load_op(clears),
                                       .storeOp = VK_ATTACHMENT_STORE_OP_STORE,
                                       .clearValue = clear_value(image, clear)};
}

static void begin_dynamic(const int *n, VkRect2D area)
{
    pass_state *p = &it.pass;
    const bool clears = n[4] & CLEARS_COLOR;
    VkRenderingAttachmentInfo colors[2] = {rendered(
        p->color, p->color_layout, clears || layout_before(p->color) == VK_IMAGE_LAYOUT_UNDEFINED, n[5])};
    slot_image *const all[] = {p->color, p->second, p->resolve};
    for (int i = 0; i < 3; i++)
        if (all[i] != NULL)
            image_layout(it.primary, all[i], layout_before(all[i]), p->color_layout);
    if (p->second != NULL)
        colors[1] = rendered(p->second, p->color_layout, clears, n[5] + 1);
    if (p->resolve != NULL) {
        colors[0].resolveMode = VK_RESOLVE_MODE_AVERAGE_BIT;
        colors[0].resolveImageView = p->resolve->view;
        colors[0].resolveImageLayout = p->color_layout;
    }
    VkRenderingAttachmentInfo depth;
    if (p->depth != NULL) {
        depth = rendered(p->depth, p->depth_layout, n[4] & CLEARS_DEPTH, n[5] + 2);
        image_layout(it.primary, p->depth, VK_IMAGE_LAYOUT_GENERAL, p->depth_layout);
    }
    const bool stencil = p->depth != NULL && (p->depth->kind->aspects & VK_IMAGE_ASPECT_STENCIL_BIT);
    const VkRenderingInfo info = {.sType = VK_STRUCTURE_TYPE_RENDERING_INFO,
                                  .flags = p->is_secondary ? VK_RENDERING_CONTENTS_SECONDARY_COMMAND_BUFFERS_BIT : 0,
                                  .renderArea = area,
                                  .layerCount = 1,
                                  .colorAttachmentCount = p->second != NULL ? 2 : 1,
                                  .pColorAttachments = colors,
                                  .pDepthAttachment = p->depth != NULL ? &depth : NULL,
                                  .pStencilAttachment = stencil ? &depth : NULL};
    vkCmdBeginRendering(it.primary, &info);
}

static void begin_secondary(void)
{
    const pass_state *p = &it.pass;
    const VkFormat formats[] = {p->color->kind->format, p->second != NULL ? p->second->kind->format : VK_FORMAT_UNDEFINED};
    const bool stencil = p->depth != NULL && (p->depth->kind->aspects & VK_IMAGE_ASPECT_STENCIL_BIT);
    const VkFormat depth = p->depth != NULL ? p->depth->kind->format : VK_FORMAT_UNDEFINED;
    const VkCommandBufferInheritanceRenderingInfo rendering = {
        .sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_INHERITANCE_RENDERING_INFO,
        .colorAttachmentCount = p->second != NULL ? 2 : 1,
        .pColorAttachmentFormats = formats,
        .depthAttachmentFormat = depth,
        .stencilAttachmentFormat = stencil ? depth : VK_FORMAT_UNDEFINED,
        .rasterizationSamples = p->color->kind->samples};
    const VkCommandBufferInheritanceInfo inheritance = {.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_INHERITANCE_INFO,
                                                        .pNext = p->is_dynamic ? &rendering : NULL,
                                                        .renderPass = p->pass};
    const VkCommandBufferBeginInfo info = {.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO,
                                           .flags = VK_COMMAND_BUFFER_USAGE_RENDER_PASS_CONTINUE_BIT,
                                           .pInheritanceInfo = &inheritance};
    it.commands = it.secondaries[it.secondary++];
    it.draw = (draw_state){.set = -1};
    check(vkBeginCommandBuffer(it.commands, &info));
}

/* target, second target, depth, target of a resolve, bits, clear value */
int pass_begin(const int *line)
{
    pass_state *p = &it.pass;
    int n[6];
    memcpy(n, line, sizeof n);
    if (p->is_under_way)
        return SKIPPED;
    begin_recording();
    *p = (pass_state){.pipeline = -1};
    if (!choose_targets(n))
        return SKIPPED;
    /* The earlier content of these images must not matter, so they are cleared. */
    const bool has_own_depth = p->depth == &it.images[OWN_DEPTH];
    if (p->color == &it.images[OWN_SAMPLES])
        n[4] |= CLEARS_COLOR | CLEARS_DEPTH;
    if (has_own_depth && !it.has_depth)
        n[4] |= CLEARS_DEPTH;
    p->is_dynamic = n[4] & DYNAMIC;
    p->is_secondary = (n[4] & IN_SECONDARY) != 0 && it.secondary < SECONDARIES;
    /*
     * A secondary command buffer does not say which of the images with the window's format it draws
     * to.
     */
    const bool of_window = is_window(p->color) || (p->resolve != NULL && is_window(p->resolve));
    if (it.is_followed && p->is_dynamic && !of_window)
        p->is_secondary = false;
    const bool general = n[4] & GENERAL_LAYOUT;
    p->color_layout = general ? VK_IMAGE_LAYOUT_GENERAL : VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL;
    p->depth_layout = general ? VK_IMAGE_LAYOUT_GENERAL : VK_IMAGE_LAYOUT_DEPTH_STENCIL_ATTACHMENT_OPTIMAL;
    p->final_layout = n[4] & TO_PRESENT ? VK_IMAGE_LAYOUT_PRESENT_SRC_KHR : VK_IMAGE_LAYOUT_GENERAL;
    VkRect2D area = {{0, 0}, p->extent};
    const bool is_new = of_window && !it.has_content;
    it.has_depth |= has_own_depth;
    if ((n[4] & A_PART) && !is_new && !it.is_followed)
        area = (VkRect2D){{8, 4}, {p->extent.width - 16, p->extent.height - 9}};
    barrier_all(it.primary);
    if (p->is_dynamic)
        begin_dynamic(n, area);
    else
        begin_pass_object(n, area);
    p->is_under_way = true;
    if (p->is_secondary)
        begin_secondary();
    return 0;
}

static void end_dynamic(void)
{
    pass_state *p = &it.pass;
    slot_image *const all[] = {p->color, p->second, p->resolve};
    vkCmdEndRendering(it.primary);
    for (int i = 0; i < 3; i++)
        if (all[i] != NULL)
            image_layout(it.primary, all[i], p->color_layout,
                         is_window(all[i]) ? p->final_layout : VK_IMAGE_LAYOUT_GENERAL);
    if (p->depth != NULL)
        image_layout(it.primary, p->depth, p->depth_layout, VK_IMAGE_LAYOUT_GENERAL);
}

int pass_end(void)
{
    pass_state *p = &it.pass;
    if (!p->is_under_way)
        return SKIPPED;
    if (p->query)
        pass_query(NULL);
    if (p->is_secondary) {
        check(vkEndCommandBuffer(it.commands));
        vkCmdExecuteCommands(it.primary, 1, &it.commands);
        it.commands = it.primary;
        it.draw = (draw_state){.set = -1};
    }
    if (p->is_dynamic)
        end_dynamic();
    else
        vkCmdEndRenderPass(it.primary);
    barrier_all(it.primary);
    if (is_window(p->color) || (p->resolve != NULL && is_window(p->resolve)))
        window_cleared(p->final_layout);
    p->is_under_way = false;
    return 0;
}

/* which attachments, a part or all, value */
int pass_clear(const int *n)
{
    const pass_state *p = &it.pass;
    if (!p->is_under_way || (it.is_followed && p->is_secondary))
        return SKIPPED;
    VkClearAttachment clears[2];
    uint32_t count = 0;
    if (n[0] & 1)
        clears[count++] = (VkClearAttachment){VK_IMAGE_ASPECT_COLOR_BIT, p->second != NULL && (n[0] & 4) ? 1 : 0,
                                              clear_value(p->color, n[2])};
    if ((n[0] & 2) && p->depth != NULL)
        clears[count++] = (VkClearAttachment){p->depth->kind->aspects, 0, clear_value(p->depth, n[2])};
    if (count == 0)
        return SKIPPED;
    /* The rectangle is inside each area that is drawn to. */
    const VkClearRect rect = {
        {{8 + n[1] % 4, 4 + n[1] % 3}, {p->extent.width - 20, p->extent.height - 12}}, 0, 1};
    vkCmdClearAttachments(it.commands, count, clears, 1, &rect);
    return 0;
}

/* Begins an occlusion query, or ends the one that is active. */
int pass_query(const int *n)
{
    pass_state *p = &it.pass;
    if (p->query) {
        vkCmdEndQuery(it.commands, it.queries, p->query_number);
        p->query = false;
        it.query_is_done[p->query_number] = true;
        return 0;
    }
    if (n == NULL || !p->is_under_way || p->is_secondary || it.query_is_used[n[0] % QUERIES])
        return SKIPPED;
    p->query_number = (uint32_t)(n[0] % QUERIES);
    it.query_is_used[p->query_number] = p->query = true;
    vkCmdBeginQuery(it.commands, it.queries, p->query_number, VK_QUERY_CONTROL_PRECISE_BIT);
    return 0;
}
