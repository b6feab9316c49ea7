//! Settings of the programs that are the same on all nodes: those of node 0.

use crate::launch::clock::Rate;
use crate::run::Options;

/// Settings that all nodes take from node 0.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Agreed {
    /// Rate of the clock; `None`: the programs have clocks of their own.
    rate: Option<Rate>,
    /// Seed of the random numbers.
    seed: u64,
    /// Start of the dates in seconds since 1970; 0: the usual one.
    start: u64,
    /// Size of the window; `None`: each program chooses its own.
    size: Option<(u32, u32)>,
}

impl Agreed {
    /// Number of words of [`Agreed::words`].
    pub const WORDS: usize = 4;

    /// The settings in these options.
    pub fn of_options(options: &Options) -> Self {
        let (seed, start) = options.clock.numbers();
        Self { rate: options.clock.clock, seed, start, size: options.size }
    }

    /// Sets the options to these settings. A size that node 0 leaves open stays as it is.
    pub fn apply(&self, options: &mut Options) {
        options.clock.set(self.rate, (self.seed, self.start));
        options.size = self.size.or(options.size);
    }

    /// The settings that differ from those of a node's options; `None`: there are none.
    pub fn differences(&self, own: &Self) -> Option<String> {
        let rate = |of: &Self| {
            of.rate.map_or_else(
                || "--own-clocks".to_owned(),
                |Rate { frames, seconds }| match seconds {
                    1 => format!("--clock {frames}"),
                    _ => format!("--clock {frames}/{seconds}"),
                },
            )
        };
        let size = |of: &Self| of.size.map_or_else(String::new, |(width, height)| format!("--size {width}x{height}"));
        let start = |of: &Self| match of.start {
            0 => "the usual --clock-start".to_owned(),
            start => format!("--clock-start {start} s after 1970"),
        };
        let seed = |of: &Self| format!("--seed {}", of.seed);
        let pairs = [
            (rate(self), rate(own)),
            (seed(self), seed(own)),
            (start(self), start(own)),
            (size(self), if self.size.is_some() { size(own) } else { String::new() }),
        ];
        let differ = pairs.iter().filter(|(first, own)| first != own && !own.is_empty());
        let texts: Vec<String> = differ.map(|(first, own)| format!("{first} instead of {own}")).collect();
        (!texts.is_empty()).then(|| texts.join(", "))
    }

    /// The settings as numbers.
    pub fn words(&self) -> [u64; Self::WORDS] {
        let rate = self.rate.map_or(0, |Rate { frames, seconds }| frames << 32 | seconds);
        let size = self.size.map_or(0, |(width, height)| u64::from(width) << 32 | u64::from(height));
        [rate, self.seed, self.start, size]
    }

    /// Decodes what [`Agreed::words`] made.
    pub fn of([rate, seed, start, size]: [u64; Self::WORDS]) -> Self {
        let halves = |word: u64| (word != 0).then_some(((word >> 32) as u32, word as u32));
        let rate = halves(rate).map(|(frames, seconds)| Rate { frames: frames.into(), seconds: seconds.max(1).into() });
        Self { rate, seed, start, size: halves(size) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn differences_name_both_values() {
        let first = Agreed { rate: Some(Rate { frames: 60, seconds: 1 }), seed: 7, start: 0, size: Some((96, 54)) };
        let other = Agreed { seed: 8, size: Some((64, 64)), ..first };
        let words = "--seed 7 instead of --seed 8, --size 96x54 instead of --size 64x64";
        assert_eq!(first.differences(&other).as_deref(), Some(words));
        assert_eq!(first.differences(&first), None);
        assert_eq!(Agreed { size: None, ..first }.differences(&first), None, "node 0 leaves it open");
        assert_eq!(
            Agreed { rate: None, ..first }.differences(&first).as_deref(),
            Some("--own-clocks instead of --clock 60")
        );
        for settings in [first, other, Agreed::default()] {
            assert_eq!(Agreed::of(settings.words()), settings);
        }
    }
}
