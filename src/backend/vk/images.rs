//! Images of the program's: where views are, and where they are corrected into.

use super::api::Api;
use super::memory::{Buffer, COLOR};
use crate::correct::ImageSize;
use crate::error::{Error, ErrorKind, Result};
use ash::vk;
use ash::vk::Handle;

/// An image that holds views: the plan's atlas, whose first row is the top one (a tile's first row is
/// `atlas height − y − height`), or what [`Arrangement`](crate::correct::Arrangement) has in its place. Its values are
/// encoded, as a display takes them.
#[derive(Clone, Copy, Debug)]
pub struct SourceImage {
    /// The image; null: no barrier is recorded, and it can be read in `layout` as it is.
    pub image: vk::Image,
    /// A view of its first level, 2D, of its first layer; of layers a 2D array, of the first and as many as there are views.
    pub view: vk::ImageView,
    /// The view's format: normalised or floating numbers, filtered, not sRGB.
    pub format: vk::Format,
    /// Width and height in pixels.
    pub extent: (u32, u32),
    /// The layout in which it is found, and left again.
    pub layout: vk::ImageLayout,
    /// The stages that wrote it, and will write it next.
    pub stages: vk::PipelineStageFlags,
    /// The accesses by which they do.
    pub access: vk::AccessFlags,
}

/// An image that outputs are corrected into.
#[derive(Clone, Copy, Debug)]
pub struct TargetImage {
    /// The image.
    pub image: vk::Image,
    /// A 2D view of its first level and layer.
    pub view: vk::ImageView,
    /// The view's format, the one that the backend was prepared for.
    pub format: vk::Format,
    /// Width and height in pixels.
    pub extent: (u32, u32),
    /// The layout in which it is found. `UNDEFINED`: what was in it is lost, and black where no output is.
    pub initial_layout: vk::ImageLayout,
    /// The layout in which it is left.
    pub final_layout: vk::ImageLayout,
    /// Stages and accesses that come before and have to be waited for.
    pub before: (vk::PipelineStageFlags, vk::AccessFlags),
    /// Stages and accesses that come after and have to wait.
    pub after: (vk::PipelineStageFlags, vk::AccessFlags),
}

impl SourceImage {
    pub(super) fn check(&self, api: &Api, size: ImageSize) -> Result<()> {
        let what = "an image with views";
        let needed = vk::FormatFeatureFlags::SAMPLED_IMAGE | vk::FormatFeatureFlags::SAMPLED_IMAGE_FILTER_LINEAR;
        check(api, what, self.view, self.format, needed)?;
        if self.extent != (size.width, size.height) {
            let (width, height) = self.extent;
            let message =
                format!("{what} is {width} × {height} pixels; right would be {} × {}", size.width, size.height);
            return Err(wrong(message));
        }
        if matches!(self.layout, vk::ImageLayout::UNDEFINED | vk::ImageLayout::PREINITIALIZED) {
            return Err(wrong(format!("{what} is in the layout {:?}, in which nothing can be left", self.layout)));
        }
        Ok(())
    }

    /// The layout in which it is sampled.
    pub(super) fn sampled_layout(&self) -> vk::ImageLayout {
        match self.layout {
            vk::ImageLayout::GENERAL => vk::ImageLayout::GENERAL,
            _ if self.image.is_null() => self.layout,
            _ => vk::ImageLayout::SHADER_READ_ONLY_OPTIMAL,
        }
    }

    /// Records that its first `layers` layers can be read by our shader.
    pub(super) fn acquire(&self, api: &Api, command_buffer: vk::CommandBuffer, layers: u32) {
        let read = (vk::PipelineStageFlags::FRAGMENT_SHADER, vk::AccessFlags::SHADER_READ);
        let layouts = (self.layout, self.sampled_layout());
        barrier(api, command_buffer, (self.image, layers), layouts, (self.stages, self.access), read);
    }

    /// Records that the program can write them again.
    pub(super) fn release(&self, api: &Api, command_buffer: vk::CommandBuffer, layers: u32) {
        let read = (vk::PipelineStageFlags::FRAGMENT_SHADER, vk::AccessFlags::empty());
        let layouts = (self.sampled_layout(), self.layout);
        barrier(api, command_buffer, (self.image, layers), layouts, read, (self.stages, self.access));
    }
}

impl TargetImage {
    pub(super) fn check(&self, api: &Api, format: vk::Format) -> Result<()> {
        let what = "an image to correct into";
        check(api, what, self.view, self.format, vk::FormatFeatureFlags::COLOR_ATTACHMENT)?;
        if self.image.is_null() {
            return Err(wrong(format!("{what} is VK_NULL_HANDLE")));
        }
        if self.format != format {
            return Err(wrong(format!("{what} has the format {:?}; right would be {format:?}", self.format)));
        }
        if matches!(self.final_layout, vk::ImageLayout::UNDEFINED | vk::ImageLayout::PREINITIALIZED) {
            return Err(wrong(format!("{what} cannot be left in the layout {:?}", self.final_layout)));
        }
        Ok(())
    }

    /// Records that our render pass can write it.
    pub(super) fn acquire(&self, api: &Api, command_buffer: vk::CommandBuffer) {
        let layouts = (self.initial_layout, vk::ImageLayout::COLOR_ATTACHMENT_OPTIMAL);
        barrier(api, command_buffer, (self.image, 1), layouts, self.before, WRITE);
    }

