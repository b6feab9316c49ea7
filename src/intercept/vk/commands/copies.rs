//! Copies between images: from the window's image, to it, and between images of the scene. A copy to
//! a large part of the window, between the widgets of a toolkit, fills all of each view.

mod regions;
mod scaled;

pub(super) use regions::moved;

use crate::intercept::vk::commands::copies::regions::Region;
use crate::intercept::vk::commands::copies::scaled::ScaledCopy;
use crate::intercept::vk::offscreen::view_copies;
use crate::intercept::vk::state::device::Device;
use crate::intercept::vk::state::driver::structures::slice;
use crate::intercept::vk::state::hooks::hooks;
use crate::intercept::vk::state::images::scene_graph::Made;
use crate::intercept::vk::state::recording::Event;
use crate::intercept::vk::state::views::atlas_layout::AtlasRect;
use crate::intercept::vk::state::views::view_target::ViewTarget;
use ash::vk;
use std::sync::Arc;

/// How a copy of the program is done.
pub(super) enum CopyPlan {
    /// Unchanged.
    Same,
    /// It reads the program's own picture from this rectangle of an atlas.
    Read(vk::Image, AtlasRect),
    /// All views are copied from atlas to atlas; the second is the view target that is written.
    Views(vk::Image, Arc<ViewTarget>),
    /// All views are copied from atlas to atlas, tile by tile, and their size changes. The rectangle
    /// is the part of the window that they fill; `None`: all of the picture.
    Scaled(Arc<ViewTarget>, Arc<ViewTarget>, Option<AtlasRect>),
    /// It goes to the panel of an atlas, and to the primary view.
    Panel(Arc<ViewTarget>),
}

/// One end of a copy: its image, and the corners of the copied region.
pub(super) type End = (vk::Image, [vk::Offset3D; 2]);

/// Returns the result that a copy of everything to an image makes.
fn end_of(device: &Device, image: vk::Image) -> Made {
    match device.images.target_of_image(image) {
        Some(target) if target.window => Made::Window,
        _ if device.images.is_candidate(image) => Made::Image(image),
        _ => Made::Elsewhere,
    }
}

/// True if all of an image is copied to all of another one. If that one is a `target`, it must have
/// an atlas.
fn is_of_everything(device: &Device, (from, src): End, (to, dst): End, target: Option<&ViewTarget>) -> bool {
    let whole = |image: vk::Image, corners: [vk::Offset3D; 2]| {
        let (width, height) = device.images.size(image).unwrap_or_default();
        let [first, last] = corners;
        (first.x, first.y, last.x, last.y) == (0, 0, width as i32, height as i32)
    };
    // Images of several levels that only compute shaders write are no target of a copy.
    let has_atlas = target.is_none_or(|target| target.atlas != vk::Image::null());
    whole(from, src) && whole(to, dst) && has_atlas
}

/// Returns the part of the window that a copy of a whole image fills, if it is a large one that has
/// the image's shape.
fn shown_part(
    device: &Device,
    (from, [src, end]): End,
    dst: [vk::Offset3D; 2],
    window: &ViewTarget,
) -> Option<AtlasRect> {
    let (width, height) = device.images.size(from)?;
    let part = AtlasRect { x: dst[0].x, y: dst[0].y, width: dst[1].x - dst[0].x, height: dst[1].y - dst[0].y };
    let is_whole = (src.x, src.y, end.x, end.y) == (0, 0, width as i32, height as i32);
    let fills = is_whole && device.images.may_fill_part((width, height), part, &window.layout);
    if fills && device.images.note_part(part.into()) {
        device.scene_graph.look_again();
    }
    fills.then_some(part)
}

/// Determines whether a copy is of everything, and the part of the window that it fills otherwise.
/// Notes the result that it makes. `written`: the target.
fn look(device: &Device, (from, src): End, (to, dst): End, written: Option<&ViewTarget>) -> (bool, Option<AtlasRect>) {
    let everything = is_of_everything(device, (from, src), (to, dst), written);
    let window = written.filter(|target| target.window && !everything);
    let part = window.and_then(|window| shown_part(device, (from, src), dst, window));
    if device.images.is_candidate(from) {
        let follows = everything || part.is_some();
        note_made(device, from, if follows { end_of(device, to) } else { Made::Elsewhere }, written.is_some());
    }
    (everything, part)
}

