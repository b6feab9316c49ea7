//! Finds the needs of an output's blocks: from their corners where that is safe, otherwise pixel by
//! pixel.

use crate::correct::passes::source::Source;
use crate::correct::plan::needs::{Examined, MOST_UNSEEN, Needs};
use crate::correct::plan::picture::Picture;
use crate::correct::plan::rectangles::BLOCK;
use crate::geom::rectangle::PixelSpan;
use crate::geom::screen::Bounds;
use crate::geom::{ContentMap, Frustum, Panorama, QuadraticForm};
use crate::rig::{Filter, Flip, Rig};
use crate::views::fitting::fit::LEAST_COSINE;
use crate::views::sampling::cone::{Cone, Relation, WIDEST, diameter};
use crate::views::{View, ViewPlan};
use glam::{DMat3, DVec2, DVec3};

/// Depth of a direction inside a view, in texels, at which 32-bit arithmetic surely finds it
/// inside. The planner widens the part that it knows to be sampled by more.
const SURE_TEXELS: f64 = 0.05;
/// Least value of this depth, in radians, for very narrow texels.
const SURE: f64 = 2e-7;

/// Examines the blocks of one output.
pub(super) struct Examiner<'a> {
    source: &'a Source,
    size: (u32, u32),
    content: Option<&'a ContentMap>,
    pub(super) filter: Filter,
    flip: Flip,
    views: Vec<Answering>,
    neighbours: Vec<(QuadraticForm, Cone)>,
    beyond: Vec<Option<Frustum>>,
    unseen: Vec<DVec2>,
}

/// Directions that a view serves.
struct Answering {
    cone: Cone,
    /// Viewer axes → view axes.
    rotation: DMat3,
    /// Depth at which a direction is surely inside, radians.
    sure: f64,
}

impl Answering {
    fn of(view: &View) -> Self {
        let farthest = |low: f64, high: f64| low.abs().max(high.abs());
        let (x, y) = (farthest(view.owned.left, view.owned.right), farthest(view.owned.bottom, view.owned.top));
        let texel = (view.frustum.width() / f64::from(view.tile.width.max(1)))
            .min(view.frustum.height() / f64::from(view.tile.height.max(1)));
        let sure = (SURE_TEXELS * texel / (1.0 + x * x + y * y)).max(SURE);
        Self { cone: Cone::of(view), rotation: view.rotation, sure }
    }

    /// Returns the depth of a direction inside the view's sides; negative outside.
    fn depth(&self, direction: DVec3) -> f64 {
        self.cone.depths(direction).into_iter().fold(f64::INFINITY, f64::min)
    }
}

/// Direction and point at a corner of blocks.
#[derive(Clone, Copy, Debug, Default)]
struct Corner {
    /// Direction from the viewer, unit length, where something is shown.
    direction: Option<DVec3>,
    /// Point of the surface that a projector lights, in the surface's axes, on the screen or not.
    on_surface: Option<DVec3>,
}

