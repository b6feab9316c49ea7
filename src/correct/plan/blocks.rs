//! Which rectangles of an output can be drawn by which shader.
//!
//! An output is cut into blocks. What a block needs is read off its corners where that is safe, and
//! found pixel by pixel where it is not.

use crate::cache::Cache;
use crate::correct::passes::mask::Mask;
use crate::correct::passes::output_pass::Batch;
use crate::correct::passes::source::Source;
use crate::correct::plan::needs::{self, Needs};
use crate::correct::plan::rectangles::{self, BLOCK};
use crate::geom::screen::Bounds;
use crate::geom::{Frustum, Panorama, QuadraticForm};
use crate::rig::{Filter, Flip, Rig};
use crate::views::sampling::cone::{Cone, Relation, WIDEST, diameter};
use crate::views::{View, ViewPlan};
use glam::{DMat3, DVec2, DVec3};

/// At most so many batches of an output differ only in their neighbours and in the view that they
/// sample.
const MOST_OVERLAPS: usize = 6;
/// Of these, each has at least this part of the blocks where pictures overlap: a shader for fewer
/// costs more time to compile than it saves.
const LEAST_PART: f64 = 0.02;
/// And so many blocks: a shader where pictures overlap takes a software driver a tenth of a second
/// to compile, for which so few blocks (12,288 pixels at about a nanosecond) would have to be drawn
/// eight thousand times.
const LEAST_BLOCKS: usize = 48;

/// A class of blocks that share a shader.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Class {
    /// One view everywhere.
    Plain(u32),
    /// Several views.
    Mixed,
    /// These neighbours overlap; in one view everywhere, or else in several.
    Overlap { neighbours: u128, view: Option<u32> },
    /// Some pixels show nothing.
    Edge,
    /// Some pixels show nothing, and pictures overlap.
    EdgeOverlap,
}

/// Properties of an output's picture that the rig does not say.
pub(in crate::correct) struct Picture<'a> {
    /// Its map.
    pub source: &'a Source,
    /// Width and height in pixels.
    pub size: (u32, u32),
    /// Its weight image.
    pub mask: Option<&'a Mask>,
    /// Mirroring of the finished picture.
    pub flip: Flip,
}

/// The batches of output `index` of `rig`.
///
/// Conservative: a batch lists every view that answers for one of its pixels' centres, and every
/// neighbour whose picture reaches into it (up to a part of a pixel, where its weight is nil);
/// blocks that show nothing are in none, nor those that the mask makes black. `cache` may know what
/// blocks need, or keeps it.
pub(in crate::correct) fn batches(
    rig: &Rig,
    index: usize,
    picture: &Picture<'_>,
    plan: &ViewPlan,
    cache: &Cache,
) -> Vec<Batch> {
    let Picture { source, size, mask, flip } = *picture;
    let output_views = &plan.output_views[index];
    let examiner = Examiner::new(rig, source, size, plan, output_views, flip);
    let views: Vec<&View> = output_views.iter().map(|&view| &plan.views[view]).collect();
    let key = (source, size, examiner.filter, flip, &views);
    let mut needs = needs::cached(&key, examiner.blocks(), cache, || examiner.all());
    // With light added to black, what is masked is not black.
    let output = &rig.outputs[index];
    let darkening = mask.filter(|_| output.blend.black_level == 0.0 && output.black.is_none());
    if let Some(mask) = darkening {
        needs_of_masked(&mut needs, mask, size);
    }
    let classes: Vec<Option<Class>> = needs.iter().map(classify).collect();
    let classes = with_fewer_overlaps(classes);

    // Where a mask is white it is not looked at.
    let faded = |index: usize| mask.is_some_and(|mask| !mask.is_white(block_at(index, size), size));
    let mut distinct: Vec<(Class, bool)> = Vec::new();
    let mut united: Vec<Needs> = Vec::new();
    let numbered: Vec<Option<usize>> = needs
        .iter()
        .zip(&classes)
        .enumerate()
        .map(|(index, (needs, class))| {
            let class = ((*class)?, faded(index));
            let index = distinct.iter().position(|other| *other == class).unwrap_or_else(|| {
                distinct.push(class);
                united.push(Needs::default());
                distinct.len() - 1
            });
            united[index] = united[index].and(needs);
            Some(index)
        })
        .collect();
    let mut rects = rectangles::merge(&numbered, BLOCK, size, distinct.len());
    if let Some(mask) = darkening {
        let faded = rects.iter_mut().zip(&distinct).filter(|(_, (_, faded))| *faded);
        faded.flat_map(|(rects, _)| rects).for_each(|rect| *rect = mask.trimmed(*rect, size));
    }
    let neighbours = examiner.neighbours.len();
    united
        .into_iter()
        .zip(&distinct)
        .zip(rects)
        .map(|((needs, (_, masked)), rects)| Batch {
            views: (0..output_views.len())
                .filter(|&bit| needs.views >> bit.min(63) & 1 == 1)
                .map(|bit| output_views[bit])
                .collect(),
            neighbours: (0..neighbours).filter(|&bit| needs.neighbours >> bit.min(127) & 1 == 1).collect(),
            edge: needs.dark,
            masked: *masked,
            rects,
            facets: None,
        })
        .collect()
}

