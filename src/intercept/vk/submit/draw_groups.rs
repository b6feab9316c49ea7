//! Runs of draws that share a lens: where the lens is found, and the rows that it gives each view.
//!
//! A command buffer may be recorded long before its uniform blocks are filled, and run many times. So what a draw
//! is (scene or flat, and with which lens) is decided when the command buffer is submitted, and the rows that
//! shaders read decide what is seen: a draw that does not belong to a view is moved out of its sight.

use crate::correct::projected::matrices;
use crate::correct::projected::y_down::{lens_down, rows_down};
use crate::intercept::camera::Cameras;
use crate::intercept::lens;
use crate::intercept::scene::frame_order::FrameOrder;
use crate::intercept::vk::commands::indirect::Placed;
use crate::intercept::vk::commands::recording::{Event, Recording};
use crate::intercept::vk::layer::device::Device;
use crate::intercept::vk::queries::running::{Running, Worth};
use crate::intercept::vk::spirv::{Matrix, Memory};
use crate::intercept::vk::submit::view_constants::{Piece, Place};
use crate::intercept::vk::swapchain::atlas_layout::Layout;
use crate::runtime::session::Intrinsics;
use ash::vk;
use std::collections::BTreeMap;
use std::sync::{Arc, PoisonError};

/// Rows that change nothing, to the bit.
const IDENTITY: [f32; 16] = [1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 0.0, 0.0];

/// Rows that move everything to the right of what is seen: x' = 2w, w' = w.
const OUT_OF_SIGHT: [f32; 16] = [0.0, 0.0, 2.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 0.0, 0.0];

/// Where a matrix is, or what it is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Value {
    /// Its numbers as they are in memory, column by column.
    Known([f32; 16]),
    /// In a buffer, at an offset.
    Buffer(vk::Buffer, u64),
}

/// A matrix that may be the projection.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Source {
    /// How a shader sees it.
    pub matrix: Matrix,
    /// Where it is.
    pub value: Value,
}

/// What a run turned out to be.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Outcome {
    Scene(Intrinsics),
    Flat,
    Behind,
    /// A picture of the scene over the whole of each view.
    Screen,
}

/// What draws of a run have in common.
#[derive(Clone, Debug, PartialEq)]
pub struct Kind {
    /// Where the lens may be, the likeliest first.
    pub sources: Vec<Source>,
    /// Clip coordinates have y up (a viewport of negative height), not down.
    pub y_up: bool,
    /// They are issued to the views as well as onto the panel.
    pub in_views: bool,
    /// They draw to an image that holds a scene on its way to the window.
    pub off_screen: bool,
    /// They are tested by their depth: without a matrix that can be read they may have the lens that the rig gives.
    pub deep: bool,
    /// Where they are flat they bring the scene out of such an image, over all of the picture.
    pub screen: bool,
}

/// Draws that share a lens.
pub struct Run {
    /// Where their rows are.
    pub place: Place,
    /// Where the views are.
    pub layout: Arc<Layout>,
    /// What they are.
    pub kind: Kind,
    /// How many draws.
    pub draws: u64,
    /// Those of them that are left out where they are out of sight.
    pub placed: Vec<Placed>,
    /// With which groups of rows it is in sight, bit by bit; groups from 63 on always are.
    in_sight: u64,
    /// What was written last, and for which matrices.
    last: Option<Outcome>,
    matrices: Vec<(u8, [f64; 16])>,
    lens: Option<(Intrinsics, &'static str)>,
}

impl Run {
    /// Draws that are recorded now.
    pub fn new(place: Place, layout: Arc<Layout>, kind: Kind) -> Self {
        Self {
            place,
            layout,
            kind,
            draws: 0,
            placed: Vec::new(),
            in_sight: 0,
            last: None,
            matrices: Vec::new(),
            lens: None,
        }
    }

    /// How many groups of rows it has: for the views, the panel, and the program's own picture.
    fn groups(&self) -> u32 {
        2 + if self.kind.in_views { self.layout.views.len() as u32 } else { 0 }
    }

    /// Whether something of it may be seen with a group of rows.
    fn is_in_sight(&self, group: u32) -> bool {
        self.in_sight >> group.min(63) & 1 == 1
    }

