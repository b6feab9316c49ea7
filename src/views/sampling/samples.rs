//! The directions that an output shows, sampled along lines.
//!
//! Lines are used instead of points: a line can be cut exactly where it crosses the side of a view.
//! So the openings and resolutions of cropped views do not depend on the positions of samples.

use crate::views::sampling::effort::Effort;
use crate::views::sampling::output_map::OutputMap;
use crate::views::sampling::sample::{Sample, mean_direction};
use glam::{DMat3, DVec2, DVec3};

/// Density of an output's samples.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Fineness {
    /// Number of cells of the grid in each direction.
    pub cells: u32,
    /// Number of steps along each side of a picture, or a quarter of a circle.
    pub border: u32,
}

/// Fineness for searches: an accuracy of a few per cent.
pub(crate) const COARSE: Fineness = Fineness { cells: 6, border: 12 };
/// Fineness for the result: the sagitta of a border step is below a hundredth of a pixel at 16384
/// pixels.
pub(crate) const FINE: Fineness = Fineness { cells: 64, border: 768 };

/// Least number of cells of the grid over a calibration. No curve tells where such a picture ends.
const CALIBRATION_CELLS: u32 = 12;

/// Greatest relative difference between the spread in the middle of two samples and the mean of
/// theirs.
const UNEVEN: f64 = 0.01;

/// Greatest number of times that a cell is divided.
const REFINEMENTS: u32 = 5;

/// The directions that one output shows.
#[derive(Clone, Debug)]
pub(crate) struct Samples {
    output_map: OutputMap,
    /// Lines: consecutive samples are neighbours in the picture.
    pub lines: Vec<Vec<Sample>>,
    cap: Cap,
    /// What is left of the effort. Nothing is sampled any more if it is spent.
    effort: Effort,
}

/// A cone around directions, for a quick test that they are elsewhere.
#[derive(Clone, Copy, Debug)]
struct Cap {
    axis: DVec3,
    /// Cosine of half its opening.
    cosine: f64,
}

impl Cap {
    /// Greatest distance from a side at which rounding may decide, cosine.
    const ROUNDING: f64 = 1e-9;

    /// Makes the cap around these samples.
    fn around<'a>(samples: impl Iterator<Item = &'a Sample> + Clone) -> Self {
        let axis = mean_direction(samples.clone());
        Self { axis, cosine: samples.map(|sample| sample.direction.dot(axis)).fold(1.0, f64::min) }
    }

    /// True if the whole cap lies beyond the side with this inward unit normal, widened by `slack`.
    fn is_beyond(&self, normal: DVec3, slack: f64) -> bool {
        // The cosine of the angle between the normal and the nearest direction of the cap.
        let cosine = normal.dot(self.axis);
        let nearest = if cosine >= self.cosine { 1.0 } else { cosine * self.cosine + self.sine() * sine_of(cosine) };
        nearest + slack < -Self::ROUNDING
    }

    /// True if the whole cap lies on the inner side.
    fn is_inside(&self, normal: DVec3, slack: f64) -> bool {
        let cosine = normal.dot(self.axis);
        let farthest = if -cosine >= self.cosine { -1.0 } else { cosine * self.cosine - self.sine() * sine_of(cosine) };
        farthest + slack > Self::ROUNDING
    }

    /// Returns the sine of half its opening.
    fn sine(&self) -> f64 {
        sine_of(self.cosine)
    }
}

/// Returns the sine of an angle up to π, from its cosine.
fn sine_of(cosine: f64) -> f64 {
    (1.0 - cosine * cosine).max(0.0).sqrt()
}

impl Samples {
    /// Samples `output_map`: the outermost places of pixels (or the rim of the circle), and a grid
    /// inside. They are not complete if `effort` is spent.
    pub fn new(output_map: &OutputMap, fineness: Fineness, effort: &mut Effort) -> Self {
        let cap = Cap { axis: DVec3::NEG_Z, cosine: -1.0 };
        let mut samples = Self { output_map: output_map.clone(), lines: Vec::new(), cap, effort: *effort };
        if output_map.size == (0, 0) {
            return samples;
        }
        if output_map.is_circular() {
            samples.add_disc(output_map, fineness)
        } else {
            output_map.pieces().into_iter().for_each(|piece| samples.add_rectangle(output_map, piece, fineness))
        }
        // The rim of a mesh consists of many pieces.
        let steps = if output_map.is_smooth() { 4 * fineness.border } else { 2 };
        for rim in output_map.boundary_curves() {
            samples.add_line(steps, rim);
        }
        samples.cap = Cap::around(samples.iter());
        *effort = samples.effort;
        samples
    }

