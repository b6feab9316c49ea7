//! Recording the correction of a frame into a command buffer of the program.

use crate::backend::vk::barrier::{Use, barrier};
use crate::backend::vk::passes::{Output, Recording, VkBackend};
use crate::correct::{UpperLeftRect, apart};
use crate::error::{Error, ErrorKind, Result};
use ash::vk;
use std::mem::take;

impl VkBackend {
    /// [`VkBackend::record`] for a command buffer that was vouched for.
    ///
    /// # Errors
    /// As for [`VkBackend::record`].
    pub fn correct(
        &mut self,
        recording: &Recording,
        source: usize,
        target: usize,
        viewports: &[UpperLeftRect],
    ) -> Result<()> {
        // SAFETY: as was promised to `Recording::new`.
        unsafe { self.record(recording.0, source, target, viewports) }
    }

    /// Records the correction of source `source` into target `target`: barriers, one render pass,
    /// barriers. `viewports`: rectangle of each output of the plan, in its order. With another size
    /// than the output's own, the picture is scaled without a second filter: the map is evaluated
    /// at each pixel of the target. Allocates nothing and makes no object.
    ///
    /// # Errors
    /// [`ErrorKind::InvalidArgument`] for an index that was not set; nothing is recorded then.
    ///
    /// # Safety
    /// The command buffer is being recorded, outside a render pass, for a queue that can draw; the
    /// images that were set are live and in the declared layouts.
    pub unsafe fn record(
        &mut self,
        command_buffer: vk::CommandBuffer,
        source: usize,
        target: usize,
        viewports: &[UpperLeftRect],
    ) -> Result<()> {
        let missing = |what: &str, index: usize, count: usize| {
            Error::new(ErrorKind::InvalidArgument, format!("there is no {what} {index}; {count} were set"))
        };
        let (sources, index) = (&self.descriptors.sources, source);
        let source = sources.get(index).ok_or_else(|| missing("source", index, sources.len()))?;
        let (image, framebuffer) =
            self.targets.get(target).ok_or_else(|| missing("target", target, self.targets.len()))?;
        let clear = usize::from(image.initial_layout == vk::ImageLayout::UNDEFINED);
        let black = [vk::ClearValue { color: vk::ClearColorValue { float32: [0.0, 0.0, 0.0, 1.0] } }];
        let extent = vk::Extent2D { width: image.extent.0, height: image.extent.1 };
        let begin = vk::RenderPassBeginInfo::default()
            .render_pass(self.common.render_passes[clear])
            .framebuffer(*framebuffer)
            .render_area(extent.into())
            .clear_values(&black);
        let device = &self.api.device;
        // SAFETY: as promised above; all other objects are Cupola's and live.
        unsafe {
            if take(&mut self.upload) {
                self.fill_textures(command_buffer);
            }
            self.timers.start(&self.api, command_buffer, index);
            for (image, layers) in &source.images {
                image.acquire(&self.api, command_buffer, *layers);
            }
            image.acquire(&self.api, command_buffer);
            device.cmd_begin_render_pass(command_buffer, &begin, vk::SubpassContents::INLINE);
            device.cmd_bind_vertex_buffers(command_buffer, 0, &[self.vertices.handle], &[0]);
            device.cmd_bind_index_buffer(command_buffer, self.indices.handle, 0, vk::IndexType::UINT32);
            let mut sets = source.sets.as_slice();
            let is_black = clear == 1 && apart(viewports, UpperLeftRect::meets);
            for (output, viewport) in self.outputs.iter().zip(viewports) {
                let (own, others) = sets.split_at(output.draws.len().min(sets.len()));
                self.draw_output(command_buffer, output, own, *viewport, extent, is_black);
                sets = others;
            }
            device.cmd_end_render_pass(command_buffer);
            image.release(&self.api, command_buffer);
            for (image, layers) in &source.images {
                image.release(&self.api, command_buffer, *layers);
            }
            self.timers.stop(&self.api, command_buffer, index);
        }
        Ok(())
    }

    /// Draws one output. `is_black`: the target is already black where the output is.
    ///
    /// # Safety
    /// As for [`VkBackend::record`], inside the render pass.
    unsafe fn draw_output(
        &self,
        command_buffer: vk::CommandBuffer,
        output: &Output,
        sets: &[[vk::DescriptorSet; 2]],
        UpperLeftRect { x, y, width, height }: UpperLeftRect,
        extent: vk::Extent2D,
        is_black: bool,
    ) {
        // A scissor must not be negative. Parts of a viewport outside the target are clipped
        // anyway.
        let (left, top) = (x.clamp(0, extent.width as i32), y.clamp(0, extent.height as i32));
        let (right, bottom) = (x.saturating_add(width), y.saturating_add(height));
        let (right, bottom) = (right.clamp(left, extent.width as i32), bottom.clamp(top, extent.height as i32));
        if right == left || bottom == top {
            return;
        }
        let [x, y, across, down] = [x, y, width, height].map(crate::correct::single::pixels);
        let viewport = vk::Viewport { x, y, width: across, height: down, min_depth: 0.0, max_depth: 1.0 };
        let scissor = vk::Rect2D {
            offset: vk::Offset2D { x: left, y: top },
            extent: vk::Extent2D { width: (right - left) as u32, height: (bottom - top) as u32 },
        };
        let unscaled = (i64::from(width), i64::from(height)) == (output.size.0.into(), output.size.1.into());
        let (device, graphics) = (&self.api.device, vk::PipelineBindPoint::GRAPHICS);
        // SAFETY: as promised above.
        unsafe {
            device.cmd_set_viewport(command_buffer, 0, &[viewport]);
            device.cmd_set_scissor(command_buffer, 0, &[scissor]);
            for (draw, sets) in output.draws.iter().zip(sets).filter(|(draw, _)| !(is_black && draw.black)) {
                let set = sets[usize::from(draw.nearest && unscaled)];
                device.cmd_bind_descriptor_sets(command_buffer, graphics, self.common.layout, 0, &[set], &[]);
                device.cmd_bind_pipeline(command_buffer, graphics, draw.pipeline);
                device.cmd_draw_indexed(command_buffer, draw.count, 1, draw.first, 0, 0);
            }
        }
    }

    /// Records the copies of masks, tables and pictures of black.
    ///
    /// # Safety
    /// As for [`VkBackend::record`].
    unsafe fn fill_textures(&self, command_buffer: vk::CommandBuffer) {
        let (nothing, copied) = (Use::nothing(vk::ImageLayout::UNDEFINED), Use::COPIED_TO);
        let read = Use::sampled(vk::ImageLayout::SHADER_READ_ONLY_OPTIMAL);
        let (device, values) = (&self.api.device, self.staging.handle);
        for texture in &self.textures {
            let image = texture.image.handle;
            let region = vk::BufferImageCopy::default()
                .buffer_offset(texture.offset)
                .image_subresource(vk::ImageSubresourceLayers {
                    aspect_mask: vk::ImageAspectFlags::COLOR,
                    layer_count: 1,
                    ..Default::default()
                })
                .image_extent(vk::Extent3D { width: texture.size.0, height: texture.size.1, depth: 1 });
            // SAFETY: as promised above; buffer and image are Cupola's, and the values lie in the
            // buffer.
            unsafe {
                barrier(device, command_buffer, (image, 1), nothing, copied);
                device.cmd_copy_buffer_to_image(command_buffer, values, image, copied.layout, &[region]);
                barrier(device, command_buffer, (image, 1), copied, read);
            }
        }
    }
}
