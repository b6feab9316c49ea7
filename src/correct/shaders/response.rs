//! The display's response, as the shaders evaluate it: a linear-light weight becomes a factor on
//! encoded values.

/// Number of coefficients of [`encoding_polynomial`].
pub const COEFFICIENTS: usize = 8;

/// Coefficients h (constant first) of `w^(1/γ) ≈ t·(1 + (t − 1)·h(t))`, `t = ⁴√w`, for 0 ≤ w ≤ 1.
///
/// Two square roots and a polynomial cost a third of the power function, are exactly 0 at 0 and 1
/// at 1 (so that nothing changes where only one projector lights a point), and need no test for 0.
/// The fourth root turns the exponent 1/γ, whose slope at 0 no polynomial follows, into 4/γ.
/// Absolute error ≤ 6.1e-4 for 1 ≤ γ ≤ 4, a sixth of a step of 8 bits, and ≤ 1.6e-4 up to γ 2.4; γ
/// outside 1…4 is clamped.
pub fn encoding_polynomial(gamma: f64) -> [f64; COEFFICIENTS] {
    // t^(4/γ) = t·t^e
    let e = 4.0 / gamma.clamp(1.0, 4.0) - 1.0;
    let h = |t: f64| if 1.0 - t < 1e-9 { e } else { (t.powf(e) - 1.0) / (t - 1.0) };
    // Newton's divided differences, then powers of t. The nodes are Chebyshev's, moved up a little,
    // since near 0 the factor t hides errors.
    let chebyshev = |i: usize| 0.5 - 0.5 * (std::f64::consts::PI * (i as f64 + 0.5) / COEFFICIENTS as f64).cos();
    let node = |i: usize| chebyshev(i).powf(0.8);
    let mut differences: [f64; COEFFICIENTS] = std::array::from_fn(|i| h(node(i)));
    for order in 1..COEFFICIENTS {
        for i in (order..COEFFICIENTS).rev() {
            differences[i] = (differences[i] - differences[i - 1]) / (node(i) - node(i - order));
        }
    }
    let mut powers = [0.0; COEFFICIENTS];
    for i in (0..COEFFICIENTS).rev() {
        // powers = powers·(t − node) + difference
        for k in (1..COEFFICIENTS).rev() {
            powers[k] = powers[k - 1] - node(i) * powers[k];
        }
        powers[0] = differences[i] - node(i) * powers[0];
    }
    powers
}

#[cfg(test)]
mod tests {
    use super::*;

    fn encode(h: &[f64; COEFFICIENTS], w: f64) -> f64 {
        let t = w.sqrt().sqrt();
        t * (1.0 + (t - 1.0) * h.iter().rev().fold(0.0, |sum, c| sum * t + c))
    }

    fn worst(h: &[f64; COEFFICIENTS], gamma: f64) -> f64 {
        (0..=100_000)
            .map(|i| (f64::from(i) / 100_000.0).powi(3))
            .map(|w| (encode(h, w) - w.powf(1.0 / gamma)).abs())
            .fold(0.0, f64::max)
    }

    #[test]
    fn is_the_power_function() {
        for i in 0..=60 {
            let gamma = 1.0 + f64::from(i) * 0.05;
            let h = encoding_polynomial(gamma);
            let error = worst(&h, gamma);
            assert!(error <= if gamma <= 2.4 { 1.6e-4 } else { 6.1e-4 }, "γ {gamma}: {error:e}");
            assert_eq!((encode(&h, 0.0), encode(&h, 1.0)), (0.0, 1.0));
        }
        // Negative control: another display's response is not the same.
        assert!(worst(&encoding_polynomial(2.2), 2.3) > 1e-2);
    }
}
