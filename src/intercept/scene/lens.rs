//! Finds the lens among a program's 4×4 matrices. No graphics API is named.

use crate::runtime::session::{CameraFunction, Intrinsics, MatrixClass, classify};
use glam::{DMat4, DVec3, Vec4Swizzles};
use std::collections::BTreeSet;

/// A matrix that may hold the lens.
#[derive(Clone, Copy, Debug)]
pub struct Candidate<'a> {
    /// Rank of its name, by [`rank`].
    pub rank: u8,
    /// Its value.
    pub value: &'a DMat4,
    /// Order of its values, as far as it is known.
    pub order: Order,
}

/// Order in which a shader reads the values that a program gives column by column.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Order {
    /// They are columns.
    Columns,
    /// They are rows.
    Rows,
    /// They may be either: the shader may multiply column vectors or row vectors.
    Either,
}

/// Part of a lens that a matrix determines.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Certainty {
    /// All of it: the matrix is the lens alone.
    Projection,
    /// All of it, unless a model is stretched along the camera's own axes.
    Product,
    /// Only E and F, since a model is stretched or skewed.
    Depth,
}

/// A lens that a program draws with, found in a matrix.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Told {
    /// The lens. Only E and F are valid for [`Certainty::Depth`].
    pub intrinsics: Intrinsics,
    /// Part of it that is known.
    pub certainty: Certainty,
}

/// A lens and the doubt about it: of several lenses, the one with the least doubt is taken.
#[derive(Clone, Copy, Debug)]
struct Found {
    told: Told,
    doubt: (bool, bool, u8),
}

impl Told {
    /// Returns a lens of which every part is known.
    pub fn sure(intrinsics: Intrinsics) -> Self {
        Self { intrinsics, certainty: Certainty::Projection }
    }

    /// Returns the kind of matrix in which the lens was found.
    pub fn how(&self) -> &'static str {
        match self.certainty {
            Certainty::Projection => "projection matrix uniform",
            Certainty::Product | Certainty::Depth => "model-view-projection matrix uniform",
        }
    }

    /// Returns the lens, completed from the `known` lenses where the matrix does not determine all
    /// of it. A product of a known lens has the E and F of that lens, whatever the model is. A lens
    /// with pixels that are not square, or with a picture off the centre, may come from a stretched
    /// model: a known lens without these signs is preferred. `aspect`: width by height of the
    /// viewport. `None`: the lens is not known.
    pub fn settled<'a>(&self, known: impl Iterator<Item = &'a Intrinsics>, aspect: f64) -> Option<Intrinsics> {
        let lens = self.intrinsics;
        let regular = |lens: &Intrinsics| {
            (lens.c / lens.a / aspect - 1.0).abs() < IRREGULAR && lens.b.abs() < IRREGULAR && lens.d.abs() < IRREGULAR
        };
        let same_depth = |other: &Intrinsics| {
            let e = (other.e - lens.e).abs() <= DEPTH_TOLERANCE * lens.e.abs().max(1.0);
            e && other.f.zip(lens.f).is_none_or(|(a, b)| (a - b).abs() <= OFFSET_TOLERANCE * a.abs().max(b.abs()))
        };
        match self.certainty {
            Certainty::Projection => Some(lens),
            Certainty::Product if regular(&lens) => Some(lens),
            Certainty::Product => {
                let mut fitting = known.filter(|known| same_depth(known) && regular(known));
                Some(fitting.next().copied().unwrap_or(lens))
            }
            Certainty::Depth => {
                let fitting: Vec<&Intrinsics> = known.filter(|known| same_depth(known)).collect();
                fitting.iter().find(|known| regular(known)).or(fitting.first()).map(|known| **known)
            }
        }
    }
}

/// Greatest deviation of a lens that counts as regular, as those of most programs are.
const IRREGULAR: f64 = 0.02;

/// Greatest deviation of E that rounding of a product in f32 explains; relative, for lenses with E
/// beyond ±1.
const DEPTH_TOLERANCE: f64 = 2e-6;