/// The block with this number, row by row.
fn block_at(index: usize, size: (u32, u32)) -> Block {
    let (columns, index) = (size.0.div_ceil(BLOCK), index as u32);
    let (x, y) = (index % columns * BLOCK, index / columns * BLOCK);
    [x, y, (x + BLOCK).min(size.0), (y + BLOCK).min(size.1)]
}

/// Takes away what blocks need whose pixels the mask makes black.
fn needs_of_masked(needs: &mut [Needs], mask: &Mask, size: (u32, u32)) {
    for (index, needs) in needs.iter_mut().enumerate() {
        if needs.lit && mask.is_black(block_at(index, size), size) {
            *needs = Needs { dark: true, ..Needs::default() };
        }
    }
}

fn classify(needs: &Needs) -> Option<Class> {
    needs.lit.then(|| match (needs.dark, needs.neighbours != 0) {
        (true, true) => Class::EdgeOverlap,
        (true, false) => Class::Edge,
        (false, true) => Class::Overlap { neighbours: needs.neighbours, view: needs.only_view() },
        (false, false) => needs.only_view().map_or(Class::Mixed, Class::Plain),
    })
}

/// Keeps the most frequent overlaps apart, since each neighbour and the choice of a view cost time
/// in every pixel, and unites the others, since each shader costs time to compile.
fn with_fewer_overlaps(mut classes: Vec<Option<Class>>) -> Vec<Option<Class>> {
    let mut overlaps: Vec<(u128, Option<u32>, usize)> = Vec::new();
    for class in &classes {
        if let Some(Class::Overlap { neighbours, view }) = *class {
            match overlaps.iter_mut().find(|entry| (entry.0, entry.1) == (neighbours, view)) {
                Some(entry) => entry.2 += 1,
                None => overlaps.push((neighbours, view, 1)),
            }
        }
    }
    overlaps.sort_by_key(|&(neighbours, view, count)| (std::cmp::Reverse(count), neighbours, view));
    let total: usize = overlaps.iter().map(|overlap| overlap.2).sum();
    let is_frequent = |count: usize| count >= LEAST_BLOCKS && count as f64 >= LEAST_PART * total as f64;
    let frequent = overlaps.iter().filter(|overlap| is_frequent(overlap.2)).count();
    let rare = &overlaps[frequent.min(MOST_OVERLAPS - 1)..];
    // The edge has a shader for all neighbours anyway: where one of the two is small, it serves
    // both.
    let edge = classes.iter().filter(|class| **class == Some(Class::EdgeOverlap)).count();
    let few: usize = rare.iter().map(|overlap| overlap.2).sum();
    let with_edge = edge > 0 && edge.min(few) < LEAST_BLOCKS;
    // Where there is one, it stays what it is.
    if rare.len() > 1 || with_edge {
        let union = rare.iter().fold(0, |union, (neighbours, ..)| union | neighbours);
        let united = if with_edge { Class::EdgeOverlap } else { Class::Overlap { neighbours: union, view: None } };
        for class in &mut classes {
            if let Some(Class::Overlap { neighbours, view }) = *class
                && rare.iter().any(|other| (other.0, other.1) == (neighbours, view))
            {
                *class = Some(united);
            }
        }
    }
    classes
}

/// Examines the blocks of one output.
pub(super) struct Examiner<'a> {
    pub(super) source: &'a Source,
    pub(super) size: (u32, u32),
    pub(super) filter: Filter,
    pub(super) flip: Flip,
    pub(super) views: Vec<Cone>,
    pub(super) neighbours: Vec<(QuadraticForm, Cone)>,
}

/// Direction and point at a corner of blocks.
#[derive(Clone, Copy, Debug, Default)]
struct Corner {
    /// Direction from the viewer, unit length, where something is shown.
    direction: Option<DVec3>,
    /// Point of the surface that a projector lights, in the surface's axes, on the screen or not.
    on_surface: Option<DVec3>,
}

/// A rectangle of pixels: left, top, right and bottom, the latter two excluded.
type Block = [u32; 4];

