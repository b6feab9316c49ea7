//! Images of the program: sources, which contain views, and targets of the correction.

use super::barrier::{Use, barrier};
use super::memory::Buffer;
use crate::backend::vk::driver::api::Api;
use crate::backend::vk::driver::formats::check_source_format;
use crate::correct::ImageSize;
use crate::error::{Error, ErrorKind, Result};
use ash::vk;
use ash::vk::Handle;

/// An image that contains views: the plan's atlas, or an image of another
/// [`Arrangement`](crate::correct::Arrangement). The first row of the atlas is the top one: a
/// tile's first row is `atlas height − y − height`. Values are encoded, as a display expects them.
#[derive(Clone, Copy, Debug)]
pub struct SourceImage {
    /// The image. Null: no barrier is recorded, and the view can be read in `layout`.
    pub image: vk::Image,
    /// View of the first level: 2D, of the first layer; for layers a 2D array with one layer for
    /// each view.
    pub view: vk::ImageView,
    /// Format of the view: normalised or floating-point, can be filtered, not sRGB.
    pub format: vk::Format,
    /// Width and height in pixels.
    pub extent: (u32, u32),
    /// Layout of the image before and after the correction.
    pub layout: vk::ImageLayout,
    /// Stages that wrote the image, and that will write it next.
    pub stages: vk::PipelineStageFlags,
    /// Accesses of these stages.
    pub access: vk::AccessFlags,
}

/// An image that outputs are corrected into.
#[derive(Clone, Copy, Debug)]
pub struct TargetImage {
    /// The image.
    pub image: vk::Image,
    /// A 2D view of its first level and layer.
    pub view: vk::ImageView,
    /// Format of the view: the format for which the backend was prepared.
    pub format: vk::Format,
    /// Width and height in pixels.
    pub extent: (u32, u32),
    /// Layout before the correction. `UNDEFINED`: the former content is lost, and pixels outside
    /// all outputs become black.
    pub initial_layout: vk::ImageLayout,
    /// Layout after the correction.
    pub final_layout: vk::ImageLayout,
    /// Stages and accesses before the correction, for which it waits.
    pub before: (vk::PipelineStageFlags, vk::AccessFlags),
    /// Stages and accesses after the correction, which wait for it.
    pub after: (vk::PipelineStageFlags, vk::AccessFlags),
}

impl SourceImage {
    /// Returns the same image as a target. Its former content is lost; its layout afterwards is the
    /// same.
    pub fn overwritten(&self) -> TargetImage {
        TargetImage {
            image: self.image,
            view: self.view,
            format: self.format,
            extent: self.extent,
            initial_layout: vk::ImageLayout::UNDEFINED,
            final_layout: self.layout,
            before: (self.stages, self.access),
            after: (self.stages, self.access),
        }
    }

    pub(super) fn check(&self, api: &Api, size: ImageSize) -> Result<()> {
        let what = "an image with views";
        if self.view.is_null() {
            return Err(wrong(format!("the view of {what} is VK_NULL_HANDLE")));
        }
        check_source_format(api, self.format)?;
        if self.extent != (size.width, size.height) {
            let (width, height) = self.extent;
            let message = format!("{what} is {width} × {height} pixels; expected {} × {}", size.width, size.height);
            return Err(wrong(message));
        }
        if matches!(self.layout, vk::ImageLayout::UNDEFINED | vk::ImageLayout::PREINITIALIZED) {
            return Err(wrong(format!("{what} has the layout {:?}, in which an image cannot be left", self.layout)));
        }
        Ok(())
    }

    /// Returns the layout in which the image is sampled.
    pub(super) fn sampled_layout(&self) -> vk::ImageLayout {
        match self.layout {
            vk::ImageLayout::GENERAL => vk::ImageLayout::GENERAL,
            _ if self.image.is_null() => self.layout,
            _ => vk::ImageLayout::SHADER_READ_ONLY_OPTIMAL,
        }
    }

