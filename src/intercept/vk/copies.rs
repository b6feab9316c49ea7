//! Copies between images: from the program's picture of its window, and between pictures of its scene.

use super::device::Device;
use super::hook::hooks;
use super::images::Shown;
use super::layout::Rect;
use super::offscreen::Made;
use super::prints;
use super::recording::Event;
use ash::vk;
use std::sync::Arc;

/// What becomes of a copy.
enum Becomes {
    /// It stays the program's.
    Same,
    /// It reads the program's own picture at this place of an atlas.
    Read(vk::Image, Rect),
    /// All views go from atlas to atlas; the second is what is drawn then.
    Views(vk::Image, Arc<Shown>),
}

/// One end of a copy: its image, and the corners of what is copied there.
type End = (vk::Image, [vk::Offset3D; 2]);

/// Where an image that is copied to goes, for a copy of everything.
fn end_of(device: &Device, image: vk::Image) -> Made {
    match device.images.shown_image(image) {
        Some(shown) if shown.window => Made::Window,
        _ if device.images.is_candidate(image) => Made::Image(image),
        _ => Made::Elsewhere,
    }
}

/// What a copy becomes. Where that cannot be, the program is shown flat.
fn becomes(device: &Device, buffer: vk::CommandBuffer, (from, source): End, (to, target): End) -> Becomes {
    let (read, written) = (device.images.shown_image(from), device.images.shown_image(to));
    let whole = |image: vk::Image, corners: [vk::Offset3D; 2]| {
        let (width, height) = device.images.size(image).unwrap_or_default();
        let [first, last] = corners;
        (first.x, first.y, last.x, last.y) == (0, 0, width as i32, height as i32)
    };
    let everything = whole(from, source) && whole(to, target);
    if device.images.is_candidate(from) {
        device.paths.leads(from, if everything { end_of(device, to) } else { Made::Elsewhere });
    }
    let drawn = |shown: &Arc<Shown>, in_views| {
        let event = Event::Drawn(Arc::clone(shown), in_views);
        device.recordings.with(buffer, |recording| recording.events.push(event));
    };
    if !device.draws_views() {
        written.iter().for_each(|shown| drawn(shown, false));
        return Becomes::Same;
    }
    match (read, written) {
        (None, Some(shown)) if everything => match device.images.twin_of_size(from, shown.layout.atlas) {
            Some(twin) => {
                drawn(&shown, true);
                Becomes::Views(twin, shown)
            }
            None => {
                if !device.images.is_candidate(from) {
                    device.give_up("it copies its picture to the window");
                }
                drawn(&shown, false);
                Becomes::Same
            }
        },
        (Some(read), Some(shown)) if everything && Arc::ptr_eq(&read.layout, &shown.layout) => {
            drawn(&shown, true);
            Becomes::Views(read.atlas, shown)
        }
        (_, Some(shown)) => {
            device.give_up("it copies its picture to the window");
            drawn(&shown, false);
            Becomes::Same
        }
        (Some(read), None) => match read.layout.own() {
            Some(own) => Becomes::Read(read.atlas, own),
            None => {
                device.give_up("it copies its picture from the window");
                Becomes::Same
            }
        },
        (None, None) => Becomes::Same,
    }
}

fn moved(offset: vk::Offset3D, [x, y, ..]: Rect) -> vk::Offset3D {
    vk::Offset3D { x: offset.x + x, y: offset.y + y, z: offset.z }
}

fn extent(from: vk::Offset3D, size: vk::Extent3D) -> [vk::Offset3D; 2] {
    let last = vk::Offset3D { x: from.x + size.width as i32, y: from.y + size.height as i32, z: 1 };
    [from, last]
}

/// What a copy of nothing copies.
const NOTHING: [vk::Offset3D; 2] = [vk::Offset3D { x: 0, y: 0, z: 0 }; 2];

/// The whole of an atlas.
fn atlas(shown: &Shown) -> vk::Extent3D {
    let (width, height) = shown.layout.atlas;
    vk::Extent3D { width, height, depth: 1 }
}

/// After all views were copied into an atlas that is in `layout`.
///
/// # Safety
/// The command buffer is being recorded, outside of a pass.
unsafe fn copied(device: &Device, buffer: vk::CommandBuffer, shown: &Shown, layout: vk::ImageLayout) {
    // SAFETY: as promised.
    unsafe { prints::make(device, buffer, shown, layout) };
}

