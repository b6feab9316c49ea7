//! A draw of the program → one draw per view, and one on the panel.

use crate::correct::single::pixels;
use crate::intercept::scene;
use crate::intercept::vk::commands::bound_state::set_window;
use crate::intercept::vk::offscreen::scene_graph;
use crate::intercept::vk::pipelines::matrix_sources::source;
use crate::intercept::vk::state::atlas_layout::{AtlasLayout, Rect, rectangle};
use crate::intercept::vk::state::device::Device;
use crate::intercept::vk::state::draw_groups::{DrawFacts, DrawGroup};
use crate::intercept::vk::state::draw_parameters::{DrawParameters, IndirectDraw};
use crate::intercept::vk::state::hooks::hooks;
use crate::intercept::vk::state::pipelines::{Pipeline, Variants};
use crate::intercept::vk::state::recording::{Event, Recording, drawn};
use crate::intercept::vk::state::scene_graph::{COVERING_VERTICES, Made};
use crate::intercept::vk::state::view_constants::ChunkOffset;
use ash::vk;
use std::sync::Arc;

/// How large a draw is.
#[derive(Clone, Copy)]
enum DrawSize {
    /// The program says it.
    Known(DrawParameters),
    /// Only the device knows.
    Unknown,
}

impl DrawSize {
    /// How many vertices it has, more where that is not known.
    fn vertices(&self) -> u32 {
        match self {
            Self::Known(parameters) => parameters.vertices(),
            Self::Unknown => u32::MAX,
        }
    }
}

/// Issues a draw of the program by `issue`.
///
/// # Safety
/// The command buffer is being recorded; `issue` records the program's own draw, of that `size`.
unsafe fn draw(device: &Device, buffer: vk::CommandBuffer, size: DrawSize, issue: impl Fn()) {
    let vertices = size.vertices();
    let covers_viewport = vertices <= COVERING_VERTICES;
    let known = device.recordings.with(buffer, |recording| {
        // SAFETY: as promised.
        unsafe {
            match recording.graphics.pipeline.clone() {
                Some(pipeline) if recording.pass.is_some() => {
                    each_view(device, buffer, recording, (&pipeline, size), &issue);
                }
                Some(pipeline) => {
                    if device.images.has_candidates() && device.draws_views() {
                        suspect(device, recording, (&pipeline, covers_viewport));
                    }
                    restore(device, buffer, recording);
                    drawn(recording, None, vertices, Some(1));
                    issue();
                }
                None => {
                    drawn(recording, None, vertices, Some(1));
                    issue();
                }
            }
        }
    });
    if known.is_none() {
        issue();
    }
}

/// A draw in a pass of the program's own says what it may be of the scene.
fn suspect(device: &Device, recording: &mut Recording, (pipeline, covers_viewport): (&Pipeline, bool)) {
    let targets = recording.plain.iter().flatten();
    let size = targets.filter_map(|target| device.images.size(*target)).next();
    let viewport = pipeline.viewport.or(recording.graphics.viewport).unwrap_or_default();
    let main = size.is_some_and(|size| is_main(&viewport, size));
    let matrices = pipeline.variants.as_ref().map_or(&[][..], |variants| &variants.matrices);
    scene_graph::drawn(device, recording, matrices, (main, covers_viewport));
}

/// Whether a viewport shows the main picture of an image of this size.
fn is_main(viewport: &vk::Viewport, (width, height): (u32, u32)) -> bool {
    let area = f64::from(width) * f64::from(height);
    scene::viewport::is_main(viewport.width.into(), viewport.height.abs().into(), area)
}

/// A set with which the program's shaders see each view of the scene, where it drew that off screen, and the atlas copies of
/// attachments that they read.
struct SetOfViews {
    number: u32,
    /// One for each view.
    sets: Arc<[vk::DescriptorSet]>,
    dynamic: Vec<u32>,
    /// It has attachments, so that the program's own set fits no pass that is drawn for each view.
    attachments: bool,
}

/// All of them that a draw needs.
type OfViews = Vec<SetOfViews>;