impl<'a> Examiner<'a> {
    pub(super) fn new(
        rig: &Rig,
        source: &'a Source,
        size: (u32, u32),
        plan: &ViewPlan,
        output_views: &[usize],
        flip: Flip,
    ) -> Self {
        let cone = |&index: &usize| Cone::of(&plan.views[index]);
        let neighbours = match source {
            Source::Projector(projector) => projector.neighbours.as_slice(),
            _ => &[],
        };
        // Picture coordinates have z > 0 in front; a cone looks along −z.
        let in_front = DMat3::from_diagonal(DVec3::new(1.0, 1.0, -1.0));
        let picture = Frustum { left: -1.0, right: 1.0, bottom: -1.0, top: 1.0 };
        Self {
            source,
            size,
            filter: rig.views.filter,
            flip,
            views: output_views.iter().map(cone).collect(),
            neighbours: neighbours.iter().map(|neighbour| (neighbour.picture, Cone::new(in_front, &picture))).collect(),
        }
    }

    /// Returns the number of blocks.
    pub(super) fn blocks(&self) -> usize {
        self.size.0.div_ceil(BLOCK) as usize * self.size.1.div_ceil(BLOCK) as usize
    }

    /// Returns the needs of every block, row by row.
    pub(super) fn all(&self) -> Vec<Needs> {
        let (columns, rows) = (self.size.0.div_ceil(BLOCK), self.size.1.div_ceil(BLOCK));
        let position = |index: u32, end: u32| (index * BLOCK).min(end);
        let corner_row = |row: u32| -> Vec<Corner> {
            (0..=columns).map(|column| self.corner(position(column, self.size.0), position(row, self.size.1))).collect()
        };
        let mut needs = Vec::with_capacity(self.blocks());
        let mut above = corner_row(0);
        for row in 0..rows {
            let below = corner_row(row + 1);
            for (column, (upper, lower)) in (0..columns).zip(above.windows(2).zip(below.windows(2))) {
                let block = [
                    position(column, self.size.0),
                    position(row, self.size.1),
                    position(column + 1, self.size.0),
                    position(row + 1, self.size.1),
                ];
                needs.push(self.block(block, [upper[0], upper[1], lower[0], lower[1]]));
            }
            above = below;
        }
        needs
    }

    /// Normalised coordinates of a pixel position.
    pub(super) fn normalised(&self, x: f64, y: f64) -> (f64, f64) {
        self.source.normalised(self.size, x, y)
    }

    fn corner(&self, x: u32, y: u32) -> Corner {
        let (x, y) = self.normalised(f64::from(x), f64::from(y));
        let on_surface = match self.source {
            Source::Projector(projector) => projector.pinhole.hit(x, y),
            Source::Optics(optics) => optics.hit(x, y),
            _ => None,
        };
        Corner { direction: self.source.direction(x, y).and_then(DVec3::try_normalize), on_surface }
    }

    fn block(&self, block: Block, corners: [Corner; 4]) -> Needs {
        let torn = matches!(self.source, Source::Panorama { panorama: Panorama::CubeStrip, .. });
        if torn || matches!(self.source, Source::Table(_)) {
            // Nothing is known between a table's pixels, nor across the border of two faces.
            return self.by_pixels(block);
        }
        if self.surely_dark(block, &corners) {
            return Needs { dark: true, ..Needs::default() };
        }
        let by_corners = all_of(corners.map(|corner| corner.direction)).and_then(|directions| {
            let diameter = diameter(&directions);
            if diameter < WIDEST && self.surely_on_screen(&corners) {
                self.only_view(&directions, diameter * diameter)
            } else {
                None
            }
        });
        let mut needs = match by_corners {
            Some(view) => Needs { views: 1 << view.min(63), neighbours: 0, dark: false, lit: true },
            None => self.by_pixels(block),
        };
        if needs.lit {
            needs.neighbours = self.overlapping(block);
        }
        needs
    }

    /// Whether a block shows nothing, told without looking at its pixels.
    fn surely_dark(&self, block: Block, corners: &[Corner; 4]) -> bool {
        match self.source {
            source if source.is_circular() => {
                let centre = (0.5 * f64::from(self.size.0), 0.5 * f64::from(self.size.1));
                let nearest = |low: u32, high: u32, centre: f64| centre.clamp(f64::from(low), f64::from(high));
                let (x, y) =
                    self.normalised(nearest(block[0], block[2], centre.0), nearest(block[1], block[3], centre.1));
                x * x + y * y > 1.0
            }
            Source::Fisheye { .. } | Source::Panorama { .. } | Source::Perspective { .. } | Source::Table(_) => false,
            Source::Projector(projector) => on_screen(&projector.bounds, corners) == Some(false),
            Source::Optics(optics) => on_screen(&optics.bounds, corners) == Some(false),
        }
    }

