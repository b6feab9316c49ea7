#include "player.h"

#include <X11/Xutil.h>
#include <string.h>

void check(VkResult result)
{
    if (result != VK_SUCCESS)
        it.code = result;
}

static void begin(VkCommandBuffer commands)
{
    const VkCommandBufferBeginInfo info = {.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO};
    check(vkBeginCommandBuffer(commands, &info));
}

/* A barrier after all recorded commands and before all following ones. */
void barrier_all(VkCommandBuffer commands)
{
    if (it.ways & 1) {
        const VkMemoryBarrier2 memory = {.sType = VK_STRUCTURE_TYPE_MEMORY_BARRIER_2,
                                         .srcStageMask = VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT,
                                         .srcAccessMask = VK_ACCESS_2_MEMORY_READ_BIT | VK_ACCESS_2_MEMORY_WRITE_BIT,
                                         .dstStageMask = VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT,
                                         .dstAccessMask = VK_ACCESS_2_MEMORY_READ_BIT | VK_ACCESS_2_MEMORY_WRITE_BIT};
        const VkDependencyInfo info = {
            .sType = VK_STRUCTURE_TYPE_DEPENDENCY_INFO, .memoryBarrierCount = 1, .pMemoryBarriers = &memory};
        vkCmdPipelineBarrier2(commands, &info);
        return;
    }
    const VkMemoryBarrier memory = {.sType = VK_STRUCTURE_TYPE_MEMORY_BARRIER,
                                    .srcAccessMask = VK_ACCESS_MEMORY_READ_BIT | VK_ACCESS_MEMORY_WRITE_BIT,
                                    .dstAccessMask = VK_ACCESS_MEMORY_READ_BIT | VK_ACCESS_MEMORY_WRITE_BIT};
    vkCmdPipelineBarrier(commands, VK_PIPELINE_STAGE_ALL_COMMANDS_BIT, VK_PIPELINE_STAGE_ALL_COMMANDS_BIT, 0, 1, &memory, 0,
                         NULL, 0, NULL);
}

void image_layout(VkCommandBuffer commands, const slot_image *image, VkImageLayout from, VkImageLayout to)
{
    const VkImageSubresourceRange all = {image->kind->aspects, 0, VK_REMAINING_MIP_LEVELS, 0, 1};
    if (it.ways & 2) {
        const VkImageMemoryBarrier2 barrier = {.sType = VK_STRUCTURE_TYPE_IMAGE_MEMORY_BARRIER_2,
                                               .srcStageMask = VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT,
                                               .srcAccessMask = VK_ACCESS_2_MEMORY_READ_BIT | VK_ACCESS_2_MEMORY_WRITE_BIT,
                                               .dstStageMask = VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT,
                                               .dstAccessMask = VK_ACCESS_2_MEMORY_READ_BIT | VK_ACCESS_2_MEMORY_WRITE_BIT,
                                               .oldLayout = from,
                                               .newLayout = to,
                                               .srcQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED,
                                               .dstQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED,
                                               .image = image->image,
                                               .subresourceRange = all};
        const VkDependencyInfo info = {
            .sType = VK_STRUCTURE_TYPE_DEPENDENCY_INFO, .imageMemoryBarrierCount = 1, .pImageMemoryBarriers = &barrier};
        vkCmdPipelineBarrier2(commands, &info);
        return;
    }
    const VkImageMemoryBarrier barrier = {.sType = VK_STRUCTURE_TYPE_IMAGE_MEMORY_BARRIER,
                                          .srcAccessMask = VK_ACCESS_MEMORY_READ_BIT | VK_ACCESS_MEMORY_WRITE_BIT,
                                          .dstAccessMask = VK_ACCESS_MEMORY_READ_BIT | VK_ACCESS_MEMORY_WRITE_BIT,
                                          .oldLayout = from,
                                          .newLayout = to,
                                          .srcQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED,
                                          .dstQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED,
                                          .image = image->image,
                                          .subresourceRange = all};
    vkCmdPipelineBarrier(commands, VK_PIPELINE_STAGE_ALL_COMMANDS_BIT, VK_PIPELINE_STAGE_ALL_COMMANDS_BIT, 0, 0, NULL, 0,
                         NULL, 1, &barrier);
}

