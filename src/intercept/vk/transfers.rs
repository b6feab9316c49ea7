//! Barriers, clears and copies: the twins' layouts follow the images', clears reach each tile.

use super::device::Device;
use super::draws::rectangle;
use super::hook::hooks;
use super::layout::{Layout, Rect};
use super::recording::Event;
use ash::vk;

/// Where a clear of `rect` of the window goes: views, or the panel only.
fn cleared(layout: &Layout, rect: &vk::Rect2D) -> (Vec<Rect>, Rect) {
    let (width, height) = layout.window;
    let whole = rect.offset.x <= 0
        && rect.offset.y <= 0
        && i64::from(rect.offset.x) + i64::from(rect.extent.width) >= i64::from(width)
        && i64::from(rect.offset.y) + i64::from(rect.extent.height) >= i64::from(height);
    let [x, y, ..] = layout.panel;
    let panel = [x + rect.offset.x, y + rect.offset.y, rect.extent.width as i32, rect.extent.height as i32];
    let views = layout.views.iter().map(|(tile, own)| {
        let [x, y, ..] = *tile;
        if *own { [x + rect.offset.x, y + rect.offset.y, panel[2], panel[3]] } else { *tile }
    });
    if whole { (views.collect(), layout.glass()) } else { (Vec::new(), panel) }
}

/// Clears parts of the window in a pass that is drawn for each view.
///
/// # Safety
/// The command buffer is being recorded, within the pass.
unsafe fn clear(
    device: &Device,
    buffer: vk::CommandBuffer,
    layout: &Layout,
    what: &[vk::ClearAttachment],
    rects: &[vk::ClearRect],
) {
    let rect = |rect| vk::ClearRect { rect: rectangle(rect), base_array_layer: 0, layer_count: 1 };
    for given in rects {
        let (views, panel) = cleared(layout, &given.rect);
        let (in_views, panel) = (views.iter().map(|tile| rect(*tile)).collect::<Vec<_>>(), [rect(panel)]);
        // What is cleared as a whole is seen through; what is cleared in part is a picture on the panel.
        let glass = |clear: &vk::ClearAttachment| match clear.aspect_mask.contains(vk::ImageAspectFlags::COLOR) {
            true if !in_views.is_empty() => vk::ClearAttachment { clear_value: vk::ClearValue::default(), ..*clear },
            _ => *clear,
        };
        let on_panel: Vec<_> = what.iter().map(glass).collect();
        // SAFETY: as promised; the tiles lie in the atlas.
        unsafe {
            if !in_views.is_empty() {
                device.functions.cmd_clear_attachments(buffer, what, &in_views);
            }
            device.functions.cmd_clear_attachments(buffer, &on_panel, &panel);
        }
    }
}

/// A command other than a draw writes or reads a swapchain's image.
fn touched(device: &Device, buffer: vk::CommandBuffer, from: vk::Image, to: vk::Image) {
    if let Some(shown) = device.images.shown_image(to) {
        device.give_up("it copies its picture to the window");
        device.recordings.with(buffer, |recording| recording.events.push(Event::Drawn(shown, false)));
    } else if device.images.shown_image(from).is_some() {
        device.give_up("it copies its picture from the window");
    }
}

