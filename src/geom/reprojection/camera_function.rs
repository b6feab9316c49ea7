//! Matrices of a program that are functions of its camera, and their values for a view.
//!
//! A shader that computes positions from pixels, or pixels from positions, has such a matrix beside
//! the one for its vertices. It is the projection or its inverse, alone or with a view matrix, of
//! this frame or of the last. It maps to or from normalised device coordinates or those of a
//! texture.
//!
//! In a view, clip coordinates are those of the program times the view's reprojection R. So a
//! matrix M to clip coordinates becomes R·M there, and a matrix M from clip coordinates becomes
//! M·R⁻¹. Eye coordinates, and those before them, stay those of the program.

use super::Intrinsics;
use glam::{DMat4, DVec4};

/// Greatest relative deviation from a similarity that rounding explains: the program formed the
/// product or the inverse in f32. Lenses whose openings differ by more are different lenses.
const TOLERANCE: f64 = 1e-3;

/// A matrix is singular if its determinant is at most this part of the product of its columns'
/// lengths.
const SINGULAR: f64 = 1e-14;

/// Dependence of a matrix on the camera.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CameraFunction {
    direction: Direction,
    coordinates: Coordinates,
    /// True if the matrix is written for row vectors.
    transposed: bool,
}

/// Direction in which a matrix maps coordinates.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Direction {
    /// To clip coordinates.
    ToClip,
    /// From clip coordinates.
    FromClip,
}

/// Form of the clip coordinates to or from which a matrix maps.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Coordinates {
    /// Clip coordinates themselves.
    Clip,
    /// Coordinates of a texture in x and y, which go from 0 to w.
    Texture,
    /// The same in z, too.
    TextureAndDepth,
}

impl Coordinates {
    const ALL: [Self; 3] = [Self::Clip, Self::Texture, Self::TextureAndDepth];

    /// Returns the matrix from clip coordinates to these coordinates.
    fn matrix(self) -> DMat4 {
        let diagonal = |z: f64| {
            let offset = DVec4::new(0.5, 0.5, 1.0 - z, 1.0);
            DMat4::from_cols(0.5 * DVec4::X, 0.5 * DVec4::Y, z * DVec4::Z, offset)
        };
        match self {
            Self::Clip => DMat4::IDENTITY,
            Self::Texture => diagonal(1.0),
            Self::TextureAndDepth => diagonal(0.5),
        }
    }
}

impl CameraFunction {
    /// Returns the dependence of `matrix` on the camera with this lens; `None` if
    /// its numbers show none.
    pub fn of(matrix: &DMat4, lens: &Intrinsics) -> Option<Self> {
        let mut best: Option<(Self, f64)> = None;
        for function in Self::all() {
            // If near and far are far apart, the two kinds of texture coordinates differ little in
            // z, so the function with the least deviation is taken.
            let deviation = function.deviation(matrix, lens).unwrap_or(f64::INFINITY);
            if deviation < best.map_or(TOLERANCE, |(_, least)| least) {
                best = Some((function, deviation));
            }
        }
        best.map(|(function, _)| function)
    }

    /// Relative deviation from a similarity of the matrix without the lens.
    fn deviation(&self, matrix: &DMat4, lens: &Intrinsics) -> Option<f64> {
        match (self.direction, lens.f) {
            // Inverting the matrix would multiply its rounding errors.
            (Direction::FromClip, Some(f)) => {
                let matrix = self.oriented(*matrix);
                Some(of_similarity(matrix * self.coordinates.matrix() * lens.projection(f), f))
            }
            _ => Some(Rows::of(self.to_clip(matrix)?).deviation(lens)),
        }
    }

