//! Draw groups at submission: their lenses, and the view constants for each view.
//!
//! A draw's class (scene or flat, and with which lens) is decided when the command buffer is
//! submitted. The view constants carry out the decision: a draw that does not belong in a tile is
//! moved out of it.

use crate::correct::projected::matrices::{LensConstants, ReprojectionMatrix};
use crate::correct::single;
use crate::intercept::inspection;
use crate::intercept::process::{call_sum, log};
use crate::intercept::scene::flat_program::OffScreen;
use crate::intercept::scene::lens::{self, Candidate, Told};
use crate::intercept::scene::to_window::ToWindow;
use crate::intercept::vk::pipelines::matrix_sources::matrix;
use crate::intercept::vk::queries::running::{RunningQuery, SampleScale};
use crate::intercept::vk::state::device::Device;
use crate::intercept::vk::state::recording::draw_groups::{DrawClass, DrawGroup, Frame, MatrixSource, ShownLayout};
use crate::intercept::vk::state::recording::{Event, Recording};
use crate::intercept::vk::state::views::atlas_layout::{AtlasLayout, AtlasRect};
use crate::intercept::vk::state::views::view_constants::ConstantChunk;
use crate::intercept::vk::submit::backdrops;
use crate::intercept::vk::submit::camera_matrices;
use crate::intercept::vk::submit::inspected;
use crate::lock::Lock;
use crate::runtime::session::Intrinsics;
use std::sync::Arc;
use std::sync::atomic::Ordering;

/// Matrices that do not change positions, not even by rounding.
const IDENTITY: ReprojectionMatrix = ReprojectionMatrix::IDENTITY;

/// Matrices that move everything to the right of the visible area: x' = 2w, w' = w.
const OUT_OF_SIGHT: ReprojectionMatrix =
    ReprojectionMatrix::from_array([0.0, 0.0, 2.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 0.0, 0.0]);

impl Frame {
    /// Ends a frame. `in_views`: draws of scenes are issued to each view. `off_screen` returns what
    /// is drawn off screen.
    pub fn end(&mut self, in_views: bool, off_screen: impl FnOnce() -> OffScreen) {
        if let Some(layout) = self.layout.as_ref().filter(|_| in_views) {
            let has_scene = !self.counts.found.is_empty() || self.counts.duplicated > 0;
            let counts = &self.counts;
            let text = self.flat_program.look(counts.seen, has_scene, &layout.session, &counts.missing, off_screen);
            text.into_iter().for_each(log::once);
            self.small_window.look(&layout.session);
        }
        self.order.end_frame();
        self.cameras.end_frame();
    }

    fn follow(&mut self, layout: &Arc<AtlasLayout>) {
        if self.layout.as_ref().is_none_or(|known| !known.has_views_of(layout)) {
            self.layout = Some(Arc::clone(layout));
            self.cameras.clear();
            self.sampled = None;
            self.behind_part = None;
        }
    }

    /// Computes again what depends on the adaptation of the program's camera.
    pub fn adjust_cameras(&mut self) {
        if let Some(layout) = &self.layout {
            self.cameras.adjust(&layout.session);
        }
        self.sampled = None;
    }
}

impl Frame {
    /// Computes the matrices that show, in each view, the panel or the part of it that belongs to an
    /// image of this layout.
    fn prepare_behind(&mut self, layout: &AtlasLayout) {
        let part = layout.panel_part();
        if self.behind_part.replace(part) != Some(part) {
            let rows = layout.session.panel_rows();
            self.behind = rows.iter().map(|whole| ReprojectionMatrix::of(&part.reprojection(whole))).collect();
        }
    }

    /// Returns the number of samples that show the field of view of a lens, in all views. `own`:
    /// number of samples of the primary view.
    fn samples(&mut self, lens: &Intrinsics, layout: &AtlasLayout, own: f64) -> f64 {
        let index = self.cameras.index(lens, &layout.session);
        let lens = self.cameras.get(index).map_or(*lens, |camera| camera.intrinsics);
        if let Some((_, samples)) = self.sampled.filter(|(known, _)| *known == lens) {
            return samples;
        }
        let samples = layout.session.samples(&lens, own, false);
        self.sampled = Some((lens, samples));
        samples
    }
}

/// Handles a submitted command buffer: its draws get their view constants.
pub fn submitted(device: &Device, recording: &mut Recording) {
    run_events(device, recording, &mut Vec::new());
}

