//! Barriers of an image: which stages wait for which, and the image's layout.

use ash::vk;

/// Colour range of an image with one level and one layer.
pub const COLOR: vk::ImageSubresourceRange = vk::ImageSubresourceRange {
    aspect_mask: vk::ImageAspectFlags::COLOR,
    base_mip_level: 0,
    level_count: 1,
    base_array_layer: 0,
    layer_count: 1,
};

/// Use of an image before or after a barrier.
#[derive(Clone, Copy, Debug)]
pub struct Use {
    /// Layout of the image.
    pub layout: vk::ImageLayout,
    /// Stages that use the image. Empty: there is no stage to wait for, or no stage that waits.
    pub stages: vk::PipelineStageFlags,
    /// Accesses of these stages.
    pub access: vk::AccessFlags,
}

impl Use {
    /// Returns a use in `layout` without stages.
    pub const fn nothing(layout: vk::ImageLayout) -> Self {
        Self { layout, stages: vk::PipelineStageFlags::empty(), access: vk::AccessFlags::empty() }
    }

    /// Returns the use of an image that a fragment shader reads.
    pub const fn sampled(layout: vk::ImageLayout) -> Self {
        Self { layout, stages: vk::PipelineStageFlags::FRAGMENT_SHADER, access: vk::AccessFlags::SHADER_READ }
    }

    /// Use of an image that a copy or a clear writes.
    pub const COPIED_TO: Self = Self {
        layout: vk::ImageLayout::TRANSFER_DST_OPTIMAL,
        stages: vk::PipelineStageFlags::TRANSFER,
        access: vk::AccessFlags::TRANSFER_WRITE,
    };
}

/// Records a barrier for the first `layers` layers of an image's first level. Does nothing for a
/// null image.
///
/// # Safety
/// The command buffer is being recorded, outside a render pass, and the image is live.
pub unsafe fn barrier(
    device: &ash::Device,
    command_buffer: vk::CommandBuffer,
    (image, layers): (vk::Image, u32),
    before: Use,
    after: Use,
) {
    if image == vk::Image::null() {
        return;
    }
    let or = |stages: vk::PipelineStageFlags, none| if stages.is_empty() { none } else { stages };
    let change = vk::ImageMemoryBarrier::default()
        .image(image)
        .old_layout(before.layout)
        .new_layout(after.layout)
        .src_access_mask(before.access)
        .dst_access_mask(after.access)
        .src_queue_family_index(vk::QUEUE_FAMILY_IGNORED)
        .dst_queue_family_index(vk::QUEUE_FAMILY_IGNORED)
        .subresource_range(vk::ImageSubresourceRange { layer_count: layers, ..COLOR });
    // SAFETY: as promised above.
    unsafe {
        device.cmd_pipeline_barrier(
            command_buffer,
            or(before.stages, vk::PipelineStageFlags::TOP_OF_PIPE),
            or(after.stages, vk::PipelineStageFlags::BOTTOM_OF_PIPE),
            vk::DependencyFlags::empty(),
            &[],
            &[],
            &[change],
        );
    }
}
