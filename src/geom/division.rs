//! Division of lines and triangles until the straight edges that a rasteriser draws are near enough
//! to the curves that a picture of a dome should show (Kooima, Roberts & SubbaRao 2008, section
//! 2.2).
//!
//! The decision to cut an edge, and the place of the cut, depend on the two ends of the edge alone.
//! So two triangles with a common edge stay without a gap, however deep each of them is divided.

pub mod rule;

use super::lenses::picture_map::Place;
use super::{PictureLens, PictureMap};
use glam::{DVec2, DVec3};
use rule::{EDGE_SHARE, NARROWEST, OUTSIDE, WIDEST, WIDTH_SQUARED};

/// Greatest number of cuts of a primitive; each cut halves one, two or three of its edges.
pub const DEEPEST: u32 = 24;

/// Target of the division.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Division {
    /// The picture.
    pub map: PictureMap,
    /// Its width and height in pixels.
    pub pixels: DVec2,
    /// Greatest distance in pixels of a point of a primitive from its exact place, > 0.
    pub max_error: f64,
    /// Greatest number of parts of a primitive. Parts that are still too coarse at this limit are
    /// counted in [`Outcome::coarse`].
    pub most: usize,
}

/// Weights of a primitive's corners.
pub type Weights = DVec3;

/// Result of dividing a primitive.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Outcome {
    /// Number of parts near the picture.
    pub parts: usize,
    /// Number of parts that were not divided far enough.
    pub coarse: usize,
}

/// Point of the primitive.
#[derive(Clone, Copy)]
struct Corner {
    /// Position, lens axes.
    at: DVec3,
    /// Weights of the primitive's corners there.
    weights: Weights,
}

impl Division {
    /// Returns the widest allowed edge, radians. Edges through the centre of a fisheye stay
    /// straight at any width, but the error inside their triangle grows with the square of the
    /// width.
    pub fn widest(&self) -> f64 {
        let scale = match self.map.lens {
            PictureLens::Fisheye { aperture, circle, .. } => circle * 2.0 / aperture,
            PictureLens::Pinhole(frustum) => {
                let (half_x, half_y) = frustum.half_size();
                DVec2::new(1.0 / half_x, 1.0 / half_y)
            }
        };
        let pixels_per_radian = (scale * 0.5 * self.pixels).max_element();
        (WIDTH_SQUARED * self.max_error / pixels_per_radian).sqrt().min(WIDEST)
    }

    /// True if the edge between two vertices, from the viewer in lens axes, must be cut: as a
    /// straight line it deviates too far from the curve in the picture.
    pub fn cuts(&self, a: DVec3, b: DVec3) -> bool {
        let (a, b) = (a.normalize_or_zero(), b.normalize_or_zero());
        let sum = a + b;
        if sum.length() < 2.0 * (0.5 * self.widest()).cos() {
            return true;
        }
        match (self.map.place(a), self.map.place(b), self.map.place(sum)) {
            (Place::Beyond(_), Place::Beyond(_), _) => false,
            (Place::At(seen), Place::Beyond(_), _) | (Place::Beyond(_), Place::At(seen), _) => {
                !self.is_outside([seen; 3]) && a.distance(b) > NARROWEST
            }
            (_, _, Place::Beyond(_)) => true,
            (Place::At(from), Place::At(to), Place::At(middle)) => {
                let off = (middle - 0.5 * (from + to)) * 0.5 * self.pixels;
                !self.is_outside([from, to, middle]) && off.length() > EDGE_SHARE * self.max_error
            }
        }
    }

    /// True if an edge with these ends and middle is so far outside the picture that its curve
    /// cannot be seen: beyond the circle of a fisheye, or beyond one side.
    fn is_outside(&self, places: [DVec2; 3]) -> bool {
        match self.map.lens {
            PictureLens::Fisheye { circle, .. } => places.iter().all(|at| (*at / circle).length() > OUTSIDE),
            PictureLens::Pinhole(_) => {
                let low = places[0].min(places[1]).min(places[2]);
                let high = places[0].max(places[1]).max(places[2]);
                low.max_element() > OUTSIDE || high.min_element() < -OUTSIDE
            }
        }
    }

    /// Returns the fraction of the way from `a` to `b` at which the viewer sees the point halfway
    /// between them.
    pub fn middle(a: DVec3, b: DVec3) -> f64 {
        let (from, to) = (a.length(), b.length());
        if from + to > 0.0 { from / (from + to) } else { 0.5 }
    }