/// A command that copies, blits or resolves from image to image: `$regions` of it have `$source` and `$target` as
/// functions that give their corners, `$read` moves where a region reads, `$whole` makes it one of the whole atlas.
macro_rules! between {
    ($state:ident, $buffer:ident, $from:expr, $to:expr, $to_layout:expr, $regions:expr, $kind:ty,
     $source:expr, $target:expr, $read:expr, $whole:expr, |$f:ident, $t:ident, $r:ident| $next:expr) => {{
        let regions: &[$kind] = $regions;
        let corners = regions.first().filter(|_| regions.len() == 1);
        let (source, target): (fn(&$kind) -> [vk::Offset3D; 2], fn(&$kind) -> [vk::Offset3D; 2]) = ($source, $target);
        let ends = (corners.map_or(NOTHING, source), corners.map_or(NOTHING, target));
        match becomes(&$state, $buffer, ($from, ends.0), ($to, ends.1)) {
            Becomes::Same => {
                let ($f, $t, $r) = ($from, $to, regions);
                $next
            }
            Becomes::Read(image, at) => {
                let read: fn(&mut $kind, Rect) = $read;
                let mut changed = regions.to_vec();
                changed.iter_mut().for_each(|region| read(region, at));
                let ($f, $t, $r) = (image, $to, &changed[..]);
                $next
            }
            Becomes::Views(image, shown) => {
                let whole: fn(&mut $kind, vk::Extent3D) = $whole;
                let mut changed = regions.to_vec();
                changed.iter_mut().for_each(|region| whole(region, atlas(&shown)));
                {
                    let ($f, $t, $r) = (image, shown.atlas, &changed[..]);
                    $next
                }
                copied(&$state, $buffer, &shown, $to_layout);
            }
        }
    }};
}

/// The same for regions with an extent.
macro_rules! sized {
    ($state:ident, $buffer:ident, $from:expr, $to:expr, $to_layout:expr, $regions:expr, $kind:ty, $next:expr) => {
        between!(
            $state,
            $buffer,
            $from,
            $to,
            $to_layout,
            $regions,
            $kind,
            |r| extent(r.src_offset, r.extent),
            |r| extent(r.dst_offset, r.extent),
            |r, at| r.src_offset = moved(r.src_offset, at),
            |r, size| r.extent = size,
            |f, t, r| $next(f, t, r)
        )
    };
}

/// The same for blits.
macro_rules! scaled {
    ($state:ident, $buffer:ident, $from:expr, $to:expr, $to_layout:expr, $regions:expr, $kind:ty, $next:expr) => {
        between!(
            $state,
            $buffer,
            $from,
            $to,
            $to_layout,
            $regions,
            $kind,
            |r| r.src_offsets,
            |r| r.dst_offsets,
            |r, at| r.src_offsets = r.src_offsets.map(|offset| moved(offset, at)),
            |r, size| {
                r.src_offsets = extent(vk::Offset3D::default(), size);
                r.dst_offsets = r.src_offsets;
            },
            |f, t, r| $next(f, t, r)
        )
    };
}

/// A copy between an image and a buffer: where an image is read, and whether it was one of the window's.
fn with_buffer(
    device: &Device,
    buffer: vk::CommandBuffer,
    from: vk::Image,
    to: vk::Image,
) -> Option<(vk::Image, Rect)> {
    match becomes(device, buffer, (from, NOTHING), (to, NOTHING)) {
        Becomes::Read(image, at) => Some((image, at)),
        Becomes::Same | Becomes::Views(..) => None,
    }
}

