//! Barriers and clears. Atlas copies follow the layouts of their images, and clears are done in
//! each tile. Writes to buffers are recorded as events, for `submit`.

use crate::intercept::vk::offscreen::view_copies;
use crate::intercept::vk::state::device::Device;
use crate::intercept::vk::state::driver::own_image::{barrier_of, left_in, ready_in};
use crate::intercept::vk::state::driver::structures::slice;
use crate::intercept::vk::state::hooks::hooks;
use crate::intercept::vk::state::recording::Event;
use crate::intercept::vk::state::views::atlas_layout::{AtlasLayout, AtlasRect, ViewTile};
use ash::vk;
use std::collections::HashSet;
use std::sync::atomic::Ordering;

/// Tiles that a clear goes to.
struct Cleared {
    /// True if the clear covers the whole window, and therefore all of each view.
    whole: bool,
    /// Rectangles in the views and in the primary view.
    pictures: Vec<AtlasRect>,
    /// Rectangle on the panel; `None` if the views have the program's own lens, so that the panel
    /// stays empty.
    panel: Option<AtlasRect>,
}

/// Returns the tiles that a clear of `rect` of the window goes to.
fn cleared(layout: &AtlasLayout, rect: &vk::Rect2D) -> Cleared {
    let (width, height) = layout.window;
    let whole = rect.offset.x <= 0
        && rect.offset.y <= 0
        && i64::from(rect.offset.x) + i64::from(rect.extent.width) >= i64::from(width)
        && i64::from(rect.offset.y) + i64::from(rect.extent.height) >= i64::from(height);
    let moved = |tile: AtlasRect| AtlasRect {
        x: tile.x + rect.offset.x,
        y: tile.y + rect.offset.y,
        width: rect.extent.width as i32,
        height: rect.extent.height as i32,
    };
    // A part of the window has no corresponding part in a view with another lens.
    let of_view = |view: &ViewTile| if view.own_lens { Some(moved(view.rect)) } else { whole.then_some(view.rect) };
    let pictures = layout.views.iter().filter_map(of_view).chain(layout.primary.map(moved)).collect();
    let panel = match whole {
        true => Some(layout.panel_with_border()),
        false => (!layout.shows_own_lens()).then(|| moved(layout.panel)),
    };
    Cleared { whole, pictures, panel }
}

/// Clears parts of the window in a pass that is drawn for each view.
///
/// # Safety
/// The command buffer is being recorded, within the pass.
pub unsafe fn clear(
    device: &Device,
    buffer: vk::CommandBuffer,
    layout: &AtlasLayout,
    what: &[vk::ClearAttachment],
    rects: &[vk::ClearRect],
) {
    let rect = |rect| vk::ClearRect { rect: AtlasRect::to_vk(rect), base_array_layer: 0, layer_count: 1 };
    for given in rects {
        let Cleared { whole, pictures, panel } = cleared(layout, &given.rect);
        let (pictures, panel) = (pictures.into_iter().map(rect).collect::<Vec<_>>(), panel.map(rect));
        // A full clear makes the panel transparent. A clear of a part is drawn on the panel.
        let panel_with_border =
            |clear: &vk::ClearAttachment| match clear.aspect_mask.contains(vk::ImageAspectFlags::COLOR) {
                true if whole => vk::ClearAttachment { clear_value: vk::ClearValue::default(), ..*clear },
                _ => *clear,
            };
        let on_panel: Vec<_> = what.iter().map(panel_with_border).collect();
        // SAFETY: as promised; the tiles lie in the atlas.
        unsafe {
            if !pictures.is_empty() {
                device.driver.functions.cmd_clear_attachments(buffer, what, &pictures);
            }
            if let Some(panel) = panel {
                device.driver.functions.cmd_clear_attachments(buffer, &on_panel, &[panel]);
            }
        }
    }
}

