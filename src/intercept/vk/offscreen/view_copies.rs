//! View copies: one image per view of an off-screen scene, for the program's shaders.
//!
//! A pass draws all views into one atlas, so that no draw changes its framebuffer. Shaders that
//! sample the image get the view's copy, so that coordinates, filter and wrapping of the program
//! stay valid.

use crate::backend::vk::Use;
use crate::intercept::vk::state::device::Device;
use crate::intercept::vk::state::driver::own_image::{
    ANYTHING, COLOR_LAYER, COPIED_FROM, COPIED_TO, barrier_of, left_in, ready_in,
};
use crate::intercept::vk::state::views::atlas_layout::AtlasRect;
use crate::intercept::vk::state::views::view_target::ViewTarget;
use ash::vk;

/// Records with `read` commands that copy from the view copies of a scene, in this layout.
///
/// # Safety
/// The command buffer is being recorded, outside of a pass.
pub unsafe fn read(
    device: &Device,
    buffer: vk::CommandBuffer,
    target: &ViewTarget,
    layout: vk::ImageLayout,
    read: impl FnOnce(),
) {
    let change = |from: vk::ImageLayout, to: vk::ImageLayout| {
        for view_copy in target.view_copies.iter().chain(&target.nothing) {
            // SAFETY: as promised.
            unsafe {
                barrier_of(&device.driver, buffer, (view_copy.image, target.aspects), left_in(from), ready_in(to))
            };
        }
    };
    change(target.kept, layout);
    read();
    change(layout, target.kept);
}

/// Records the copies from an atlas that has just been drawn and is in `layout` to its view copies;
/// does nothing for a window. The program's own image gets the program's own picture, if the atlas
/// has it. It gets the layout in any case: the passes that the program recorded for it, which would
/// change its layout, draw to the atlas.
///
/// # Safety
/// The command buffer is being recorded, outside of a pass.
pub unsafe fn make(device: &Device, buffer: vk::CommandBuffer, target: &ViewTarget, layout: vk::ImageLayout) {
    if target.window {
        return;
    }
    let own = target.layout.own().filter(|_| target.copied_to);
    let layer = vk::ImageSubresourceLayers { aspect_mask: target.aspects, ..COLOR_LAYER };
    // SAFETY: as promised below.
    let barrier = |image: vk::Image, from: Use, to: Use| unsafe {
        barrier_of(&device.driver, buffer, (image, target.aspects), from, to);
    };
    // SAFETY: as promised; tiles lie in the atlas, and view copies are as large as tiles.
    unsafe {
        if own.is_none() && target.view_copies.is_empty() {
            return barrier(target.given, ANYTHING, ready_in(layout));
        }
        barrier(target.atlas, left_in(layout), COPIED_FROM);
        let copy = |to: vk::Image, tile: AtlasRect| {
            let region = vk::ImageCopy::default()
                .src_subresource(layer)
                .src_offset(tile.offset())
                .dst_subresource(layer)
                .extent(tile.extent());
            device.driver.functions.cmd_copy_image(
                buffer,
                target.atlas,
                COPIED_FROM.layout,
                to,
                COPIED_TO.layout,
                &[region],
            );
        };
        for (view_copy, view) in target.view_copies.iter().zip(&target.layout.views) {
            barrier(view_copy.image, ANYTHING, COPIED_TO);
            copy(view_copy.image, view.rect);
            barrier(view_copy.image, COPIED_TO, ready_in(target.kept));
        }
        match own {
            Some(tile) => {
                barrier(target.given, ANYTHING, COPIED_TO);
                copy(target.given, tile);
                barrier(target.given, COPIED_TO, ready_in(layout));
            }
            None => barrier(target.given, ANYTHING, ready_in(layout)),
        }
        barrier(target.atlas, COPIED_FROM, ready_in(layout));
    }
}