    /// Returns every sample.
    pub fn iter(&self) -> impl Iterator<Item = &Sample> + Clone {
        self.lines.iter().flatten()
    }

    /// Returns the samples within a convex cone, given by the inward unit normals of its sides (at
    /// least three) and widened by `slack` (radians; negative = narrowed). Lines are cut at the
    /// sides, and the cone's own edges are sampled, too. Together these contain all corners of the
    /// shown part.
    pub fn within(&self, normals: &[DVec3], slack: f64) -> Vec<Sample> {
        let mut found: Vec<Sample> = if normals.iter().any(|&normal| self.cap.is_beyond(normal, slack)) {
            Vec::new()
        } else if normals.iter().all(|&normal| self.cap.is_inside(normal, slack)) {
            self.iter().copied().collect()
        } else {
            let mut found = Vec::new();
            self.lines.iter().for_each(|line| add_pieces(line, normals, slack, &mut found));
            found
        };
        found.extend(self.corners(normals, slack));
        found
    }

    /// True if [`Samples::within`] finds any samples.
    pub fn reach_into(&self, normals: &[DVec3], slack: f64) -> bool {
        let beyond = normals.iter().any(|&normal| self.cap.is_beyond(normal, slack));
        let of_lines = || self.lines.iter().any(|line| meets(line, normals, slack));
        !beyond && of_lines() || self.corners(normals, slack).next().is_some()
    }

    /// Returns the samples where two sides of a cone meet.
    fn corners(&self, normals: &[DVec3], slack: f64) -> impl Iterator<Item = Sample> {
        pairs(normals).filter_map(move |(first, second)| {
            let edge = first.cross(second).normalize_or_zero();
            let ahead = normals.iter().map(|normal| normal.dot(edge)).sum::<f64>();
            let edge = edge * ahead.signum();
            // Where two sides meet beyond a third there is no corner.
            let corner = normals.iter().all(|normal| normal.dot(edge) >= -1e-9);
            if !corner || edge == DVec3::ZERO {
                return None;
            }
            // The point beyond both sides by `slack`. For a narrowed cone this point itself has to
            // be shown, since the corner may lie on a rim.
            let direction = (edge - (first + second) * (slack / (1.0 + first.dot(second)))).normalize_or(edge);
            let sample = self.output_map.sample_towards(if slack < 0.0 { direction } else { edge })?;
            Some(Sample { direction, ..sample })
        })
    }

    /// True if the output shows nothing.
    pub fn is_empty(&self) -> bool {
        self.lines.is_empty()
    }

    fn add_rectangle(&mut self, output_map: &OutputMap, [low, high]: [DVec2; 2], fineness: Fineness) {
        let at = |x: f64, y: f64| low + (high - low) * DVec2::new(x, y);
        // Parts that stand out of a mesh may be small.
        let cells = if output_map.is_smooth() { fineness.cells } else { 4 * fineness.cells };
        let cells = if output_map.is_calibration() { cells.max(CALIBRATION_CELLS) } else { cells };
        for index in 1..cells {
            let part = f64::from(index) / f64::from(cells);
            self.add_line(cells, |t| output_map.sample(at(t, part)));
            self.add_line(cells, |t| output_map.sample(at(part, t)));
        }
        self.add_sides(output_map, [low, high], fineness);
    }

    fn add_disc(&mut self, output_map: &OutputMap, fineness: Fineness) {
        let polar = |radius: f64, turn: f64| {
            output_map.sample(output_map.pixel(DVec2::from_angle(turn * std::f64::consts::TAU) * radius))
        };
        let spokes = 4 * fineness.cells;
        for index in 0..spokes {
            self.add_line(fineness.cells, |t| polar(t, f64::from(index) / f64::from(spokes)));
        }
        for index in 1..fineness.cells {
            self.add_line(spokes, |t| polar(f64::from(index) / f64::from(fineness.cells), t));
        }
        // Just within the circle: rounding must not push the rim out of it.
        self.add_line(4 * fineness.border, |t| polar(1.0 - 1e-12, t));
        let ends = [DVec2::X, DVec2::Y, -DVec2::X, -DVec2::Y].map(|end| output_map.pixel(end));
        for piece @ [low, high] in output_map.pieces() {
            // A circle that the picture cuts off ends at the picture's sides.
            if ends.iter().any(|end| end.cmplt(low - 1.0).any() || end.cmpgt(high + 1.0).any()) {
                self.add_sides(output_map, piece, fineness);
            }
        }
    }

