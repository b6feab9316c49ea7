//! Copies between images: from the window's image, to it, and between images of the scene.

use crate::backend::vk::Use;
use crate::intercept::vk::offscreen::view_copies;
use crate::intercept::vk::state::device::Device;
use crate::intercept::vk::state::driver::own_image::{COLOR_LAYER, COPIED_TO, barrier_of, left_in, ready_in};
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
    /// All views are copied from atlas to atlas, tile by tile, and their size changes.
    Scaled(Arc<ViewTarget>, Arc<ViewTarget>),
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

/// Plans a copy. If it cannot be followed, the program is shown flat.
pub(super) fn becomes(device: &Device, buffer: vk::CommandBuffer, (from, src): End, (to, dst): End) -> CopyPlan {
    let (read, written) = (device.images.target_of_image(from), device.images.target_of_image(to));
    device.images.overwritten(to);
    let everything = is_of_everything(device, (from, src), (to, dst), written.as_deref());
    if device.images.is_candidate(from) {
        note_made(device, from, if everything { end_of(device, to) } else { Made::Elsewhere }, written.is_some());
    }
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
        (Some(read), Some(target)) if everything && read.layout.has_views_of(&target.layout) => {
            drawn(&target, true);
            match Arc::ptr_eq(&read.layout, &target.layout) && !read.is_stored() {
                true => CopyPlan::Views(read.atlas, target),
                false => CopyPlan::Scaled(read, target),
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

pub(super) fn moved(offset: vk::Offset3D, AtlasRect { x, y, .. }: AtlasRect) -> vk::Offset3D {
    vk::Offset3D { x: offset.x + x, y: offset.y + y, z: offset.z }
}

fn extent(from: vk::Offset3D, size: vk::Extent3D) -> [vk::Offset3D; 2] {
    let last = vk::Offset3D { x: from.x + size.width as i32, y: from.y + size.height as i32, z: 1 };
    [from, last]
}

/// Corners of an empty copy.
pub(super) const NOTHING: [vk::Offset3D; 2] = [vk::Offset3D { x: 0, y: 0, z: 0 }; 2];

/// Returns the size of an atlas.
fn atlas(target: &ViewTarget) -> vk::Extent3D {
    let (width, height) = target.layout.atlas;
    vk::Extent3D { width, height, depth: 1 }
}

/// Region of a command that copies, blits or resolves from image to image.
trait Region: Clone {
    /// Whether the command can change the size.
    const SCALES: bool;
    /// Whether the command resolves samples.
    const RESOLVES: bool;
    /// Returns the corners of the region that is read.
    fn src(&self) -> [vk::Offset3D; 2];
    /// Returns the corners of the region that is written.
    fn dst(&self) -> [vk::Offset3D; 2];
    /// Moves the region that is read to a rectangle.
    fn read_at(&mut self, place: AtlasRect);
    /// Changes the region to all of an image of this size.
    fn take_all(&mut self, size: vk::Extent3D);
    /// Changes the region to a copy from one rectangle to another.
    fn take(&mut self, from: AtlasRect, to: AtlasRect);
}

/// Regions with one extent.
macro_rules! sized {
    ($($kind:ty, $resolves:literal);+) => { $( impl Region for $kind {
        const SCALES: bool = false;
        const RESOLVES: bool = $resolves;
        fn src(&self) -> [vk::Offset3D; 2] {
            extent(self.src_offset, self.extent)
        }
        fn dst(&self) -> [vk::Offset3D; 2] {
            extent(self.dst_offset, self.extent)
        }
        fn read_at(&mut self, place: AtlasRect) {
            self.src_offset = moved(self.src_offset, place);
        }
        fn take_all(&mut self, size: vk::Extent3D) {
            self.extent = size;
        }
        /// Only blits change the size.
        fn take(&mut self, from: AtlasRect, to: AtlasRect) {
            (self.src_offset, self.dst_offset, self.extent) = (from.offset(), to.offset(), to.extent());
        }
    } )+ };
}
sized!(vk::ImageCopy, false; vk::ImageResolve, true; vk::ImageCopy2<'_>, false; vk::ImageResolve2<'_>, true);

/// Regions with corners.
macro_rules! scaled {
    ($($kind:ty),+) => { $( impl Region for $kind {
        const SCALES: bool = true;
        const RESOLVES: bool = false;
        fn src(&self) -> [vk::Offset3D; 2] {
            self.src_offsets
        }
        fn dst(&self) -> [vk::Offset3D; 2] {
            self.dst_offsets
        }
        fn read_at(&mut self, place: AtlasRect) {
            self.src_offsets = self.src_offsets.map(|offset| moved(offset, place));
        }
        fn take_all(&mut self, size: vk::Extent3D) {
            self.src_offsets = extent(vk::Offset3D::default(), size);
            self.dst_offsets = self.src_offsets;
        }
        fn take(&mut self, from: AtlasRect, to: AtlasRect) {
            self.src_offsets = extent(from.offset(), from.extent());
            self.dst_offsets = extent(to.offset(), to.extent());
        }
    } )+ };
}
scaled!(vk::ImageBlit, vk::ImageBlit2<'_>);

/// Blits a rectangle of an image in a layout to a rectangle of another image.
///
/// # Safety
/// The command buffer is being recorded, outside of a pass.
unsafe fn scale(
    device: &Device,
    buffer: vk::CommandBuffer,
    (from, read, read_layout): (vk::Image, AtlasRect, vk::ImageLayout),
    (to, written, layout): (vk::Image, AtlasRect, vk::ImageLayout),
) {
    let mut region = vk::ImageBlit::default().src_subresource(COLOR_LAYER).dst_subresource(COLOR_LAYER);
    region.take(read, written);
    // SAFETY: as promised; the rectangles lie in the images.
    unsafe {
        let filter = vk::Filter::LINEAR;
        device.driver.functions.cmd_blit_image(buffer, from, read_layout, to, layout, &[region], filter);
    }
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
        CopyPlan::Scaled(read, target) => {
            device.recordings.with(buffer, |recording| recording.samples(Arc::clone(&read)));
            let same_size = read.layout.atlas == target.layout.atlas;
            let same_format = device.images.format(from) == device.images.format(to);
            if R::RESOLVES && !same_size {
                device.show_flat("it resolves its picture into an image with other views");
                return next(from, to, regions);
            }
            // A copy keeps bits, and a blit keeps values. If the formats differ, the views are
            // scaled in the format of the first image.
            let scaled = match !R::SCALES && !same_format && !same_size {
                true => match device.images.scaled_atlas(device, from, &target.layout) {
                    Ok(image) => Some(image),
                    Err(why) => {
                        device.show_flat(why);
                        return next(from, to, regions);
                    }
                },
                false => None,
            };
            // SAFETY: as promised.
            let bring = |from: Use, to: Use| {
                scaled.iter().for_each(|image| unsafe {
                    barrier_of(&device.driver, buffer, (*image, read.aspects), from, to);
                })
            };
            let of_view = |image: vk::Image, from: AtlasRect, to: AtlasRect| {
                let (end, end_layout) = scaled.map_or((target.atlas, layout), |scaled| (scaled, COPIED_TO.layout));
                let is_same = scaled.is_none() && (from.width, from.height) == (to.width, to.height);
                match R::SCALES || is_same {
                    true => next(image, target.atlas, &changed(&|region| region.take(from, to))),
                    // SAFETY: as promised.
                    false => unsafe { scale(device, buffer, (image, from, from_layout), (end, to, end_layout)) },
                }
            };
            bring(left_in(from_layout), COPIED_TO);
            let whole = |AtlasRect { width, height, .. }| AtlasRect { x: 0, y: 0, width, height };
            // SAFETY: as promised; the atlas has just been written in this layout.
            unsafe {
                view_copies::read(device, buffer, &read, from_layout, || {
                    // A filter would read texels beside a tile, but reads none beside an image.
                    let mut view_copies = read.view_copies.iter();
                    for (from, to) in read.layout.views.iter().zip(&target.layout.views) {
                        match view_copies.next() {
                            Some(view_copy) => of_view(view_copy.image, whole(from.rect), to.rect),
                            None => of_view(read.atlas, from.rect, to.rect),
                        }
                    }
                    if let Some(nothing) = &read.nothing {
                        // In the window's atlas tiles have gaps between them, and a filter reads
                        // texels beside the panel.
                        let layout = &target.layout;
                        let panel = if target.window { layout.panel_with_border() } else { layout.panel };
                        of_view(nothing.image, AtlasRect { x: 0, y: 0, width: 1, height: 1 }, panel);
                    }
                });
                // The program's image holds what compute shaders wrote, and also what was drawn, if
                // that can be copied there.
                let in_image = read.is_stored() && !device.images.lacks_own_picture(read.given);
                match (in_image, target.layout.primary, read.layout.primary) {
                    (true, Some(to), _) => of_view(read.given, whole(read.layout.panel), to),
                    (false, Some(to), Some(from)) => of_view(read.atlas, from, to),
                    _ => {}
                }
                if !read.is_stored() {
                    // The panel of an off-screen scene is empty. Only its middle is read, so that a
                    // filter reads no texels beside the panel.
                    of_view(read.atlas, read.layout.panel.middle(), target.layout.panel);
                }
                bring(COPIED_TO, ready_in(from_layout));
                if let Some(scaled) = scaled {
                    next(scaled, target.atlas, &changed(&|region| region.take_all(atlas(&target))));
                }
                view_copies::make(device, buffer, &target, layout);
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
