//! Boxes around vertices, and tests whether a view can show any point of a box.

use crate::intercept::gl::per_view::culling::position::{Transform, View};
use glam::{DVec2, DVec3, DVec4};

/// Greatest rounding error of the driver's products of 32-bit numbers, divided by the sum of the
/// terms' absolute values: five roundings of 2⁻²⁴ for each of up to ten matrices, times more than
/// three for safety.
const ROUNDING: f64 = 1e-5;

/// Box after a product of matrices.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlacedBox {
    middle: DVec4,
    /// Half of each edge.
    edges: [DVec4; 3],
    /// Greatest sums of the terms' absolute values.
    sizes: DVec4,
}

impl PlacedBox {
    /// Returns the box `low`…`high` after a transformation.
    pub fn of(Transform { matrix, sizes }: &Transform, low: DVec3, high: DVec3) -> Self {
        let (middle, half) = (0.5 * (low + high), 0.5 * (high - low));
        let farthest = low.abs().max(high.abs());
        Self {
            middle: *matrix * middle.extend(1.0),
            edges: [matrix.x_axis * half.x, matrix.y_axis * half.y, matrix.z_axis * half.z],
            sizes: *sizes * farthest.extend(1.0),
        }
    }

    /// Returns the least value of a linear form over the box, and the greatest error of 32-bit
    /// numbers.
    fn least(&self, form: DVec4, form_sizes: DVec4) -> (f64, f64) {
        let reach: f64 = self.edges.iter().map(|edge| form.dot(*edge).abs()).sum();
        (form.dot(self.middle) - reach, ROUNDING * form_sizes.dot(self.sizes))
    }
}

/// Part of a picture; the whole picture is −1…1 in both directions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PicturePart {
    /// Left and bottom.
    pub low: DVec2,
    /// Right and top.
    pub high: DVec2,
}

impl PicturePart {
    /// The whole picture.
    pub const ALL: Self = Self { low: DVec2::NEG_ONE, high: DVec2::ONE };

    /// True if the part lies in the picture.
    pub fn is_inside(&self) -> bool {
        self.low.cmpge(Self::ALL.low).all() && self.high.cmple(Self::ALL.high).all()
    }
}

/// Returns true if no point of the box is in the picture of a `view` or within `beside` of it (in
/// units of half the picture's width and height).
///
/// The box is outside if all of it is beyond one of the four planes `±x = (1 + beside)·w`. The
/// planes are linear, so this holds for points behind the eye as well. Near and far planes do not
/// count, as the program may have switched off their clipping. Returns false in all cases of doubt,
/// such as numbers that are not finite.
pub fn outside(view: &View, placed: &PlacedBox, beside: DVec2) -> bool {
    let ([x, y, w], [x_sizes, y_sizes, w_sizes]) = (view.rows, view.sizes);
    [(x, x_sizes, beside.x), (y, y_sizes, beside.y)].into_iter().any(|(row, sizes, beside)| {
        let out = 1.0 + beside;
        [1.0, -1.0].into_iter().any(|sign| {
            let (least, error) = placed.least(sign * row - out * w, sizes + out * w_sizes);
            least > error
        })
    })
}

/// Returns the part of the picture of a `view` that contains the visible points of the box. `None`:
/// the box reaches behind the eye, so it may be visible anywhere.
pub fn extent(view: &View, placed: &PlacedBox) -> Option<PicturePart> {
    // x, y and w of clip coordinates.
    let clip = |point: DVec4| DVec3::from(view.rows.map(|row| row.dot(point)));
    let [x_error, y_error, w_error] = view.sizes.map(|sizes| ROUNDING * sizes.dot(placed.sizes));
    let (middle, edges) = (clip(placed.middle), placed.edges.map(clip));
    let mut part = PicturePart { low: DVec2::INFINITY, high: DVec2::NEG_INFINITY };
    for corner in 0..8 {
        let sign = |edge: usize| if corner >> edge & 1 == 0 { -1.0 } else { 1.0 };
        let [x, y, w] = (middle + sign(0) * edges[0] + sign(1) * edges[1] + sign(2) * edges[2]).to_array();
        let (place, w) = (DVec2::new(x, y), w - w_error);
        // Nearer to the eye the errors have no useful limit.
        if w.is_nan() || w <= 4.0 * w_error {
            return None;
        }
        let at = place / w;
        if !at.is_finite() {
            return None;
        }
        let off = (DVec2::new(x_error, y_error) + 2.0 * at.abs() * w_error) / w;
        // The least w gives a point too far outward, the greatest w one too far inward.
        let inner = place / (w + 2.0 * w_error);
        part.low = part.low.min(at.min(inner) - off);
        part.high = part.high.max(at.max(inner) + off);
    }
    Some(part)
}

#[cfg(test)]
mod tests {
    use super::{PicturePart, PlacedBox, Transform, View};
    use crate::intercept::gl::state::draw::bounds::Bounds;
    use crate::testing::random::Random;
    use glam::{DMat3, DMat4, DVec2, DVec3, DVec4};

    /// Does the same as the function under test, for a projection after a model-view matrix.
    fn outside(projection: &DMat4, model_view: &DMat4, low: DVec3, high: DVec3, beside: DVec2) -> bool {
        super::outside(&View::of(projection), &PlacedBox::of(&Transform::of(model_view), low, high), beside)
    }