hooks! { transfers;
    [c"vkCmdPipelineBarrier"] cmd_pipeline_barrier: vk::PFN_vkCmdPipelineBarrier = (
        buffer: vk::CommandBuffer, before: vk::PipelineStageFlags, after: vk::PipelineStageFlags, flags: vk::DependencyFlags,
        memory_count: u32, memory: *const vk::MemoryBarrier<'_>, buffer_count: u32, buffers: *const vk::BufferMemoryBarrier<'_>,
        image_count: u32, images: *const vk::ImageMemoryBarrier<'_>
    ) { |state, next| {
        let given = super::slice(images, image_count);
        let mut all = given.to_vec();
        for barrier in given {
            state.images.moved(barrier.image, barrier.new_layout);
            all.extend(state.images.twins(barrier.image).into_iter().map(|twin| (*barrier).image(twin)));
        }
        next(buffer, before, after, flags, memory_count, memory, buffer_count, buffers, all.len() as u32, all.as_ptr())
    } }
    [c"vkCmdPipelineBarrier2", c"vkCmdPipelineBarrier2KHR"] cmd_pipeline_barrier2: vk::PFN_vkCmdPipelineBarrier2 = (
        buffer: vk::CommandBuffer, info: *const vk::DependencyInfo<'_>
    ) { |state, next| {
        let given = super::slice((*info).p_image_memory_barriers, (*info).image_memory_barrier_count);
        let mut all = given.to_vec();
        for barrier in given {
            state.images.moved(barrier.image, barrier.new_layout);
            all.extend(state.images.twins(barrier.image).into_iter().map(|twin| (*barrier).image(twin)));
        }
        let changed = (*info).image_memory_barriers(&all);
        next(buffer, &changed)
    } }
    [c"vkCmdClearAttachments"] cmd_clear_attachments: vk::PFN_vkCmdClearAttachments = (
        buffer: vk::CommandBuffer, count: u32, what: *const vk::ClearAttachment, rect_count: u32, rects: *const vk::ClearRect
    ) { |state, next| {
        let layout = state.recordings.with(buffer, |recording| {
            recording.pass.as_ref().map(|pass| std::sync::Arc::clone(&pass.shown.layout))
        });
        match layout.flatten() {
            Some(layout) => clear(&state, buffer, &layout, super::slice(what, count), super::slice(rects, rect_count)),
            None => next(buffer, count, what, rect_count, rects),
        }
    } }
    [c"vkCmdClearColorImage"] cmd_clear_color_image: vk::PFN_vkCmdClearColorImage = (
        buffer: vk::CommandBuffer, image: vk::Image, layout: vk::ImageLayout, color: *const vk::ClearColorValue, count: u32, ranges: *const vk::ImageSubresourceRange
    ) { |state, next| {
        for twin in state.images.twins(image) {
            next(buffer, twin, layout, color, count, ranges);
        }
        next(buffer, image, layout, color, count, ranges)
    } }
    [c"vkCmdClearDepthStencilImage"] cmd_clear_depth_stencil_image: vk::PFN_vkCmdClearDepthStencilImage = (
        buffer: vk::CommandBuffer, image: vk::Image, layout: vk::ImageLayout, value: *const vk::ClearDepthStencilValue, count: u32, ranges: *const vk::ImageSubresourceRange
    ) { |state, next| {
        for twin in state.images.twins(image) {
            next(buffer, twin, layout, value, count, ranges);
        }
        next(buffer, image, layout, value, count, ranges)
    } }
    [c"vkCmdCopyImage"] cmd_copy_image: vk::PFN_vkCmdCopyImage = (
        buffer: vk::CommandBuffer, from: vk::Image, from_layout: vk::ImageLayout, to: vk::Image, to_layout: vk::ImageLayout, count: u32, regions: *const vk::ImageCopy
    ) { |state, next| {
        touched(&state, buffer, from, to);
        next(buffer, from, from_layout, to, to_layout, count, regions)
    } }
    [c"vkCmdBlitImage"] cmd_blit_image: vk::PFN_vkCmdBlitImage = (
        buffer: vk::CommandBuffer, from: vk::Image, from_layout: vk::ImageLayout, to: vk::Image, to_layout: vk::ImageLayout, count: u32, regions: *const vk::ImageBlit, filter: vk::Filter
    ) { |state, next| {
        touched(&state, buffer, from, to);
        next(buffer, from, from_layout, to, to_layout, count, regions, filter)
    } }
    [c"vkCmdResolveImage"] cmd_resolve_image: vk::PFN_vkCmdResolveImage = (
        buffer: vk::CommandBuffer, from: vk::Image, from_layout: vk::ImageLayout, to: vk::Image, to_layout: vk::ImageLayout, count: u32, regions: *const vk::ImageResolve
    ) { |state, next| {
        touched(&state, buffer, from, to);
        next(buffer, from, from_layout, to, to_layout, count, regions)
    } }
    [c"vkCmdCopyBufferToImage"] cmd_copy_buffer_to_image: vk::PFN_vkCmdCopyBufferToImage = (
        buffer: vk::CommandBuffer, from: vk::Buffer, to: vk::Image, to_layout: vk::ImageLayout, count: u32, regions: *const vk::BufferImageCopy
    ) { |state, next| {
        touched(&state, buffer, vk::Image::null(), to);
        next(buffer, from, to, to_layout, count, regions)
    } }
    [c"vkCmdCopyImageToBuffer"] cmd_copy_image_to_buffer: vk::PFN_vkCmdCopyImageToBuffer = (
        buffer: vk::CommandBuffer, from: vk::Image, from_layout: vk::ImageLayout, to: vk::Buffer, count: u32, regions: *const vk::BufferImageCopy
    ) { |state, next| {
        touched(&state, buffer, from, vk::Image::null());
        next(buffer, from, from_layout, to, count, regions)
    } }
    [c"vkCmdCopyImage2", c"vkCmdCopyImage2KHR"] cmd_copy_image2: vk::PFN_vkCmdCopyImage2 = (
        buffer: vk::CommandBuffer, info: *const vk::CopyImageInfo2<'_>
    ) { |state, next| {
        touched(&state, buffer, (*info).src_image, (*info).dst_image);
        next(buffer, info)
    } }
    [c"vkCmdBlitImage2", c"vkCmdBlitImage2KHR"] cmd_blit_image2: vk::PFN_vkCmdBlitImage2 = (
        buffer: vk::CommandBuffer, info: *const vk::BlitImageInfo2<'_>
    ) { |state, next| {
        touched(&state, buffer, (*info).src_image, (*info).dst_image);
        next(buffer, info)
    } }
    [c"vkCmdResolveImage2", c"vkCmdResolveImage2KHR"] cmd_resolve_image2: vk::PFN_vkCmdResolveImage2 = (
        buffer: vk::CommandBuffer, info: *const vk::ResolveImageInfo2<'_>
    ) { |state, next| {
        touched(&state, buffer, (*info).src_image, (*info).dst_image);
        next(buffer, info)
    } }
    [c"vkCmdCopyBufferToImage2", c"vkCmdCopyBufferToImage2KHR"] cmd_copy_buffer_to_image2: vk::PFN_vkCmdCopyBufferToImage2 = (
        buffer: vk::CommandBuffer, info: *const vk::CopyBufferToImageInfo2<'_>
    ) { |state, next| {
        touched(&state, buffer, vk::Image::null(), (*info).dst_image);
        next(buffer, info)
    } }
    [c"vkCmdCopyImageToBuffer2", c"vkCmdCopyImageToBuffer2KHR"] cmd_copy_image_to_buffer2: vk::PFN_vkCmdCopyImageToBuffer2 = (
        buffer: vk::CommandBuffer, info: *const vk::CopyImageToBufferInfo2<'_>
    ) { |state, next| {
        touched(&state, buffer, (*info).src_image, vk::Image::null());
        next(buffer, info)
    } }
    [c"vkCmdCopyBuffer"] cmd_copy_buffer: vk::PFN_vkCmdCopyBuffer = (
        buffer: vk::CommandBuffer, from: vk::Buffer, to: vk::Buffer, count: u32, regions: *const vk::BufferCopy
    ) { |state, next| {
        state.recordings.with(buffer, |recording| {
            let regions = super::slice(regions, count).iter();
            recording.events.extend(regions.map(|region| Event::Copy(from, to, *region)));
        });
        next(buffer, from, to, count, regions)
    } }
    [c"vkCmdCopyBuffer2", c"vkCmdCopyBuffer2KHR"] cmd_copy_buffer2: vk::PFN_vkCmdCopyBuffer2 = (
        buffer: vk::CommandBuffer, info: *const vk::CopyBufferInfo2<'_>
    ) { |state, next| {
        state.recordings.with(buffer, |recording| {
            let regions = super::slice((*info).p_regions, (*info).region_count).iter();
            let plain = |r: &vk::BufferCopy2<'_>| vk::BufferCopy { src_offset: r.src_offset, dst_offset: r.dst_offset, size: r.size };
            recording.events.extend(regions.map(|r| Event::Copy((*info).src_buffer, (*info).dst_buffer, plain(r))));
        });
        next(buffer, info)
    } }
    [c"vkCmdUpdateBuffer"] cmd_update_buffer: vk::PFN_vkCmdUpdateBuffer = (
        buffer: vk::CommandBuffer, to: vk::Buffer, offset: vk::DeviceSize, size: vk::DeviceSize, data: *const std::ffi::c_void
    ) { |state, next| {
        let bytes = super::slice(data.cast::<u8>(), size as u32).to_vec();
        state.recordings.with(buffer, |recording| recording.events.push(Event::Update(to, offset, bytes)));
        next(buffer, to, offset, size, data)
    } }
}

#[cfg(test)]
mod tests {
    use super::cleared;
    use crate::intercept::vk::layout::Layout;
    use ash::vk;

    #[test]
    fn a_whole_clear_reaches_each_view_and_a_part_of_it_the_panel_only() {
        let rig = crate::rig::load("fisheye").expect("a preset");
        let layout = Layout::new(&rig, (200, 200), 16384).expect("a plan");
        let whole = vk::Rect2D { offset: vk::Offset2D::default(), extent: vk::Extent2D { width: 200, height: 200 } };
        let (views, panel) = cleared(&layout, &whole);
        assert_eq!((views.len(), panel), (layout.views.len(), layout.glass()));
        let part = vk::Rect2D { offset: vk::Offset2D { x: 20, y: 30 }, ..whole };
        let (views, panel) = cleared(&layout, &part);
        assert!(views.is_empty());
        assert_eq!(panel[..2], [layout.panel[0] + 20, layout.panel[1] + 30]);
    }
}