/// Plans a copy. If it cannot be followed, the program is shown flat.
pub(super) fn becomes(device: &Device, buffer: vk::CommandBuffer, (from, src): End, (to, dst): End) -> CopyPlan {
    let (read, written) = (device.images.target_of_image(from), device.images.target_of_image(to));
    device.images.overwritten(to);
    let (everything, part) = look(device, (from, src), (to, dst), written.as_deref());
    let drawn = |target: &Arc<ViewTarget>, in_views| {
        let event = Event::Drawn(Arc::clone(target), in_views);
        device.recordings.with(buffer, |recording| recording.events.push(event));
    };
    if !device.draws_views() {
        written.iter().for_each(|target| drawn(target, false));
        return CopyPlan::Same;
    }
    match (read, written) {
        (Some(read), None) if has_own_picture(device, &read) => CopyPlan::Same,
        (None, Some(target)) if everything => match device.images.atlas_copy_of_size(from, target.layout.atlas) {
            Some(atlas_copy) => {
                drawn(&target, true);
                CopyPlan::Views(atlas_copy, target)
            }
            None => {
                // An image that only compute shaders draw may never become a scene.
                let waits = device.images.is_attached(from) || device.scene_graph.may_be_followed();
                if !device.images.is_candidate(from) || !waits {
                    device.show_flat("it copies its picture to the window");
                }
                drawn(&target, false);
                CopyPlan::Same
            }
        },
        (None, Some(target)) if part.is_some() && device.scene_graph.may_be_followed() => {
            drawn(&target, true);
            CopyPlan::Panel(target)
        }
        (Some(read), Some(target)) if (everything || part.is_some()) && read.layout.has_views_of(&target.layout) => {
            drawn(&target, true);
            part.iter().for_each(|_| device.scene_graph.begin_waiting());
            match Arc::ptr_eq(&read.layout, &target.layout) && !read.is_stored() && everything {
                true => CopyPlan::Views(read.atlas, target),
                false => CopyPlan::Scaled(read, target, part),
            }
        }
        (_, Some(target)) => {
            device.show_flat("it copies its picture to the window");
            drawn(&target, false);
            CopyPlan::Same
        }
        (Some(read), None) => match read.layout.own() {
            Some(own) => CopyPlan::Read(read.atlas, own),
            None => {
                // An image made from a complete scene may be followed from the next frame on.
                if read.window || !everything || !device.images.is_candidate(to) {
                    device.show_flat("it copies its picture from the window");
                }
                CopyPlan::Same
            }
        },
        (None, None) => CopyPlan::Same,
    }
}

/// Notes the result that a copy makes from the image `from`. `written`: the target has a copy per
/// view.
fn note_made(device: &Device, from: vk::Image, made: Made, written: bool) {
    // If there is a primary view, copies that do not lead to the window read the program's own
    // picture.
    let served = !written && device.swapchains.latest_layout().is_some_and(|layout| layout.own().is_some());
    if made != Made::Elsewhere || !served {
        device.scene_graph.note_made(from, made);
    }
}

/// True if the program's image holds the program's own picture, because compute shaders may write
/// it.
pub(super) fn has_own_picture(device: &Device, target: &ViewTarget) -> bool {
    let drawn = device.images.is_attached(target.given);
    target.is_stored() && !device.images.lacks_own_picture(target.given) && (!drawn || target.layout.own().is_some())
}

/// Corners of an empty copy.
pub(super) const NOTHING: [vk::Offset3D; 2] = [vk::Offset3D { x: 0, y: 0, z: 0 }; 2];

/// Returns the size of an atlas.
fn atlas(target: &ViewTarget) -> vk::Extent3D {
    let (width, height) = target.layout.atlas;
    vk::Extent3D { width, height, depth: 1 }
}

