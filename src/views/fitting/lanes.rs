//! Four numbers at a time.
//!
//! Plain arrays, of which compilers make vector instructions; what is computed is to the bit what single numbers give.

use std::ops::{Add, Div, Mul, Neg, Sub};

/// How many numbers.
pub(in crate::views) const LANES: usize = 4;

/// Numbers that are computed alike.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::views) struct Lanes(pub [f64; LANES]);

impl Lanes {
    /// The same number in all.
    pub fn all(value: f64) -> Self {
        Self([value; LANES])
    }

    /// The results of `of`.
    #[inline(always)]
    fn each(self, other: Self, of: impl Fn(f64, f64) -> f64) -> Self {
        Self(std::array::from_fn(|lane| of(self.0[lane], other.0[lane])))
    }

    /// The greater ones; those of `self` where one is no number.
    #[inline(always)]
    pub fn max(self, other: Self) -> Self {
        self.each(other, |a, b| if b > a { b } else { a })
    }

    /// The smaller ones; those of `self` where one is no number.
    #[inline(always)]
    pub fn min(self, other: Self) -> Self {
        self.each(other, |a, b| if b < a { b } else { a })
    }

    /// The square roots.
    #[inline(always)]
    pub fn sqrt(self) -> Self {
        Self(self.0.map(f64::sqrt))
    }

    /// The greatest of them that is a number.
    pub fn greatest(self) -> f64 {
        self.0.into_iter().fold(f64::NEG_INFINITY, f64::max)
    }

    /// The least of them that is a number.
    pub fn least(self) -> f64 {
        self.0.into_iter().fold(f64::INFINITY, f64::min)
    }
}

/// Operators, number by number.
macro_rules! operators {
    ($($trait:ident $method:ident $operator:tt),*) => {
        $(impl $trait for Lanes {
            type Output = Self;

            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                self.each(other, |a, b| a $operator b)
            }
        })*
    };
}

operators!(Add add +, Sub sub -, Mul mul *, Div div /);

impl Neg for Lanes {
    type Output = Self;

    #[inline(always)]
    fn neg(self) -> Self {
        Self(self.0.map(|value| -value))
    }
}
