//! Computation with four numbers at a time, as [`DVec4`]. Compilers make vector instructions of it,
//! and the results are those of single numbers to the bit.
//!
//! `DVec4::max` returns its argument where either number is NaN. The functions here keep the value
//! that was found so far.

use glam::DVec4;

/// Number of lanes.
pub(in crate::views) const LANES: usize = 4;

/// Returns the greater numbers; those of `found` where one is NaN.
#[inline(always)]
pub(in crate::views) fn greater(found: DVec4, other: DVec4) -> DVec4 {
    other.max(found)
}

/// Returns the smaller numbers; those of `found` where one is NaN.
#[inline(always)]
pub(in crate::views) fn lesser(found: DVec4, other: DVec4) -> DVec4 {
    other.min(found)
}

/// Returns the greatest number that is not NaN.
pub(in crate::views) fn greatest(numbers: DVec4) -> f64 {
    numbers.to_array().into_iter().fold(f64::NEG_INFINITY, f64::max)
}

/// Returns the least number that is not NaN.
pub(in crate::views) fn least(numbers: DVec4) -> f64 {
    numbers.to_array().into_iter().fold(f64::INFINITY, f64::min)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_no_number_changes_nothing() {
        let (found, nan) = (DVec4::new(1.0, -2.0, 0.0, f64::NAN), DVec4::new(f64::NAN, 3.0, f64::NAN, 4.0));
        assert_eq!(greater(found, nan).to_array()[..3], [1.0, 3.0, 0.0]);
        assert_eq!(lesser(found, nan).to_array()[..3], [1.0, -2.0, 0.0]);
        assert!(greater(found, nan).w.is_nan() && lesser(found, nan).w.is_nan());
        assert_eq!((greatest(nan), least(nan)), (4.0, 3.0));
    }
}
