//! Boxes around vertices, and tests whether a view can show any point of a box.

use crate::intercept::gl::per_view::culling::position::{Transform, View};

/// Greatest rounding error of the driver's products of 32-bit numbers, divided by the sum of the
/// terms' absolute values: five roundings of 2⁻²⁴ for each of up to ten matrices, times more than
/// three for safety.
const ROUNDING: f64 = 1e-5;

/// Box after a product of matrices.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlacedBox {
    middle: [f64; 4],
    /// Half of each edge.
    edges: [[f64; 4]; 3],
    /// Greatest sums of the terms' absolute values.
    sizes: [f64; 4],
}

impl PlacedBox {
    /// Returns the box `low`…`high` after a transformation.
    pub fn of(Transform { matrix, sizes }: &Transform, low: [f64; 3], high: [f64; 3]) -> Self {
        let column = |m: &[f64; 16], column: usize| -> [f64; 4] { std::array::from_fn(|row| m[4 * column + row]) };
        let mut placed = Self { middle: column(matrix, 3), edges: [[0.0; 4]; 3], sizes: column(sizes, 3) };
        for k in 0..3 {
            let (middle, half) = (0.5 * (low[k] + high[k]), 0.5 * (high[k] - low[k]));
            let farthest = low[k].abs().max(high[k].abs());
            let (factors, sizes) = (column(matrix, k), column(sizes, k));
            for row in 0..4 {
                placed.middle[row] += factors[row] * middle;
                placed.edges[k][row] = factors[row] * half;
                placed.sizes[row] += sizes[row] * farthest;
            }
        }
        placed
    }

    /// Returns the least value of a linear form over the box, and the greatest error of 32-bit
    /// numbers.
    fn least(&self, form: &[f64; 4], form_sizes: &[f64; 4]) -> (f64, f64) {
        let reach: f64 = self.edges.iter().map(|edge| product(form, edge).abs()).sum();
        (product(form, &self.middle) - reach, ROUNDING * product(form_sizes, &self.sizes))
    }
}

fn product(a: &[f64; 4], b: &[f64; 4]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + (a[2] * b[2] + a[3] * b[3])
}

/// Returns true if no point of the box is in the picture of a `view` or within `beside` of it (in
/// units of half the picture's width and height).
/// half the picture's width and height).
///
/// The box is outside if all of it is beyond one of the four planes `±x = (1 + beside)·w`. The
/// planes are linear, so this holds for points behind the eye as well. Near and far planes do not
/// count, as the program may have switched off their clipping. Returns false in all cases of doubt,
/// such as numbers that are not finite.
pub fn outside(view: &View, placed: &PlacedBox, beside: [f64; 2]) -> bool {
    (0..2).any(|axis| {
        let out = 1.0 + beside[axis];
        let sizes = std::array::from_fn(|k| view.sizes[axis][k] + out * view.sizes[2][k]);
        [1.0, -1.0].into_iter().any(|sign| {
            let form = std::array::from_fn(|k| sign * view.rows[axis][k] - out * view.rows[2][k]);
            let (least, error) = placed.least(&form, &sizes);
            least > error
        })
    })
}

/// Returns the part of the picture of a `view` that contains the visible points of the box (left,
/// bottom, right, top; the picture is −1…1). `None`: the box reaches behind the eye, so it may be
/// visible anywhere.
pub fn extent(view: &View, placed: &PlacedBox) -> Option<[f64; 4]> {
    let error: [f64; 3] = std::array::from_fn(|row| ROUNDING * product(&view.sizes[row], &placed.sizes));
    let middle: [f64; 3] = std::array::from_fn(|row| product(&view.rows[row], &placed.middle));
    let edges: [[f64; 3]; 3] =
        std::array::from_fn(|row| std::array::from_fn(|k| product(&view.rows[row], &placed.edges[k])));
    let mut part = [f64::INFINITY, f64::INFINITY, f64::NEG_INFINITY, f64::NEG_INFINITY];
    for corner in 0..8 {
        let along = |row: usize| {
            (0..3).fold(
                middle[row],
                |sum, k| if corner >> k & 1 == 0 { sum - edges[row][k] } else { sum + edges[row][k] },
            )
        };
        let w = along(2) - error[2];
        // Nearer to the eye the errors have no useful limit.
        if w.is_nan() || w <= 4.0 * error[2] {
            return None;
        }
        for axis in 0..2 {
            let at = along(axis) / w;
            let off = (error[axis] + 2.0 * at.abs() * error[2]) / w;
            if !at.is_finite() {
                return None;
            }
            // The least w gives a point too far outward, the greatest w one too far inward.
            let inner = along(axis) / (w + 2.0 * error[2]);
            part[axis] = part[axis].min(at.min(inner) - off);
            part[axis + 2] = part[axis + 2].max(at.max(inner) + off);
        }
    }
    Some(part)
}

#[cfg(test)]
mod tests {
    use super::{PlacedBox, Transform, View};
    use crate::intercept::gl::state::draw::bounds::Bounds;
    use crate::testing::random::Random;

    /// Does the same as the function under test, for a projection after a model-view matrix.
    fn outside(
        projection: &[f64; 16],
        model_view: &[f64; 16],
        low: [f64; 3],
        high: [f64; 3],
        beside: [f64; 2],
    ) -> bool {
        super::outside(&View::of(projection), &PlacedBox::of(&Transform::of(model_view), low, high), beside)
    }