/* Begins the command buffer for the next commands if there is none. */
void begin_recording(void)
{
    if (it.is_recording)
        return;
    it.is_recording = true;
    it.secondary = 0;
    it.now = (recorded){.is_valid = true};
    it.draw = (draw_state){.set = -1};
    it.commands = it.primary;
    begin(it.primary);
    barrier_all(it.primary);
    vkCmdResetQueryPool(it.primary, it.queries, 0, QUERIES);
    memset(it.query_is_used, 0, sizeof it.query_is_used);
    memset(it.query_is_done, 0, sizeof it.query_is_done);
}

/* Called when the window has a new swapchain. */
void window_opened(void)
{
    it.window_kind = (image_kind){it.w.format,
                                  it.w.extent.width,
                                  it.w.extent.height,
                                  1,
                                  VK_SAMPLE_COUNT_1_BIT,
                                  VK_IMAGE_ASPECT_COLOR_BIT,
                                  VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT | VK_IMAGE_USAGE_TRANSFER_SRC_BIT |
                                      VK_IMAGE_USAGE_TRANSFER_DST_BIT,
                                  4};
    it.images[WINDOW] = (slot_image){.kind = &it.window_kind};
}

/* Acquires the image of this frame. A command buffer keeps the number of its image. */
static bool acquire(void)
{
    if (it.is_acquired)
        return true;
    const VkResult result =
        vkAcquireNextImageKHR(it.w.device, it.w.swapchain, UINT64_MAX, it.objects.acquired, VK_NULL_HANDLE, &it.index);
    check(result);
    if (result != VK_SUCCESS && result != VK_SUBOPTIMAL_KHR)
        return false;
    it.images[WINDOW] =
        (slot_image){.kind = &it.window_kind, .image = it.w.images[it.index], .view = it.w.views[it.index]};
    it.is_acquired = true;
    it.is_waited_for = it.has_content = it.has_depth = false;
    it.window_layout = VK_IMAGE_LAYOUT_UNDEFINED;
    return true;
}

/* Whether the command buffer can use the window's image. */
bool need_window(void)
{
    if (!acquire())
        return false;
    begin_recording();
    if (!it.now.uses_window) {
        it.now.uses_window = true;
        it.now.index = it.index;
        it.now.clears_window = !it.has_content;
        it.now.window_layout = it.window_layout;
    }
    return true;
}

/* Called when recorded commands give the window content. */
void window_cleared(VkImageLayout layout)
{
    it.has_content = true;
    it.window_layout = layout;
}

static void end_window(void)
{
    const VkClearColorValue color = {{0.5f, 0.25f, 0.0f, 1.0f}};
    const VkImageSubresourceRange all = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 1, 0, 1};
    const slot_image *window = &it.images[WINDOW];
    if (!it.has_content) {
        image_layout(it.primary, window, VK_IMAGE_LAYOUT_UNDEFINED, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL);
        vkCmdClearColorImage(it.primary, window->image, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, &color, 1, &all);
        window_cleared(VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL);
    }
    if (it.window_layout != VK_IMAGE_LAYOUT_PRESENT_SRC_KHR)
        image_layout(it.primary, window, it.window_layout, VK_IMAGE_LAYOUT_PRESENT_SRC_KHR);
    it.window_layout = VK_IMAGE_LAYOUT_PRESENT_SRC_KHR;
}

