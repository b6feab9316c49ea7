//! Coarse map from parts of an output to the parts of the views that they sample. With it, only the
//! parts whose texels were drawn are corrected.

use crate::correct::LowerLeftRect;
use crate::correct::passes::output_pass::{OutputPass, Plan};
use crate::correct::passes::source::Source;
use crate::rig::Flip;
use crate::views::View;
use glam::{DVec2, DVec3};

/// Number of cells of an output, across and down.
const CELLS: u32 = 24;
/// Number of samples of a cell, across and down, including its borders.
const SAMPLES: u32 = 5;
/// Number of samples of an output, across and down.
const SIDE: u32 = CELLS * (SAMPLES - 1) + 1;

/// Rectangle of texels of the atlas, from the bottom left.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TexelSpan {
    /// First column.
    pub left: i32,
    /// First row.
    pub bottom: i32,
    /// First column beyond it.
    pub right: i32,
    /// First row beyond it.
    pub top: i32,
}

impl TexelSpan {
    /// No texels.
    pub const NOTHING: Self = Self { left: i32::MAX, bottom: i32::MAX, right: i32::MIN, top: i32::MIN };
    /// All texels.
    pub const EVERYTHING: Self = Self { left: i32::MIN, bottom: i32::MIN, right: i32::MAX, top: i32::MAX };

    /// True if the span has no texels.
    pub fn is_empty(&self) -> bool {
        self.left >= self.right || self.bottom >= self.top
    }

    /// True if both spans have a texel in common.
    pub fn meets(&self, other: &Self) -> bool {
        self.left < other.right && other.left < self.right && self.bottom < other.top && other.bottom < self.top
    }

    /// Returns the smallest span that contains both.
    pub fn union(&self, other: &Self) -> Self {
        Self {
            left: self.left.min(other.left),
            bottom: self.bottom.min(other.bottom),
            right: self.right.max(other.right),
            top: self.top.max(other.top),
        }
    }
}

/// Texels of a view that a cell samples.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Part {
    /// Column and row of the cell, from the top left.
    place: [u32; 2],
    view: usize,
    texels: TexelSpan,
}

/// Texels that the cells of one output sample.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Footprints {
    size: (u32, u32),
    flip: Flip,
    parts: Vec<Part>,
}

/// Returns the footprints of the output `pass`, which samples `views` of the plan. `None` for
/// outputs whose map may jump (tables, pictures of several faces).
pub fn footprints(plan: &Plan, pass: &OutputPass, views: &[usize]) -> Option<Footprints> {
    match pass.source {
        Source::Fisheye { .. } | Source::Projector(_) | Source::Optics(_) | Source::Perspective { .. } => {}
        Source::Panorama { .. } | Source::Table(_) => return None,
    }
    // Draws into a view with projected vertices have no known bounds.
    if views.iter().any(|&view| plan.views.views.get(view).is_some_and(|view| view.curved.is_some())) {
        return None;
    }
    // Neighbouring cells share their borders, and all views the directions.
    let lattice: Vec<Option<DVec3>> =
        (0..SIDE * SIDE).map(|number| direction(pass, [number % SIDE, number / SIDE])).collect();
    let mut parts = Vec::new();
    for place in (0..CELLS * CELLS).map(|cell| [cell % CELLS, cell / CELLS]) {
        for &view in views {
            let Some(shown) = plan.views.views.get(view) else { continue };
            if let Some(texels) = part(plan, &lattice, shown, place) {
                parts.push(Part { place, view, texels });
            }
        }
    }
    Some(Footprints { size: pass.size, flip: pass.flip, parts })
}

/// Returns the direction of a place of the lattice of samples, counted from the top left.
fn direction(pass: &OutputPass, place: [u32; 2]) -> Option<DVec3> {
    let at = |place: u32, length: u32| f64::from(place) / f64::from(SAMPLES - 1) * f64::from(length) / f64::from(CELLS);
    let (x, y) = pass.source.normalised(pass.size, at(place[0], pass.size.0), at(place[1], pass.size.1));
    pass.source.direction(x, y)
}