/// [`submitted`], while `queries` run.
fn run_events(device: &Device, recording: &mut Recording, queries: &mut Vec<RunningQuery>) {
    let Recording { events, draw_groups, constants, .. } = recording;
    for event in events.iter() {
        match event {
            Event::DrawGroup(index) => {
                if let Some(group) = draw_groups.get_mut(*index) {
                    resolve(device, group, &constants.chunks);
                }
            }
            Event::Copy(from, to, region) => device.host_memory.copied(*from, *to, region),
            Event::Update(buffer, offset, bytes) => {
                // SAFETY: pointer and length are those of a slice.
                unsafe { call_sum::add_values(bytes.as_ptr(), bytes.len()) };
                device.host_memory.written(*buffer, *offset, bytes.clone());
            }
            Event::Layout(image, layout) => device.images.submitted(*image, *layout),
            Event::Execute(other) => {
                device.recordings.with(*other, |other| run_events(device, other, queries));
            }
            Event::Drawn(target, in_views) => {
                crate::intercept::vk::state::views::view_target::drawn(target, *in_views);
                if device.images.is_retired(target) && target.was_missed() {
                    device.show_flat("the commands that draw its scene were recorded before its views changed");
                }
            }
            Event::Suspected(targets, sources) => {
                crate::intercept::vk::offscreen::scene_graph::ran(device, targets, sources)
            }
            Event::Computed(images) => crate::intercept::vk::offscreen::scene_graph::computed(device, images),
            Event::Measured(block) => block.submitted.store(true, Ordering::Relaxed),
            Event::BeginQuery(pool, query) => queries.push(RunningQuery::new(Arc::clone(pool), *query)),
            Event::EndQuery(pool, query) => {
                let ended = queries.iter().position(|running| running.is(pool, *query));
                ended.into_iter().for_each(|index| queries.swap_remove(index).end(device));
            }
            Event::Counted { group, vertices, times } => {
                let group = group.and_then(|index| draw_groups.get(index)).filter(|_| !queries.is_empty());
                let sample_scale = group.map_or(SampleScale::ONCE, |group| sample_scale(device, group));
                let times = times.or_else(|| group.map(|group| group.times()[1])).unwrap_or(1);
                queries.iter_mut().for_each(|running| running.add(sample_scale, *vertices, times));
            }
        }
    }
}

/// Returns the scale from samples of a group's draws to samples of the primary view. Drawing that
/// fills the primary view gets the number of samples of that picture.
fn sample_scale(device: &Device, group: &DrawGroup) -> SampleScale {
    let mut frame = device.frame.locked();
    frame.follow(&group.layout);
    let layout = &group.layout;
    let area = |width: f64, height: f64| width * height;
    let own = area(layout.window.0.into(), layout.window.1.into());
    let of_window = own / layout.pixels;
    // Pictures with the program's own lens show everything once more.
    let views = if group.facts.in_views { &layout.views[..] } else { &[] };
    let repeated = f64::from(u8::from(layout.primary.is_some()));
    let same = repeated + views.iter().filter(|view| view.own_lens).count() as f64;
    let seen = match group.last.map(|(class, _)| class) {
        Some(DrawClass::Scene(lens)) => repeated + frame.samples(&lens, layout, of_window) / of_window,
        Some(DrawClass::Screen | DrawClass::Backdrop(_)) => {
            let shown = group.facts.part.map_or(own, AtlasRect::area);
            repeated + views.iter().map(|view| view.rect.area()).sum::<f64>() / shown
        }
        Some(DrawClass::Flat) if !group.facts.off_screen && !layout.shows_own_lens() => same + 1.0,
        // The draw covers the area of the panel in the views, which is about as large as the panel.
        _ => same.max(1.0),
    };
    SampleScale { factor: 1.0 / seen, of_scene: !matches!(group.last, Some((DrawClass::Flat, _))) }
}

/// Decides the class of a group, and writes its view constants and the parameters of its draws into
/// the `chunks` of its command buffer.
fn resolve(device: &Device, group: &mut DrawGroup, chunks: &[ConstantChunk]) {
    let mut frame = device.frame.locked();
    frame.follow(&group.layout);
    let functions_changed = camera_matrices::look(device, group, &frame);
    find_lens(device, group);
    sum_up(group);
    let facts = &group.facts;
    frame.counts.seen += group.draws;
    let in_views = facts.in_views && device.draws_views();
    // What fills a rectangle of the window is a picture, although it may have a perspective.
    let settled = group.lens.filter(|_| in_views && facts.part.is_none()).and_then(|(told, how)| {
        let (width, height) = group.layout.window;
        let lens = told.settled(frame.cameras.lenses(), f64::from(width) / f64::from(height))?;
        Some((lens, how))
    });
    let outcome = classify(group, settled, in_views, &mut frame);
    if inspection::is_recording() {
        inspected::note(group, outcome, settled.map(|(_, how)| how), in_views, |source| matrix(device, source));
    }
    frame.counts.in_views += if outcome == DrawClass::Flat { 0 } else { group.draws };
    frame.counts.duplicated += if facts.off_screen { group.draws } else { 0 };
    frame.counts.left_out += group.elsewhere;
    let camera = match outcome {
        DrawClass::Scene(intrinsics) => Some(frame.cameras.index(&intrinsics, &group.layout.session)),
        _ => None,
    };
    camera.into_iter().for_each(|index| frame.cameras.show(index));
    let written = Some((outcome, frame.cameras.adjustments()));
    if group.last != written || functions_changed {
        group.last = written;
        if outcome == DrawClass::Behind {
            frame.prepare_behind(&group.layout);
        }
        camera_matrices::write(device, group, outcome, &mut frame, chunks);
        backdrops::write(device, group, outcome, &mut frame, chunks);
        let of_views = match camera {
            Some(index) => frame.cameras.get(index).map(|camera| &camera.reprojections),
            None => (outcome == DrawClass::Behind).then_some(&frame.behind),
        };
        write(device, group, outcome, of_views, chunks);
    }
    if !group.indirect.is_empty() {
        let [issued, in_sight] = group.times();
        frame.counts.left_out += group.indirect.len() as u64 * u64::from(issued - in_sight);
    }
}

