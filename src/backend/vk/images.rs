//! Images of the program's: where views are, and where they are corrected into.

use super::barrier::{Use, barrier};
use super::memory::Buffer;
use crate::backend::vk::driver::api::Api;
use crate::backend::vk::driver::formats::check_source_format;
use crate::correct::ImageSize;
use crate::error::{Error, ErrorKind, Result};
use ash::vk;
use ash::vk::Handle;

/// An image that holds views: the plan's atlas, whose first row is the top one (a tile's first row
/// is `atlas height − y − height`), or what [`Arrangement`](crate::correct::Arrangement) has in its
/// place. Its values are encoded, as a display takes them.
#[derive(Clone, Copy, Debug)]
pub struct SourceImage {
    /// The image; null: no barrier is recorded, and it can be read in `layout` as it is.
    pub image: vk::Image,
    /// A view of its first level, 2D, of its first layer; of layers a 2D array, of the first and as
    /// many as there are views.
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
    /// The layout in which it is found. `UNDEFINED`: what was in it is lost, and black where no
    /// output is.
    pub initial_layout: vk::ImageLayout,
    /// The layout in which it is left.
    pub final_layout: vk::ImageLayout,
    /// Stages and accesses that come before and have to be waited for.
    pub before: (vk::PipelineStageFlags, vk::AccessFlags),
    /// Stages and accesses that come after and have to wait.
    pub after: (vk::PipelineStageFlags, vk::AccessFlags),
}

impl SourceImage {
    /// The same image as a target: what was in it is lost, and it is left as it is found here.
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
    ///
    /// # Safety
    /// As for [`barrier`].
    pub(super) unsafe fn acquire(&self, api: &Api, command_buffer: vk::CommandBuffer, layers: u32) {
        let read = Use::sampled(self.sampled_layout());
        // SAFETY: as promised above.
        unsafe { barrier(&api.device, command_buffer, (self.image, layers), self.written(), read) };
    }

    /// Records that the program can write them again.
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
    /// Checks it for a backend that was prepared for `format`.
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

    /// Records that our render pass can write it.
    ///
    /// # Safety
    /// As for [`barrier`].
    pub(super) unsafe fn acquire(&self, api: &Api, command_buffer: vk::CommandBuffer) {
        let before = Use { layout: self.initial_layout, stages: self.before.0, access: self.before.1 };
        // SAFETY: as promised above.
        unsafe { barrier(&api.device, command_buffer, (self.image, 1), before, DRAWN) };
    }

    /// Records that what comes after can use it.
    ///
    /// # Safety
    /// As for [`barrier`].
    pub(super) unsafe fn release(&self, api: &Api, command_buffer: vk::CommandBuffer) {
        let after = Use { layout: self.final_layout, stages: self.after.0, access: self.after.1 };
        // SAFETY: as promised above.
        unsafe { barrier(&api.device, command_buffer, (self.image, 1), DRAWN, after) };
    }
}

/// Our render pass draws.
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
/// processor reads after it.
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
