//! Copies between images and buffers. A program that reads its own picture gets it from the tile
//! where it is drawn.
//!
//! A program may read its scene, for example to find the object under the mouse. Such a read is
//! answered from the primary view. There is no primary view until such a copy was seen. From the
//! next frame on, layouts with even tiles are used, which have one.

use crate::intercept::vk::commands::copies::{NOTHING, becomes, has_own_picture, moved};
use crate::intercept::vk::state::device::Device;
use crate::intercept::vk::state::driver::structures::slice;
use crate::intercept::vk::state::hooks::hooks;
use crate::intercept::vk::state::images::scene_graph::Made;
use crate::intercept::vk::state::views::atlas_layout::AtlasRect;
use ash::vk;

/// Finds the program's own picture of `image`, if it is not in the image itself: an internal image,
/// and a rectangle there.
fn own_picture(device: &Device, image: vk::Image) -> Option<(vk::Image, AtlasRect)> {
    let note = || {
        if device.images.is_candidate(image) {
            device.scene_graph.note_copied(image);
        }
        None
    };
    match device.images.target_of_image(image).filter(|_| device.draws_views()) {
        Some(target) if has_own_picture(device, &target) => None,
        // The image has several levels.
        Some(target) if target.atlas == vk::Image::null() => {
            device.scene_graph.note_made(image, Made::Elsewhere);
            None
        }
        Some(target) => match target.layout.own() {
            Some(own) => Some((target.atlas, own)),
            None if target.window => {
                device.show_flat("it copies its picture from the window");
                None
            }
            None => note(),
        },
        None => match device.images.drawn_in(image).filter(|_| device.draws_views()) {
            Some((layout, atlas_copy)) => layout.own().map(|own| (atlas_copy, own)).or_else(note),
            None => note(),
        },
    }
}

hooks! {
    cmd_copy_buffer_to_image = (
        buffer: vk::CommandBuffer, from: vk::Buffer, to: vk::Image, to_layout: vk::ImageLayout, count: u32, regions: *const vk::BufferImageCopy
    ) { |state, next| {
        becomes(&state, buffer, (vk::Image::null(), NOTHING), (to, NOTHING));
        next(buffer, from, to, to_layout, count, regions)
    } }
    cmd_copy_buffer_to_image2 = (
        buffer: vk::CommandBuffer, info: *const vk::CopyBufferToImageInfo2<'_>
    ) { |state, next| {
        becomes(&state, buffer, (vk::Image::null(), NOTHING), ((*info).dst_image, NOTHING));
        next(buffer, info)
    } }
    cmd_copy_image_to_buffer = (
        buffer: vk::CommandBuffer, from: vk::Image, from_layout: vk::ImageLayout, to: vk::Buffer, count: u32, regions: *const vk::BufferImageCopy
    ) { |state, next| match own_picture(&state, from) {
        None => next(buffer, from, from_layout, to, count, regions),
        Some((image, at)) => {
            let mut regions = slice(regions, count).to_vec();
            regions.iter_mut().for_each(|region| region.image_offset = moved(region.image_offset, at));
            next(buffer, image, from_layout, to, count, regions.as_ptr())
        }
    } }
    cmd_copy_image_to_buffer2 = (
        buffer: vk::CommandBuffer, info: *const vk::CopyImageToBufferInfo2<'_>
    ) { |state, next| match own_picture(&state, (*info).src_image) {
        None => next(buffer, info),
        Some((image, at)) => {
            let mut regions = slice((*info).p_regions, (*info).region_count).to_vec();
            regions.iter_mut().for_each(|region| region.image_offset = moved(region.image_offset, at));
            next(buffer, &(*info).src_image(image).regions(&regions))
        }
    } }
}