/// # Errors
/// Why there are none.
fn sets_of_views(device: &Device, recording: &Recording, layout: &AtlasLayout, ours: u32) -> Result<OfViews, String> {
    let mut all = Vec::new();
    if !device.images.has_candidates() && !device.descriptors.any_attachments() {
        return Ok(all);
    }
    for (number, bound) in (0..ours).zip(&recording.graphics.bound) {
        let Some(bound) = bound else { continue };
        if let Some(sets) = device.descriptors.of_views(device, bound.set, layout)? {
            let attachments = device.descriptors.reads_attachments(bound.set);
            all.push(SetOfViews { number, sets, dynamic: bound.dynamic.clone(), attachments });
        }
    }
    Ok(all)
}

/// Puts back what the program bound and set, after draws of ours.
///
/// # Safety
/// The command buffer is being recorded.
unsafe fn restore(device: &Device, buffer: vk::CommandBuffer, recording: &mut Recording) {
    let Some(pipeline) = recording.graphics.pipeline.clone() else { return };
    // SAFETY: as promised; what is bound and set is the program's own.
    unsafe {
        if recording.graphics.current != pipeline.own {
            device.driver.functions.cmd_bind_pipeline(buffer, vk::PipelineBindPoint::GRAPHICS, pipeline.own);
            recording.graphics.current = pipeline.own;
        }
        if recording.graphics.disturbed {
            if let (None, Some(viewport)) = (pipeline.viewport, recording.graphics.viewport) {
                device.driver.functions.cmd_set_viewport(buffer, 0, &[viewport]);
            }
            if let (None, Some(scissor)) = (pipeline.scissor, recording.graphics.scissor) {
                device.driver.functions.cmd_set_scissor(buffer, 0, &[scissor]);
            }
            recording.graphics.disturbed = false;
        }
        rebind(device, buffer, recording, &pipeline);
    }
}

/// Binds the program's descriptor sets again whose place a set of ours took.
///
/// # Safety
/// The command buffer is being recorded.
unsafe fn rebind(device: &Device, buffer: vk::CommandBuffer, recording: &mut Recording, pipeline: &Pipeline) {
    let (Some(from), Some(layout)) = (recording.graphics.displaced, &pipeline.layout) else { return };
    if from >= layout.ours {
        return;
    }
    for (number, bound) in (0..layout.ours).zip(&recording.graphics.bound).filter(|(number, _)| *number >= from) {
        let Some(bound) = bound else { continue };
        // SAFETY: as promised; the program bound the set, or pushed it, for this place.
        unsafe {
            let (functions, point) = (&device.driver.functions, vk::PipelineBindPoint::GRAPHICS);
            match &bound.pushed {
                Some(pushed) => pushed.repeat(&device.next, buffer, point, layout.handle, number),
                None => {
                    let (sets, dynamic) = ([bound.set], &bound.dynamic);
                    functions.cmd_bind_descriptor_sets(buffer, point, layout.handle, number, &sets, dynamic);
                }
            }
        }
    }
    recording.graphics.displaced = None;
}