static void submit_commands(VkCommandBuffer commands, bool presents)
{
    const VkPipelineStageFlags stage = VK_PIPELINE_STAGE_ALL_COMMANDS_BIT;
    const bool waits = it.is_acquired && !it.is_waited_for;
    const VkSubmitInfo info = {.sType = VK_STRUCTURE_TYPE_SUBMIT_INFO,
                               .waitSemaphoreCount = waits,
                               .pWaitSemaphores = &it.objects.acquired,
                               .pWaitDstStageMask = &stage,
                               .commandBufferCount = 1,
                               .pCommandBuffers = &commands,
                               .signalSemaphoreCount = presents,
                               .pSignalSemaphores = &it.w.drawn[it.index]};
    check(vkQueueSubmit(it.w.queue, 1, &info, it.objects.done));
    it.is_waited_for = it.is_acquired;
    check(vkWaitForFences(it.w.device, 1, &it.objects.done, VK_TRUE, UINT64_MAX));
    check(vkResetFences(it.w.device, 1, &it.objects.done));
}

/* Submits the recorded commands, if there are any, and waits for them. */
void submit(bool presents)
{
    if (!it.is_recording)
        return;
    if (it.pass.is_under_way)
        pass_end();
    if (presents)
        end_window();
    check(vkEndCommandBuffer(it.primary));
    it.now.end_layout = it.window_layout;
    it.is_recording = false;
    submit_commands(it.primary, presents);
}

/* Submits the last command buffer again. */
int submit_again(void)
{
    if (it.is_recording || !it.now.is_valid)
        return SKIPPED;
    if (it.now.uses_window) {
        if (!acquire() || it.index != it.now.index)
            return SKIPPED;
        const bool fits = it.now.window_layout == VK_IMAGE_LAYOUT_UNDEFINED || it.now.window_layout == it.window_layout;
        if (!fits || (!it.now.clears_window && !it.has_content))
            return SKIPPED;
    }
    submit_commands(it.primary, false);
    if (it.now.uses_window)
        window_cleared(it.now.end_layout);
    return 0;
}

static unsigned long long shot(void)
{
    unsigned long long all = 0xcbf29ce484222325ULL;
    XSync(it.w.display, False);
    XImage *image =
        XGetImage(it.w.display, it.w.window, 0, 0, it.w.extent.width, it.w.extent.height, AllPlanes, ZPixmap);
    if (image == NULL)
        return 0;
    for (int y = 0; y < image->height; y++)
        for (int x = 0; x < image->width; x++)
            all = (all ^ (XGetPixel(image, x, y) & 0xffffff)) * 0x100000001b3ULL;
    XDestroyImage(image);
    return all;
}

/* Presents the window's image, and reads what the window then shows. */
int present(unsigned long long *digest)
{
    if (!need_window())
        return SKIPPED;
    submit(true);
    const VkPresentInfoKHR info = {.sType = VK_STRUCTURE_TYPE_PRESENT_INFO_KHR,
                                   .waitSemaphoreCount = 1,
                                   .pWaitSemaphores = &it.w.drawn[it.index],
                                   .swapchainCount = 1,
                                   .pSwapchains = &it.w.swapchain,
                                   .pImageIndices = &it.index};
    const VkResult result = vkQueuePresentKHR(it.w.queue, &info);
    check(result);
    it.is_acquired = false;
    check(vkQueueWaitIdle(it.w.queue));
    *digest = result == VK_SUCCESS ? shot() : 0;
    return 0;
}

int swapchain_make(int size)
{
    static const uint32_t sizes[][2] = {{64, 48}, {80, 60}, {33, 17}, {64, 48}};
    if (it.is_acquired)
        return SKIPPED;
    submit(false);
    it.now.is_valid = false;
    const uint32_t *wanted = sizes[size % 4];
    /* The server reports a size only if it changes. */
    if (wanted[0] != it.w.extent.width || wanted[1] != it.w.extent.height)
        window_ask_size(&it.w, wanted[0], wanted[1]);
    check(vkDeviceWaitIdle(it.w.device));
    window_make_swapchain(&it.w);
    window_opened();
    return 0;
}

/*
 * Begins a separate command buffer, which is submitted at once. Nothing is recorded to the other
 * one meanwhile.
 */
void own_commands_begin(void)
{
    begin(it.own);
    barrier_all(it.own);
}

void own_commands_end(void)
{
    barrier_all(it.own);
    check(vkEndCommandBuffer(it.own));
    submit_commands(it.own, false);
}