/// Greatest relative deviation of F, as the classification gives it.
const OFFSET_TOLERANCE: f64 = 2e-3;

impl Candidate<'_> {
    /// A matrix of either order.
    pub fn either(rank: u8, value: &DMat4) -> Candidate<'_> {
        Candidate { rank, value, order: Order::Either }
    }

    /// Returns the lens that the matrix holds.
    pub fn lens(&self) -> Option<Intrinsics> {
        let told = self.found()?.told;
        (told.certainty != Certainty::Depth).then_some(told.intrinsics)
    }

    /// Describes its values in words.
    pub fn description(&self) -> String {
        match self.found().map(|found| (found.told.certainty, found.told.intrinsics)) {
            Some((Certainty::Projection, lens)) => format!("projection, {}", field_of_view(&lens)),
            Some((Certainty::Product, lens)) => format!("perspective with a model, {}", field_of_view(&lens)),
            Some((Certainty::Depth, _)) => "perspective with a stretched model".to_owned(),
            None => match classify(self.value) {
                MatrixClass::Affine => "no perspective".to_owned(),
                MatrixClass::Perspective(_) => "inverse of a projection".to_owned(),
                MatrixClass::Stretched { .. } | MatrixClass::Other => "no projection".to_owned(),
            },
        }
    }

    fn found(&self) -> Option<Found> {
        let turned = self.value.transpose();
        let found = |value: &DMat4, pure: bool, guessed: bool| {
            let (intrinsics, certainty) = match classify(value) {
                MatrixClass::Perspective(lens) if pure => (lens, Certainty::Projection),
                MatrixClass::Perspective(lens) => (lens, Certainty::Product),
                MatrixClass::Stretched { e, f } => {
                    (Intrinsics { a: 1.0, b: 0.0, c: 1.0, d: 0.0, e, f }, Certainty::Depth)
                }
                _ => return None,
            };
            // The inverse of a projection has the form of one whose E is 0.
            if intrinsics.e == 0.0 && CameraFunction::of_inverse(value).is_some() {
                return None;
            }
            let doubt = (certainty == Certainty::Depth, guessed, self.rank * 2 + u8::from(!pure));
            Some(Found { told: Told { intrinsics, certainty }, doubt })
        };
        if is_projection(&turned) {
            return found(&turned, true, false);
        }
        match self.order {
            Order::Columns => found(self.value, is_projection(self.value), false),
            Order::Rows => found(&turned, false, false),
            Order::Either if is_projection(self.value) => found(self.value, true, false),
            // The transpose of a translation looks like a perspective.
            Order::Either if [self.value, &turned].iter().any(|value| classify(value) == MatrixClass::Affine) => None,
            Order::Either => {
                let both = [found(self.value, false, false), found(&turned, false, true)];
                both.into_iter().flatten().min_by_key(|found| found.doubt)
            }
        }
    }
}

/// Returns the lens that the matrices hold, and the index of its matrix. `None`: draws with these
/// matrices are flat. A product that is a perspective only if its values are read as rows counts
/// only if no other matrix holds a lens.
pub fn find<'a>(candidates: impl Iterator<Item = Candidate<'a>>) -> Option<(Told, usize)> {
    let mut best: Option<(Found, usize)> = None;
    for (number, candidate) in candidates.enumerate() {
        let Some(found) = candidate.found() else { continue };
        if best.as_ref().is_none_or(|(known, _)| found.doubt < known.doubt) {
            best = Some((found, number));
        }
    }
    best.map(|(found, number)| (found.told, number))
}

/// Describes the field of view of a lens, in degrees.
pub fn field_of_view(lens: &Intrinsics) -> String {
    // The edges of the picture are where x, or y, is w or −w.
    let angle = |scale: f64, offset: f64| {
        let edge = |sign: f64| ((sign + offset) / scale).atan();
        (edge(1.0) - edge(-1.0)).to_degrees().abs()
    };
    let off_centre = if lens.b.abs().max(lens.d.abs()) > 1e-6 { ", off centre" } else { "" };
    format!("{:.2}° × {:.2}°{off_centre}", angle(lens.a, lens.b), angle(lens.c, lens.d))
}

