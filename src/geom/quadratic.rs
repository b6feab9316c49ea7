//! The exact closed form of a pinhole ray that meets a sphere and is seen by a perspective view.

/// `s(x, y) = Q(x, y) + L(x, y)·√D(x, y)`: 33 coefficients over the monomials in the order
/// `[x², y², xy, x, y, 1]` (Q and D) and `[x, y, 1]` (L). `s` is a homogeneous direction with
/// positive scale; the ray meets the sphere iff `D ≥ 0`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct QuadraticForm {
    /// The quadratic part, a row per component of `s`.
    pub q: [[f64; 6]; 3],
    /// The linear factor of the root, a row per component of `s`.
    pub l: [[f64; 3]; 3],
    /// The discriminant.
    pub d: [f64; 6],
}