    /// Whether draws are issued onto the panel: where the program's own lens shows everything there is none.
    pub fn is_on_panel(&self) -> bool {
        !self.kind.off_screen && !self.layout.shows_own_lens()
    }

    /// With how many groups draws are issued, and with how many of these they are in sight.
    fn times(&self) -> [u32; 2] {
        let (panel, own) = (self.groups() - 2, self.groups() - 1);
        let panel = self.is_on_panel().then_some(panel);
        let issued = (0..self.groups() - 2).chain(panel).chain(self.layout.primary.map(|_| own));
        [issued.clone().count(), issued.filter(|group| self.is_in_sight(*group)).count()].map(|times| times as u32)
    }

    /// Whether a draw of this kind belongs to it.
    pub fn takes(&self, layout: &Arc<Layout>, kind: &Kind) -> bool {
        Arc::ptr_eq(&self.layout, layout) && self.kind == *kind
    }
}

/// What is counted for the statistics.
#[derive(Clone, Debug, Default)]
pub struct Counts {
    /// Draws of the program to its window.
    pub seen: u64,
    /// Those that are flat.
    pub flat: u64,
    /// Those that were issued to each view.
    pub in_views: u64,
    /// Those of them that went to pictures of the scene that are drawn off screen.
    pub duplicated: u64,
    /// How often one was left out of a view or the panel, because it is out of sight there.
    pub left_out: u64,
    /// How the lens was found.
    pub found: BTreeMap<&'static str, u64>,
}

/// The frame that is being submitted.
#[derive(Default)]
pub struct Frame {
    cameras: Cameras,
    layout: Option<Arc<Layout>>,
    /// Rows that show the panel in each view, for flat drawing behind the scene.
    behind: Vec<[f32; 16]>,
    /// The lens for which it was last found out how many samples show what it sees, and how many.
    sampled: Option<(Intrinsics, f64)>,
    order: FrameOrder,
    /// What was counted.
    pub counts: Counts,
}

impl Frame {
    /// A frame ended.
    pub fn end(&mut self) {
        self.order.end_frame();
        self.cameras.end_frame();
    }

