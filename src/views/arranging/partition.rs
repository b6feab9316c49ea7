//! Views that several outputs share: the sphere of directions is cut into cells, and each cell that
//! is sampled gets a view.
//!
//! The cells are the faces of a cube in one of several orientations, whose front, upper and lower
//! face may be narrower or wider than 90°. Or they are any other cells that are bounded by planes
//! through the viewer (`diagram`). A cell that is sampled only in part gets its own axes: the view
//! of half a face is tighter if it is tilted towards that half, and a triangle needs another roll
//! than a square.

use crate::rig::Favour;
use crate::views::arranging::cost::PlannerOptions;
use crate::views::fitting::axes::{OrientedView, facing, refined, texels};
use crate::views::fitting::density::golden_section;
use crate::views::fitting::fit::{Patch, WIDENING, fit};
use crate::views::sampling::cone::Cone;
use crate::views::sampling::sample::Sample;
use crate::views::sampling::samples::Samples;
use glam::{DMat3, DVec3};
use std::f64::consts::FRAC_PI_4;

/// The widths of a cube's upper and lower faces are changed only if the cost falls below this part.
const WORTH_IT: f64 = 0.998;

/// Number of cube orientations that are refined.
const BEST_TURNS: usize = 3;

/// A view of a partition.
#[derive(Clone, Debug)]
pub(crate) struct Part {
    /// Middle of the cell, viewer axes.
    pub towards: DVec3,
    /// Axes, opening and resolution.
    pub oriented: OrientedView,
    /// Indices of the given outputs that sample the view.
    pub outputs: Vec<usize>,
}

/// Views of a partition, and the cells without a view.
#[derive(Clone, Debug, Default)]
pub(crate) struct Partition {
    /// The views, in order of precedence.
    pub parts: Vec<Part>,
    /// Centres of the cells that no output samples, viewer axes.
    pub skipped: Vec<DVec3>,
}

/// Index of a cell that no perspective view can show.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct WideCell(pub usize);

/// Input of the search for a partition.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Task<'a> {
    /// The outputs' samples for the search.
    pub coarse: &'a [&'a Samples],
    /// The outputs' samples for the result.
    pub fine: &'a [&'a Samples],
    /// Texels per pixel.
    pub quality: f64,
    /// Size of the finest pixel, radians.
    pub pixel: f64,
    /// Cost of a view beside its texels, in texels.
    pub beside: f64,
    /// True if upper and lower faces may be narrower or wider than a cube's: that saves texels, but
    /// more of the remaining texels are sampled, and so shaded.
    any_height: bool,
}

/// A cell: a convex cone.
#[derive(Clone, Debug)]
pub(crate) struct Cell {
    /// Axes of the view that fits the whole cell (local → viewer).
    axes: DMat3,
    /// Inward unit normals, viewer axes.
    normals: Vec<DVec3>,
}

/// Widths of the faces of a distorted cube.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Widths {
    /// Tangent to which the front face reaches towards right and left.
    front: f64,
    /// Tangent from the axis up, and from the axis down, at which the faces right and left begin.
    upright: f64,
}

impl Widths {
    const CUBE: Self = Self { front: 1.0, upright: 1.0 };

    /// Returns the vectors of front, right, left, up, down, back whose [`diagram`] has these cells.
    fn vectors(self) -> [DVec3; 6] {
        let (x, y, z) = (DVec3::X, DVec3::Y, DVec3::Z);
        [-z * self.front, x, -x, y * self.upright, -y * self.upright, z]
    }
}

/// Returns the cells of a cube (`turned`: cube → viewer axes) with faces of these widths: front,
/// right, left, up, down, back.
fn cells(turned: DMat3, widths: Widths) -> [Cell; 6] {
    let vectors = widths.vectors();
    vectors.map(|vector| Cell {
        axes: turned * facing(vector),
        // Opposite faces have no side in common.
        normals: (vectors.iter().filter(|other| other.cross(vector) != DVec3::ZERO))
            .map(|other| (turned * (vector - other)).normalize_or_zero())
            .collect(),
    })
}

/// Returns the cells of a power diagram on the sphere (Aurenhammer 1987): a direction belongs to
/// the cell of the vector with which it has the greatest scalar product. Every cell is convex and
/// bounded by planes through the viewer; equal vectors share a cell.
pub(crate) fn diagram(vectors: &[DVec3]) -> Vec<Cell> {
    let middle = vectors.iter().sum::<DVec3>() / vectors.len().max(1) as f64;
    let cell = |&vector: &DVec3| Cell {
        axes: facing(vector - middle),
        normals: vectors.iter().filter_map(|&other| (vector - other).try_normalize()).collect(),
    };
    vectors.iter().map(cell).collect()
}

