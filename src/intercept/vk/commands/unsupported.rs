//! Commands that change what is drawn in ways that are not followed: a program that uses one is shown flat.
//!
//! With the hooks of the other files these are all commands that could draw, bind or copy past us; a test compares them
//! with those that there are.

use crate::intercept::vk::layer::device::Device;
use crate::intercept::vk::layer::hooks::hooks;
use ash::vk;

/// Whether an image of the program has a twin, or stands for the window.
fn is_followed(device: &Device, image: vk::Image) -> bool {
    device.images.shown_image(image).is_some() || !device.images.twins(image).is_empty()
}

/// The processor reads or writes images without a command.
fn by_host(device: &Device, images: &[vk::Image]) {
    if images.iter().any(|image| is_followed(device, *image)) {
        device.give_up("it changes images of its picture without commands");
    }
}

/// Where what is drawn is cut, scaled or thinned out is said in the window's pixels.
const WINDOW_SPACE: &str = "what it draws is cut or scaled by places in the window";

/// Descriptors or constants are bound that are not seen.
const BINDINGS: &str = "it binds descriptors or constants by commands that are not followed";

/// The device decides what is drawn.
const GENERATED: &str = "the device makes its commands";

hooks! { unfollowed;
    [c"vkCmdBindDescriptorSets2KHR", c"vkCmdBindDescriptorSets2"] cmd_bind_descriptor_sets2: vk::PFN_vkCmdBindDescriptorSets2KHR = (
        buffer: vk::CommandBuffer, info: *const vk::BindDescriptorSetsInfoKHR<'_>
    ) { |state, next| { state.give_up(BINDINGS); next(buffer, info) } }
    [c"vkCmdPushConstants2KHR", c"vkCmdPushConstants2"] cmd_push_constants2: vk::PFN_vkCmdPushConstants2KHR = (
        buffer: vk::CommandBuffer, info: *const vk::PushConstantsInfoKHR<'_>
    ) { |state, next| { state.give_up(BINDINGS); next(buffer, info) } }
    [c"vkCmdPushDescriptorSet2KHR", c"vkCmdPushDescriptorSet2"] cmd_push_descriptor_set2: vk::PFN_vkCmdPushDescriptorSet2KHR = (
        buffer: vk::CommandBuffer, info: *const vk::PushDescriptorSetInfoKHR<'_>
    ) { |state, next| { state.give_up(BINDINGS); next(buffer, info) } }
    [c"vkCmdPushDescriptorSetWithTemplate2KHR", c"vkCmdPushDescriptorSetWithTemplate2"] cmd_push_with_template2: vk::PFN_vkCmdPushDescriptorSetWithTemplate2KHR = (
        buffer: vk::CommandBuffer, info: *const vk::PushDescriptorSetWithTemplateInfoKHR<'_>
    ) { |state, next| { state.give_up(BINDINGS); next(buffer, info) } }
    [c"vkCmdBindDescriptorBuffersEXT"] cmd_bind_descriptor_buffers: vk::PFN_vkCmdBindDescriptorBuffersEXT = (
        buffer: vk::CommandBuffer, count: u32, buffers: *const vk::DescriptorBufferBindingInfoEXT<'_>
    ) { |state, next| { state.give_up(BINDINGS); next(buffer, count, buffers) } }
    [c"vkCmdBindPipelineShaderGroupNV"] cmd_bind_shader_group: vk::PFN_vkCmdBindPipelineShaderGroupNV = (
        buffer: vk::CommandBuffer, point: vk::PipelineBindPoint, pipeline: vk::Pipeline, group: u32
    ) { |state, next| { state.give_up(GENERATED); next(buffer, point, pipeline, group) } }
    [c"vkCmdExecuteGeneratedCommandsNV"] cmd_execute_generated: vk::PFN_vkCmdExecuteGeneratedCommandsNV = (
        buffer: vk::CommandBuffer, prepared: vk::Bool32, info: *const vk::GeneratedCommandsInfoNV<'_>
    ) { |state, next| { state.give_up(GENERATED); next(buffer, prepared, info) } }
    [c"vkCmdDrawClusterHUAWEI"] cmd_draw_cluster: vk::PFN_vkCmdDrawClusterHUAWEI = (
        buffer: vk::CommandBuffer, x: u32, y: u32, z: u32
    ) { |state, next| { state.give_up("it draws clusters"); next(buffer, x, y, z) } }
    [c"vkCmdDrawClusterIndirectHUAWEI"] cmd_draw_cluster_indirect: vk::PFN_vkCmdDrawClusterIndirectHUAWEI = (
        buffer: vk::CommandBuffer, from: vk::Buffer, offset: vk::DeviceSize
    ) { |state, next| { state.give_up("it draws clusters"); next(buffer, from, offset) } }
    [c"vkCmdSubpassShadingHUAWEI"] cmd_subpass_shading: vk::PFN_vkCmdSubpassShadingHUAWEI = (
        buffer: vk::CommandBuffer
    ) { |state, next| { state.give_up("it shades a pass by compute shaders"); next(buffer) } }
    [c"vkCmdSetDiscardRectangleEXT"] cmd_set_discard_rectangle: vk::PFN_vkCmdSetDiscardRectangleEXT = (
        buffer: vk::CommandBuffer, first: u32, count: u32, rectangles: *const vk::Rect2D
    ) { |state, next| { state.give_up(WINDOW_SPACE); next(buffer, first, count, rectangles) } }
    [c"vkCmdSetExclusiveScissorNV"] cmd_set_exclusive_scissor: vk::PFN_vkCmdSetExclusiveScissorNV = (
        buffer: vk::CommandBuffer, first: u32, count: u32, rectangles: *const vk::Rect2D
    ) { |state, next| { state.give_up(WINDOW_SPACE); next(buffer, first, count, rectangles) } }
    [c"vkCmdSetViewportWScalingNV"] cmd_set_viewport_w_scaling: vk::PFN_vkCmdSetViewportWScalingNV = (
        buffer: vk::CommandBuffer, first: u32, count: u32, scalings: *const vk::ViewportWScalingNV
    ) { |state, next| { state.give_up(WINDOW_SPACE); next(buffer, first, count, scalings) } }
    [c"vkCmdSetViewportSwizzleNV"] cmd_set_viewport_swizzle: vk::PFN_vkCmdSetViewportSwizzleNV = (
        buffer: vk::CommandBuffer, first: u32, count: u32, swizzles: *const vk::ViewportSwizzleNV
    ) { |state, next| { state.give_up(WINDOW_SPACE); next(buffer, first, count, swizzles) } }
    [c"vkCmdBindShadingRateImageNV"] cmd_bind_shading_rate_image: vk::PFN_vkCmdBindShadingRateImageNV = (
        buffer: vk::CommandBuffer, view: vk::ImageView, layout: vk::ImageLayout
    ) { |state, next| { state.give_up(WINDOW_SPACE); next(buffer, view, layout) } }
    [c"vkCmdBindInvocationMaskHUAWEI"] cmd_bind_invocation_mask: vk::PFN_vkCmdBindInvocationMaskHUAWEI = (
        buffer: vk::CommandBuffer, view: vk::ImageView, layout: vk::ImageLayout
    ) { |state, next| { state.give_up(WINDOW_SPACE); next(buffer, view, layout) } }
    [c"vkCmdSetRenderingAttachmentLocationsKHR", c"vkCmdSetRenderingAttachmentLocations"] cmd_set_attachment_locations: vk::PFN_vkCmdSetRenderingAttachmentLocationsKHR = (
        buffer: vk::CommandBuffer, info: *const vk::RenderingAttachmentLocationInfoKHR<'_>
    ) { |state, next| { state.give_up("its shaders read what they draw to"); next(buffer, info) } }
    [c"vkCmdSetRenderingInputAttachmentIndicesKHR", c"vkCmdSetRenderingInputAttachmentIndices"] cmd_set_input_indices: vk::PFN_vkCmdSetRenderingInputAttachmentIndicesKHR = (
        buffer: vk::CommandBuffer, info: *const vk::RenderingInputAttachmentIndexInfoKHR<'_>
    ) { |state, next| { state.give_up("its shaders read what they draw to"); next(buffer, info) } }
    [c"vkCmdCopyMemoryToImageIndirectNV"] cmd_copy_memory_to_image: vk::PFN_vkCmdCopyMemoryToImageIndirectNV = (
        buffer: vk::CommandBuffer, from: vk::DeviceAddress, count: u32, stride: u32, to: vk::Image, layout: vk::ImageLayout, layers: *const vk::ImageSubresourceLayers
    ) { |state, next| {
        if is_followed(&state, to) {
            state.give_up("it copies its picture to the window");
        }
        next(buffer, from, count, stride, to, layout, layers)
    } }
    [c"vkCopyMemoryToImageEXT", c"vkCopyMemoryToImage"] copy_memory_to_image: vk::PFN_vkCopyMemoryToImageEXT = (
        device: vk::Device, info: *const vk::CopyMemoryToImageInfoEXT<'_>
    ) -> vk::Result { |state, next| { by_host(&state, &[(*info).dst_image]); next(device, info) } }
    [c"vkCopyImageToMemoryEXT", c"vkCopyImageToMemory"] copy_image_to_memory: vk::PFN_vkCopyImageToMemoryEXT = (
        device: vk::Device, info: *const vk::CopyImageToMemoryInfoEXT<'_>
    ) -> vk::Result { |state, next| { by_host(&state, &[(*info).src_image]); next(device, info) } }
    [c"vkCopyImageToImageEXT", c"vkCopyImageToImage"] copy_image_to_image: vk::PFN_vkCopyImageToImageEXT = (
        device: vk::Device, info: *const vk::CopyImageToImageInfoEXT<'_>
    ) -> vk::Result { |state, next| { by_host(&state, &[(*info).src_image, (*info).dst_image]); next(device, info) } }
    [c"vkTransitionImageLayoutEXT", c"vkTransitionImageLayout"] transition_image_layout: vk::PFN_vkTransitionImageLayoutEXT = (
        device: vk::Device, count: u32, changes: *const vk::HostImageLayoutTransitionInfoEXT<'_>
    ) -> vk::Result { |state, next| {
        let images: Vec<_> = crate::intercept::vk::slice(changes, count).iter().map(|change| change.image).collect();
        by_host(&state, &images);
        next(device, count, changes)
    } }
}