/// Issues a draw to each view and onto the panel.
///
/// # Safety
/// As for [`draw`].
unsafe fn each_view(
    device: &Device,
    buffer: vk::CommandBuffer,
    recording: &mut Recording,
    (pipeline, size): (&Arc<Pipeline>, DrawSize),
    issue: &dyn Fn(),
) {
    let vertices = size.vertices();
    let covers_viewport = vertices <= COVERING_VERTICES;
    let Some(variants) = &pipeline.variants else {
        // Its window space is not that of a tile.
        device.give_up(&device.flatness.pipeline_obstacle());
        return;
    };
    // SAFETY: as promised.
    unsafe {
        rebind(device, buffer, recording, pipeline);
        let Some(pass) = &mut recording.pass else { return };
        let uncleared_panels = std::mem::take(&mut pass.uncleared_panels);
        let layout = Arc::clone(&pass.target.layout);
        crate::intercept::vk::commands::panel_clears::clear_panel(device, buffer, &layout, &uncleared_panels);
        let (width, height) = (pixels(layout.window.0 as i32), pixels(layout.window.1 as i32));
        let whole = vk::Viewport { x: 0.0, y: 0.0, width, height, min_depth: 0.0, max_depth: 1.0 };
        let viewport = pipeline.viewport.or(recording.graphics.viewport).unwrap_or(whole);
        let scissor = pipeline.scissor.or(recording.graphics.scissor).unwrap_or(whole_window(&layout));
        let main = is_main(&viewport, layout.window);
        let own_lens = layout.views.iter().any(|(_, own)| *own);
        let sources: Vec<_> = match variants.follows && main {
            true => variants.matrices.iter().filter_map(|m| source(device, recording, m)).collect(),
            false => Vec::new(),
        };
        let ours = pipeline.layout.as_ref().map_or(0, |layout| layout.ours);
        let of_views = match sets_of_views(device, recording, &layout, ours) {
            Ok(of_views) => of_views,
            Err(why) => {
                device.give_up(&why);
                return;
            }
        };
        let pictures = scene_graph::pictures(device, recording);
        let Some(pass) = &mut recording.pass else { return };
        let made = match pass.target.window {
            _ if !main || !covers_viewport && sources.is_empty() => Made::Elsewhere,
            true => Made::Window,
            false => Made::Image(pass.target.given),
        };
        for picture in pictures {
            device.scene_graph.note_made(picture, made);
            device.images.scene(picture).into_iter().for_each(|scene| recording.samples(scene));
        }
        let Some(pass) = &mut recording.pass else { return };
        let (screen, off_screen) = (!of_views.is_empty() && main && covers_viewport, !pass.target.window);
        if screen && variants.asks_place {
            device.give_up("a shader that reads a picture of its scene asks for its place on the screen");
        }
        // A flat draw may have to go behind the scene, if none was drawn yet.
        let deep = variants.deep && main && layout.session.given_lens().is_some();
        let may_be_behind = !sources.is_empty() || !pass.scene || off_screen || deep;
        let in_views = own_lens || main && (screen || variants.follows && may_be_behind);
        pass.scene |= !sources.is_empty() || screen || deep;
        let y_up = viewport.height < 0.0;
        let kind = DrawFacts { sources, y_up, in_views, off_screen, deep, screen };
        let last = recording.draw_groups.last_mut().filter(|group| group.takes(&layout, &kind));
        let slots = 2 + if in_views { layout.views.len() } else { 0 };
        let place = match last {
            Some(group) => {
                group.draws += 1;
                group.place
            }
            None => {
                let stride = device.slot_stride();
                let Ok(place) = device.view_constants.take(&device.driver, &mut recording.constants, slots, stride)
                else {
                    device.give_up("there is no memory for its views");
                    return;
                };
                recording.events.push(Event::DrawGroup(recording.draw_groups.len()));
                let mut group = DrawGroup::new(place, Arc::clone(&layout), kind);
                group.draws = 1;
                recording.draw_groups.push(group);
                place
            }
        };
        let group = recording.draw_groups.len() - 1;
        let on_panel = recording.draw_groups[group].is_on_panel();
        let tiles = if in_views { layout.views.len() } else { 0 };
        let times = tiles + usize::from(on_panel) + usize::from(layout.primary.is_some());
        let placed = match &size {
            DrawSize::Known(parameters) => IndirectDraw::new(device, recording, parameters, slots as u32),
            DrawSize::Unknown => None,
        };
        drawn(recording, Some(group), vertices, placed.is_none().then_some(times as u32));
        recording.draw_groups[group].placed.extend(placed);
        let mut tile = Tile { device, buffer, recording, pipeline, variants, place, viewport, scissor };
        if in_views {
            for (index, (rect, own_lens)) in layout.views.iter().enumerate() {
                tile.begin(variants.view, index, *rect, *own_lens, layout.window);
                tile.bind(&of_views, index);
                tile.issue(&placed, index, issue);
            }
        }
        tile.unbind(&of_views);
        let attached: OfViews = of_views.into_iter().filter(|set| set.attachments).collect();
        if on_panel {
            tile.begin(variants.panel, tiles, layout.panel, true, layout.window);
            tile.bind(&attached, 0);
            tile.issue(&placed, tiles, issue);
        }
        if let Some(primary) = layout.primary {
            tile.begin(variants.view, tiles + 1, primary, true, layout.window);
            tile.bind(&attached, 0);
            tile.issue(&placed, tiles + 1, issue);
        }
        tile.unbind(&attached);
    }
}