    fn add_sides(&mut self, output_map: &OutputMap, [low, high]: [DVec2; 2], fineness: Fineness) {
        let at = |x: f64, y: f64| low + (high - low) * DVec2::new(x, y);
        for side in [0.0, 1.0] {
            self.add_line(fineness.border, |t| output_map.sample(at(t, side)));
            self.add_line(fineness.border, |t| output_map.sample(at(side, t)));
        }
    }

    /// Adds the line `at(0…1)` in `steps` steps, interrupted and ended exactly where nothing is
    /// shown.
    fn add_line(&mut self, steps: u32, at: impl Fn(f64) -> Option<Sample>) {
        if !self.effort.take(u64::from(steps) + 1) {
            return;
        }
        let mut line: Vec<Sample> = Vec::new();
        let mut before = 0.0;
        for step in 0..=steps {
            let here = f64::from(step) / f64::from(steps);
            let sample = at(here);
            if step > 0 && line.is_empty() && sample.is_some() {
                line.extend(border(&at, here, before));
            } else if !line.is_empty() && sample.is_none() {
                line.extend(border(&at, before, here));
                self.lines.push(std::mem::take(&mut line));
            }
            if let (Some(last), Some(sample)) = (line.last().copied(), &sample) {
                let known = line.len();
                refine(&at, (before, &last), (here, sample), REFINEMENTS, &mut line);
                self.effort.take((line.len() - known) as u64);
            }
            line.extend(sample);
            before = here;
        }
        if !line.is_empty() {
            self.lines.push(line);
        }
    }
}

/// Adds samples between two neighbours where their spread does not vary evenly, as it does near the
/// outline of a dome seen from outside and close to the viewer.
fn refine(
    at: &impl Fn(f64) -> Option<Sample>,
    from: (f64, &Sample),
    to: (f64, &Sample),
    depth: u32,
    line: &mut Vec<Sample>,
) {
    let middle = 0.5 * (from.0 + to.0);
    let Some(sample) = at(middle).filter(|_| depth > 0) else { return };
    let expected = between(from.1, to.1, 0.5).spread;
    let size = |matrix: DMat3| matrix.to_cols_array().iter().map(|value| value * value).sum::<f64>();
    if size(sample.spread - expected) > UNEVEN * UNEVEN * size(sample.spread) {
        refine(at, from, (middle, &sample), depth - 1, line);
        line.push(sample);
        refine(at, (middle, &sample), to, depth - 1, line);
    }
}

/// Returns the last sample between `shown` and `dark` that shows something.
fn border(at: &impl Fn(f64) -> Option<Sample>, shown: f64, dark: f64) -> Option<Sample> {
    let (mut inside, mut outside, mut last) = (shown, dark, None);
    // 40 halvings of a grid cell end far below a thousandth of a pixel.
    for _ in 0..40 {
        let middle = 0.5 * (inside + outside);
        match at(middle) {
            Some(sample) => (inside, last) = (middle, Some(sample)),
            None => outside = middle,
        }
    }
    last
}

/// Adds the samples of a line within a cone, and those where it crosses the cone's sides.
fn add_pieces(line: &[Sample], normals: &[DVec3], slack: f64, found: &mut Vec<Sample>) {
    for pair in line.windows(2) {
        let (from, to) = (&pair[0], &pair[1]);
        let Some((start, end)) = cut(from.direction, to.direction, normals, slack) else { continue };
        found.push(between(from, to, start));
        // The end of this piece is the start of the next, unless the line leaves the cone here.
        if end < 1.0 {
            found.push(between(from, to, end));
        }
    }
    found.extend(line.last().filter(|last| is_within(last, normals, slack)));
}

/// True if some of a line is within a cone.
fn meets(line: &[Sample], normals: &[DVec3], slack: f64) -> bool {
    let crosses = |pair: &[Sample]| cut(pair[0].direction, pair[1].direction, normals, slack).is_some();
    line.windows(2).any(crosses) || line.last().is_some_and(|last| is_within(last, normals, slack))
}

/// True if a sample is within a cone.
fn is_within(sample: &Sample, normals: &[DVec3], slack: f64) -> bool {
    normals.iter().all(|normal| normal.dot(sample.direction) >= -slack)
}