    fn extent(low: DVec3, high: DVec3) -> Option<PicturePart> {
        super::extent(&View::of(&RIGHT_ANGLE), &PlacedBox::of(&Transform::of(&DMat4::IDENTITY), low, high))
    }

    /// Field of view of 90° in both directions, looking along −z.
    const RIGHT_ANGLE: DMat4 =
        DMat4::from_cols(DVec4::X, DVec4::Y, DVec4::new(0.0, 0.0, -1.0, -1.0), DVec4::new(0.0, 0.0, -0.2, 0.0));

    /// Returns a source of random numbers in −1…1, the same in every run.
    fn numbers() -> impl FnMut() -> f64 {
        let mut random = Random::new(1);
        move || random.range(-1.0, 1.0)
    }

    #[test]
    fn boxes_beside_and_behind_are_outside_and_those_ahead_are_not() {
        let gone = |low: [f64; 3], high: [f64; 3]| {
            outside(&RIGHT_ANGLE, &DMat4::IDENTITY, low.into(), high.into(), DVec2::ZERO)
        };
        assert!(!gone([-1.0, -1.0, -3.0], [1.0, 1.0, -2.0]));
        assert!(gone([-1.0, -1.0, 2.0], [1.0, 1.0, 3.0]));
        assert!(gone([9.0, -1.0, -3.0], [10.0, 1.0, -2.0]));
        // A box around the eye, and a box across a border.
        assert!(!gone([-1.0; 3], [1.0; 3]));
        assert!(!gone([1.0, -1.0, -2.0], [9.0, 1.0, -1.5]));
    }

    #[test]
    fn spread_keeps_what_touches_the_picture_from_beside() {
        let (low, high) = (DVec3::new(2.1, 0.0, -2.0), DVec3::new(2.2, 0.0, -2.0));
        let gone = |beside| outside(&RIGHT_ANGLE, &DMat4::IDENTITY, low, high, beside);
        assert!(gone(DVec2::ZERO));
        assert!(!gone(DVec2::new(0.1, 0.0)));
    }

    /// The computed part contains all of the box, and is not much larger.
    #[test]
    fn the_part_of_a_box_holds_all_of_it() {
        let mut number = numbers();
        let mut found = 0;
        for _ in 0..5_000 {
            let low = 4.0 * DVec3::new(number(), number(), number()) - 6.0 * DVec3::Z;
            let high = low.map(|v| v + 1.0 + number());
            let Some(part) = extent(low, high) else {
                assert!(high.z > -0.1, "{low} {high} is ahead");
                continue;
            };
            found += 1;
            for _ in 0..20 {
                let point = low + (high - low) * 0.5 * (1.0 + DVec3::new(number(), number(), number()));
                let at = point.truncate() / -point.z;
                assert!(part.low.cmple(at).all() && at.cmple(part.high).all(), "{point} is not in {part:?}");
            }
        }
        assert!(found > 3_000, "{found}");
        let part = extent(DVec3::new(-1.0, -2.0, -4.0), DVec3::new(1.0, 2.0, -2.0)).expect("ahead");
        let near = |a: DVec2, b: DVec2| a.abs_diff_eq(b, 1e-3);
        assert!(near(part.low, DVec2::new(-0.5, -1.0)) && near(part.high, DVec2::new(0.5, 1.0)), "{part:?}");
        assert!(!part.is_inside() && PicturePart::ALL.is_inside());
    }

    /// No vertex of a box that is left out is in the picture. Some boxes are left out.
    #[test]
    fn nothing_visible_is_left_out() {
        let mut number = numbers();
        let mut left_out = 0;
        for _ in 0..20_000 {
            let mut point = || DVec3::new(number(), number(), number());
            let turn = DMat3::from_cols(point(), point(), point()) * 3.0;
            let model_view = DMat4::from_mat3_translation(turn, 3.0 * point());
            let corner = 2.0 * point();
            let mut bounds = Bounds::EMPTY;
            let points: Vec<DVec4> = (0..8).map(|_| (corner + 0.5 * point()).extend(1.0)).collect();
            points.iter().for_each(|p| bounds.add(p.to_array()));
            let (low, high) = bounds.known().expect("finite points");
            if !outside(&RIGHT_ANGLE, &model_view, low, high, DVec2::ZERO) {
                continue;
            }
            left_out += 1;
            for p in points {
                let DVec4 { x, y, w, .. } = RIGHT_ANGLE * (model_view * p);
                assert!(w < 0.0 || x.abs() > w || y.abs() > w, "{p} is in the picture");
            }
        }
        assert!(left_out > 5_000, "{left_out}");
    }

    #[test]
    fn doubt_is_not_outside() {
        let mut bounds = Bounds::EMPTY;
        assert_eq!(bounds.known(), None);
        bounds.add([1.0, 2.0, 3.0, 1.0]);
        assert_eq!(bounds.known(), Some((DVec3::new(1.0, 2.0, 3.0), DVec3::new(1.0, 2.0, 3.0))));
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
        assert!(!outside(&DMat4::NAN, &DMat4::IDENTITY, DVec3::ZERO, DVec3::ONE, DVec2::ZERO));
    }
}