    /// Divides a triangle. `emit` gets the weights of the triangle's corners at each corner of a
    /// part. The corners of a part have the same orientation as those of the triangle.
    pub fn triangle(&self, corners: [DVec3; 3], emit: &mut dyn FnMut([Weights; 3])) -> Outcome {
        let axes = [DVec3::X, DVec3::Y, DVec3::Z];
        let whole = std::array::from_fn(|i| Corner { at: corners[i], weights: axes[i] });
        let mut outcome = Outcome::default();
        let mut waiting: Vec<([Corner; 3], u32)> = vec![(whole, 0)];
        while let Some((triangle, depth)) = waiting.pop() {
            let parts = self.parts(&triangle);
            let room = outcome.parts + waiting.len() + parts.len() <= self.most;
            if parts.len() > 1 && depth < DEEPEST && room {
                waiting.extend(parts.into_iter().rev().map(|part| (part, depth + 1)));
            } else if self.is_near(&triangle.map(|corner| corner.at)) {
                outcome.parts += 1;
                outcome.coarse += usize::from(parts.len() > 1);
                emit(triangle.map(|corner| corner.weights));
            }
        }
        outcome
    }

    /// Divides a line. `emit` gets the weight of the line's second end at both ends of a part.
    pub fn line(&self, ends: [DVec3; 2], emit: &mut dyn FnMut([f64; 2])) -> Outcome {
        let mut outcome = Outcome::default();
        let mut waiting = vec![([0.0, 1.0], 0)];
        while let Some(([from, to], depth)) = waiting.pop() {
            let [a, b] = [from, to].map(|weight: f64| ends[0].lerp(ends[1], weight));
            let cut = self.cuts(a, b);
            if cut && depth < DEEPEST && outcome.parts + waiting.len() + 2 <= self.most {
                let middle = from + (to - from) * Self::middle(a, b);
                waiting.extend([([middle, to], depth + 1), ([from, middle], depth + 1)]);
            } else if self.is_near(&[a, b]) {
                outcome.parts += 1;
                outcome.coarse += usize::from(cut);
                emit([from, to]);
            }
        }
        outcome
    }

    /// True if a part may be visible in the picture, provided that none of its edges needs to be
    /// cut.
    fn is_near(&self, corners: &[DVec3]) -> bool {
        let (mut low, mut high) = (DVec2::INFINITY, DVec2::NEG_INFINITY);
        let mut seen = false;
        for corner in corners {
            match self.map.place(*corner) {
                Place::At(at) => (low, high, seen) = (low.min(at), high.max(at), true),
                // The corner counts as a point at infinity in this direction.
                Place::Beyond(to) => {
                    let far = to * f64::INFINITY;
                    let side = |part: f64, far: f64| if part == 0.0 { 0.0 } else { far };
                    let far = DVec2::new(side(to.x, far.x), side(to.y, far.y));
                    (low, high) = (low.min(far), high.max(far));
                }
            }
        }
        seen && low.max_element() <= OUTSIDE && high.min_element() >= -OUTSIDE
    }

    /// Divides a triangle at all its edges that must be cut. Returns the triangle itself if there
    /// are none.
    fn parts(&self, triangle: &[Corner; 3]) -> Vec<[Corner; 3]> {
        let cut = |i: usize| self.cuts(triangle[i].at, triangle[(i + 1) % 3].at);
        let cuts = [cut(0), cut(1), cut(2)];
        // Rotation of the corners after which the first edge is cut, if any is, and the last is
        // not, unless all are.
        let start = match cuts {
            [true, _, false] | [true, true, true] | [false, false, false] => 0,
            [false, true, _] => 1,
            [_, false, true] => 2,
        };
        let [a, b, c] = [0, 1, 2].map(|i| triangle[(start + i) % 3]);
        let (ab, bc, ca) = (halfway(a, b), halfway(b, c), halfway(c, a));
        // Undoes the rotation.
        let own = |part: [Corner; 3]| std::array::from_fn(|i| part[(i + 3 - start) % 3]);
        match cuts.into_iter().filter(|cut| *cut).count() {
            0 => vec![*triangle],
            1 => vec![own([a, ab, c]), own([ab, b, c])],
            2 => vec![own([a, ab, c]), own([ab, b, bc]), own([ab, bc, c])],
            _ => vec![own([a, ab, ca]), own([ab, b, bc]), own([ca, bc, c]), own([ab, bc, ca])],
        }
    }
}

/// Returns the point that the viewer sees halfway between two, the same to the bit in either order.
fn halfway(first: Corner, second: Corner) -> Corner {
    let turned = first.at.to_array() > second.at.to_array();
    let (a, b) = if turned { (second, first) } else { (first, second) };
    let part = Division::middle(a.at, b.at);
    Corner { at: a.at.lerp(b.at, part), weights: a.weights.lerp(b.weights, part) }
}

#[cfg(test)]
mod tests;