hooks! { copies;
    [c"vkCmdCopyImage"] cmd_copy_image: vk::PFN_vkCmdCopyImage = (
        buffer: vk::CommandBuffer, from: vk::Image, from_layout: vk::ImageLayout, to: vk::Image, to_layout: vk::ImageLayout, count: u32, regions: *const vk::ImageCopy
    ) { |state, next| sized!(state, buffer, from, to, to_layout, super::slice(regions, count), vk::ImageCopy,
        |f, t, r: &[vk::ImageCopy]| next(buffer, f, from_layout, t, to_layout, r.len() as u32, r.as_ptr())) }
    [c"vkCmdBlitImage"] cmd_blit_image: vk::PFN_vkCmdBlitImage = (
        buffer: vk::CommandBuffer, from: vk::Image, from_layout: vk::ImageLayout, to: vk::Image, to_layout: vk::ImageLayout, count: u32, regions: *const vk::ImageBlit, filter: vk::Filter
    ) { |state, next| scaled!(state, buffer, from, to, to_layout, super::slice(regions, count), vk::ImageBlit,
        |f, t, r: &[vk::ImageBlit]| next(buffer, f, from_layout, t, to_layout, r.len() as u32, r.as_ptr(), filter)) }
    [c"vkCmdResolveImage"] cmd_resolve_image: vk::PFN_vkCmdResolveImage = (
        buffer: vk::CommandBuffer, from: vk::Image, from_layout: vk::ImageLayout, to: vk::Image, to_layout: vk::ImageLayout, count: u32, regions: *const vk::ImageResolve
    ) { |state, next| sized!(state, buffer, from, to, to_layout, super::slice(regions, count), vk::ImageResolve,
        |f, t, r: &[vk::ImageResolve]| next(buffer, f, from_layout, t, to_layout, r.len() as u32, r.as_ptr())) }
    [c"vkCmdCopyImage2", c"vkCmdCopyImage2KHR"] cmd_copy_image2: vk::PFN_vkCmdCopyImage2 = (
        buffer: vk::CommandBuffer, info: *const vk::CopyImageInfo2<'_>
    ) { |state, next| { let given = &*info; sized!(state, buffer, given.src_image, given.dst_image, given.dst_image_layout,
        super::slice(given.p_regions, given.region_count), vk::ImageCopy2<'_>,
        |f, t, r: &[vk::ImageCopy2<'_>]| next(buffer, &(*given).src_image(f).dst_image(t).regions(r))) } }
    [c"vkCmdBlitImage2", c"vkCmdBlitImage2KHR"] cmd_blit_image2: vk::PFN_vkCmdBlitImage2 = (
        buffer: vk::CommandBuffer, info: *const vk::BlitImageInfo2<'_>
    ) { |state, next| { let given = &*info; scaled!(state, buffer, given.src_image, given.dst_image, given.dst_image_layout,
        super::slice(given.p_regions, given.region_count), vk::ImageBlit2<'_>,
        |f, t, r: &[vk::ImageBlit2<'_>]| next(buffer, &(*given).src_image(f).dst_image(t).regions(r))) } }
    [c"vkCmdResolveImage2", c"vkCmdResolveImage2KHR"] cmd_resolve_image2: vk::PFN_vkCmdResolveImage2 = (
        buffer: vk::CommandBuffer, info: *const vk::ResolveImageInfo2<'_>
    ) { |state, next| { let given = &*info; sized!(state, buffer, given.src_image, given.dst_image, given.dst_image_layout,
        super::slice(given.p_regions, given.region_count), vk::ImageResolve2<'_>,
        |f, t, r: &[vk::ImageResolve2<'_>]| next(buffer, &(*given).src_image(f).dst_image(t).regions(r))) } }
    [c"vkCmdCopyBufferToImage"] cmd_copy_buffer_to_image: vk::PFN_vkCmdCopyBufferToImage = (
        buffer: vk::CommandBuffer, from: vk::Buffer, to: vk::Image, to_layout: vk::ImageLayout, count: u32, regions: *const vk::BufferImageCopy
    ) { |state, next| {
        with_buffer(&state, buffer, vk::Image::null(), to);
        next(buffer, from, to, to_layout, count, regions)
    } }
    [c"vkCmdCopyBufferToImage2", c"vkCmdCopyBufferToImage2KHR"] cmd_copy_buffer_to_image2: vk::PFN_vkCmdCopyBufferToImage2 = (
        buffer: vk::CommandBuffer, info: *const vk::CopyBufferToImageInfo2<'_>
    ) { |state, next| {
        with_buffer(&state, buffer, vk::Image::null(), (*info).dst_image);
        next(buffer, info)
    } }
    [c"vkCmdCopyImageToBuffer"] cmd_copy_image_to_buffer: vk::PFN_vkCmdCopyImageToBuffer = (
        buffer: vk::CommandBuffer, from: vk::Image, from_layout: vk::ImageLayout, to: vk::Buffer, count: u32, regions: *const vk::BufferImageCopy
    ) { |state, next| match with_buffer(&state, buffer, from, vk::Image::null()) {
        None => next(buffer, from, from_layout, to, count, regions),
        Some((image, at)) => {
            let mut regions = super::slice(regions, count).to_vec();
            regions.iter_mut().for_each(|region| region.image_offset = moved(region.image_offset, at));
            next(buffer, image, from_layout, to, count, regions.as_ptr())
        }
    } }
    [c"vkCmdCopyImageToBuffer2", c"vkCmdCopyImageToBuffer2KHR"] cmd_copy_image_to_buffer2: vk::PFN_vkCmdCopyImageToBuffer2 = (
        buffer: vk::CommandBuffer, info: *const vk::CopyImageToBufferInfo2<'_>
    ) { |state, next| match with_buffer(&state, buffer, (*info).src_image, vk::Image::null()) {
        None => next(buffer, info),
        Some((image, at)) => {
            let mut regions = super::slice((*info).p_regions, (*info).region_count).to_vec();
            regions.iter_mut().for_each(|region| region.image_offset = moved(region.image_offset, at));
            next(buffer, &(*info).src_image(image).regions(&regions))
        }
    } }
}