fn whole_window(layout: &AtlasLayout) -> vk::Rect2D {
    vk::Extent2D { width: layout.window.0, height: layout.window.1 }.into()
}

/// What a draw into a tile needs.
struct Tile<'a> {
    device: &'a Device,
    buffer: vk::CommandBuffer,
    recording: &'a mut Recording,
    pipeline: &'a Pipeline,
    variants: &'a Variants,
    place: ChunkOffset,
    viewport: vk::Viewport,
    scissor: vk::Rect2D,
}

impl Tile<'_> {
    /// Binds and sets what the next draw into `tile` needs. `own`: the tile is in the program's own window space.
    ///
    /// # Safety
    /// The command buffer is being recorded.
    unsafe fn begin(&mut self, by: vk::Pipeline, slot: usize, tile: Rect, own: bool, window: (u32, u32)) {
        let (device, buffer) = (self.device, self.buffer);
        let (viewport, scissor) = if own {
            (moved(&self.viewport, tile), cut(&self.scissor, tile, window))
        } else {
            (filling(&self.viewport, tile), rectangle(tile))
        };
        // SAFETY: as promised.
        unsafe {
            let graphics = vk::PipelineBindPoint::GRAPHICS;
            if self.recording.graphics.current != by {
                device.driver.functions.cmd_bind_pipeline(buffer, graphics, by);
                self.recording.graphics.current = by;
            }
            set_window(device, buffer, &viewport, &scissor, self.variants.with_count);
            self.recording.graphics.disturbed = true;
            if let (Some(layout), Some(chunk)) =
                (&self.pipeline.layout, self.recording.constants.chunks.get(self.place.chunk))
            {
                let offset = self.place.offset + slot as u32 * device.slot_stride();
                let functions = &device.driver.functions;
                functions.cmd_bind_descriptor_sets(
                    buffer,
                    graphics,
                    layout.handle,
                    layout.ours,
                    &[chunk.set(layout.counts)],
                    &[offset],
                );
                let from = self.recording.graphics.displaced.map_or(layout.ours, |from| from.min(layout.ours));
                self.recording.graphics.displaced = Some(from);
            }
        }
    }
}

impl Tile<'_> {
    /// Issues the draw with a slot of view constants: by its parameters in memory, or else by `issue`.
    ///
    /// # Safety
    /// The command buffer is being recorded.
    unsafe fn issue(&self, placed: &Option<IndirectDraw>, slot: usize, issue: &dyn Fn()) {
        match placed {
            // SAFETY: as promised; the places are those of this recording.
            Some(placed) => unsafe {
                placed.issue(&self.device.driver, self.buffer, &self.recording.constants.chunks, slot as u32)
            },
            None => issue(),
        }
    }

    /// Lets the next draw see one view of the scene, where the program drew that off screen.
    ///
    /// # Safety
    /// The command buffer is being recorded.
    unsafe fn bind(&mut self, sets: &OfViews, view: usize) {
        let Some(layout) = &self.pipeline.layout else { return };
        for SetOfViews { number, sets, dynamic, .. } in sets {
            let Some(set) = sets.get(view) else { continue };
            let (functions, graphics) = (&self.device.driver.functions, vk::PipelineBindPoint::GRAPHICS);
            // SAFETY: as promised; the set is like the program's, which it bound for this place.
            unsafe {
                functions.cmd_bind_descriptor_sets(self.buffer, graphics, layout.handle, *number, &[*set], dynamic);
            }
        }
    }

    /// Puts the program's own sets back in the place of those.
    ///
    /// # Safety
    /// The command buffer is being recorded.
    unsafe fn unbind(&mut self, sets: &OfViews) {
        let Some(first) = sets.first().map(|set| set.number) else { return };
        self.recording.graphics.displaced =
            Some(self.recording.graphics.displaced.map_or(first, |from| from.min(first)));
        // SAFETY: as promised.
        unsafe { rebind(self.device, self.buffer, self.recording, self.pipeline) };
    }
}

