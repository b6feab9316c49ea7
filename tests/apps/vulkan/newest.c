#include "newest.h"

void end_newest_frame(const vulkan_window *w, const frame_parts *parts, uint32_t index, uint64_t number)
{
    const VkSemaphoreSubmitInfo before = {.sType = VK_STRUCTURE_TYPE_SEMAPHORE_SUBMIT_INFO,
                                          .semaphore = parts->acquired,
                                          .stageMask = VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT};
    VkSemaphoreSubmitInfo after[] = {before, before};
    after[0].semaphore = w->drawn[index];
    after[1].semaphore = parts->timeline;
    after[1].value = number;
    const VkCommandBufferSubmitInfo buffer = {.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_SUBMIT_INFO,
                                              .commandBuffer = parts->commands};
    const VkSubmitInfo2 work = {.sType = VK_STRUCTURE_TYPE_SUBMIT_INFO_2,
                                .waitSemaphoreInfoCount = 1,
                                .pWaitSemaphoreInfos = &before,
                                .commandBufferInfoCount = 1,
                                .pCommandBufferInfos = &buffer,
                                .signalSemaphoreInfoCount = 2,
                                .pSignalSemaphoreInfos = after};
    expect(vkQueueSubmit2(w->queue, 1, &work, VK_NULL_HANDLE), "vkQueueSubmit2");
    const VkRectLayerKHR all = {{0, 0}, w->extent, 0};
    const VkPresentRegionKHR region = {1, &all};
    const VkPresentRegionsKHR regions = {
        .sType = VK_STRUCTURE_TYPE_PRESENT_REGIONS_KHR, .swapchainCount = 1, .pRegions = &region};
    const VkPresentIdKHR id = {.sType = VK_STRUCTURE_TYPE_PRESENT_ID_KHR,
                               .pNext = w->has.incremental_present ? &regions : NULL,
                               .swapchainCount = 1,
                               .pPresentIds = &number};
    const VkPresentInfoKHR present = {.sType = VK_STRUCTURE_TYPE_PRESENT_INFO_KHR,
                                      .pNext = w->has.present_id ? &id : id.pNext,
                                      .waitSemaphoreCount = 1,
                                      .pWaitSemaphores = &w->drawn[index],
                                      .swapchainCount = 1,
                                      .pSwapchains = &w->swapchain,
                                      .pImageIndices = &index};
    expect(vkQueuePresentKHR(w->queue, &present), "vkQueuePresentKHR");
    const VkSemaphoreWaitInfo wait = {
        .sType = VK_STRUCTURE_TYPE_SEMAPHORE_WAIT_INFO, .semaphoreCount = 1, .pSemaphores = &parts->timeline, .pValues = &number};
    expect(vkWaitSemaphores(w->device, &wait, UINT64_MAX), "vkWaitSemaphores");
    PFN_vkWaitForPresentKHR shown = (PFN_vkWaitForPresentKHR)vkGetDeviceProcAddr(w->device, "vkWaitForPresentKHR");
    if (w->has.present_wait && shown != NULL)
        expect(shown(w->device, w->swapchain, number, UINT64_MAX), "vkWaitForPresentKHR");
}