/// Copies, blits or resolves with `next` (from, to, regions): as the program says, or according to
/// the plan for the copy. The layouts are those of both images.
///
/// # Safety
/// The command buffer is being recorded, outside of a pass; `next` records the program's command
/// with other images.
unsafe fn between<R: Region>(
    device: &Device,
    buffer: vk::CommandBuffer,
    from: vk::Image,
    to: vk::Image,
    [from_layout, layout]: [vk::ImageLayout; 2],
    regions: &[R],
    next: impl Fn(vk::Image, vk::Image, &[R]),
) {
    let only = regions.first().filter(|_| regions.len() == 1);
    let (src, dst) = (only.map_or(NOTHING, R::src), only.map_or(NOTHING, R::dst));
    let changed = |change: &dyn Fn(&mut R)| {
        let mut changed = regions.to_vec();
        changed.iter_mut().for_each(change);
        changed
    };
    match becomes(device, buffer, (from, src), (to, dst)) {
        CopyPlan::Same => next(from, to, regions),
        CopyPlan::Read(image, place) => next(image, to, &changed(&|region| region.read_at(place))),
        CopyPlan::Views(image, target) => {
            next(image, target.atlas, &changed(&|region| region.take_all(atlas(&target))));
            // SAFETY: as promised; the atlas has just been written in this layout.
            unsafe { view_copies::make(device, buffer, &target, layout) };
        }
        CopyPlan::Panel(target) => {
            for tile in [Some(target.layout.panel), target.layout.primary].into_iter().flatten() {
                next(from, target.atlas, &changed(&|region| region.write_at(tile)));
            }
        }
        CopyPlan::Scaled(read, target, part) => {
            let copy = ScaledCopy { device, buffer, given: from, read, target, part, layouts: [from_layout, layout] };
            // SAFETY: as promised.
            if let Err(why) = unsafe { copy.record(regions, &next) } {
                device.show_flat(why);
                next(from, to, regions);
            }
        }
    }
}

hooks! {
    cmd_copy_image = (
        buffer: vk::CommandBuffer, from: vk::Image, from_layout: vk::ImageLayout, to: vk::Image, to_layout: vk::ImageLayout, count: u32, regions: *const vk::ImageCopy
    ) { |state, next| between(&state, buffer, from, to, [from_layout, to_layout], slice(regions, count),
        |f, t, r| next(buffer, f, from_layout, t, to_layout, r.len() as u32, r.as_ptr())) }
    cmd_blit_image = (
        buffer: vk::CommandBuffer, from: vk::Image, from_layout: vk::ImageLayout, to: vk::Image, to_layout: vk::ImageLayout, count: u32, regions: *const vk::ImageBlit, filter: vk::Filter
    ) { |state, next| between(&state, buffer, from, to, [from_layout, to_layout], slice(regions, count),
        |f, t, r| next(buffer, f, from_layout, t, to_layout, r.len() as u32, r.as_ptr(), filter)) }
    cmd_resolve_image = (
        buffer: vk::CommandBuffer, from: vk::Image, from_layout: vk::ImageLayout, to: vk::Image, to_layout: vk::ImageLayout, count: u32, regions: *const vk::ImageResolve
    ) { |state, next| between(&state, buffer, from, to, [from_layout, to_layout], slice(regions, count),
        |f, t, r| next(buffer, f, from_layout, t, to_layout, r.len() as u32, r.as_ptr())) }
    cmd_copy_image2 = (
        buffer: vk::CommandBuffer, info: *const vk::CopyImageInfo2<'_>
    ) { |state, next| { let given = &*info; between(&state, buffer, given.src_image, given.dst_image, [given.src_image_layout, given.dst_image_layout],
        slice(given.p_regions, given.region_count), |f, t, r| next(buffer, &(*given).src_image(f).dst_image(t).regions(r))) } }
    cmd_blit_image2 = (
        buffer: vk::CommandBuffer, info: *const vk::BlitImageInfo2<'_>
    ) { |state, next| { let given = &*info; between(&state, buffer, given.src_image, given.dst_image, [given.src_image_layout, given.dst_image_layout],
        slice(given.p_regions, given.region_count), |f, t, r| next(buffer, &(*given).src_image(f).dst_image(t).regions(r))) } }
    cmd_resolve_image2 = (
        buffer: vk::CommandBuffer, info: *const vk::ResolveImageInfo2<'_>
    ) { |state, next| { let given = &*info; between(&state, buffer, given.src_image, given.dst_image, [given.src_image_layout, given.dst_image_layout],
        slice(given.p_regions, given.region_count), |f, t, r| next(buffer, &(*given).src_image(f).dst_image(t).regions(r))) } }
}