/// Copies view copies back to their atlas, after compute shaders have written them. The atlas is in
/// the general layout.
///
/// # Safety
/// The command buffer is being recorded, outside of a pass; the writes to the view copies are
/// visible.
pub unsafe fn write_back(device: &Device, buffer: vk::CommandBuffer, target: &ViewTarget) {
    let layer = vk::ImageSubresourceLayers { aspect_mask: target.aspects, ..COLOR_LAYER };
    let general = vk::ImageLayout::GENERAL;
    // SAFETY: as promised; tiles lie in the atlas, and view copies are as large as tiles.
    unsafe {
        let atlas = (target.atlas, target.aspects);
        barrier_of(&device.driver, buffer, atlas, left_in(general), COPIED_TO);
        for (view_copy, view) in target.view_copies.iter().zip(&target.layout.views) {
            let region = vk::ImageCopy::default()
                .src_subresource(layer)
                .dst_subresource(layer)
                .dst_offset(view.rect.offset())
                .extent(view.rect.extent());
            let functions = &device.driver.functions;
            functions.cmd_copy_image(buffer, view_copy.image, target.kept, target.atlas, COPIED_TO.layout, &[region]);
        }
        barrier_of(&device.driver, buffer, atlas, COPIED_TO, ready_in(general));
    }
}

/// Blits view copies to a window, after compute shaders have written them. The shaders have also
/// written the window's own image, which is in the general layout.
///
/// # Safety
/// The command buffer is being recorded, outside of a pass.
pub unsafe fn show(device: &Device, buffer: vk::CommandBuffer, from: &ViewTarget, window: &ViewTarget) {
    let general = vk::ImageLayout::GENERAL;
    let whole = |AtlasRect { width, height, .. }| AtlasRect { x: 0, y: 0, width, height };
    let blit = |image: vk::Image, from: AtlasRect, to: AtlasRect| {
        let corners = |rect: AtlasRect| {
            let AtlasRect { x, y, width, height } = rect;
            [rect.offset(), vk::Offset3D { x: x + width, y: y + height, z: 1 }]
        };
        let region = vk::ImageBlit::default()
            .src_subresource(COLOR_LAYER)
            .dst_subresource(COLOR_LAYER)
            .src_offsets(corners(from))
            .dst_offsets(corners(to));
        let (functions, filter) = (&device.driver.functions, vk::Filter::LINEAR);
        // SAFETY: as promised; the rectangles lie in the images.
        unsafe {
            functions.cmd_blit_image(buffer, image, general, window.atlas, COPIED_TO.layout, &[region], filter);
        }
    };
    // SAFETY: as promised.
    unsafe {
        let (atlas, given) = ((window.atlas, window.aspects), (window.given, window.aspects));
        barrier_of(&device.driver, buffer, given, left_in(general), ready_in(general));
        barrier_of(&device.driver, buffer, atlas, left_in(general), COPIED_TO);
        for (view_copy, (of_copy, view)) in
            from.view_copies.iter().zip(from.layout.views.iter().zip(&window.layout.views))
        {
            blit(view_copy.image, whole(of_copy.rect), view.rect);
        }
        if let Some(primary) = window.layout.primary {
            blit(window.given, whole(primary), primary);
        }
        if let Some(nothing) = &from.nothing {
            blit(nothing.image, AtlasRect { x: 0, y: 0, width: 1, height: 1 }, window.layout.panel_with_border());
        }
        barrier_of(&device.driver, buffer, atlas, COPIED_TO, ready_in(general));
    }
}

/// Makes the results of the preceding commands visible to the following ones.
///
/// # Safety
/// The command buffer is being recorded, outside of a pass.
pub unsafe fn wait(device: &Device, buffer: vk::CommandBuffer) {
    let all = vk::PipelineStageFlags::ALL_COMMANDS;
    let memory = vk::MemoryBarrier::default()
        .src_access_mask(vk::AccessFlags::MEMORY_WRITE)
        .dst_access_mask(vk::AccessFlags::MEMORY_READ | vk::AccessFlags::MEMORY_WRITE);
    let flags = vk::DependencyFlags::empty();
    // SAFETY: as promised.
    unsafe { device.driver.functions.cmd_pipeline_barrier(buffer, all, all, flags, &[memory], &[], &[]) };
}

/// Records a change of each view copy of a scene. `change` gets the image and records the change.
///
/// # Safety
/// The command buffer is being recorded, outside of a pass.
pub unsafe fn change(device: &Device, buffer: vk::CommandBuffer, target: &ViewTarget, change: impl Fn(vk::Image)) {
    // SAFETY: as promised.
    unsafe {
        wait(device, buffer);
        target.view_copies.iter().for_each(|view_copy| change(view_copy.image));
        wait(device, buffer);
    }
}