/// Returns the cubes that are tried (cube → viewer axes). For each of `frames`: aligned with it,
/// with an edge forward (upright, and lying), rolled by 45°, and with each of two corners forward.
fn turns(frames: &[DMat3]) -> Vec<DMat3> {
    // The angle between an edge's middle and the corner of a cube.
    let corner = (1.0 / 2f64.sqrt()).atan();
    let turns = [
        DMat3::IDENTITY,
        DMat3::from_rotation_y(FRAC_PI_4),
        DMat3::from_rotation_x(FRAC_PI_4),
        DMat3::from_rotation_z(FRAC_PI_4),
        DMat3::from_rotation_x(corner) * DMat3::from_rotation_y(FRAC_PI_4),
        DMat3::from_rotation_x(-corner) * DMat3::from_rotation_y(FRAC_PI_4),
    ];
    frames.iter().flat_map(|frame| turns.map(|turn| *frame * turn)).collect()
}

impl<'a> Task<'a> {
    /// Makes the task for outputs with these samples. There is at least one output.
    pub fn new(options: &PlannerOptions, coarse: &'a [&'a Samples], fine: &'a [&'a Samples]) -> Self {
        Self {
            coarse,
            fine,
            quality: options.quality,
            pixel: finest_pixel(coarse),
            beside: options.texels_per_draw_set(),
            any_height: options.favour == Favour::Processor,
        }
    }

    /// Returns the cheapest partition found into two cells, by a plane near `middle`.
    pub fn halves(&self, middle: DVec3) -> Option<Partition> {
        const DIRECTIONS: u32 = 12;
        let frame = facing(middle);
        let cells = |turn: f64, shift: f64| {
            let across = frame * (DVec3::new(turn.cos(), turn.sin(), 0.0) - DVec3::NEG_Z * shift);
            diagram(&[across, -across])
        };
        let turns = (0..DIRECTIONS).map(|index| std::f64::consts::PI * f64::from(index) / f64::from(DIRECTIONS));
        let (_, turn) = turns
            .map(|turn| (rounded(self.estimate(&cells(turn, 0.0))), turn))
            .filter(|(cost, _)| *cost < i64::MAX)
            .min_by_key(|(cost, _)| *cost)?;
        // Beyond this the plane passes 35° from the middle.
        let shift = golden_section(|shift| self.estimate(&cells(turn, shift)), -0.7, 0.7, 0.02);
        let best = cells(turn, shift);
        self.estimate(&best).is_finite().then(|| self.partition(&best).ok()).flatten()
    }

    /// Returns the cheapest partition found. First every orientation of the cube is tried with its
    /// views along the faces. Then, for the best few, the front face's width and the views' axes
    /// are searched. Deterministic.
    ///
    /// `None` if one of its cells turns out to be too wide for a view.
    pub fn best(&self, frames: &[DMat3]) -> Option<Partition> {
        let (turned, widths) = self.best_cube(frames)?;
        self.partition(&cells(turned, widths)).ok()
    }

    /// Returns the vectors of the [`diagram`] whose cells are those of the best partition, without
    /// cells that no output samples.
    pub fn best_vectors(&self, frames: &[DMat3]) -> Vec<DVec3> {
        let Some((turned, widths)) = self.best_cube(frames) else { return Vec::new() };
        let vectors = widths.vectors().map(|vector| turned * vector);
        let sampled = cells(turned, widths).map(|cell| self.texels(&cell) > 0.0);
        vectors.into_iter().zip(sampled).filter_map(|(vector, sampled)| sampled.then_some(vector)).collect()
    }

    /// Returns the orientation and the widths of the best cube.
    fn best_cube(&self, frames: &[DMat3]) -> Option<(DMat3, Widths)> {
        let mut ranked: Vec<(i64, f64, DMat3)> = Vec::new();
        for turned in turns(frames) {
            // Costs above those of the best few need not be known.
            let limit = ranked.get(BEST_TURNS - 1).map_or(i64::MAX, |(cost, ..)| *cost);
            let cost = self.estimate_up_to(&cells(turned, Widths::CUBE), limit);
            // The cube comes after equal costs. Costs are compared to a thousandth, so that the
            // first of equals wins whatever the rounding.
            let place = ranked.partition_point(|(other, ..)| *other <= rounded(cost));
            ranked.insert(place, (rounded(cost), cost, turned));
        }
        let best = ranked
            .iter()
            .take(BEST_TURNS)
            .map(|&(_, cost, turned)| {
                let (front, cost) = self.best_front(turned, cost);
                (rounded(cost), turned, front)
            })
            .min_by_key(|(cost, _, _)| *cost);
        best.map(|(_, turned, front)| (turned, self.finer(turned, front)))
    }

    /// Returns all widths to a part of a per cent, the front's near `front`.
    fn finer(&self, turned: DMat3, front: f64) -> Widths {
        let cost = |widths: Widths| self.estimate(&cells(turned, widths));
        let near = |front: f64, upright: f64| match front == 1.0 {
            true => front,
            false => golden_section(|front| cost(Widths { front, upright }), front - 0.03, front + 0.03, 0.004),
        };
        let plain = Widths { front: near(front, 1.0), ..Widths::CUBE };
        if !self.any_height {
            return plain;
        }
        let upright = golden_section(|upright| cost(Widths { upright, ..plain }), 0.8, 1.25, 0.01);
        let other = Widths { front: near(plain.front, upright), upright };
        if cost(other) < WORTH_IT * cost(plain) { other } else { plain }
    }

    /// Returns the width of the front face and its cost: the cube's width, which costs `plain`, or
    /// another width if that is cheaper.
    fn best_front(&self, turned: DMat3, plain: f64) -> (f64, f64) {
        let cost = |front: f64| self.estimate(&cells(turned, Widths { front, ..Widths::CUBE }));
        let front = golden_section(cost, 0.7, 1.2, 0.03);
        let found = cost(front);
        if found < 0.995 * plain { (front, found) } else { (1.0, plain) }
    }

    /// Returns an angle in radians. A cell that is sampled only nearer than this to its sides
    /// leaves these directions to the neighbour.
    ///
    /// It is a fifth of a pixel. The widened part of the neighbour shows directions so near to the
    /// side. A dome that ends exactly at a side (180°, and a cube with an edge forward) must not
    /// cause views beyond it.
    fn ignored(&self) -> f64 {
        (0.2 * self.pixel).clamp(1e-9, 0.02)
    }

    /// Returns the samples of a cell, and the outputs that sample it.
    fn sampled(&self, outputs: &[&Samples], cell: &Cell) -> (Patch, Vec<usize>) {
        let users: Vec<usize> =
            (0..outputs.len()).filter(|&index| outputs[index].reach_into(&cell.normals, -self.ignored())).collect();
        let samples: Vec<Sample> =
            users.iter().flat_map(|&index| outputs[index].within(&cell.normals, 2.0 * self.ignored())).collect();
        (Patch::new(&samples), users)
    }

    /// Returns the cost of a partition, with axes only tilted and rolled in steps. It is infinite
    /// if an output is so small, and so near to the sides of cells, that all cells leave it to a
    /// neighbour.
    pub fn estimate(&self, cells: &[Cell]) -> f64 {
        self.estimate_up_to(cells, i64::MAX)
    }

    /// Returns [`Task::estimate`], or infinity if it is [`rounded`] to more than `limit`.
    fn estimate_up_to(&self, cells: &[Cell], limit: i64) -> f64 {
        let mut left: Vec<bool> = self.coarse.iter().map(|samples| !samples.is_empty()).collect();
        let mut cost = 0.0;
        for cell in cells {
            let (samples, users) = self.sampled(self.coarse, cell);
            users.iter().for_each(|&user| left[user] = false);
            if !users.is_empty() {
                cost += tilted(cell, &samples, self.quality).0 + self.beside;
            }
            if rounded(cost) > limit {
                return f64::INFINITY;
            }
        }
        if left.contains(&true) { f64::INFINITY } else { cost }
    }

    /// Returns the approximate number of texels of a cell's view; 0 if no output samples it,
    /// infinite if no perspective view can show it.
    pub fn texels(&self, cell: &Cell) -> f64 {
        let (samples, users) = self.sampled(self.coarse, cell);
        if users.is_empty() { 0.0 } else { tilted(cell, &samples, self.quality).0 }
    }

    /// Returns the partition with refined axes of its views, and with openings and resolutions from
    /// the finest samples.
    ///
    /// # Errors
    /// A cell that was chosen by the coarse samples, but whose finest samples show more than a
    /// perspective view can.
    pub fn partition(&self, cells: &[Cell]) -> Result<Partition, WideCell> {
        let mut found = Partition::default();
        for (index, cell) in cells.iter().enumerate() {
            let (fine, users) = self.sampled(self.fine, cell);
            let (coarse, _) = self.sampled(self.coarse, cell);
            if users.is_empty() {
                found.skipped.push(-cell.axes.z_axis);
                continue;
            }
            let (cost, axes) = tilted(cell, &coarse, self.quality);
            let better = refined(&coarse, axes, self.quality);
            // A cell keeps its own axes unless others gain something.
            let least = if axes == cell.axes { 0.995 * cost } else { cost };
            let gains = texels(&coarse, better, self.quality) < least;
            let choices = [if gains { better } else { axes }, axes, cell.axes];
            let oriented = choices.into_iter().find_map(|axes| {
                let rotation = axes.transpose();
                Some(OrientedView { rotation, fit: fit(rotation, &fine, self.quality, true)? })
            });
            let oriented = oriented.ok_or(WideCell(index))?;
            found.parts.push(Part { towards: -cell.axes.z_axis, oriented, outputs: users });
        }
        self.raise(&mut found);
        Ok(found)
    }

    /// Raises the resolution of views for directions outside their cells but inside their openings,
    /// unless an earlier view serves these.
    fn raise(&self, partition: &mut Partition) {
        // Directions deeper than this in an earlier view (radians) are left to that view.
        // Directions at its border may lie between two samples, so more are counted than needed.
        const DEPTH: f64 = 0.04;
        let mut earlier: Vec<(Cone, Vec<usize>)> = Vec::new();
        for part in &mut partition.parts {
            let cone = Cone::new(part.oriented.rotation, &part.oriented.fit.extent);
            let left = |output: usize, sample: &Sample| {
                !earlier.iter().any(|(other, outputs)| {
                    outputs.contains(&output) && other.depths(sample.direction).iter().all(|&depth| depth > DEPTH)
                })
            };
            // The view also serves the directions by which `layout` widens its part.
            let widening = WIDENING / part.oriented.fit.density.min_element();
            let others: Vec<Sample> = part
                .outputs
                .iter()
                .flat_map(|&output| {
                    self.fine[output].within(&cone.sides(), widening).into_iter().map(move |sample| (output, sample))
                })
                .filter(|(output, sample)| left(*output, sample))
                .map(|(_, sample)| sample)
                .collect();
            part.oriented.fit.raise(part.oriented.rotation, &others, self.quality);
            earlier.push((cone, part.outputs.clone()));
        }
    }
}