    /// Returns the dependence and the lens of a projection of which `matrix` is the inverse, alone
    /// or times a similarity. F of the lens stays unknown. Returns `None` also for lenses whose E
    /// is 0 (reversed depth without a far plane), since their inverses have the form of
    /// projections.
    pub fn of_inverse(matrix: &DMat4) -> Option<(Self, Intrinsics)> {
        let mut best: Option<(Self, Intrinsics)> = None;
        for transposed in [false, true] {
            for coordinates in [Coordinates::Clip, Coordinates::Texture] {
                let function = Self { direction: Direction::FromClip, coordinates, transposed };
                let Some(rows) = function.to_clip(matrix).map(Rows::of) else { continue };
                let Some(lens) = rows.lens().filter(|lens| lens.e.abs() > TOLERANCE) else { continue };
                // The middle of texture coordinates is at one half. Taken for clip coordinates,
                // that is a lens far off its axis.
                let beside = |lens: &Intrinsics| lens.b.abs() + lens.d.abs();
                let better = best.is_none_or(|(_, known)| beside(&lens) < beside(&known));
                if better && rows.deviation(&lens) < TOLERANCE {
                    best = Some((function, lens));
                }
            }
        }
        best
    }

    fn all() -> impl Iterator<Item = Self> {
        let directions = [Direction::ToClip, Direction::FromClip];
        directions.into_iter().flat_map(|direction| {
            Coordinates::ALL.into_iter().flat_map(move |coordinates| {
                [false, true].map(|transposed| Self { direction, coordinates, transposed })
            })
        })
    }

    /// True if the matrix is written for row vectors.
    pub fn is_transposed(&self) -> bool {
        self.transposed
    }

    /// Returns the direction in which the matrix maps coordinates.
    pub fn direction(&self) -> Direction {
        self.direction
    }

    pub(super) fn oriented(&self, matrix: DMat4) -> DMat4 {
        if self.transposed { matrix.transpose() } else { matrix }
    }

    /// Returns the matrix to clip coordinates from which `matrix` follows.
    pub(super) fn to_clip(self, matrix: &DMat4) -> Option<DMat4> {
        let matrix = self.oriented(*matrix);
        let matrix = match self.direction {
            Direction::ToClip => matrix,
            Direction::FromClip => inverse(matrix)?,
        };
        Some(inverse(self.coordinates.matrix())? * matrix)
    }

    /// Returns the matrix that replaces `matrix` for a view with the reprojection `view`.
    pub fn for_view(&self, matrix: &DMat4, view: &DMat4) -> Option<DMat4> {
        let matrix = self.oriented(*matrix);
        let change = self.coordinates.matrix();
        let view = change * *view * inverse(change)?;
        let matrix = match self.direction {
            Direction::ToClip => view * matrix,
            Direction::FromClip => matrix * inverse(view)?,
        };
        Some(self.oriented(matrix))
    }
}

/// Returns the inverse; `None` if the matrix is singular in f64.
pub(super) fn inverse(matrix: DMat4) -> Option<DMat4> {
    let scale: f64 = (0..4).map(|column| matrix.col(column).length()).product();
    let determinant = matrix.determinant();
    // Written so that NaN is refused.
    (determinant.abs() > SINGULAR * scale).then(|| matrix.inverse())
}

/// Sum of the absolute deviations, as parts of a scale.
fn relative(parts: impl Iterator<Item = f64>, scale: f64) -> f64 {
    let sum: f64 = parts.map(|part| (part / scale).abs()).sum();
    if sum.is_finite() { sum } else { f64::INFINITY }
}

/// Relative deviation of a matrix from a similarity. `near` is a distance in the scene.
fn of_similarity(matrix: DMat4, near: f64) -> f64 {
    let [x, y, z] = [0, 1, 2].map(|column| matrix.col(column).truncate());
    let last = matrix.row(3);
    let scale = z.length();
    let lengths = [x.length() - scale, y.length() - scale];
    let angles = [x.dot(y), x.dot(z), y.dot(z)].map(|product| product / scale);
    relative(lengths.into_iter().chain(angles), scale) + relative([last.truncate().length() * near].into_iter(), last.w)
}

/// Rows of a matrix to clip coordinates.
struct Rows([DVec4; 4]);

impl Rows {
    fn of(matrix: DMat4) -> Self {
        Self([0, 1, 2, 3].map(|row| matrix.row(row)))
    }