    /// Records that what comes after can use it.
    pub(super) fn release(&self, api: &Api, command_buffer: vk::CommandBuffer) {
        let layouts = (vk::ImageLayout::COLOR_ATTACHMENT_OPTIMAL, self.final_layout);
        barrier(api, command_buffer, (self.image, 1), layouts, WRITE, self.after);
    }
}

/// How the correction writes.
const WRITE: (vk::PipelineStageFlags, vk::AccessFlags) = (
    vk::PipelineStageFlags::COLOR_ATTACHMENT_OUTPUT,
    vk::AccessFlags::from_raw(
        vk::AccessFlags::COLOR_ATTACHMENT_READ.as_raw() | vk::AccessFlags::COLOR_ATTACHMENT_WRITE.as_raw(),
    ),
);

fn check(api: &Api, what: &str, view: vk::ImageView, format: vk::Format, needed: vk::FormatFeatureFlags) -> Result<()> {
    if view.is_null() {
        return Err(wrong(format!("the view of {what} is VK_NULL_HANDLE")));
    }
    if is_srgb(format) {
        return Err(wrong(format!(
            "{what} has the format {format:?}, which converts; right would be a view of the same image with the \
             _UNORM format (VK_IMAGE_CREATE_MUTABLE_FORMAT_BIT)"
        )));
    }
    if !api.features(format).contains(needed) {
        let message = format!("The device cannot use {format:?} for {what}: it needs {needed:?}.");
        return Err(Error::new(ErrorKind::Graphics, message));
    }
    Ok(())
}

fn is_srgb(format: vk::Format) -> bool {
    use vk::Format as F;
    matches!(format, F::R8G8B8A8_SRGB | F::B8G8R8A8_SRGB | F::A8B8G8R8_SRGB_PACK32 | F::R8G8B8_SRGB | F::B8G8R8_SRGB)
}

fn wrong(message: String) -> Error {
    Error::new(ErrorKind::InvalidArgument, message)
}

/// Records a barrier for the first level and `layers` layers of an image; none for a null image. An empty set of
/// stages means that there is nothing to wait for.
pub(super) fn barrier(
    api: &Api,
    command_buffer: vk::CommandBuffer,
    (image, layers): (vk::Image, u32),
    layouts: (vk::ImageLayout, vk::ImageLayout),
    before: (vk::PipelineStageFlags, vk::AccessFlags),
    after: (vk::PipelineStageFlags, vk::AccessFlags),
) {
    if image.is_null() {
        return;
    }
    let or = |stages: vk::PipelineStageFlags, none| if stages.is_empty() { none } else { stages };
    let barrier = vk::ImageMemoryBarrier::default()
        .image(image)
        .old_layout(layouts.0)
        .new_layout(layouts.1)
        .src_access_mask(before.1)
        .dst_access_mask(after.1)
        .src_queue_family_index(vk::QUEUE_FAMILY_IGNORED)
        .dst_queue_family_index(vk::QUEUE_FAMILY_IGNORED)
        .subresource_range(vk::ImageSubresourceRange { layer_count: layers, ..COLOR });
    // SAFETY: the command buffer is being recorded, outside a render pass, and the image is live.
    unsafe {
        api.device.cmd_pipeline_barrier(
            command_buffer,
            or(before.0, vk::PipelineStageFlags::TOP_OF_PIPE),
            or(after.0, vk::PipelineStageFlags::BOTTOM_OF_PIPE),
            vk::DependencyFlags::empty(),
            &[],
            &[],
            &[barrier],
        );
    }
}

/// Records the copy of an image of `size`, in `TRANSFER_SRC_OPTIMAL`, into a buffer that the processor reads after it.
pub(super) fn copy_to(
    api: &Api,
    command_buffer: vk::CommandBuffer,
    image: vk::Image,
    size: (u32, u32),
    buffer: &Buffer,
) {
    let region = vk::BufferImageCopy::default()
        .image_subresource(vk::ImageSubresourceLayers {
            aspect_mask: vk::ImageAspectFlags::COLOR,
            layer_count: 1,
            ..Default::default()
        })
        .image_extent(vk::Extent3D { width: size.0, height: size.1, depth: 1 });
    let written = [vk::BufferMemoryBarrier::default()
        .buffer(buffer.handle)
        .size(vk::WHOLE_SIZE)
        .src_access_mask(vk::AccessFlags::TRANSFER_WRITE)
        .dst_access_mask(vk::AccessFlags::HOST_READ)
        .src_queue_family_index(vk::QUEUE_FAMILY_IGNORED)
        .dst_queue_family_index(vk::QUEUE_FAMILY_IGNORED)];
    let (copy, host) = (vk::PipelineStageFlags::TRANSFER, vk::PipelineStageFlags::HOST);
    let layout = vk::ImageLayout::TRANSFER_SRC_OPTIMAL;
    // SAFETY: the command buffer is being recorded; image and buffer are live, and the buffer is large enough.
    unsafe {
        api.device.cmd_copy_image_to_buffer(command_buffer, image, layout, buffer.handle, &[region]);
        api.device.cmd_pipeline_barrier(command_buffer, copy, host, vk::DependencyFlags::empty(), &[], &written, &[]);
    }
}
