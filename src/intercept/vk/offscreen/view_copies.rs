//! View copies: one image per view of a scene that is drawn off screen, for the program's shaders.
//!
//! A pass draws all views into one atlas, so that no draw changes its framebuffer. Shaders that
//! sample the image get the view's copy: coordinates, filter and wrapping are as the program has
//! them.

use crate::backend::vk::Use;
use crate::intercept::vk::state::device::Device;
use crate::intercept::vk::state::driver::own_image::{
    ANYTHING, COLOR_LAYER, COPIED_FROM, COPIED_TO, barrier_of, left_in, ready_in,
};
use crate::intercept::vk::state::views::atlas_layout::AtlasRect;
use crate::intercept::vk::state::views::view_target::ViewTarget;
use ash::vk;

/// As a shader finds a view copy.
pub const SAMPLED: vk::ImageLayout = vk::ImageLayout::SHADER_READ_ONLY_OPTIMAL;

/// Records by `read` commands that copy from the view copies of a scene, in this layout.
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
        for view_copy in &target.view_copies {
            // SAFETY: as promised.
            unsafe {
                barrier_of(&device.driver, buffer, (view_copy.image, target.aspects), left_in(from), ready_in(to))
            };
        }
    };
    change(SAMPLED, layout);
    read();
    change(layout, SAMPLED);
}

/// Records the copies of an atlas that has just been drawn and is in `layout`; nothing for a
/// window's. The program's own image gets the program's own picture, if the atlas has it, and the
/// layout in any case: the passes that the program recorded for it, which would bring it there,
/// draw to the atlas.
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
            barrier(view_copy.image, COPIED_TO, ready_in(SAMPLED));
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