    /// Whether no pixel of a block whose corners show something can miss the screen.
    fn surely_on_screen(&self, corners: &[Corner; 4]) -> bool {
        match self.source {
            Source::Projector(projector) => {
                projector.rim.is_none() || on_screen(&projector.bounds, corners) == Some(true)
            }
            Source::Optics(optics) => on_screen(&optics.bounds, corners) == Some(true),
            _ => true,
        }
    }

    /// The one view that answers for all of a patch, if the corners tell.
    pub(super) fn only_view(&self, directions: &[DVec3; 4], margin: f64) -> Option<usize> {
        for (index, view) in self.views.iter().enumerate() {
            match view.relation(directions, margin) {
                Relation::Inside => return Some(index),
                Relation::Outside => {}
                Relation::Unclear => return None,
            }
        }
        None
    }

    /// Returns the needs of the sampled places of a block's pixels.
    pub(super) fn by_pixels(&self, block: Block) -> Needs {
        let mut needs = self.by_centres(block);
        if self.filter.has_four_places() && needs.lit {
            // A table of all pixels is interpolated between the pixels around a place.
            let ring = u32::from(matches!(self.source, Source::Table(_)));
            let columns = block[0].saturating_sub(ring)..(block[2] + ring).min(self.size.0);
            let rows = block[1].saturating_sub(ring)..(block[3] + ring).min(self.size.1);
            for (row, column) in rows.flat_map(|row| columns.clone().map(move |column| (row, column))) {
                for place in Filter::FOUR_PLACES {
                    // The grid is that of the finished picture.
                    let place = DVec2::from(place) * self.flip.signs();
                    let (x, y) = self.normalised(f64::from(column) + 0.5 + place.x, f64::from(row) + 0.5 + place.y);
                    match self.source.direction(x, y) {
                        Some(direction) => needs.views |= 1 << self.answering(direction).min(63),
                        None => needs.dark = true,
                    }
                }
            }
        }
        needs
    }

    /// Returns the needs of the centres of a block's pixels.
    pub(super) fn by_centres(&self, block: Block) -> Needs {
        let mut needs = Needs::default();
        for row in block[1]..block[3] {
            for column in block[0]..block[2] {
                let (x, y) = self.normalised(f64::from(column) + 0.5, f64::from(row) + 0.5);
                match self.source.direction(x, y) {
                    Some(direction) => {
                        needs.lit = true;
                        needs.views |= 1 << self.answering(direction).min(63);
                    }
                    None => needs.dark = true,
                }
            }
        }
        needs
    }

    /// The view that answers for a direction: the first that contains it. The planner leaves no
    /// gap; should rounding make one, the nearest view answers.
    pub(super) fn answering(&self, direction: DVec3) -> usize {
        let shallowest = |view: &Cone| view.depths(direction).into_iter().fold(f64::INFINITY, f64::min);
        self.views.iter().position(|view| view.contains(direction)).unwrap_or_else(|| {
            let nearest = (0..self.views.len())
                .max_by(|&a, &b| shallowest(&self.views[a]).total_cmp(&shallowest(&self.views[b])));
            nearest.unwrap_or(0)
        })
    }

    /// The neighbours whose pictures reach into a block.
    pub(super) fn overlapping(&self, block: Block) -> u128 {
        let places = [(block[0], block[1]), (block[2], block[1]), (block[0], block[3]), (block[2], block[3])];
        let places = places.map(|(x, y)| self.normalised(f64::from(x), f64::from(y)));
        self.neighbours.iter().enumerate().fold(0, |set, (index, (picture, cone))| {
            let corners = places.map(|(x, y)| picture.evaluate(x, y).and_then(DVec3::try_normalize));
            let apart = all_of(corners).is_some_and(|corners| {
                let diameter = diameter(&corners);
                diameter < WIDEST && cone.relation(&corners, diameter * diameter) == Relation::Outside
            });
            if apart { set } else { set | 1 << index.min(127) }
        })
    }
}

/// Whether all of a block that a projector lights is on the screen; `None` where that is not clear.
fn on_screen(bounds: &Bounds, corners: &[Corner; 4]) -> Option<bool> {
    let points = all_of(corners.map(|corner| corner.on_surface))?;
    // No point of the patch is farther than its diameter from a corner.
    bounds.hold_all(&points, diameter(&points))
}

/// The values, if there are all four.
fn all_of(values: [Option<DVec3>; 4]) -> Option<[DVec3; 4]> {
    match values {
        [Some(a), Some(b), Some(c), Some(d)] => Some([a, b, c, d]),
        _ => None,
    }
}