/// Returns the texels of a view that the cell at `place` may sample: those around its samples,
/// widened by the distance of neighbouring samples.
fn part(plan: &Plan, lattice: &[Option<DVec3>], view: &View, place: [u32; 2]) -> Option<TexelSpan> {
    let tile = &view.tile;
    let (low, size) =
        (DVec2::new(f64::from(tile.x), f64::from(tile.y)), DVec2::new(f64::from(tile.width), f64::from(tile.height)));
    let mut seen = [[None; SAMPLES as usize]; SAMPLES as usize];
    for (row, line) in seen.iter_mut().enumerate() {
        for (column, found) in line.iter_mut().enumerate() {
            let [x, y] = [(0, column), (1, row)].map(|(axis, step)| place[axis] * (SAMPLES - 1) + step as u32);
            *found = lattice[(y * SIDE + x) as usize].map(|direction| view.rotation * direction).and_then(|v| {
                let tangent = DVec2::new(v.x, v.y) / -v.z;
                let corner = DVec2::new(view.frustum.left, view.frustum.bottom);
                let part = (tangent - corner) / DVec2::new(view.frustum.width(), view.frustum.height());
                let near = v.z < 0.0 && part.min_element() > -0.5 && part.max_element() < 1.5;
                near.then(|| low + part * size)
            });
        }
    }
    let all = || seen.iter().flatten().flatten();
    let least = all().copied().reduce(DVec2::min)?;
    let greatest = all().copied().reduce(DVec2::max)?;
    let mut step: f64 = 0.0;
    for row in 0..SAMPLES as usize {
        for column in 0..SAMPLES as usize {
            for (r, c) in [(row + 1, column), (row, column + 1)] {
                let next = seen.get(r).and_then(|line| line.get(c)).copied().flatten();
                if let (Some(a), Some(b)) = (seen[row][column], next) {
                    step = step.max((a - b).abs().max_element());
                }
            }
        }
    }
    // If only some samples are in the view, the places between them are uncertain.
    let partly = all().count() < (SAMPLES * SAMPLES) as usize;
    let apart = if partly { 2.0 * step + 0.1 * size.max_element() } else { step };
    let around = DVec2::splat(apart + f64::from(plan.views.guard) + 2.0);
    let (from, to) = ((least - around).max(low), (greatest + around).min(low + size));
    (from.x < to.x && from.y < to.y).then(|| TexelSpan {
        left: from.x.floor() as i32,
        bottom: from.y.floor() as i32,
        right: to.x.ceil() as i32,
        top: to.y.ceil() as i32,
    })
}

impl Footprints {
    /// Returns a rectangle of the output; no pixel outside it samples a touched texel. `touched`:
    /// the touched texels of each view, by index; views beyond the list are touched everywhere.
    pub fn sampling(&self, touched: &[TexelSpan]) -> LowerLeftRect {
        let (mut low, mut high) = ([CELLS; 2], [0; 2]);
        for part in &self.parts {
            if touched.get(part.view).is_none_or(|texels| texels.meets(&part.texels)) {
                for k in 0..2 {
                    low[k] = low[k].min(part.place[k]);
                    high[k] = high[k].max(part.place[k] + 1);
                }
            }
        }
        if low[0] >= high[0] {
            return LowerLeftRect::default();
        }
        // One more cell on each side: the samples may have missed pixels at a rim.
        let from = |cell: u32, length: u32| cell.saturating_sub(1) * length / CELLS;
        let to = |cell: u32, length: u32| (cell + 1).min(CELLS) * length / CELLS;
        let (width, height) = self.size;
        let (left, right) = (from(low[0], width), to(high[0], width));
        let (top, bottom) = (from(low[1], height), to(high[1], height));
        let x = if self.flip.horizontal { width - right } else { left };
        let y = if self.flip.vertical { top } else { height - bottom };
        LowerLeftRect::new(x as i32, y as i32, (right - left) as i32, (bottom - top) as i32)
    }
}

#[cfg(test)]
mod tests {
    use super::{TexelSpan, footprints};
    use crate::correct::passes::output_pass::Plan;
    use crate::correct::plan::builder::build;
    use crate::geom::LowerLeftRect;
    use crate::rig;
    use crate::testing::random::Random;
    use crate::views::Request;
    use std::path::Path;