/// A viewport moved to a tile.
fn moved(viewport: &vk::Viewport, tile: Rect) -> vk::Viewport {
    vk::Viewport { x: viewport.x + pixels(tile[0]), y: viewport.y + pixels(tile[1]), ..*viewport }
}

/// A viewport over the whole of a tile, the same way up.
fn filling(viewport: &vk::Viewport, [x, y, width, height]: Rect) -> vk::Viewport {
    let (y, height) = if viewport.height < 0.0 { (y + height, -height) } else { (y, height) };
    vk::Viewport { x: pixels(x), y: pixels(y), width: pixels(width), height: pixels(height), ..*viewport }
}

/// A scissor moved to a tile and cut at the borders of the window that it stands for.
fn cut(scissor: &vk::Rect2D, tile: Rect, window: (u32, u32)) -> vk::Rect2D {
    let axis = |offset: i32, extent: u32, window: u32, tile: i32| {
        let end = i64::from(offset) + i64::from(extent);
        let end = end.clamp(0, i64::from(window)) as i32;
        let start = offset.clamp(0, end);
        (tile + start, (end - start) as u32)
    };
    let (x, width) = axis(scissor.offset.x, scissor.extent.width, window.0, tile[0]);
    let (y, height) = axis(scissor.offset.y, scissor.extent.height, window.1, tile[1]);
    vk::Rect2D { offset: vk::Offset2D { x, y }, extent: vk::Extent2D { width, height } }
}