impl<'a> Examiner<'a> {
    pub(super) fn new(rig: &Rig, picture: &'a Picture, plan: &ViewPlan, output_views: &[usize]) -> Self {
        let &Picture { ref source, size, flip, ref content, .. } = picture;
        let answering = |&index: &usize| Answering::of(&plan.views[index]);
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
            content: content.as_ref(),
            filter: rig.views.filter,
            flip,
            views: output_views.iter().map(answering).collect(),
            neighbours: neighbours.iter().map(|neighbour| (neighbour.picture, Cone::new(in_front, &picture))).collect(),
            beyond: vec![None; output_views.len()],
            unseen: Vec::new(),
        }
    }

    /// Returns the number of blocks.
    pub(super) fn blocks(&self) -> usize {
        self.size.0.div_ceil(BLOCK) as usize * self.size.1.div_ceil(BLOCK) as usize
    }

    /// Examines every block.
    pub(super) fn all(mut self) -> Examined {
        let (columns, rows) = (self.size.0.div_ceil(BLOCK), self.size.1.div_ceil(BLOCK));
        let position = |index: u32, end: u32| (index * BLOCK).min(end);
        let size = self.size;
        let corner_row = |this: &Self, row: u32| -> Vec<Corner> {
            (0..=columns).map(|column| this.corner(position(column, size.0), position(row, size.1))).collect()
        };
        let mut needs = Vec::with_capacity(self.blocks());
        let mut above = corner_row(&self, 0);
        for row in 0..rows {
            let below = corner_row(&self, row + 1);
            for (column, (upper, lower)) in (0..columns).zip(above.windows(2).zip(below.windows(2))) {
                let block = PixelSpan {
                    left: position(column, self.size.0),
                    top: position(row, self.size.1),
                    right: position(column + 1, self.size.0),
                    bottom: position(row + 1, self.size.1),
                };
                needs.push(self.block(block, [upper[0], upper[1], lower[0], lower[1]]));
            }
            above = below;
        }
        Examined { needs, beyond: self.beyond, unseen: self.unseen }
    }

    /// For each pixel, row by row, true if a view shows its direction, or if it has none.
    pub(super) fn served(&self) -> Vec<bool> {
        let centre = |at: u32| f64::from(at) + 0.5;
        let places = (0..self.size.1).flat_map(|y| (0..self.size.0).map(move |x| (centre(x), centre(y))));
        let served = |(x, y)| {
            let direction = self.direction(x, y);
            direction.is_none_or(|direction| self.views.iter().any(|view| view.depth(direction) >= 0.0))
        };
        places.map(served).collect()
    }

    /// Returns the normalised coordinates of a pixel position.
    fn normalised(&self, x: f64, y: f64) -> (f64, f64) {
        self.source.normalised(self.size, x, y)
    }

    fn corner(&self, x: u32, y: u32) -> Corner {
        let direction = self.direction(f64::from(x), f64::from(y));
        let (x, y) = self.normalised(f64::from(x), f64::from(y));
        let on_surface = match self.source {
            Source::Projector(projector) => projector.pinhole.hit(x, y),
            Source::Optics(optics) => optics.hit(x, y),
            _ => None,
        };
        Corner { direction, on_surface }
    }

    fn block(&mut self, block: PixelSpan, corners: [Corner; 4]) -> Needs {
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
            let clear = diameter < WIDEST && self.surely_on_screen(&corners);
            clear.then(|| self.only_view(&directions, self.departure(block, &directions)?)).flatten()
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

    /// True if a block surely shows nothing, found without examining its pixels.
    fn surely_dark(&self, block: PixelSpan, corners: &[Corner; 4]) -> bool {
        match self.source {
            source if source.is_circular() => {
                let centre = (0.5 * f64::from(self.size.0), 0.5 * f64::from(self.size.1));
                let nearest = |low: u32, high: u32, centre: f64| centre.clamp(f64::from(low), f64::from(high));
                let (x, y) = self
                    .normalised(nearest(block.left, block.right, centre.0), nearest(block.top, block.bottom, centre.1));
                x * x + y * y > 1.0
            }
            Source::Fisheye { .. } | Source::Panorama { .. } | Source::Perspective { .. } | Source::Table(_) => false,
            Source::Projector(projector) => on_screen(&projector.bounds, corners) == Some(false),
            Source::Optics(optics) => on_screen(&optics.bounds, corners) == Some(false),
        }
    }

    /// True if no pixel of a block whose corners show something can miss the screen.
    fn surely_on_screen(&self, corners: &[Corner; 4]) -> bool {
        match self.source {
            Source::Projector(projector) => {
                projector.rim.is_none() || on_screen(&projector.bounds, corners) == Some(true)
            }
            Source::Optics(optics) => on_screen(&optics.bounds, corners) == Some(true),
            _ => true,
        }
    }

    /// Returns a bound, in radians, on the distance of a block's directions from the quadrilateral
    /// of the directions at its corners. It is the greater of two values: the square of their
    /// diameter, and four times the departure of the middles of the block and of its sides from
    /// those of the quadrilateral. Next to a silhouette the second value decides, since directions
    /// change there with the root of the distance. `None` if one of the middles shows nothing.
    fn departure(&self, block: PixelSpan, corners: &[DVec3; 4]) -> Option<f64> {
        let [left, top, right, bottom] = block.edges();
        let (x, y) = (0.5 * (left + right), 0.5 * (top + bottom));
        let [upper_left, upper_right, lower_left, lower_right] = *corners;
        let middles = [
            (x, top, upper_left + upper_right),
            (x, bottom, lower_left + lower_right),
            (left, y, upper_left + lower_left),
            (right, y, upper_right + lower_right),
            (x, y, 0.5 * (upper_left + upper_right + lower_left + lower_right)),
        ];
        let mut departure = diameter(corners).powi(2);
        for (x, y, sum) in middles {
            departure = departure.max(4.0 * self.direction(x, y)?.distance(0.5 * sum));
        }
        Some(departure)
    }

    /// Returns the only view that serves all directions of a patch, if the corners prove that.
    fn only_view(&self, directions: &[DVec3; 4], departure: f64) -> Option<usize> {
        if let Some(content) = self.content {
            return content.surely_shows(directions, departure).then_some(0);
        }
        for (index, view) in self.views.iter().enumerate() {
            match view.cone.relation(directions, departure) {
                Relation::Inside => return Some(index),
                Relation::Outside => {}
                Relation::Unclear => return None,
            }
        }
        None
    }

    /// Returns the needs of the sampled places of a block's pixels.
    fn by_pixels(&mut self, block: PixelSpan) -> Needs {
        let mut needs = self.by_centres(block);
        if self.filter.has_four_places() && needs.lit {
            // A table of all pixels is interpolated between the pixels around a place.
            let ring = u32::from(matches!(self.source, Source::Table(_)));
            let columns = block.left.saturating_sub(ring)..(block.right + ring).min(self.size.0);
            let rows = block.top.saturating_sub(ring)..(block.bottom + ring).min(self.size.1);
            for (row, column) in rows.flat_map(|row| columns.clone().map(move |column| (row, column))) {
                for place in Filter::FOUR_PLACES {
                    // The grid is that of the finished picture.
                    let place = DVec2::from(place) * self.flip.signs();
                    self.add_place(f64::from(column) + 0.5 + place.x, f64::from(row) + 0.5 + place.y, &mut needs);
                }
            }
        }
        needs
    }

    /// Returns the needs of the centres of a block's pixels.
    fn by_centres(&mut self, block: PixelSpan) -> Needs {
        let mut needs = Needs::default();
        for row in block.top..block.bottom {
            for column in block.left..block.right {
                let shown = self.add_place(f64::from(column) + 0.5, f64::from(row) + 0.5, &mut needs);
                needs.lit |= shown;
            }
        }
        needs
    }

    /// Adds the needs of a place of the picture. Returns true if it shows something.
    fn add_place(&mut self, x: f64, y: f64, needs: &mut Needs) -> bool {
        let Some(direction) = self.direction(x, y) else {
            needs.dark = true;
            return false;
        };
        needs.views |= 1 << self.answering(direction, DVec2::new(x, y)).min(63);
        true
    }

    /// Returns the direction at a pixel position, unit length, if something is shown there.
    fn direction(&self, x: f64, y: f64) -> Option<DVec3> {
        let (x, y) = self.normalised(x, y);
        let direction = self.source.direction(x, y).and_then(DVec3::try_normalize)?;
        self.content.is_none_or(|content| content.place(direction).is_some()).then_some(direction)
    }

    /// Returns the view that serves a direction: the first that contains it, otherwise the one in
    /// which it lies deepest. If no view surely contains the direction, notes that the returned
    /// view has to be widened. If no view contains it and the view cannot be widened so far, notes
    /// the place.
    fn answering(&mut self, direction: DVec3, place: DVec2) -> usize {
        if self.content.is_some() {
            return 0;
        }
        let mut first = None;
        let mut deepest = (0, f64::NEG_INFINITY);
        for (index, view) in self.views.iter().enumerate() {
            let depth = view.depth(direction);
            if depth >= 0.0 && first.is_none() {
                first = Some(index);
            }
            if depth >= view.sure {
                return first.unwrap_or(index);
            }
            if depth > deepest.1 {
                deepest = (index, depth);
            }
        }
        let index = first.unwrap_or(deepest.0);
        let local = self.views.get(index).map(|view| view.rotation * direction);
        match (local.filter(|local| -local.z >= LEAST_COSINE), self.beyond.get_mut(index)) {
            (Some(local), Some(beyond)) => {
                let (x, y) = (local.x / -local.z, local.y / -local.z);
                let point = Frustum { left: x, right: x, bottom: y, top: y };
                *beyond = Some(beyond.map_or(point, |others| others.union(&point)));
            }
            _ if first.is_none() && self.unseen.len() < MOST_UNSEEN => self.unseen.push(place),
            _ => {}
        }
        index
    }

    /// Returns the neighbours whose pictures may reach into a block.
    fn overlapping(&self, block: PixelSpan) -> u128 {
        let places = [
            (block.left, block.top),
            (block.right, block.top),
            (block.left, block.bottom),
            (block.right, block.bottom),
        ];
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

/// Tests whether all of a block that a projector lights is on the screen; `None` if that is not
/// clear.
fn on_screen(bounds: &Bounds, corners: &[Corner; 4]) -> Option<bool> {
    let points = all_of(corners.map(|corner| corner.on_surface))?;
    // No point of the patch is farther than its diameter from a corner.
    bounds.hold_all(&points, diameter(&points))
}

/// Returns the values, if all four exist.
fn all_of(values: [Option<DVec3>; 4]) -> Option<[DVec3; 4]> {
    match values {
        [Some(a), Some(b), Some(c), Some(d)] => Some([a, b, c, d]),
        _ => None,
    }
}
