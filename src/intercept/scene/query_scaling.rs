//! Factors for query results. A draw is issued once per view, but the program gets the count of its
//! own picture.
//!
//! - Samples: the sum over all views, scaled so that drawing that fills the program's own picture
//!   counts as many samples as that picture has. Samples outside the program's own picture count
//!   too. Otherwise the program would leave out objects that are only visible on the dome.
//! - Primitives, vertices and the shader invocations for them: divided by the number of times that
//!   the draw was issued.
//! - Time, and whether any sample passed: unchanged.
//!
//! A factor never turns a count above 0 into 0: the result is at least 1.

/// Quantity that a query counts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quantity {
    /// Samples and fragments.
    Samples,
    /// Primitives, vertices, and invocations of the stages before rasterisation.
    Primitives,
    /// Time, and everything else that does not depend on the number of issued draws.
    Unscaled,
}

/// Factors for the counts of a query.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct QueryScaling {
    /// Factor for samples; 0: samples are not counted.
    pub samples: f64,
    /// Factor for primitives.
    pub primitives: f64,
}

impl QueryScaling {
    /// The factors of draws that are issued once.
    pub const ONCE: Self = Self { samples: 1.0, primitives: 1.0 };

    /// The factor for a quantity.
    pub fn of(&self, quantity: Quantity) -> f64 {
        match quantity {
            Quantity::Samples => self.samples,
            Quantity::Primitives => self.primitives,
            Quantity::Unscaled => 1.0,
        }
    }
}

/// Returns the factor of a count: the size `own` of the program's picture divided by the size
/// `issued` of all targets that the draw is issued to. Returns 1 if that is not a positive number.
pub fn factor(own: f64, issued: f64) -> f64 {
    let ratio = own / issued;
    if ratio.is_finite() && ratio > 0.0 { ratio } else { 1.0 }
}

#[cfg(test)]
mod tests {
    use super::{Quantity, QueryScaling, factor};

    #[test]
    fn each_quantity_has_its_factor() {
        let factors = QueryScaling { samples: 0.5, primitives: 0.25 };
        assert_eq!(
            [Quantity::Samples, Quantity::Primitives, Quantity::Unscaled].map(|q| factors.of(q)),
            [0.5, 0.25, 1.0]
        );
        assert_eq!(QueryScaling::ONCE.of(Quantity::Samples), 1.0);
    }

    #[test]
    fn a_factor_is_a_positive_number() {
        assert_eq!(factor(100.0, 400.0), 0.25);
        for (own, issued) in [(0.0, 400.0), (100.0, 0.0), (0.0, 0.0), (f64::NAN, 1.0), (1.0, f64::INFINITY)] {
            assert_eq!(factor(own, issued), 1.0, "{own} of {issued}");
        }
    }
}
