//! Class and lens of a matrix that a program gives.

use super::{Intrinsics, MatrixClass};
use glam::{DMat4, DVec3, DVec4};

/// Greatest cosine between two rows that ought to be perpendicular, for matrices whose products
/// were formed in f32 (measured: ≤ 3e-7). A non-uniform scale of 1 % shows 1.7e-3 or more.
const SKEW_TOLERANCE: f64 = 2e-6;

/// Least size of F, as a part of the numbers whose difference it is. A smaller F is `None`, so that
/// the relative error of F is below about 1e-3 for a matrix formed in f32.
const OFFSET_SIGNIFICANCE: f64 = 3e-4;

/// Classifies `matrix`, which multiplies column vectors.
///
/// The entries of a bare projection, with zeros in their places, are returned bit for bit (apart
/// from the signs below). A projection times model and view matrices, `P·[sR|t]`, is separated by
/// the RQ decomposition. From f32 products A and C have a relative error ≤ 4e-7, and B, D and E an
/// absolute error of the same size. If `t` is large compared with F, F is lost and is `None`.
///
/// Signs: the lens is returned as the window shows it. A and C are positive, and w grows in front
/// of the eye. A program may be mirrored (negative determinant), upside down or left-handed (`w =
/// +z`). Then its eye axes contain the mirroring, and reprojected directions still agree with its
/// own picture.
///
/// `Stretched`: a model with non-uniform scale or skew. A scale along the camera's own axes cannot
/// be distinguished from another lens; E and F of that lens are right.
///
/// `Other`: non-finite entries, singular, or a depth row that is not parallel to the w row (oblique
/// near plane).
pub fn classify(matrix: &DMat4) -> MatrixClass {
    if !matrix.is_finite() {
        return MatrixClass::Other;
    }
    let w = matrix.row(3);
    if w.truncate() == DVec3::ZERO {
        return if w.w != 0.0 { MatrixClass::Affine } else { MatrixClass::Other };
    }
    projection(matrix).map_or_else(|| product(matrix), MatrixClass::Perspective)
}

/// A bare projection matrix, `[A 0 B 0; 0 C D 0; 0 0 E F; 0 0 ∓1 0]`.
fn projection(matrix: &DMat4) -> Option<Intrinsics> {
    let rows = matrix.transpose().to_cols_array_2d();
    let [[a, x1, b, x3], [y0, c, d, y3], [z0, z1, e, f], [w0, w1, w, w3]] = rows;
    let zeros = [x1, x3, y0, y3, z0, z1, w0, w1, w3];
    if zeros.iter().any(|&entry| entry != 0.0) || w.abs() != 1.0 || a == 0.0 || c == 0.0 {
        return None;
    }
    // In axes with w = −z; exact, since w is 1 or −1.
    Some(Intrinsics { a: a.abs(), b: b * -w, c: c.abs(), d: d * -w, e: e * -w, f: Some(f) })
}

/// A projection times an affine matrix, by the RQ decomposition of the 3×3 parts of the rows x, y
/// and w.
fn product(matrix: &DMat4) -> MatrixClass {
    let [x, y, z, w] = [0, 1, 2, 3].map(|row| matrix.row(row).truncate());
    let scale = w.length();
    let axis = w / scale;
    // B, D and E times the scale.
    let [b, d, e] = [-x.dot(axis), -y.dot(axis), -z.dot(axis)];
    let (right, up, depth) = (x + b * axis, y + d * axis, z + e * axis);
    let (a, c) = (right.length(), up.length());
    // Effect of the rounding of a row on its part perpendicular to the axis.
    let noise = |row: DVec3, part: f64| SKEW_TOLERANCE * row.length() / part;
    let tolerance = noise(x, a) + noise(y, c);
    let skew = right.dot(up).abs() / (a * c);
    // Written so that NaN (a row parallel to w, an overflow) is refused.
    let parallel = depth.length() <= 10.0 * SKEW_TOLERANCE * z.length();
    if !(parallel && tolerance < 1e-2) {
        return MatrixClass::Other;
    }
    let DVec4 { z: offset, w: last, .. } = matrix.w_axis;
    let moved = e / scale * last;
    let f = offset + moved;
    let significant = f.abs() >= OFFSET_SIGNIFICANCE * (offset.abs() + moved.abs()) && f != 0.0;
    let f = significant.then_some(f);
    let intrinsics = Intrinsics { a: a / scale, b: b / scale, c: c / scale, d: d / scale, e: e / scale, f };
    let finite = [intrinsics.a, intrinsics.b, intrinsics.c, intrinsics.d, intrinsics.e].iter().all(|n| n.is_finite());
    match () {
        () if !finite => MatrixClass::Other,
        () if skew <= tolerance => MatrixClass::Perspective(intrinsics),
        // Written so that NaN and matrices without an inverse are refused.
        () if skew < 1.0 - 1e-6 => MatrixClass::Stretched { e: intrinsics.e, f },
        () => MatrixClass::Other,
    }
}