    /// Relative deviation from this lens times a similarity; infinite if the rows are no
    /// projection.
    fn deviation(&self, lens: &Intrinsics) -> f64 {
        let [x, y, z, w] = self.0;
        let back = -w.truncate();
        let right = (x + lens.b * w).truncate() / lens.a;
        let up = (y + lens.d * w).truncate() / lens.c;
        // Depth is a function of the distance along the axis alone.
        let depth = (z + lens.e * w).truncate();
        let scale = back.length();
        let lengths = [right.length() - scale, up.length() - scale, depth.length()];
        let angles = [right.dot(up), right.dot(back), up.dot(back)].map(|product| product / scale);
        relative(lengths.into_iter().chain(angles), scale)
    }

    /// Returns the lens, if the rows are those of a lens times a similarity.
    fn lens(&self) -> Option<Intrinsics> {
        let [x, y, z, w] = self.0.map(DVec4::truncate);
        let square = w.length_squared();
        let [b, d, e] = [x, y, z].map(|row| -row.dot(w) / square);
        let [a, c] = [x + b * w, y + d * w].map(|row| row.length() / square.sqrt());
        ([a, b, c, d, e].iter().all(|part| part.is_finite()) && a > 0.0 && c > 0.0).then_some(Intrinsics {
            a,
            b,
            c,
            d,
            e,
            f: None,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::{CameraFunction, Coordinates, Direction, inverse};
    use crate::geom::reprojection::{CameraAdjustment, Intrinsics, MatrixClass, classify, clip_rows};
    use crate::geom::{Frustum, pose};
    use glam::{DMat3, DMat4, DVec3, DVec4};

    /// A projection with these tangents to the left, right, bottom and top.
    fn perspective([left, right, bottom, top]: [f64; 4], near: f64, far: f64) -> DMat4 {
        let (width, height, depth) = (right - left, top - bottom, near - far);
        DMat4::from_cols(
            DVec4::X * (2.0 / width),
            DVec4::Y * (2.0 / height),
            DVec4::new((right + left) / width, (top + bottom) / height, (far + near) / depth, -1.0),
            DVec4::Z * (2.0 * far * near / depth),
        )
    }

    fn projection(near: f64, far: f64) -> DMat4 {
        perspective([-0.5, 0.8, -0.4, 0.4], near, far)
    }

    fn orthographic() -> DMat4 {
        DMat4::from_translation(DVec3::new(0.3, 0.0, -1.1)) * DMat4::from_scale(DVec3::new(0.3, 0.5, -0.04))
    }

    fn lens(matrix: DMat4) -> Intrinsics {
        match classify(&matrix) {
            MatrixClass::Perspective(lens) => lens,
            other => panic!("{other:?}"),
        }
    }

    /// Rounds a matrix to f32, as in a program.
    fn rounded(matrix: DMat4) -> DMat4 {
        matrix.as_mat4().as_dmat4()
    }

    fn camera() -> DMat4 {
        let turn = DMat3::from_rotation_y(0.7) * DMat3::from_rotation_x(-0.4);
        DMat4::from_mat3(turn) * DMat4::from_translation(DVec3::new(3.0, -1.5, 12.0))
    }

    #[test]
    fn functions_of_the_camera_are_recognised_in_every_form() {
        for (near, far) in [(0.1, 100.0), (0.01, 5000.0), (1.0, 3.0)] {
            let p = projection(near, far);
            for affine in [DMat4::IDENTITY, camera(), DMat4::from_scale(DVec3::splat(3.0)) * camera()] {
                for coordinates in Coordinates::ALL {
                    let to_clip = coordinates.matrix() * p * affine;
                    for (direction, matrix) in [(Direction::ToClip, to_clip), (Direction::FromClip, to_clip.inverse())]
                    {
                        for transposed in [false, true] {
                            let given = if transposed { matrix.transpose() } else { matrix };
                            let found = CameraFunction::of(&rounded(given), &lens(p));
                            let expected = CameraFunction { direction, coordinates, transposed };
                            assert_eq!(found, Some(expected), "{near} {far}");
                        }
                    }
                }
            }
        }
    }

    #[test]
    fn what_is_of_no_camera_or_of_another_is_none() {
        let p = projection(0.1, 100.0);
        let lamp = perspective([-0.6, 0.6, -0.6, 0.6], 0.1, 100.0) * camera();
        let stretched = p * DMat4::from_scale(DVec3::new(1.0, 2.0, 1.0));
        let flat = orthographic();
        let nothing = [DMat4::ZERO, DMat4::NAN];
        for matrix in [lamp, lamp.inverse(), stretched, flat, flat.inverse(), camera(), DMat4::IDENTITY]
            .into_iter()
            .chain(nothing)
        {
            assert_eq!(CameraFunction::of(&rounded(matrix), &lens(p)), None, "{matrix}");
        }
    }

    #[test]
    fn an_inverse_tells_its_lens() {
        let p = projection(0.1, 100.0);
        for affine in [DMat4::IDENTITY, camera()] {
            let (function, found) = CameraFunction::of_inverse(&rounded((p * affine).inverse())).expect("an inverse");
            assert_eq!(function.direction(), Direction::FromClip);
            let expected = lens(p);
            let near = |a: f64, b: f64| (a - b).abs() < 1e-4;
            assert!(near(found.a, expected.a) && near(found.c, expected.c), "{found:?}");
            assert!(near(found.b, expected.b) && near(found.d, expected.d) && near(found.e, expected.e), "{found:?}");
        }
        let texture = Coordinates::Texture.matrix() * p * camera();
        let (function, found) = CameraFunction::of_inverse(&rounded(texture.inverse())).expect("an inverse");
        assert_eq!(function.coordinates, Coordinates::Texture);
        assert!((found.b - lens(p).b).abs() < 1e-4, "{found:?}");
        for matrix in [p, camera(), DMat4::IDENTITY, orthographic()] {
            assert_eq!(CameraFunction::of_inverse(&rounded(matrix)), None, "{matrix}");
        }
    }

    /// A view's matrices map a point of the scene to its pixel in the view, and that pixel back to
    /// the point.
    #[test]
    fn a_view_s_matrices_lead_to_its_pixels_and_back() {
        let p = projection(0.1, 100.0);
        let own = lens(p);
        let frustum = Frustum { left: -0.9, right: 0.7, bottom: -1.0, top: 0.6 };
        let rotation = pose::rotation(40.0, 25.0, 10.0);
        let rows = clip_rows(&own, &CameraAdjustment::NONE, rotation, &frustum);
        let rows = rows.widened(&own, &CameraAdjustment::NONE, &frustum);
        let view = rows.matrix();
        let scene = camera();
        let point = scene.inverse() * (rotation.transpose() * DVec3::new(0.2, -0.3, -4.0)).extend(1.0);
        for coordinates in Coordinates::ALL {
            let to_clip = coordinates.matrix() * p * scene;
            let there = CameraFunction { direction: Direction::ToClip, coordinates, transposed: false };
            let back = CameraFunction { direction: Direction::FromClip, ..there };
            let there = there.for_view(&to_clip, &view).expect("a matrix");
            let back = back.for_view(&to_clip.inverse(), &view).expect("a matrix");
            let pixel = there * point;
            let pixel = pixel / pixel.w;
            let expected = DVec4::new(((0.2 / 4.0) - -0.1) / 0.8, ((-0.3 / 4.0) - -0.2) / 0.8, f64::NAN, 1.0);
            let from = inverse(coordinates.matrix()).expect("one") * pixel;
            assert!((from.x - expected.x).abs() < 1e-12 && (from.y - expected.y).abs() < 1e-12, "{from} {expected}");
            assert!(from.z.abs() < 1.0, "within the view's planes");
            let found = back * pixel;
            assert!((found / found.w - point).length() < 1e-9, "{found} {point}");
        }
    }
}
