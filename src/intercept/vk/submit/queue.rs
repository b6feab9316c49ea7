//! Submissions. The draws of submitted command buffers get their view constants here.

use crate::backend::vk::COLOR;
use crate::intercept::vk::state::device::Device;
use crate::intercept::vk::state::driver::own_image::{barrier as barrier_of_color, left_in, ready_in};
use crate::intercept::vk::state::driver::structures::slice;
use crate::intercept::vk::state::hooks::hooks;
use crate::intercept::vk::state::images::PendingLayout;
use crate::intercept::vk::submit::draw_groups;
use ash::prelude::VkResult;
use ash::vk;

/// Handles command buffers that are submitted to a queue.
///
/// # Safety
/// The program submits on this queue, so that no other thread uses it.
unsafe fn submitted(device: &Device, queue: vk::Queue, buffers: impl Iterator<Item = vk::CommandBuffer>) {
    for buffer in buffers {
        device.recordings.with(buffer, |recording| draw_groups::submitted(device, recording));
    }
    let pending = device.images.take_pending();
    if !pending.is_empty() {
        // SAFETY: as promised.
        if let Err(error) = unsafe { bring(device, queue, &pending) } {
            device.show_flat(format!("the driver refuses commands: {error}"));
        }
    }
}

/// Changes new atlas copies to the layouts that the program expects its images to have. This is
/// done once for each copy, and waits for the device.
///
/// # Safety
/// As for [`submitted`].
unsafe fn bring(device: &Device, queue: vk::Queue, pending: &[PendingLayout]) -> VkResult<()> {
    let family = device.queue(queue).family;
    let functions = &device.driver.functions;
    let barrier = |pending: &PendingLayout| {
        let range = vk::ImageSubresourceRange {
            aspect_mask: pending.aspects,
            level_count: vk::REMAINING_MIP_LEVELS,
            layer_count: 1,
            ..Default::default()
        };
        vk::ImageMemoryBarrier::default()
            .image(pending.image)
            .new_layout(pending.layout)
            .dst_access_mask(vk::AccessFlags::MEMORY_READ | vk::AccessFlags::MEMORY_WRITE)
            .src_queue_family_index(vk::QUEUE_FAMILY_IGNORED)
            .dst_queue_family_index(vk::QUEUE_FAMILY_IGNORED)
            .subresource_range(range)
    };
    let barriers: Vec<_> = pending.iter().map(barrier).collect();
    let cleared: Vec<_> = pending.iter().filter(|pending| pending.cleared).collect();
    let info = vk::CommandPoolCreateInfo::default().queue_family_index(family);
    // SAFETY: as promised; the pool is destroyed after the device has finished with it.
    unsafe {
        let pool = functions.create_command_pool(&info, None)?;
        let run = || {
            let buffer = device.driver.command_buffer(pool)?;
            functions.begin_command_buffer(buffer, &vk::CommandBufferBeginInfo::default())?;
            let stages = vk::PipelineStageFlags::ALL_COMMANDS;
            functions.cmd_pipeline_barrier(buffer, stages, stages, vk::DependencyFlags::empty(), &[], &[], &barriers);
            for PendingLayout { image, layout, .. } in &cleared {
                functions.cmd_clear_color_image(buffer, *image, *layout, &vk::ClearColorValue::default(), &[COLOR]);
                barrier_of_color(&device.driver, buffer, *image, left_in(*layout), ready_in(*layout));
            }
            for pending in pending {
                fill(device, buffer, pending);
            }
            functions.end_command_buffer(buffer)?;
            let fence = functions.create_fence(&vk::FenceCreateInfo::default(), None)?;
            let work = vk::SubmitInfo::default().command_buffers(std::slice::from_ref(&buffer));
            let done = functions
                .queue_submit(queue, &[work], fence)
                .and_then(|()| functions.wait_for_fences(&[fence], true, u64::MAX));
            functions.destroy_fence(fence, None);
            done
        };
        let result = run();
        functions.destroy_command_pool(pool, None);
        result
    }
}

/// Copies the content of the program's image to an atlas.
///
/// # Safety
/// The command buffer is being recorded, and the program's image is in the layout of `pending`.
unsafe fn fill(device: &Device, buffer: vk::CommandBuffer, pending: &PendingLayout) {
    let PendingLayout { image, layout, aspects, filled, .. } = *pending;
    let Some((from, place)) = filled.filter(|_| layout != vk::ImageLayout::UNDEFINED) else { return };
    let functions = &device.driver.functions;
    let both = |[from_layout, to_layout]: [vk::ImageLayout; 2], back: bool| {
        let one = |image, copies| {
            let range = vk::ImageSubresourceRange { aspect_mask: aspects, ..COLOR };
            let (old, new) = if back { (copies, layout) } else { (layout, copies) };
            vk::ImageMemoryBarrier::default()
                .image(image)
                .old_layout(old)
                .new_layout(new)
                .src_access_mask(vk::AccessFlags::MEMORY_WRITE)
                .dst_access_mask(vk::AccessFlags::MEMORY_READ | vk::AccessFlags::MEMORY_WRITE)
                .src_queue_family_index(vk::QUEUE_FAMILY_IGNORED)
                .dst_queue_family_index(vk::QUEUE_FAMILY_IGNORED)
                .subresource_range(range)
        };
        let barriers = [one(from, from_layout), one(image, to_layout)];
        let (stages, flags) = (vk::PipelineStageFlags::ALL_COMMANDS, vk::DependencyFlags::empty());
        // SAFETY: as promised.
        unsafe { functions.cmd_pipeline_barrier(buffer, stages, stages, flags, &[], &[], &barriers) };
    };
    let layers = vk::ImageSubresourceLayers { aspect_mask: aspects, layer_count: 1, ..Default::default() };
    let region = vk::ImageCopy::default().src_subresource(layers).dst_subresource(layers);
    let extent = vk::Extent3D { width: place.width as u32, height: place.height as u32, depth: 1 };
    let copied = [vk::ImageLayout::TRANSFER_SRC_OPTIMAL, vk::ImageLayout::TRANSFER_DST_OPTIMAL];
    both(copied, false);
    // SAFETY: as promised; the rectangle lies in the atlas, and is as large as the image.
    unsafe {
        functions.cmd_copy_image(
            buffer,
            from,
            copied[0],
            image,
            copied[1],
            &[region.dst_offset(place.offset()).extent(extent)],
        );
    }
    both(copied, true);
}

hooks! {
    queue_submit = (
        queue: vk::Queue, count: u32, submits: *const vk::SubmitInfo<'_>, fence: vk::Fence
    ) -> vk::Result { |state, next| {
        let batches = slice(submits, count).iter();
        submitted(&state, queue, batches.flat_map(|s| slice(s.p_command_buffers, s.command_buffer_count)).copied());
        next(queue, count, submits, fence)
    } }
    queue_submit2 = (
        queue: vk::Queue, count: u32, submits: *const vk::SubmitInfo2<'_>, fence: vk::Fence
    ) -> vk::Result { |state, next| {
        let batches = slice(submits, count).iter();
        let buffers = batches.flat_map(|s| slice(s.p_command_buffer_infos, s.command_buffer_info_count));
        submitted(&state, queue, buffers.map(|info| info.command_buffer));
        next(queue, count, submits, fence)
    } }
}