/// A barrier for an image.
trait Barrier: Copy {
    /// Returns the image, its old layout and its new layout.
    fn target(&self) -> (vk::Image, vk::ImageLayout, vk::ImageLayout);
    /// Returns the same barrier for another image.
    fn of(self, image: vk::Image) -> Self;
    /// Returns the same barrier from any layout.
    fn of_anything(self) -> Self;
}

/// Barriers of either kind.
macro_rules! barriers {
    ($($kind:ty),+) => { $( impl Barrier for $kind {
        fn target(&self) -> (vk::Image, vk::ImageLayout, vk::ImageLayout) {
            (self.image, self.old_layout, self.new_layout)
        }
        fn of(self, image: vk::Image) -> Self {
            self.image(image)
        }
        fn of_anything(self) -> Self {
            self.old_layout(vk::ImageLayout::UNDEFINED)
        }
    } )+ };
}
barriers!(vk::ImageMemoryBarrier<'_>, vk::ImageMemoryBarrier2<'_>);

/// Notes that a command buffer changes an image to a layout.
pub fn moved(device: &Device, buffer: vk::CommandBuffer, image: vk::Image, layout: vk::ImageLayout) {
    if device.images.moved(image, layout) {
        device.recordings.with(buffer, |recording| recording.events.push(Event::Layout(image, layout)));
    }
}

/// Returns the barriers of the program, and the same ones for the atlas copies of their images.
fn with_atlas_copies<B: Barrier>(device: &Device, buffer: vk::CommandBuffer, given: &[B]) -> Vec<B> {
    let mut all = given.to_vec();
    for barrier in given {
        let (image, found, layout) = barrier.target();
        device.recordings.with(buffer, |recording| recording.finds(image, found));
        moved(device, buffer, image, layout);
        // Passes of a program that is shown flat do not change the layouts of atlas copies.
        let followed = if device.draws_views() { *barrier } else { barrier.of_anything() };
        all.extend(device.images.atlas_copies(image).into_iter().map(|atlas_copy| followed.of(atlas_copy)));
    }
    all
}

/// Returns the images of `views` that barriers of this command buffer changed and that have no
/// atlas copy for `layout` yet. Each comes with the layout in which its first barrier found it.
pub fn moved_before(
    device: &Device,
    buffer: vk::CommandBuffer,
    views: &[vk::ImageView],
    layout: &AtlasLayout,
) -> Vec<(vk::Image, vk::ImageLayout)> {
    let late = |image: &vk::Image| {
        device.images.target_of_image(*image).is_none()
            && device.images.atlas_copy_of_size(*image, layout.atlas).is_none()
    };
    // Depth and stencil are usually one image.
    let images: HashSet<_> = views.iter().filter_map(|view| device.images.of(*view)).filter(late).collect();
    if images.is_empty() {
        return Vec::new();
    }
    let moved = device.recordings.with(buffer, |recording| {
        images.iter().filter_map(|image| Some((*image, *recording.found.get(image)?))).collect()
    });
    moved.unwrap_or_default()
}

/// Makes atlas copies that are new since [`moved_before`] follow the barriers that were recorded
/// before. If the command buffer is submitted again, it finds them in the layouts of the program's
/// images.
///
/// # Safety
/// The command buffer is being recorded, outside of a pass.
pub unsafe fn follow(
    device: &Device,
    buffer: vk::CommandBuffer,
    moved: &[(vk::Image, vk::ImageLayout)],
    layout: &AtlasLayout,
) {
    for (image, found) in moved {
        let atlas_copy = device.images.atlas_copy_of_size(*image, layout.atlas);
        let Some((atlas_copy, aspects, now)) = atlas_copy.and_then(|copy| device.images.begins_in(copy, *found)) else {
            continue;
        };
        // SAFETY: as promised; the atlas copy will be in this layout when the buffer runs.
        unsafe {
            barrier_of(&device.driver, buffer, (atlas_copy, aspects), left_in(*found), ready_in(now));
        }
    }
}

/// # Safety
/// `info` must be the program's.
unsafe fn barriers_of<'a>(info: &vk::DependencyInfo<'a>) -> &'a [vk::ImageMemoryBarrier2<'a>] {
    // SAFETY: as promised.
    unsafe { slice(info.p_image_memory_barriers, info.image_memory_barrier_count) }
}

