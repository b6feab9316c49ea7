//! Limit on the number of flushes that show the front buffer.

use std::time::{Duration, Instant};

/// Count of recent flushes. It limits the number of flushes that are answered.
#[derive(Default)]
pub struct FrontBufferThrottle {
    begun: Option<Instant>,
    shown: u32,
}

/// Time over which flushes are counted.
pub(in crate::intercept::gl) const SPAN: Duration = Duration::from_millis(16);

/// Greatest number of flushes in a span that are answered. More flushes come from a program that
/// flushes after each primitive.
pub(in crate::intercept::gl) const MOST: u32 = 8;

impl FrontBufferThrottle {
    /// True if one more frame may be shown `now`.
    pub(in crate::intercept::gl) fn allows(&mut self, now: Instant) -> bool {
        if self.begun.is_none_or(|begun| now.duration_since(begun) > SPAN) {
            *self = Self { begun: Some(now), shown: 0 };
        }
        self.shown += 1;
        self.shown <= MOST
    }
}

#[cfg(test)]
mod tests {
    use super::{FrontBufferThrottle, MOST, SPAN};
    use std::time::Instant;

    #[test]
    fn a_flush_after_each_primitive_is_slowed_down_and_a_single_one_never() {
        let start = Instant::now();
        let mut pace = FrontBufferThrottle::default();
        assert_eq!((0..1000).filter(|_| pace.allows(start)).count(), MOST as usize);
        assert!((1..50).all(|i| pace.allows(start + (SPAN * 2) * i)));
    }
}