    fn planned(text: &str, size: (u32, u32)) -> Plan {
        let rig = rig::parse(text, "test.toml", Path::new("")).expect("valid");
        let sizes = vec![size; rig.outputs.len()];
        let request = Request { output_sizes: sizes, window: size, panel: false, primary: false, max_atlas: 8192 };
        build(&rig, &request).expect("can be planned")
    }

    const DOME: &str = "[dome]\ntilt = 90\n[[output]]\nkind = \"domemaster\"\ntilt = 90\n";
    const PROJECTOR: &str =
        "[[output]]\nkind = \"projector\"\nposition = [0.5, 1.0, 3.0]\nyaw = 20\nroll = 12\nfov = [70, 50]\n";
    const FLAT: &str = "[[output]]\nkind = \"perspective\"\nyaw = 30\npitch = 20\nroll = 30\nfov = [90, 60]\n";

    /// Every pixel that samples a touched texel lies in the rectangle.
    #[test]
    fn no_pixel_outside_samples_what_was_touched() {
        let mut random = Random::new(7);
        for (text, size) in [(DOME, (300, 300)), (DOME, (1000, 700)), (PROJECTOR, (400, 300)), (FLAT, (333, 222))] {
            let plan = planned(text, size);
            let (pass, views) = (&plan.passes[0], &plan.views.output_views[0]);
            let footprints = footprints(&plan, pass, views).expect("smooth");
            let mut narrowed = 0;
            for _ in 0..60 {
                let view = views[(random.unit() * views.len() as f64) as usize];
                let mut touched = vec![TexelSpan::NOTHING; plan.views.views.len()];
                let tile = plan.views.views[view].tile;
                let (x, y) = (random.unit() * f64::from(tile.width), random.unit() * f64::from(tile.height));
                let (x, y) = (tile.x as i32 + x as i32, tile.y as i32 + y as i32);
                touched[view] = TexelSpan { left: x, bottom: y, right: x + 9, top: y + 5 };
                let LowerLeftRect { x: left, y: bottom, width, height } = footprints.sampling(&touched);
                narrowed += u32::from(4 * width * height < (size.0 * size.1) as i32);
                for row in 0..size.1 {
                    for column in 0..size.0 {
                        let inside = (left..left + width).contains(&(column as i32))
                            && (bottom..bottom + height).contains(&((size.1 - 1 - row) as i32));
                        if inside {
                            continue;
                        }
                        let (u, v) = pass.source.normalised(size, f64::from(column) + 0.5, f64::from(row) + 0.5);
                        let Some(direction) = pass.source.direction(u, v) else { continue };
                        let shown = &plan.views.views[view];
                        let seen = shown.rotation * direction;
                        let part = [
                            (seen.x / -seen.z - shown.frustum.left) / shown.frustum.width(),
                            (seen.y / -seen.z - shown.frustum.bottom) / shown.frustum.height(),
                        ];
                        let at = [
                            f64::from(tile.x) + part[0] * f64::from(tile.width),
                            f64::from(tile.y) + part[1] * f64::from(tile.height),
                        ];
                        let reads = seen.z < 0.0
                            && (f64::from(x) - 2.0..f64::from(x) + 11.0).contains(&at[0])
                            && (f64::from(y) - 2.0..f64::from(y) + 7.0).contains(&at[1])
                            && part.iter().all(|p| (0.0..=1.0).contains(p));
                        assert!(!reads, "{text}: pixel {column}, {row} reads {at:?} of {:?}", touched[view]);
                    }
                }
            }
            assert!(narrowed > 20, "{text}: only {narrowed} of 60 are small");
        }
    }

    #[test]
    fn nothing_touched_needs_nothing_and_everything_everything() {
        let plan = planned(DOME, (300, 300));
        let footprints = footprints(&plan, &plan.passes[0], &plan.views.output_views[0]).expect("smooth");
        assert_eq!(footprints.sampling(&[TexelSpan::NOTHING; 8]), LowerLeftRect::default());
        assert_eq!(footprints.sampling(&[]), LowerLeftRect::new(0, 0, 300, 300));
        let table = planned("[[output]]\nkind = \"equirectangular\"\n", (200, 100));
        assert!(super::footprints(&table, &table.passes[0], &table.views.output_views[0]).is_none());
    }
}