hooks! {
    cmd_pipeline_barrier = (
        buffer: vk::CommandBuffer, before: vk::PipelineStageFlags, after: vk::PipelineStageFlags, flags: vk::DependencyFlags,
        memory_count: u32, memory: *const vk::MemoryBarrier<'_>, buffer_count: u32, buffers: *const vk::BufferMemoryBarrier<'_>,
        image_count: u32, images: *const vk::ImageMemoryBarrier<'_>
    ) { |state, next| {
        let all = with_atlas_copies(&state, buffer, slice(images, image_count));
        next(buffer, before, after, flags, memory_count, memory, buffer_count, buffers, all.len() as u32, all.as_ptr())
    } }
    cmd_pipeline_barrier2 = (
        buffer: vk::CommandBuffer, info: *const vk::DependencyInfo<'_>
    ) { |state, next| {
        let all = with_atlas_copies(&state, buffer, barriers_of(&*info));
        next(buffer, &(*info).image_memory_barriers(&all))
    } }
    cmd_wait_events = (
        buffer: vk::CommandBuffer, count: u32, events: *const vk::Event, before: vk::PipelineStageFlags, after: vk::PipelineStageFlags,
        memory_count: u32, memory: *const vk::MemoryBarrier<'_>, buffer_count: u32, buffers: *const vk::BufferMemoryBarrier<'_>,
        image_count: u32, images: *const vk::ImageMemoryBarrier<'_>
    ) { |state, next| {
        let all = with_atlas_copies(&state, buffer, slice(images, image_count));
        next(buffer, count, events, before, after, memory_count, memory, buffer_count, buffers, all.len() as u32, all.as_ptr())
    } }
    cmd_set_event2 = (
        buffer: vk::CommandBuffer, event: vk::Event, info: *const vk::DependencyInfo<'_>
    ) { |state, next| {
        // The barriers that wait for the event must be the same.
        let all = with_atlas_copies(&state, buffer, barriers_of(&*info));
        next(buffer, event, &(*info).image_memory_barriers(&all))
    } }
    cmd_wait_events2 = (
        buffer: vk::CommandBuffer, count: u32, events: *const vk::Event, infos: *const vk::DependencyInfo<'_>
    ) { |state, next| {
        let given = slice(infos, count);
        let all: Vec<_> = given.iter().map(|info| with_atlas_copies(&state, buffer, barriers_of(info))).collect();
        let changed: Vec<_> = given.iter().zip(&all).map(|(info, all)| (*info).image_memory_barriers(all)).collect();
        next(buffer, count, events, changed.as_ptr())
    } }
    cmd_clear_attachments = (
        buffer: vk::CommandBuffer, count: u32, what: *const vk::ClearAttachment, rect_count: u32, rects: *const vk::ClearRect
    ) { |state, next| {
        let layout = state.recordings.with(buffer, |recording| {
            recording.pass.as_ref().map(|pass| std::sync::Arc::clone(&pass.target.layout))
        });
        match layout.flatten() {
            Some(layout) => clear(&state, buffer, &layout, slice(what, count), slice(rects, rect_count)),
            None => next(buffer, count, what, rect_count, rects),
        }
    } }
    cmd_clear_color_image = (
        buffer: vk::CommandBuffer, image: vk::Image, layout: vk::ImageLayout, color: *const vk::ClearColorValue, count: u32, ranges: *const vk::ImageSubresourceRange
    ) { |state, next| {
        for atlas_copy in state.atlas_copies(image) {
            next(buffer, atlas_copy, layout, color, count, ranges);
        }
        if let Some(target) = state.images.target_of_image(image) {
            target.panel_is_filled.store(true, Ordering::Relaxed);
        }
        if let Some(window) = state.images.target_of_image(image).filter(|target| target.window) {
            let drawn = Event::Drawn(window, state.draws_views());
            state.recordings.with(buffer, |recording| recording.events.push(drawn));
        }
        if let Some(scene) = state.images.scene(image).filter(|scene| scene.is_stored()) {
            state.recordings.with(buffer, |recording| recording.samples(std::sync::Arc::clone(&scene)));
            view_copies::change(&state, buffer, &scene, |view_copy| next(buffer, view_copy, scene.kept, color, count, ranges));
        }
        next(buffer, image, layout, color, count, ranges)
    } }
    cmd_clear_depth_stencil_image = (
        buffer: vk::CommandBuffer, image: vk::Image, layout: vk::ImageLayout, value: *const vk::ClearDepthStencilValue, count: u32, ranges: *const vk::ImageSubresourceRange
    ) { |state, next| {
        for atlas_copy in state.atlas_copies(image) {
            next(buffer, atlas_copy, layout, value, count, ranges);
        }
        next(buffer, image, layout, value, count, ranges)
    } }
    cmd_copy_buffer = (
        buffer: vk::CommandBuffer, from: vk::Buffer, to: vk::Buffer, count: u32, regions: *const vk::BufferCopy
    ) { |state, next| {
        state.recordings.with(buffer, |recording| {
            let regions = slice(regions, count).iter();
            recording.events.extend(regions.map(|region| Event::Copy(from, to, *region)));
        });
        next(buffer, from, to, count, regions)
    } }
    cmd_copy_buffer2 = (
        buffer: vk::CommandBuffer, info: *const vk::CopyBufferInfo2<'_>
    ) { |state, next| {
        state.recordings.with(buffer, |recording| {
            let regions = slice((*info).p_regions, (*info).region_count).iter();
            let plain = |r: &vk::BufferCopy2<'_>| vk::BufferCopy { src_offset: r.src_offset, dst_offset: r.dst_offset, size: r.size };
            recording.events.extend(regions.map(|r| Event::Copy((*info).src_buffer, (*info).dst_buffer, plain(r))));
        });
        next(buffer, info)
    } }
    cmd_update_buffer = (
        buffer: vk::CommandBuffer, to: vk::Buffer, offset: vk::DeviceSize, size: vk::DeviceSize, data: *const std::ffi::c_void
    ) { |state, next| {
        let bytes = slice(data.cast::<u8>(), size as u32).to_vec();
        state.recordings.with(buffer, |recording| recording.events.push(Event::Update(to, offset, bytes)));
        next(buffer, to, offset, size, data)
    } }
}

