#include "depth_pass.h"

static const VkImageLayout deep = VK_IMAGE_LAYOUT_DEPTH_STENCIL_ATTACHMENT_OPTIMAL;
static const VkClearValue far = {.depthStencil = {1.0f, 0}};

static VkRenderPass make_pass(const vulkan_window *w, VkSampleCountFlagBits samples)
{
    const VkPipelineStageFlags stages =
        VK_PIPELINE_STAGE_EARLY_FRAGMENT_TESTS_BIT | VK_PIPELINE_STAGE_LATE_FRAGMENT_TESTS_BIT;
    const VkAccessFlags access =
        VK_ACCESS_DEPTH_STENCIL_ATTACHMENT_WRITE_BIT | VK_ACCESS_DEPTH_STENCIL_ATTACHMENT_READ_BIT;
    const VkAttachmentDescription attachment = {.format = DEPTH_FORMAT,
                                                .samples = samples,
                                                .loadOp = VK_ATTACHMENT_LOAD_OP_CLEAR,
                                                .storeOp = VK_ATTACHMENT_STORE_OP_STORE,
                                                .stencilLoadOp = VK_ATTACHMENT_LOAD_OP_DONT_CARE,
                                                .stencilStoreOp = VK_ATTACHMENT_STORE_OP_DONT_CARE,
                                                .finalLayout = deep};
    const VkAttachmentReference reference = {0, deep};
    const VkSubpassDescription subpass = {.pDepthStencilAttachment = &reference};
    const VkSubpassDependency around[2] = {{VK_SUBPASS_EXTERNAL, 0, stages, stages, access, access, 0},
                                           {0, VK_SUBPASS_EXTERNAL, stages, stages, access, access, 0}};
    const VkRenderPassCreateInfo info = {.sType = VK_STRUCTURE_TYPE_RENDER_PASS_CREATE_INFO,
                                         .attachmentCount = 1,
                                         .pAttachments = &attachment,
                                         .subpassCount = 1,
                                         .pSubpasses = &subpass,
                                         .dependencyCount = 2,
                                         .pDependencies = around};
    VkRenderPass pass;
    expect(vkCreateRenderPass(w->device, &info, NULL, &pass), "vkCreateRenderPass");
    return pass;
}

depth_pass make_depth_pass(const vulkan_window *w, VkImageView view, const pipeline_description *description)
{
    depth_pass made = {.view = view, .extent = w->extent};
    pipeline_description own = *description;
    own.colorless = true;
    if (own.pass != VK_NULL_HANDLE) {
        own.pass = made.pass = make_pass(w, own.samples);
        const VkFramebufferCreateInfo info = {.sType = VK_STRUCTURE_TYPE_FRAMEBUFFER_CREATE_INFO,
                                              .renderPass = made.pass,
                                              .attachmentCount = 1,
                                              .pAttachments = &made.view,
                                              .width = w->extent.width,
                                              .height = w->extent.height,
                                              .layers = 1};
        expect(vkCreateFramebuffer(w->device, &info, NULL, &made.framebuffer), "vkCreateFramebuffer");
    }
    made.pipeline = make_pipeline(w, &own);
    return made;
}

void free_depth_pass(const vulkan_window *w, depth_pass *made)
{
    free_pipeline(w, &made->pipeline);
    vkDestroyFramebuffer(w->device, made->framebuffer, NULL);
    vkDestroyRenderPass(w->device, made->pass, NULL);
    *made = (depth_pass){0};
}

void begin_depth_pass(const depth_pass *made, VkCommandBuffer buffer)
{
    const VkRect2D area = {{0, 0}, made->extent};
    if (made->pass != VK_NULL_HANDLE) {
        const VkRenderPassBeginInfo begin = {.sType = VK_STRUCTURE_TYPE_RENDER_PASS_BEGIN_INFO,
                                             .renderPass = made->pass,
                                             .framebuffer = made->framebuffer,
                                             .renderArea = area,
                                             .clearValueCount = 1,
                                             .pClearValues = &far};
        vkCmdBeginRenderPass(buffer, &begin, VK_SUBPASS_CONTENTS_INLINE);
        return;
    }
    const VkRenderingAttachmentInfo attachment = {.sType = VK_STRUCTURE_TYPE_RENDERING_ATTACHMENT_INFO,
                                                  .imageView = made->view,
                                                  .imageLayout = deep,
                                                  .loadOp = VK_ATTACHMENT_LOAD_OP_CLEAR,
                                                  .storeOp = VK_ATTACHMENT_STORE_OP_STORE,
                                                  .clearValue = far};
    const VkRenderingInfo info = {.sType = VK_STRUCTURE_TYPE_RENDERING_INFO,
                                  .renderArea = area,
                                  .layerCount = 1,
                                  .pDepthAttachment = &attachment};
    vkCmdBeginRendering(buffer, &info);
}

void end_depth_pass(const depth_pass *made, VkCommandBuffer buffer)
{
    const VkPipelineStageFlags stages =
        VK_PIPELINE_STAGE_EARLY_FRAGMENT_TESTS_BIT | VK_PIPELINE_STAGE_LATE_FRAGMENT_TESTS_BIT;
    const VkAccessFlags written = VK_ACCESS_DEPTH_STENCIL_ATTACHMENT_WRITE_BIT;
    const VkMemoryBarrier barrier = {.sType = VK_STRUCTURE_TYPE_MEMORY_BARRIER,
                                     .srcAccessMask = written,
                                     .dstAccessMask = written | VK_ACCESS_DEPTH_STENCIL_ATTACHMENT_READ_BIT};
    if (made->pass != VK_NULL_HANDLE) {
        vkCmdEndRenderPass(buffer);
        return;
    }
    vkCmdEndRendering(buffer);
    vkCmdPipelineBarrier(buffer, stages, stages, 0, 1, &barrier, 0, NULL, 0, NULL);
}
