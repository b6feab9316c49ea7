#include "frames.h"

frame_objects make_frame_objects(const vulkan_window *w)
{
    const VkCommandPoolCreateInfo pool = {.sType = VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO,
                                          .flags = VK_COMMAND_POOL_CREATE_RESET_COMMAND_BUFFER_BIT,
                                          .queueFamilyIndex = w->family};
    const VkSemaphoreCreateInfo semaphore = {.sType = VK_STRUCTURE_TYPE_SEMAPHORE_CREATE_INFO};
    const VkFenceCreateInfo fence = {.sType = VK_STRUCTURE_TYPE_FENCE_CREATE_INFO};
    frame_objects made;
    expect(vkCreateCommandPool(w->device, &pool, NULL, &made.pool), "vkCreateCommandPool");
    expect(vkCreateSemaphore(w->device, &semaphore, NULL, &made.acquired), "vkCreateSemaphore");
    expect(vkCreateFence(w->device, &fence, NULL, &made.done), "vkCreateFence");
    return made;
}

void free_frame_objects(const vulkan_window *w, frame_objects *objects)
{
    vkDestroyCommandPool(w->device, objects->pool, NULL);
    vkDestroySemaphore(w->device, objects->acquired, NULL);
    vkDestroyFence(w->device, objects->done, NULL);
}

void make_commands(const vulkan_window *w, const frame_objects *objects, VkCommandBufferLevel level, uint32_t count,
                   VkCommandBuffer *made)
{
    const VkCommandBufferAllocateInfo info = {.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO,
                                              .commandPool = objects->pool,
                                              .level = level,
                                              .commandBufferCount = count};
    expect(vkAllocateCommandBuffers(w->device, &info, made), "vkAllocateCommandBuffers");
}

uint32_t next_image(const vulkan_window *w, const frame_objects *objects)
{
    uint32_t index;
    expect(vkAcquireNextImageKHR(w->device, w->swapchain, UINT64_MAX, objects->acquired, VK_NULL_HANDLE, &index), "acquire");
    return index;
}

bool end_frame(const vulkan_window *w, const frame_objects *objects, VkCommandBuffer commands, uint32_t index)
{
    const VkPipelineStageFlags stage = VK_PIPELINE_STAGE_ALL_COMMANDS_BIT;
    const VkSubmitInfo work = {.sType = VK_STRUCTURE_TYPE_SUBMIT_INFO,
                               .waitSemaphoreCount = 1,
                               .pWaitSemaphores = &objects->acquired,
                               .pWaitDstStageMask = &stage,
                               .commandBufferCount = 1,
                               .pCommandBuffers = &commands,
                               .signalSemaphoreCount = 1,
                               .pSignalSemaphores = &w->drawn[index]};
    expect(vkQueueSubmit(w->queue, 1, &work, objects->done), "vkQueueSubmit");
    const VkPresentInfoKHR present = {.sType = VK_STRUCTURE_TYPE_PRESENT_INFO_KHR,
                                      .waitSemaphoreCount = 1,
                                      .pWaitSemaphores = &w->drawn[index],
                                      .swapchainCount = 1,
                                      .pSwapchains = &w->swapchain,
                                      .pImageIndices = &index};
    const VkResult presented = vkQueuePresentKHR(w->queue, &present);
    if (presented != VK_SUBOPTIMAL_KHR && presented != VK_ERROR_OUT_OF_DATE_KHR)
        expect(presented, "vkQueuePresentKHR");
    expect(vkWaitForFences(w->device, 1, &objects->done, VK_TRUE, UINT64_MAX), "vkWaitForFences");
    expect(vkResetFences(w->device, 1, &objects->done), "vkResetFences");
    return presented == VK_SUCCESS;
}

void run_frames(const vulkan_window *w, const frame_objects *objects, VkCommandBuffer commands, int count,
                const char *shot, void (*record)(uint32_t index))
{
    for (int number = 0; number < count; number++) {
        const uint32_t index = next_image(w, objects);
        record(index);
        end_frame(w, objects, commands, index);
    }
    if (shot != NULL)
        window_shot(w, shot);
}

void change_layout(VkCommandBuffer commands, VkImage image, VkImageAspectFlags aspect, VkImageLayout from,
                   VkImageLayout to)
{
    const VkImageMemoryBarrier2 change = {.sType = VK_STRUCTURE_TYPE_IMAGE_MEMORY_BARRIER_2,
                                          .srcStageMask = VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT,
                                          .srcAccessMask = VK_ACCESS_2_MEMORY_WRITE_BIT,
                                          .dstStageMask = VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT,
                                          .dstAccessMask = VK_ACCESS_2_MEMORY_WRITE_BIT | VK_ACCESS_2_MEMORY_READ_BIT,
                                          .oldLayout = from,
                                          .newLayout = to,
                                          .srcQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED,
                                          .dstQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED,
                                          .image = image,
                                          .subresourceRange = {aspect, 0, 1, 0, 1}};
    const VkDependencyInfo info = {
        .sType = VK_STRUCTURE_TYPE_DEPENDENCY_INFO, .imageMemoryBarrierCount = 1, .pImageMemoryBarriers = &change};
    vkCmdPipelineBarrier2(commands, &info);
}