#[cfg(test)]
mod tests {
    use super::{AtlasRect, cleared};
    use crate::intercept::vk::state::views::atlas_layout::AtlasLayout;
    use crate::intercept::vk::state::views::vertices::VertexProcessing;
    use ash::vk;

    #[test]
    fn a_whole_clear_reaches_each_view_and_a_part_of_it_the_panel_only() {
        let rig = crate::rig::load("fisheye").expect("a preset");
        let layout = AtlasLayout::new(&rig, (200, 200), 16384, false, VertexProcessing::Divided).expect("a plan");
        let whole = vk::Rect2D { offset: vk::Offset2D::default(), extent: vk::Extent2D { width: 200, height: 200 } };
        let all = cleared(&layout, &whole);
        assert_eq!(
            (all.whole, all.pictures.len(), all.panel),
            (true, layout.views.len(), Some(layout.panel_with_border()))
        );
        let part = vk::Rect2D { offset: vk::Offset2D { x: 20, y: 30 }, ..whole };
        let some = cleared(&layout, &part);
        assert!(!some.whole && some.pictures.is_empty());
        let AtlasRect { x, y, .. } = layout.panel;
        assert_eq!(some.panel, Some(AtlasRect { x: x + 20, y: y + 30, width: 200, height: 200 }));
        let layout = AtlasLayout::new(&rig, (200, 200), 16384, true, VertexProcessing::Divided).expect("a plan");
        assert_eq!(
            cleared(&layout, &part).pictures,
            [AtlasRect { x: 20, y: 30, width: 200, height: 200 }],
            "the program's own picture"
        );
    }
}