hooks! {
    cmd_draw = (
        buffer: vk::CommandBuffer, vertices: u32, instances: u32, first_vertex: u32, first_instance: u32
    ) { |state, next| draw(&state, buffer, DrawSize::Known(DrawParameters::of_vertices(vertices, instances, first_vertex, first_instance)), || next(buffer, vertices, instances, first_vertex, first_instance)) }
    cmd_draw_indexed = (
        buffer: vk::CommandBuffer, indices: u32, instances: u32, first_index: u32, vertex_offset: i32, first_instance: u32
    ) { |state, next| draw(&state, buffer, DrawSize::Known(DrawParameters::of_indices(indices, instances, first_index, vertex_offset, first_instance)), || next(buffer, indices, instances, first_index, vertex_offset, first_instance)) }
    cmd_draw_indirect = (
        buffer: vk::CommandBuffer, from: vk::Buffer, offset: vk::DeviceSize, count: u32, stride: u32
    ) { |state, next| draw(&state, buffer, DrawSize::Unknown, || next(buffer, from, offset, count, stride)) }
    cmd_draw_indexed_indirect = (
        buffer: vk::CommandBuffer, from: vk::Buffer, offset: vk::DeviceSize, count: u32, stride: u32
    ) { |state, next| draw(&state, buffer, DrawSize::Unknown, || next(buffer, from, offset, count, stride)) }
    cmd_draw_indirect_count = (
        buffer: vk::CommandBuffer, from: vk::Buffer, offset: vk::DeviceSize, counts: vk::Buffer, count_offset: vk::DeviceSize, most: u32, stride: u32
    ) { |state, next| draw(&state, buffer, DrawSize::Unknown, || next(buffer, from, offset, counts, count_offset, most, stride)) }
    cmd_draw_indexed_indirect_count = (
        buffer: vk::CommandBuffer, from: vk::Buffer, offset: vk::DeviceSize, counts: vk::Buffer, count_offset: vk::DeviceSize, most: u32, stride: u32
    ) { |state, next| draw(&state, buffer, DrawSize::Unknown, || next(buffer, from, offset, counts, count_offset, most, stride)) }
    cmd_draw_multi = (
        buffer: vk::CommandBuffer, count: u32, infos: *const vk::MultiDrawInfoEXT, instances: u32, first_instance: u32, stride: u32
    ) { |state, next| draw(&state, buffer, DrawSize::Unknown, || next(buffer, count, infos, instances, first_instance, stride)) }
    cmd_draw_multi_indexed = (
        buffer: vk::CommandBuffer, count: u32, infos: *const vk::MultiDrawIndexedInfoEXT, instances: u32, first_instance: u32, stride: u32, vertex_offset: *const i32
    ) { |state, next| draw(&state, buffer, DrawSize::Unknown, || next(buffer, count, infos, instances, first_instance, stride, vertex_offset)) }
    cmd_draw_mesh_tasks = (
        buffer: vk::CommandBuffer, x: u32, y: u32, z: u32
    ) { |state, next| draw(&state, buffer, DrawSize::Unknown, || next(buffer, x, y, z)) }
    cmd_draw_mesh_tasks_nv = (
        buffer: vk::CommandBuffer, count: u32, first: u32
    ) { |state, next| draw(&state, buffer, DrawSize::Unknown, || next(buffer, count, first)) }
    cmd_draw_mesh_tasks_indirect = (
        buffer: vk::CommandBuffer, from: vk::Buffer, offset: vk::DeviceSize, count: u32, stride: u32
    ) { |state, next| draw(&state, buffer, DrawSize::Unknown, || next(buffer, from, offset, count, stride)) }
    cmd_draw_mesh_tasks_indirect_nv = (
        buffer: vk::CommandBuffer, from: vk::Buffer, offset: vk::DeviceSize, count: u32, stride: u32
    ) { |state, next| draw(&state, buffer, DrawSize::Unknown, || next(buffer, from, offset, count, stride)) }
    cmd_draw_mesh_tasks_count = (
        buffer: vk::CommandBuffer, from: vk::Buffer, offset: vk::DeviceSize, counts: vk::Buffer, count_offset: vk::DeviceSize, most: u32, stride: u32
    ) { |state, next| draw(&state, buffer, DrawSize::Unknown, || next(buffer, from, offset, counts, count_offset, most, stride)) }
    cmd_draw_mesh_tasks_count_nv = (
        buffer: vk::CommandBuffer, from: vk::Buffer, offset: vk::DeviceSize, counts: vk::Buffer, count_offset: vk::DeviceSize, most: u32, stride: u32
    ) { |state, next| draw(&state, buffer, DrawSize::Unknown, || next(buffer, from, offset, counts, count_offset, most, stride)) }
    cmd_draw_indirect_byte_count = (
        buffer: vk::CommandBuffer, instances: u32, first_instance: u32, counter: vk::Buffer, offset: vk::DeviceSize, counter_offset: u32, stride: u32
    ) { |state, next| draw(&state, buffer, DrawSize::Unknown, || next(buffer, instances, first_instance, counter, offset, counter_offset, stride)) }
    cmd_begin_transform_feedback = (
        buffer: vk::CommandBuffer, first: u32, count: u32, buffers: *const vk::Buffer, offsets: *const vk::DeviceSize
    ) { |state, next| {
        // Each draw would be captured several times.
        if state.recordings.with(buffer, |recording| recording.pass.is_some()) == Some(true) {
            state.give_up("it captures what it draws to the window");
        }
        next(buffer, first, count, buffers, offsets)
    } }
}

#[cfg(test)]
mod tests {
    use super::{cut, filling};
    use ash::vk;

    #[test]
    fn a_scissor_is_cut_at_the_window_and_moved() {
        let scissor =
            |x, y, width, height| vk::Rect2D { offset: vk::Offset2D { x, y }, extent: vk::Extent2D { width, height } };
        let tile = [1000, 10, 200, 100];
        assert_eq!(cut(&scissor(20, 30, 50, 40), tile, (200, 100)), scissor(1020, 40, 50, 40));
        assert_eq!(cut(&scissor(150, 0, 5000, u32::MAX), tile, (200, 100)), scissor(1150, 10, 50, 100));
        assert_eq!(cut(&scissor(300, 0, 10, 10), tile, (200, 100)).extent.width, 0);
    }

    #[test]
    fn an_upside_down_viewport_stays_so() {
        let given = vk::Viewport { x: 0.0, y: 90.0, width: 50.0, height: -90.0, min_depth: 0.25, max_depth: 1.0 };
        let filled = filling(&given, [100, 200, 30, 40]);
        assert_eq!((filled.y, filled.height, filled.min_depth), (240.0, -40.0, 0.25));
    }
}