    fn follow(&mut self, layout: &Arc<Layout>) {
        if self.layout.as_ref().is_none_or(|known| !Arc::ptr_eq(known, layout)) {
            self.layout = Some(Arc::clone(layout));
            self.cameras.clear();
            self.sampled = None;
            self.behind = layout.session.panel_rows().iter().map(matrices::clip_rows).collect();
        }
    }
}

impl Frame {
    /// How many samples of all views show what a lens sees; `own`: how many the program's own picture has.
    fn samples(&mut self, lens: &Intrinsics, layout: &Layout, own: f64) -> f64 {
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

/// A matrix out of memory.
pub fn matrix(device: &Device, source: &Source) -> Option<[f64; 16]> {
    let raw = match source.value {
        Value::Known(raw) => raw,
        Value::Buffer(buffer, offset) => {
            let stride = source.matrix.stride as usize;
            let mut bytes = [0; 256];
            let bytes = bytes.get_mut(..3 * stride + 16)?;
            if !device.memory_of_program.read(buffer, offset, bytes) {
                return None;
            }
            from_bytes(bytes, stride)?
        }
    };
    let value = raw.map(f64::from);
    Some(if source.matrix.row_major { lens::transposed(&value) } else { value })
}

/// Sixteen floats, four by four.
pub fn from_bytes(bytes: &[u8], stride: usize) -> Option<[f32; 16]> {
    let mut raw = [0.0; 16];
    for (i, value) in raw.iter_mut().enumerate() {
        let at = i / 4 * stride + i % 4 * 4;
        *value = f32::from_ne_bytes(bytes.get(at..at + 4)?.try_into().ok()?);
    }
    Some(raw)
}

/// A command buffer is submitted: what it draws gets its rows.
pub fn submitted(device: &Device, recording: &mut Recording) {
    run_events(device, recording, &mut Vec::new());
}

/// [`submitted`], while `queries` run.
fn run_events(device: &Device, recording: &mut Recording, queries: &mut Vec<Running>) {
    let Recording { events, runs, rows, .. } = recording;
    for event in events.iter() {
        match event {
            Event::Run(index) => {
                if let Some(run) = runs.get_mut(*index) {
                    resolve(device, run, &rows.pieces);
                }
            }
            Event::Copy(from, to, region) => device.memory_of_program.copied(*from, *to, region),
            Event::Update(buffer, offset, bytes) => device.memory_of_program.written(*buffer, *offset, bytes.clone()),
            Event::Execute(other) => {
                device.recordings.with(*other, |other| run_events(device, other, queries));
            }
            Event::Drawn(shown, in_views) => {
                crate::intercept::vk::offscreen::images::drawn(shown, *in_views);
                if device.images.is_retired(shown) && shown.was_missed() {
                    device.give_up("the commands that draw its scene were recorded before its views changed");
                }
            }
            Event::Suspected(targets, sources) => {
                crate::intercept::vk::offscreen::scene_graph::ran(device, targets, sources)
            }
            Event::BeginQuery(pool, query) => queries.push(Running::new(Arc::clone(pool), *query)),
            Event::EndQuery(pool, query) => {
                let ended = queries.iter().position(|running| running.is(pool, *query));
                ended.into_iter().for_each(|index| queries.swap_remove(index).end(device));
            }
            Event::Counted { run, vertices, times } => {
                let run = run.and_then(|index| runs.get(index)).filter(|_| !queries.is_empty());
                let worth = run.map_or(Worth::ONCE, |run| worth(device, run));
                let times = times.or_else(|| run.map(|run| run.times()[1])).unwrap_or(1);
                queries.iter_mut().for_each(|running| running.add(worth, *vertices, times));
            }
        }
    }
}

/// What samples of a run's draws are worth in the program's own picture, where what fills that picture counts as many as
/// it has.
fn worth(device: &Device, run: &Run) -> Worth {
    let mut frame = device.frame.lock().unwrap_or_else(PoisonError::into_inner);
    frame.follow(&run.layout);
    let layout = &run.layout;
    let area = |width: f64, height: f64| width * height;
    let own = area(layout.window.0.into(), layout.window.1.into());
    // In pictures with the program's own lens everything is seen once more.
    let views = if run.kind.in_views { &layout.views[..] } else { &[] };
    let repeated = f64::from(u8::from(layout.primary.is_some()));
    let same = repeated + views.iter().filter(|(_, own_lens)| *own_lens).count() as f64;
    let seen = match run.last {
        Some(Outcome::Scene(lens)) => repeated + frame.samples(&lens, layout, own) / own,
        Some(Outcome::Screen) => {
            repeated + views.iter().map(|(tile, _)| area(tile[2].into(), tile[3].into())).sum::<f64>() / own
        }
        Some(Outcome::Flat) if !run.kind.off_screen && !layout.shows_own_lens() => same + 1.0,
        // At the panel's place in the views, which is about as large as the panel.
        _ => same.max(1.0),
    };
    Worth { factor: 1.0 / seen, of_scene: !matches!(run.last, Some(Outcome::Flat)) }
}

/// Finds out what a run is, and writes its rows, and what is drawn with them, into the `pieces` of its command buffer.
fn resolve(device: &Device, run: &mut Run, pieces: &[Piece]) {
    let mut frame = device.frame.lock().unwrap_or_else(PoisonError::into_inner);
    frame.follow(&run.layout);
    let ranked = |source: &Source| matrix(device, source).map(|value| (source.matrix.rank, value));
    let kind = &run.kind;
    let matrices: Vec<_> = kind.sources.iter().filter_map(ranked).collect();
    if matrices != run.matrices {
        run.lens = lens::find(matrices.iter().map(|(rank, value)| (*rank, value)));
        run.matrices = matrices;
    }
    if run.matrices.is_empty() && kind.deep {
        run.lens = run.layout.session.given_lens().map(|lens| (lens, "the rig's lens"));
    }
    frame.counts.seen += run.draws;
    let in_views = kind.in_views && device.draws_views();
    let outcome = match run.lens.filter(|_| in_views) {
        Some((intrinsics, how)) => {
            frame.order.note_scene();
            *frame.counts.found.entry(how).or_default() += run.draws;
            Outcome::Scene(intrinsics)
        }
        None if kind.screen && in_views => {
            frame.order.note_scene();
            Outcome::Screen
        }
        // What is flat in a picture of the scene has no other place than the views.
        None if kind.off_screen => Outcome::Behind,
        None => {
            frame.counts.flat += run.draws;
            frame.order.note_flat();
            let behind = in_views && frame.order.is_behind();
            if behind { Outcome::Behind } else { Outcome::Flat }
        }
    };
    frame.counts.in_views += if outcome == Outcome::Flat { 0 } else { run.draws };
    frame.counts.duplicated += if kind.off_screen { run.draws } else { 0 };
    if run.last != Some(outcome) {
        run.last = Some(outcome);
        let camera = match outcome {
            Outcome::Scene(intrinsics) => Some(frame.cameras.index(&intrinsics, &run.layout.session)),
            _ => None,
        };
        let rows = match camera {
            Some(index) => frame.cameras.get(index).map(|camera| &camera.rows),
            None => (outcome == Outcome::Behind).then_some(&frame.behind),
        };
        write(device, run, outcome, rows, pieces);
    }
    if !run.placed.is_empty() {
        let [issued, in_sight] = run.times();
        frame.counts.left_out += run.placed.len() as u64 * u64::from(issued - in_sight);
    }
}

/// Writes the rows of a run, `of_views` where it is in views, and its draws' parameters.
fn write(device: &Device, run: &mut Run, outcome: Outcome, of_views: Option<&Vec<[f32; 16]>>, pieces: &[Piece]) {
    let mut in_sight = 1 << 63;
    let mut group = |index: u32, rows: &[f32; 16], lens: Option<&[f32; 16]>| {
        if rows != &OUT_OF_SIGHT {
            in_sight |= 1u64.checked_shl(index).unwrap_or(0);
        }
        if let Some(piece) = pieces.get(run.place.piece) {
            piece.write(run.place.offset + index * device.group_stride(), rows, lens);
        }
    };
    let views = &run.layout.views;
    for (index, (_, own_lens)) in views.iter().enumerate().filter(|_| run.kind.in_views) {
        let lens = run.layout.lenses.get(index);
        let at = index as u32;
        match of_views.and_then(|rows| rows.get(index)) {
            _ if *own_lens || outcome == Outcome::Screen => group(at, &IDENTITY, None),
            Some(rows) if run.kind.y_up => group(at, rows, lens),
            Some(rows) => group(at, &rows_down(rows), lens.map(lens_down).as_ref()),
            None => group(at, &OUT_OF_SIGHT, None),
        }
    }
    let panel = run.groups() - 2;
    group(panel, if outcome == Outcome::Flat && run.is_on_panel() { &IDENTITY } else { &OUT_OF_SIGHT }, None);
    group(panel + 1, &IDENTITY, None);
    run.in_sight = in_sight;
    run.placed.iter().for_each(|placed| placed.write(pieces, run.groups(), |group| run.is_in_sight(group)));
}

/// Where a shader's matrix is, with the descriptors and push constants that are bound.
pub fn source(device: &Device, recording: &Recording, matrix: &Matrix) -> Option<Source> {
    let value = match matrix.memory {
        Memory::Push => {
            Value::Known(from_bytes(recording.push.get(matrix.offset as usize..)?, matrix.stride as usize)?)
        }
        Memory::Buffer { set, binding } => {
            let bound = recording.bound.get(set as usize)?.as_ref()?;
            let (buffer, offset) = bound.buffer(device, binding)?;
            Value::Buffer(buffer, offset + u64::from(matrix.offset))
        }
    };
    Some(Source { matrix: *matrix, value })
}

#[cfg(test)]
mod tests {
    use super::{IDENTITY, OUT_OF_SIGHT, from_bytes};

    /// The shader's formula.
    fn apply(rows: &[f32; 16], clip: [f32; 4]) -> [f32; 4] {
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

    #[test]
    fn numbers_are_read_by_their_stride() {
        let mut bytes = vec![0; 3 * 32 + 16];
        bytes[2 * 32 + 4..2 * 32 + 8].copy_from_slice(&7f32.to_ne_bytes());
        assert_eq!(from_bytes(&bytes, 32).map(|m| m[9]), Some(7.0));
        assert_eq!(from_bytes(&bytes[..90], 32), None);
    }
}