    fn extent(low: [f64; 3], high: [f64; 3]) -> Option<[f64; 4]> {
        super::extent(&View::of(&RIGHT_ANGLE), &PlacedBox::of(&Transform::of(&IDENTITY), low, high))
    }

    const IDENTITY: [f64; 16] = [1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0];
    /// Field of view of 90° in both directions, looking along −z.
    const RIGHT_ANGLE: [f64; 16] = [1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, -1.0, -1.0, 0.0, 0.0, -0.2, 0.0];

    /// Returns a source of random numbers in −1…1, the same in every run.
    fn numbers() -> impl FnMut() -> f64 {
        let mut random = Random::new(1);
        move || random.range(-1.0, 1.0)
    }

    #[test]
    fn boxes_beside_and_behind_are_outside_and_those_ahead_are_not() {
        let gone = |low, high| outside(&RIGHT_ANGLE, &IDENTITY, low, high, [0.0; 2]);
        assert!(!gone([-1.0, -1.0, -3.0], [1.0, 1.0, -2.0]));
        assert!(gone([-1.0, -1.0, 2.0], [1.0, 1.0, 3.0]));
        assert!(gone([9.0, -1.0, -3.0], [10.0, 1.0, -2.0]));
        // A box around the eye, and a box across a border.
        assert!(!gone([-1.0; 3], [1.0; 3]));
        assert!(!gone([1.0, -1.0, -2.0], [9.0, 1.0, -1.5]));
    }

    #[test]
    fn spread_keeps_what_touches_the_picture_from_beside() {
        let gone = |beside| outside(&RIGHT_ANGLE, &IDENTITY, [2.1, 0.0, -2.0], [2.2, 0.0, -2.0], beside);
        assert!(gone([0.0; 2]));
        assert!(!gone([0.1, 0.0]));
    }

    /// The computed part contains all of the box, and is not much larger.
    #[test]
    fn the_part_of_a_box_holds_all_of_it() {
        let mut number = numbers();
        let mut found = 0;
        for _ in 0..5_000 {
            let low: [f64; 3] = std::array::from_fn(|k| 4.0 * number() - if k == 2 { 6.0 } else { 0.0 });
            let high = low.map(|v| v + 1.0 + number());
            let Some(part) = extent(low, high) else {
                assert!(high[2] > -0.1, "{low:?} {high:?} is ahead");
                continue;
            };
            found += 1;
            for _ in 0..20 {
                let point: [f64; 3] = std::array::from_fn(|k| low[k] + (high[k] - low[k]) * 0.5 * (1.0 + number()));
                for axis in 0..2 {
                    let at = point[axis] / -point[2];
                    assert!(part[axis] <= at && at <= part[axis + 2], "{point:?} is not in {part:?}");
                }
            }
        }
        assert!(found > 3_000, "{found}");
        let part = extent([-1.0, -2.0, -4.0], [1.0, 2.0, -2.0]).expect("ahead");
        let expected = [-0.5, -1.0, 0.5, 1.0];
        assert!(part.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-3), "{part:?}");
    }

    /// No vertex of a box that is left out is in the picture. Some boxes are left out.
    #[test]
    fn nothing_visible_is_left_out() {
        let mut number = numbers();
        let mut left_out = 0;
        for _ in 0..20_000 {
            let model_view: [f64; 16] =
                std::array::from_fn(|i| if i % 4 == 3 { f64::from(u8::from(i == 15)) } else { 3.0 * number() });
            let corner: [f64; 3] = std::array::from_fn(|_| 2.0 * number());
            let mut bounds = Bounds::EMPTY;
            let points: Vec<[f64; 4]> = (0..8)
                .map(|_| [corner[0] + 0.5 * number(), corner[1] + 0.5 * number(), corner[2] + 0.5 * number(), 1.0])
                .collect();
            points.iter().for_each(|p| bounds.add(*p));
            let (low, high) = bounds.known().expect("finite points");
            if !outside(&RIGHT_ANGLE, &model_view, low, high, [0.0; 2]) {
                continue;
            }
            left_out += 1;
            for p in points {
                let apply = |m: &[f64; 16], v: [f64; 4]| -> [f64; 4] {
                    std::array::from_fn(|row| (0..4).map(|k| m[4 * k + row] * v[k]).sum())
                };
                let [x, y, _, w] = apply(&RIGHT_ANGLE, apply(&model_view, p));
                assert!(w < 0.0 || x.abs() > w || y.abs() > w, "{p:?} is in the picture");
            }
        }
        assert!(left_out > 5_000, "{left_out}");
    }

    #[test]
    fn doubt_is_not_outside() {
        let mut bounds = Bounds::EMPTY;
        assert_eq!(bounds.known(), None);
        bounds.add([1.0, 2.0, 3.0, 1.0]);
        assert_eq!(bounds.known(), Some(([1.0, 2.0, 3.0], [1.0, 2.0, 3.0])));
        let mut other = bounds;
        other.add([1.0, 2.0, 3.0, 0.5]);
        assert_eq!(other.known(), None);
        let mut joined = Bounds::EMPTY;
        joined.join(&bounds);
        assert_eq!(joined, bounds);
        joined.join(&other);
        assert_eq!(joined.known(), None);
        bounds.add([f64::NAN, 0.0, 0.0, 1.0]);
        assert_eq!(bounds.known(), None);
        assert!(!outside(&[f64::NAN; 16], &IDENTITY, [0.0; 3], [1.0; 3], [0.0; 2]));
    }
}
