//! Commands that cannot be followed. A program that uses one is shown flat.
//!
//! These and the hooks of the other files are all commands that draw, bind or copy. A test compares
//! them with the commands of Vulkan.

use crate::intercept::vk::state::device::Device;
use crate::intercept::vk::state::driver::structures::slice;
use crate::intercept::vk::state::hooks::hooks;
use ash::vk;

/// True if an image of the program is a view target or has an atlas copy.
fn is_followed(device: &Device, image: vk::Image) -> bool {
    device.images.target_of_image(image).is_some() || !device.images.atlas_copies(image).is_empty()
}

/// Notes that the host reads or writes images without a command.
fn by_host(device: &Device, images: &[vk::Image]) {
    if images.iter().any(|image| is_followed(device, *image)) {
        device.show_flat("it changes images of its picture without commands");
    }
}

/// Reason of commands that cut, scale or thin out drawing in the window's pixels.
const WINDOW_SPACE: &str = "its drawing is cut or scaled at positions in the window";

/// Reason of commands that bind descriptors or constants in a way that is not followed.
const BINDINGS: &str = "it binds descriptors or constants by commands that cannot be followed";

/// Reason of commands by which the device decides what is drawn.
const GENERATED: &str = "the device generates its commands";

hooks! {
    cmd_bind_descriptor_sets2 = (
        buffer: vk::CommandBuffer, info: *const vk::BindDescriptorSetsInfoKHR<'_>
    ) { |state, next| { state.show_flat(BINDINGS); next(buffer, info) } }
    cmd_push_constants2 = (
        buffer: vk::CommandBuffer, info: *const vk::PushConstantsInfoKHR<'_>
    ) { |state, next| { state.show_flat(BINDINGS); next(buffer, info) } }
    cmd_push_descriptor_set2 = (
        buffer: vk::CommandBuffer, info: *const vk::PushDescriptorSetInfoKHR<'_>
    ) { |state, next| { state.show_flat(BINDINGS); next(buffer, info) } }
    cmd_push_with_template2 = (
        buffer: vk::CommandBuffer, info: *const vk::PushDescriptorSetWithTemplateInfoKHR<'_>
    ) { |state, next| { state.show_flat(BINDINGS); next(buffer, info) } }
    cmd_bind_descriptor_buffers = (
        buffer: vk::CommandBuffer, count: u32, buffers: *const vk::DescriptorBufferBindingInfoEXT<'_>
    ) { |state, next| { state.show_flat(BINDINGS); next(buffer, count, buffers) } }
    cmd_bind_shader_group = (
        buffer: vk::CommandBuffer, point: vk::PipelineBindPoint, pipeline: vk::Pipeline, group: u32
    ) { |state, next| { state.show_flat(GENERATED); next(buffer, point, pipeline, group) } }
    cmd_execute_generated = (
        buffer: vk::CommandBuffer, prepared: vk::Bool32, info: *const vk::GeneratedCommandsInfoNV<'_>
    ) { |state, next| { state.show_flat(GENERATED); next(buffer, prepared, info) } }
    cmd_draw_cluster = (
        buffer: vk::CommandBuffer, x: u32, y: u32, z: u32
    ) { |state, next| { state.show_flat("it draws clusters"); next(buffer, x, y, z) } }
    cmd_draw_cluster_indirect = (
        buffer: vk::CommandBuffer, from: vk::Buffer, offset: vk::DeviceSize
    ) { |state, next| { state.show_flat("it draws clusters"); next(buffer, from, offset) } }
    cmd_subpass_shading = (
        buffer: vk::CommandBuffer
    ) { |state, next| { state.show_flat("it shades a pass by compute shaders"); next(buffer) } }
    cmd_set_discard_rectangle = (
        buffer: vk::CommandBuffer, first: u32, count: u32, rectangles: *const vk::Rect2D
    ) { |state, next| { state.show_flat(WINDOW_SPACE); next(buffer, first, count, rectangles) } }
    cmd_set_exclusive_scissor = (
        buffer: vk::CommandBuffer, first: u32, count: u32, rectangles: *const vk::Rect2D
    ) { |state, next| { state.show_flat(WINDOW_SPACE); next(buffer, first, count, rectangles) } }
    cmd_set_viewport_w_scaling = (
        buffer: vk::CommandBuffer, first: u32, count: u32, scalings: *const vk::ViewportWScalingNV
    ) { |state, next| { state.show_flat(WINDOW_SPACE); next(buffer, first, count, scalings) } }
    cmd_set_viewport_swizzle = (
        buffer: vk::CommandBuffer, first: u32, count: u32, swizzles: *const vk::ViewportSwizzleNV
    ) { |state, next| { state.show_flat(WINDOW_SPACE); next(buffer, first, count, swizzles) } }
    cmd_bind_shading_rate_image = (
        buffer: vk::CommandBuffer, view: vk::ImageView, layout: vk::ImageLayout
    ) { |state, next| { state.show_flat(WINDOW_SPACE); next(buffer, view, layout) } }
    cmd_bind_invocation_mask = (
        buffer: vk::CommandBuffer, view: vk::ImageView, layout: vk::ImageLayout
    ) { |state, next| { state.show_flat(WINDOW_SPACE); next(buffer, view, layout) } }
    cmd_set_attachment_locations = (
        buffer: vk::CommandBuffer, info: *const vk::RenderingAttachmentLocationInfoKHR<'_>
    ) { |state, next| { state.show_flat("its shaders read the attachments that they draw to"); next(buffer, info) } }
    cmd_set_input_indices = (
        buffer: vk::CommandBuffer, info: *const vk::RenderingInputAttachmentIndexInfoKHR<'_>
    ) { |state, next| { state.show_flat("its shaders read the attachments that they draw to"); next(buffer, info) } }
    cmd_copy_memory_to_image = (
        buffer: vk::CommandBuffer, from: vk::DeviceAddress, count: u32, stride: u32, to: vk::Image, layout: vk::ImageLayout, layers: *const vk::ImageSubresourceLayers
    ) { |state, next| {
        if is_followed(&state, to) {
            state.show_flat("it copies its picture to the window");
        }
        next(buffer, from, count, stride, to, layout, layers)
    } }
    copy_memory_to_image = (
        device: vk::Device, info: *const vk::CopyMemoryToImageInfoEXT<'_>
    ) -> vk::Result { |state, next| { by_host(&state, &[(*info).dst_image]); next(device, info) } }
    copy_image_to_memory = (
        device: vk::Device, info: *const vk::CopyImageToMemoryInfoEXT<'_>
    ) -> vk::Result { |state, next| { by_host(&state, &[(*info).src_image]); next(device, info) } }
    copy_image_to_image = (
        device: vk::Device, info: *const vk::CopyImageToImageInfoEXT<'_>
    ) -> vk::Result { |state, next| { by_host(&state, &[(*info).src_image, (*info).dst_image]); next(device, info) } }
    transition_image_layout = (
        device: vk::Device, count: u32, changes: *const vk::HostImageLayoutTransitionInfoEXT<'_>
    ) -> vk::Result { |state, next| {
        let images: Vec<_> = slice(changes, count).iter().map(|change| change.image).collect();
        by_host(&state, &images);
        next(device, count, changes)
    } }
}