/// Returns the size of the finest pixel in radians.
fn finest_pixel(samples: &[&Samples]) -> f64 {
    samples
        .iter()
        .flat_map(|samples| samples.iter())
        .map(|sample| {
            let spread = &sample.spread;
            (0.5 * (spread.x_axis.x + spread.y_axis.y + spread.z_axis.z)).sqrt()
        })
        .fold(f64::INFINITY, f64::min)
}

/// Rounds costs to a thousandth.
fn rounded(cost: f64) -> i64 {
    (cost.ln() * 1e3).round() as i64
}

/// Returns the texels and the axes (local → viewer) of a view for `samples`, the sampled part of a
/// cell. The cell's axes are tilted towards the middle of the samples, and rolled by 0° or 45°.
fn tilted(cell: &Cell, samples: &Patch, quality: f64) -> (f64, DMat3) {
    let straight = (texels(samples, cell.axes, quality), cell.axes);
    let (axis, middle) = (-cell.axes.z_axis, samples.middle());
    let (hinge, angle) = (axis.cross(middle), axis.angle_between(middle));
    let Some(hinge) = hinge.try_normalize().filter(|_| angle > 0.05) else { return straight };
    [0.0, FRAC_PI_4]
        .into_iter()
        .map(|roll| {
            let turned =
                |tilt: f64| DMat3::from_axis_angle(hinge, tilt * angle) * cell.axes * DMat3::from_rotation_z(roll);
            let tilt = golden_section(|tilt| texels(samples, turned(tilt), quality).ln(), 0.0, 1.4, 0.08);
            (texels(samples, turned(tilt), quality), turned(tilt))
        })
        .chain([straight])
        .min_by(|a, b| a.0.total_cmp(&b.0))
        .unwrap_or(straight)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::random::Random;

    #[test]
    fn each_direction_lies_in_the_cell_of_the_vector_with_the_greatest_product_and_in_no_other() {
        let mut random = Random::new(3);
        for count in 2..9 {
            let vectors: Vec<DVec3> = (0..count).map(|_| random.vector(-1.0, 1.0)).collect();
            let cells = diagram(&vectors);
            for _ in 0..500 {
                let direction = random.direction();
                let product = |index: &usize| vectors[*index].dot(direction);
                let nearest = (0..count).max_by(|a, b| product(a).total_cmp(&product(b)));
                let holds = |index: &usize| cells[*index].normals.iter().all(|normal| normal.dot(direction) >= 0.0);
                let holding: Vec<usize> = (0..count).filter(holds).collect();
                assert_eq!(holding, Vec::from_iter(nearest));
            }
        }
    }
}