/// Returns the sample at `part` of the way between two neighbours; its error is of the order of
/// their distance squared.
fn between(from: &Sample, to: &Sample, part: f64) -> Sample {
    if part == 0.0 {
        return *from;
    }
    let direction = from.direction.lerp(to.direction, part);
    Sample { direction: direction.normalize_or(from.direction), spread: from.spread * (1.0 - part) + to.spread * part }
}

/// Returns all pairs of normals.
fn pairs(normals: &[DVec3]) -> impl Iterator<Item = (DVec3, DVec3)> + '_ {
    normals
        .iter()
        .enumerate()
        .flat_map(|(index, &first)| normals[index + 1..].iter().map(move |&second| (first, second)))
}

/// Returns the part of the segment from `a` to `b` on the inner side of all planes.
fn cut(a: DVec3, b: DVec3, normals: &[DVec3], slack: f64) -> Option<(f64, f64)> {
    let (mut start, mut end) = (0.0f64, 1.0f64);
    for normal in normals {
        let (from, to) = (normal.dot(a) + slack, normal.dot(b) + slack);
        if from < 0.0 && to < 0.0 {
            return None;
        }
        if from < 0.0 {
            start = start.max(from / (from - to));
        } else if to < 0.0 {
            end = end.min(from / (from - to));
        }
    }
    (start <= end).then_some((start, end))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rig::OutputKind;
    use crate::testing::random::Random;
    use crate::views::tests::{fisheye, lens, output, projector, rig};

    #[test]
    fn a_direction_alone_is_that_of_the_sample() {
        let mut random = Random::new(9);
        let mut rig = rig(vec![
            fisheye(200.0, 40.0),
            projector("p", DVec3::new(1.0, 0.5, 2.0), [30.0, 20.0, 10.0], lens(90.0, 70.0)),
            output("flat", OutputKind::Perspective { angles: [0.2, 0.1, 0.0], frustum: Some(lens(80.0, 60.0)) }),
        ]);
        rig.viewer.position = DVec3::new(0.3, -0.2, 0.4);
        for index in 0..rig.outputs.len() {
            let output_map = OutputMap::new(&rig, index, (320, 200)).expect("a map");
            for _ in 0..500 {
                let pixel = DVec2::new(random.range(0.0, 320.0), random.range(0.0, 200.0));
                assert_eq!(output_map.direction(pixel), output_map.sample(pixel).map(|sample| sample.direction));
            }
        }
    }

    #[test]
    fn the_cap_changes_nothing_of_what_is_found_within_a_cone() {
        let mut random = Random::new(8);
        let rig = rig(vec![
            fisheye(180.0, 40.0),
            projector("p", DVec3::new(1.0, 0.5, 2.0), [30.0, 20.0, 10.0], lens(60.0, 40.0)),
            projector("outside", DVec3::new(0.0, 1.0, 9.0), [0.0, 0.0, 0.0], lens(40.0, 40.0)),
        ]);
        let (mut none, mut all, mut some) = (0, 0, 0);
        for index in 0..rig.outputs.len() {
            let samples = Samples::new(
                &OutputMap::new(&rig, index, (320, 200)).expect("a map"),
                COARSE,
                &mut Effort::of_plan(&rig),
            );
            let everything = samples.iter().count();
            for _ in 0..300 {
                // Cones of all widths: three sides around an axis.
                let (axis, width) = (random.direction(), random.range(-0.4, 0.9));
                let (first, second) = axis.any_orthonormal_pair();
                let normals: Vec<DVec3> = [0.0f64, 2.1, 4.2]
                    .map(|turn| (axis * (1.0 - width) + (first * turn.cos() + second * turn.sin()) * width).normalize())
                    .to_vec();
                let slack = random.range(-0.02, 0.02);
                let mut walked = Vec::new();
                samples.lines.iter().for_each(|line| add_pieces(line, &normals, slack, &mut walked));
                let lines = walked.len();
                walked.extend(samples.corners(&normals, slack));
                let found = samples.within(&normals, slack);
                assert_eq!(format!("{found:?}"), format!("{walked:?}"), "{normals:?} {slack}");
                assert_eq!(samples.reach_into(&normals, slack), !found.is_empty());
                none += usize::from(lines == 0);
                all += usize::from(lines == everything);
                some += usize::from(lines != 0 && lines != everything);
            }
        }
        assert!(none > 50 && all > 10 && some > 50, "{none} {all} {some}");
    }
}