/// Lenses that differ by less count as equal: matrices recovered from 32-bit products scatter by
/// 4e-7.
const TOLERANCE: f64 = 1e-5;

/// True if two lenses count as equal.
pub fn same(a: &Intrinsics, b: &Intrinsics) -> bool {
    let near = |x: f64, y: f64| (x - y).abs() <= TOLERANCE * x.abs().max(y.abs()).max(1.0);
    near(a.a, b.a) && near(a.b, b.b) && near(a.c, b.c) && near(a.d, b.d) && near(a.e, b.e)
}

/// Returns the first numbers of groups of four consecutive numbers: such elements of an array of
/// vectors may be a matrix. A run of consecutive numbers is divided into groups from its first
/// number on, and again from its last number back.
pub fn fours(numbers: &[u32]) -> BTreeSet<u32> {
    let mut firsts = BTreeSet::new();
    for row in numbers.chunk_by(|before, after| before.checked_add(1) == Some(*after)) {
        firsts.extend(row.chunks_exact(4).map(|four| four[0]));
        firsts.extend(row.rchunks_exact(4).map(|four| four[0]));
    }
    firsts
}

/// `[A 0 B 0; 0 C D 0; 0 0 E F; 0 0 ∓1 0]`.
fn is_projection(m: &DMat4) -> bool {
    let zeros = [m.x_axis.yzw(), m.y_axis.xzw(), m.w_axis.xyw()];
    zeros == [DVec3::ZERO; 3] && m.z_axis.w.abs() == 1.0
}

/// Returns the rank of a name among candidates for the projection, 0…2: the lower, the more likely.
pub fn rank(name: &str) -> u8 {
    let name = name.to_ascii_lowercase();
    let has = |words: &[&str]| words.iter().any(|w| name.contains(w));
    if has(&["shadow", "light", "tex", "bias", "inv", "prev", "last", "normal", "reflect"]) {
        2
    } else if has(&["proj", "mvp", "persp", "camera", "frustum"]) {
        0
    } else {
        1
    }
}

#[cfg(test)]
mod tests {
    use super::{Candidate, Certainty, Order, Told, find, fours, is_projection, rank};
    use crate::runtime::session::Intrinsics;
    use glam::{DMat4, DVec3, DVec4};

    const PROJECTION: DMat4 = DMat4::from_cols_array_2d(&[
        [1.5, 0.0, 0.0, 0.0],
        [0.0, 2.0, 0.0, 0.0],
        [0.1, 0.2, -1.01, -1.0],
        [0.0, 0.0, -0.2, 0.0],
    ]);

    /// `PROJECTION` for a wider picture.
    fn wider() -> DMat4 {
        DMat4 { x_axis: 0.7 * DVec4::X, ..PROJECTION }
    }

    #[test]
    fn a_projection_is_told_from_its_transpose_and_from_a_translation() {
        assert!(is_projection(&PROJECTION));
        assert!(!is_projection(&PROJECTION.transpose()));
        let translation = DMat4::from_translation(DVec3::NEG_Z);
        assert!(!is_projection(&translation));
        assert!(!is_projection(&translation.transpose()));
    }

    #[test]
    fn the_inverse_of_a_projection_is_no_lens() {
        let either = |value: &DMat4| lens(&[Candidate::either(0, value)]);
        assert_eq!(either(&PROJECTION.inverse()), None);
        assert_eq!(either(&PROJECTION.inverse().transpose()), None);
        // Reversed depth without a far plane.
        let mut reversed = PROJECTION;
        (reversed.z_axis.z, reversed.w_axis.z) = (0.0, 0.1);
        assert_eq!(either(&reversed), Some(1.5));
    }

    #[test]
    fn names_promise() {
        assert!(rank("u_projectionMatrix") < rank("matrix"));
        assert!(rank("matrix") < rank("shadowProjection"));
    }

