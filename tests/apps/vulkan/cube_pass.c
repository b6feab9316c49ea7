#include "cube_pass.h"

#include "options.h"

bool multisampled(void)
{
    return options.samples > 1;
}

VkRenderPass make_pass(const vulkan_window *w)
{
    VkRenderPass made;
    const VkImageLayout color = VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL;
    const VkImageLayout deep = VK_IMAGE_LAYOUT_DEPTH_STENCIL_ATTACHMENT_OPTIMAL;
    const VkAttachmentLoadOp clear = VK_ATTACHMENT_LOAD_OP_CLEAR, any = VK_ATTACHMENT_LOAD_OP_DONT_CARE;
    const VkAttachmentStoreOp store = VK_ATTACHMENT_STORE_OP_STORE, drop = VK_ATTACHMENT_STORE_OP_DONT_CARE;
    const VkSampleCountFlagBits count = (VkSampleCountFlagBits)options.samples;
    /* Colour, depth, and the window's image if the colour is another image. */
    VkAttachmentDescription2 all[3] = {
        {VK_STRUCTURE_TYPE_ATTACHMENT_DESCRIPTION_2, NULL, 0, w->format, count, clear, store, any, drop,
         VK_IMAGE_LAYOUT_UNDEFINED, multisampled() ? color : VK_IMAGE_LAYOUT_PRESENT_SRC_KHR},
        {VK_STRUCTURE_TYPE_ATTACHMENT_DESCRIPTION_2, NULL, 0, DEPTH_FORMAT, count,
         options.depth == DEPTH_TOGETHER ? clear : VK_ATTACHMENT_LOAD_OP_LOAD, drop, any, drop,
         options.depth == DEPTH_TOGETHER ? VK_IMAGE_LAYOUT_UNDEFINED : deep, deep},
        {VK_STRUCTURE_TYPE_ATTACHMENT_DESCRIPTION_2, NULL, 0, w->format, VK_SAMPLE_COUNT_1_BIT, any, store, any, drop,
         VK_IMAGE_LAYOUT_UNDEFINED, VK_IMAGE_LAYOUT_PRESENT_SRC_KHR}};
    const uint32_t number = multisampled() ? 3 : 2;
    const VkPipelineStageFlags stages = VK_PIPELINE_STAGE_COLOR_ATTACHMENT_OUTPUT_BIT |
                                        VK_PIPELINE_STAGE_EARLY_FRAGMENT_TESTS_BIT |
                                        VK_PIPELINE_STAGE_LATE_FRAGMENT_TESTS_BIT;
    const VkAccessFlags access =
        VK_ACCESS_COLOR_ATTACHMENT_WRITE_BIT | VK_ACCESS_DEPTH_STENCIL_ATTACHMENT_WRITE_BIT;
    if (options.pass == PASS_2) {
        const VkAttachmentReference2 colors = {VK_STRUCTURE_TYPE_ATTACHMENT_REFERENCE_2, NULL, 0, color, 1};
        const VkAttachmentReference2 depths = {VK_STRUCTURE_TYPE_ATTACHMENT_REFERENCE_2, NULL, 1, deep, 2};
        const VkAttachmentReference2 resolves = {VK_STRUCTURE_TYPE_ATTACHMENT_REFERENCE_2, NULL, 2, color, 1};
        const VkSubpassDescription2 subpass = {.sType = VK_STRUCTURE_TYPE_SUBPASS_DESCRIPTION_2,
                                               .colorAttachmentCount = 1,
                                               .pColorAttachments = &colors,
                                               .pDepthStencilAttachment = &depths,
                                               .pResolveAttachments = multisampled() ? &resolves : NULL};
        const VkSubpassDependency2 before = {.sType = VK_STRUCTURE_TYPE_SUBPASS_DEPENDENCY_2,
                                             .srcSubpass = VK_SUBPASS_EXTERNAL,
                                             .srcStageMask = stages,
                                             .dstStageMask = stages,
                                             .srcAccessMask = access,
                                             .dstAccessMask = access};
        const VkRenderPassCreateInfo2 info = {.sType = VK_STRUCTURE_TYPE_RENDER_PASS_CREATE_INFO_2,
                                              .attachmentCount = number,
                                              .pAttachments = all,
                                              .subpassCount = 1,
                                              .pSubpasses = &subpass,
                                              .dependencyCount = 1,
                                              .pDependencies = &before};
        expect(vkCreateRenderPass2(w->device, &info, NULL, &made), "vkCreateRenderPass2");
        return made;
    }
    VkAttachmentDescription plain[3];
    for (int i = 0; i < 3; i++)
        plain[i] = (VkAttachmentDescription){all[i].flags, all[i].format, all[i].samples, all[i].loadOp, all[i].storeOp,
                                             all[i].stencilLoadOp, all[i].stencilStoreOp, all[i].initialLayout,
                                             all[i].finalLayout};
    const VkAttachmentReference colors = {0, color}, depths = {1, deep}, resolves = {2, color};
    const VkSubpassDescription subpass = {.colorAttachmentCount = 1,
                                          .pColorAttachments = &colors,
                                          .pDepthStencilAttachment = &depths,
                                          .pResolveAttachments = multisampled() ? &resolves : NULL};
    const VkSubpassDependency before = {VK_SUBPASS_EXTERNAL, 0, stages, stages, access, access, 0};
    const VkRenderPassCreateInfo info = {.sType = VK_STRUCTURE_TYPE_RENDER_PASS_CREATE_INFO,
                                         .attachmentCount = number,
                                         .pAttachments = plain,
                                         .subpassCount = 1,
                                         .pSubpasses = &subpass,
                                         .dependencyCount = 1,
                                         .pDependencies = &before};
    expect(vkCreateRenderPass(w->device, &info, NULL, &made), "vkCreateRenderPass");
    return made;
}