/// Finds the lens of a group among its matrices, if they have changed.
fn find_lens(device: &Device, group: &mut DrawGroup) {
    let ranked = |source: &MatrixSource| matrix(device, source).map(|value| (source.matrix.rank, value));
    let matrices: Vec<_> = group.facts.sources.iter().filter_map(ranked).collect();
    if matrices != group.matrices {
        let candidates = matrices.iter().map(|(rank, value)| Candidate::either(*rank, value));
        group.lens = lens::find(candidates).map(|(told, _)| (told, told.how()));
        group.matrices = matrices;
    }
    if group.matrices.is_empty() && group.facts.deep {
        group.lens = group.layout.session.given_lens().map(|lens| (Told::sure(lens), "the rig's lens"));
    }
}

/// Adds a group's draws to the sum of the program's calls: the number of draws, and the matrices
/// that Cupola reads for them.
fn sum_up(group: &DrawGroup) {
    if call_sum::is_on() {
        call_sum::add(group.draws);
        for (_, matrix) in &group.matrices {
            matrix.to_cols_array().iter().for_each(|value| call_sum::add(value.to_bits()));
        }
    }
}

/// Returns the class of a group, by its lens and the way that lens was found, and counts it in the
/// frame.
fn classify(
    group: &DrawGroup,
    settled: Option<(Intrinsics, &'static str)>,
    in_views: bool,
    frame: &mut Frame,
) -> DrawClass {
    let facts = &group.facts;
    match settled {
        Some((intrinsics, how)) => {
            // Flat drawing in the window is beside a part, and not behind it.
            if group.layout.part.is_none() {
                frame.order.note_scene();
            }
            *frame.counts.found.entry(how).or_default() += group.draws;
            DrawClass::Scene(intrinsics)
        }
        None if facts.screen && in_views => {
            if facts.part.is_none() {
                frame.order.note_scene();
            }
            DrawClass::Screen
        }
        None if facts.sky && in_views && group.cameras.holds_inverse(facts) => {
            frame.order.note_scene();
            *frame.counts.found.entry("inverse of a camera matrix").or_default() += group.draws;
            DrawClass::Screen
        }
        None if facts.fills && facts.off_screen && in_views => {
            frame.backdrop_lens(facts).map_or(DrawClass::Screen, DrawClass::Backdrop)
        }
        // A flat draw to an image of the scene can only go to the views.
        None if facts.off_screen => DrawClass::Behind,
        None => {
            frame.counts.missing.count(group.missing_lens(), group.draws);
            frame.counts.flat += group.draws;
            frame.order.note_flat();
            match in_views && frame.order.is_behind() {
                true if facts.fills => frame.backdrop_lens(facts).map_or(DrawClass::Behind, DrawClass::Backdrop),
                true => DrawClass::Behind,
                false => DrawClass::Flat,
            }
        }
    }
}

/// Writes the view constants of a group and the parameters of its draws. `of_views`: the
/// reprojection matrices, if the group is in views.
fn write(
    device: &Device,
    group: &mut DrawGroup,
    outcome: DrawClass,
    of_views: Option<&Vec<ReprojectionMatrix>>,
    chunks: &[ConstantChunk],
) {
    let mut in_sight = 1 << 63;
    let mut slot = |index: u32, reprojection: &ReprojectionMatrix, lens: Option<&LensConstants>| {
        if reprojection != &OUT_OF_SIGHT {
            in_sight |= 1u64.checked_shl(index).unwrap_or(0);
        }
        if let Some(chunk) = chunks.get(group.constants.chunk) {
            chunk.write(
                group.constants.slot(index),
                &reprojection.to_array(),
                lens.map(LensConstants::to_array).as_ref(),
            );
        }
    };
    let views = &group.layout.views;
    let covers = matches!(outcome, DrawClass::Screen | DrawClass::Backdrop(_));
    for (index, view) in views.iter().enumerate().filter(|_| group.facts.in_views) {
        let lens = group.layout.lenses.get(index);
        let at = index as u32;
        match of_views.and_then(|of_views| of_views.get(index)) {
            _ if view.own_lens || covers => slot(at, &IDENTITY, None),
            Some(reprojection) if group.facts.y_up => slot(at, reprojection, lens),
            Some(reprojection) => slot(at, &reprojection.y_down(), lens.map(LensConstants::y_down).as_ref()),
            None => slot(at, &OUT_OF_SIGHT, None),
        }
    }
    let panel = group.slots() - 2;
    slot(panel, if outcome == DrawClass::Flat && group.is_on_panel() { &IDENTITY } else { &OUT_OF_SIGHT }, None);
    slot(panel + 1, &IDENTITY, None);
    group.in_sight = in_sight;
    write_places(device, group, chunks);
    group.indirect.iter().for_each(|indirect| indirect.write(chunks, group.slots(), |slot| group.is_in_sight(slot)));
}

/// Writes, for each slot of a group, the conversion from its fragments to the program's window.
fn write_places(device: &Device, group: &DrawGroup, chunks: &[ConstantChunk]) {
    let (Some(viewport), Some(chunk)) = (group.facts.viewport, chunks.get(group.constants.chunk)) else { return };
    let window = group.layout.window.1 as i32;
    let own = |rect: AtlasRect| ToWindow::of_tile(rect.into(), 0);
    let pictures = &group.facts.pictures;
    let write = |slot: u32, to_window: &ToWindow, factors: &[[f32; 4]]| {
        let place = group.constants.slot(slot) + device.view_constants.to_window_offset();
        chunk.write_to_window(place, to_window);
        chunk.write_factors(place, factors);
    };
    let same = vec![[1.0; 4]; pictures.len()];
    for (slot, view) in (0..).zip(&group.layout.views).take(group.slots() as usize - 2) {
        let in_view = || ToWindow::of_view(view.rect.into(), viewport, window, 0);
        match view.own_lens {
            true => write(slot, &own(view.rect), &same),
            false => {
                let of_view = |shown: &Option<ShownLayout>| match shown {
                    Some(ShownLayout(shown)) => factors(shown, slot as usize, group.layout.window),
                    None => [1.0; 4],
                };
                write(slot, &in_view(), &pictures.iter().map(of_view).collect::<Vec<_>>());
            }
        }
    }
    write(group.slots() - 2, &own(group.layout.panel), &same);
    write(group.slots() - 1, &own(group.layout.primary.unwrap_or(group.layout.panel)), &same);
}

/// Returns the factors for a view of an image that is drawn with the layout `shown`: first from
/// texels of the program's image to texels of the view's, then from pixels of the draw's target to
/// texels of the program's image.
fn factors(shown: &AtlasLayout, view: usize, target: (u32, u32)) -> [f32; 4] {
    let Some(AtlasRect { width, height, .. }) = shown.views.get(view).map(|view| view.rect) else { return [1.0; 4] };
    let part = |of: f64, whole: u32| of / f64::from(whole.max(1));
    let (across, down) = shown.window;
    let [x, y] = [part(width.into(), across), part(height.into(), down)];
    single::values([x, y, part(across.into(), target.0), part(down.into(), target.1)])
}

#[cfg(test)]
mod tests {
    use super::{IDENTITY, OUT_OF_SIGHT};
    use crate::correct::projected::matrices::ReprojectionMatrix;

    /// The shader's formula.
    fn apply(matrix: &ReprojectionMatrix, clip: [f32; 4]) -> [f32; 4] {
        let rows = matrix.to_array();
        let [x, y, z, w] = clip;
        let q = z + rows[12] * w;
        let dot = |row: usize| rows[row] * x + rows[row + 1] * y + rows[row + 2] * w + rows[row + 3] * q;
        let (x, y, new_w) = (dot(0), dot(4), dot(8));
        let depth = rows[13] * (q - rows[12] * new_w) + rows[14] * new_w;
        [x, y, if z == w { new_w } else { depth }, new_w]
    }

    #[test]
    fn the_identity_changes_no_bit_and_the_other_leaves_nothing_in_sight() {
        for clip in [[0.3, -0.7, 0.1, 2.5], [1e-30, 7.5e8, -3.0, -1.25], [0.0, 0.0, 1.0, 1.0]] {
            assert_eq!(apply(&IDENTITY, clip), clip);
            let [x, _, _, w] = apply(&OUT_OF_SIGHT, clip);
            assert!(x > w || x < -w || w < 0.0, "{clip:?}");
        }
    }
}