    fn lens(list: &[Candidate<'_>]) -> Option<f64> {
        find(list.iter().copied()).map(|(told, _)| told.intrinsics.a)
    }

    #[test]
    fn the_purest_and_most_promising_matrix_is_believed() {
        assert_eq!(lens(&[Candidate::either(1, &PROJECTION), Candidate::either(0, &wider())]), Some(0.7));
        let turned = PROJECTION.transpose();
        assert_eq!(lens(&[Candidate::either(1, &turned), Candidate::either(1, &wider())]), Some(1.5));
        assert_eq!(lens(&[]), None);
    }

    /// `PROJECTION` after a turn by 90° and a shift.
    const PRODUCT: DMat4 = DMat4::from_cols_array_2d(&[
        [0.1, 0.2, -1.01, -1.0],
        [0.0, 2.0, 0.0, 0.0],
        [-1.5, 0.0, 0.0, 0.0],
        [3.0, 4.0, 5.0, 6.0],
    ]);

    #[test]
    fn a_product_is_found_by_its_rows_where_nothing_else_is() {
        let rows = PRODUCT.transpose();
        let close = |found: Option<f64>| found.is_some_and(|a| (a - 1.5).abs() < 1e-9);
        for (value, order) in [(&PRODUCT, Order::Columns), (&rows, Order::Rows)] {
            assert!(close(lens(&[Candidate { rank: 1, value, order }])), "{order:?}");
            assert!(close(lens(&[Candidate::either(1, value)])), "{order:?}");
        }
        for (value, order) in [(&PRODUCT, Order::Rows), (&rows, Order::Columns)] {
            assert_eq!(lens(&[Candidate { rank: 1, value, order }]), None, "{order:?}");
        }
        assert_eq!(lens(&[Candidate::either(0, &rows), Candidate::either(2, &wider())]), Some(0.7));
    }

    #[test]
    fn a_translation_by_rows_is_no_lens() {
        let translation = DMat4::from_translation(5.0 * DVec3::NEG_Z);
        for value in [translation, translation.transpose()] {
            assert_eq!(lens(&[Candidate::either(0, &value)]), None);
        }
    }

    #[test]
    fn a_known_lens_is_that_of_a_stretched_model_with_its_depth() {
        let known = Intrinsics { a: 1.5, b: 0.0, c: 2.0, d: 0.0, e: -1.01, f: Some(-0.2) };
        let other = Intrinsics { e: -1.02, ..known };
        let told = |certainty, intrinsics| Told { certainty, intrinsics };
        let aspect = 2.0 / 1.5;
        let depth = told(Certainty::Depth, Intrinsics { a: 1.0, c: 1.0, ..known });
        assert_eq!(depth.settled([other, known].iter(), aspect), Some(known));
        assert_eq!(depth.settled([other].iter(), aspect), None, "another camera");
        assert_eq!(depth.settled([Intrinsics { f: Some(-0.3), ..known }].iter(), aspect), None, "another near plane");
        let along_axes = Intrinsics { c: 0.01, d: 0.4, ..known };
        assert_eq!(told(Certainty::Product, along_axes).settled([other, known].iter(), aspect), Some(known));
        assert_eq!(told(Certainty::Product, along_axes).settled([other].iter(), aspect), Some(along_axes));
        let zoomed = Intrinsics { a: 3.0, c: 4.0, ..known };
        assert_eq!(told(Certainty::Product, zoomed).settled([known].iter(), aspect), Some(zoomed), "a lens of its own");
        assert_eq!(Told::sure(along_axes).settled([known].iter(), aspect), Some(along_axes), "the lens alone");
    }

    #[test]
    fn four_numbers_in_a_row_are_a_group() {
        let firsts = |numbers: &[u32]| fours(numbers).into_iter().collect::<Vec<_>>();
        assert_eq!(firsts(&[0, 1, 2, 3]), [0]);
        assert_eq!(firsts(&[0, 2, 3, 4, 6, 7, 8, 9, 10]), [6, 7]);
        assert_eq!(firsts(&[1, 2, 3]), [0; 0]);
        assert_eq!(firsts(&[u32::MAX - 1, u32::MAX, 0, 1]), [0; 0]);
    }
}