    /// Records the barrier after which Cupola's shaders can read the first `layers` layers.
    ///
    /// # Safety
    /// As for [`barrier`].
    pub(super) unsafe fn acquire(&self, api: &Api, command_buffer: vk::CommandBuffer, layers: u32) {
        let read = Use::sampled(self.sampled_layout());
        // SAFETY: as promised above.
        unsafe { barrier(&api.device, command_buffer, (self.image, layers), self.written(), read) };
    }

    /// Records the barrier after which the program can write the layers again.
    ///
    /// # Safety
    /// As for [`barrier`].
    pub(super) unsafe fn release(&self, api: &Api, command_buffer: vk::CommandBuffer, layers: u32) {
        let read = Use { access: vk::AccessFlags::empty(), ..Use::sampled(self.sampled_layout()) };
        // SAFETY: as promised above.
        unsafe { barrier(&api.device, command_buffer, (self.image, layers), read, self.written()) };
    }

    fn written(&self) -> Use {
        Use { layout: self.layout, stages: self.stages, access: self.access }
    }
}

impl TargetImage {
    /// Checks the image for a backend that was prepared for `format`.
    pub(super) fn check(&self, api: &Api, format: vk::Format) -> Result<()> {
        let what = "an image to correct into";
        if self.image.is_null() || self.view.is_null() {
            return Err(wrong(format!("{what}, or its view, is VK_NULL_HANDLE")));
        }
        if self.format != format {
            return Err(wrong(format!("{what} has the format {:?}; expected {format:?}", self.format)));
        }
        if matches!(self.final_layout, vk::ImageLayout::UNDEFINED | vk::ImageLayout::PREINITIALIZED) {
            return Err(wrong(format!("{what} cannot be left in the layout {:?}", self.final_layout)));
        }
        let ((width, height), limits) = (self.extent, &api.limits);
        let (widest, highest) = (limits.max_framebuffer_width, limits.max_framebuffer_height);
        if !(1..=widest).contains(&width) || !(1..=highest).contains(&height) {
            let right = format!("1 × 1 to {widest} × {highest}");
            return Err(wrong(format!("{what} is {width} × {height} pixels; expected {right}")));
        }
        Ok(())
    }

    /// Records the barrier after which Cupola's render pass can write the image.
    ///
    /// # Safety
    /// As for [`barrier`].
    pub(super) unsafe fn acquire(&self, api: &Api, command_buffer: vk::CommandBuffer) {
        let before = Use { layout: self.initial_layout, stages: self.before.0, access: self.before.1 };
        // SAFETY: as promised above.
        unsafe { barrier(&api.device, command_buffer, (self.image, 1), before, DRAWN) };
    }

    /// Records the barrier after which later commands can use the image.
    ///
    /// # Safety
    /// As for [`barrier`].
    pub(super) unsafe fn release(&self, api: &Api, command_buffer: vk::CommandBuffer) {
        let after = Use { layout: self.final_layout, stages: self.after.0, access: self.after.1 };
        // SAFETY: as promised above.
        unsafe { barrier(&api.device, command_buffer, (self.image, 1), DRAWN, after) };
    }
}

/// Use of a target by Cupola's render pass.
const DRAWN: Use = Use {
    layout: vk::ImageLayout::COLOR_ATTACHMENT_OPTIMAL,
    stages: vk::PipelineStageFlags::COLOR_ATTACHMENT_OUTPUT,
    access: vk::AccessFlags::from_raw(
        vk::AccessFlags::COLOR_ATTACHMENT_READ.as_raw() | vk::AccessFlags::COLOR_ATTACHMENT_WRITE.as_raw(),
    ),
};

fn wrong(message: String) -> Error {
    Error::new(ErrorKind::InvalidArgument, message)
}

/// Records the copy of an image of `size`, in `TRANSFER_SRC_OPTIMAL`, into a buffer that the
/// processor reads afterwards.
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
    // SAFETY: the command buffer is being recorded; image and buffer are live, and the buffer is
    // large enough.
    unsafe {
        api.device.cmd_copy_image_to_buffer(command_buffer, image, layout, buffer.handle, &[region]);
        api.device.cmd_pipeline_barrier(command_buffer, copy, host, vk::DependencyFlags::empty(), &[], &written, &[]);
    }
}
