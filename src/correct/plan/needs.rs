//! Needs of blocks. They are cached, since finding them can mean examining every pixel.

use crate::cache::Cache;
use crate::geom::Frustum;
use glam::DVec2;
use serde::Serialize;
use std::convert::Infallible;

/// Needs of a block. Views and neighbours are sets of bits; the last bit, 63 or 127, stands for all
/// further ones.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub(super) struct Needs {
    pub(super) views: u64,
    pub(super) neighbours: u128,
    /// True if some pixel shows nothing.
    pub(super) dark: bool,
    /// True if some pixel shows something.
    pub(super) lit: bool,
}

impl Needs {
    /// Returns the view, if there is only one.
    pub(super) fn only_view(&self) -> Option<u32> {
        (self.views.count_ones() == 1).then(|| self.views.trailing_zeros())
    }

    pub(super) fn and(self, other: &Self) -> Self {
        Self {
            views: self.views | other.views,
            neighbours: self.neighbours | other.neighbours,
            dark: self.dark | other.dark,
            lit: self.lit | other.lit,
        }
    }
}

/// Results for the blocks of one output.
#[derive(Clone, Debug, Default)]
pub(in crate::correct) struct Examined {
    /// Needs of every block, row by row.
    pub(super) needs: Vec<Needs>,
    /// For each of the output's views, the tangents of directions by which it has to be widened: no
    /// view surely contains them, and this view is the nearest.
    pub beyond: Vec<Option<Frustum>>,
    /// Pixel positions whose directions are too far from the axes of all views; at most
    /// [`MOST_UNSEEN`].
    pub unseen: Vec<DVec2>,
}

/// Greatest number of positions that no view can show. Views that are added for these also show
/// others like them, or can be widened.
pub(super) const MOST_UNSEEN: usize = 4096;

/// Cached form: runs of blocks with the same needs, with their lengths, the tangents beyond each
/// view, and the positions that no view can show.
type Kept = (Vec<(u32, Needs)>, Vec<Option<Frustum>>, Vec<DVec2>);

/// Returns the result of `compute` for these numbers of blocks and views, or the cached result for
/// `key`.
pub(super) fn cached(
    key: &impl Serialize,
    blocks: usize,
    views: usize,
    cache: &Cache,
    compute: impl FnOnce() -> Examined,
) -> Examined {
    let is_sound = |(runs, beyond, unseen): &Kept| {
        is_sound(runs, blocks)
            && beyond.len() == views
            && beyond.iter().flatten().all(Frustum::is_finite)
            && unseen.len() <= MOST_UNSEEN
            && unseen.iter().all(|place| place.is_finite())
    };
    let compute = || {
        let Examined { needs, beyond, unseen } = compute();
        Ok((runs(&needs), beyond, unseen))
    };
    let found: Result<Kept, Infallible> = cache.cached("blocks", key, is_sound, compute);
    let Ok((runs, beyond, unseen)) = found;
    let needs = runs.iter().flat_map(|(length, needs)| std::iter::repeat_n(*needs, *length as usize)).collect();
    Examined { needs, beyond, unseen }
}

/// Returns runs of blocks with the same needs, with their lengths.
fn runs(needs: &[Needs]) -> Vec<(u32, Needs)> {
    needs.chunk_by(|one, other| one == other).map(|run| (run.len() as u32, run[0])).collect()
}

/// True if the runs have this number of blocks in total.
fn is_sound(runs: &[(u32, Needs)], blocks: usize) -> bool {
    runs.iter().map(|(length, _)| u64::from(*length)).sum::<u64>() == blocks as u64
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cache::{decode, encode};

    #[test]
    fn what_is_cached_is_what_was_found() {
        let of = |number: u64| Needs {
            views: number << 62 | number,
            neighbours: u128::from(number) << 126 | u128::from(number),
            dark: number.is_multiple_of(3),
            lit: number.is_multiple_of(2),
        };
        let needs: Vec<Needs> = (0..200).map(|block| of(block / 7 % 5)).collect();
        let runs = runs(&needs);
        let bytes = encode(&runs).expect("bytes");
        assert!(bytes.len() < 200 * 7, "runs: {}", bytes.len());
        assert_eq!(decode::<Vec<(u32, Needs)>>(&bytes).as_ref(), Some(&runs));
        assert!(is_sound(&runs, 200) && !is_sound(&runs, 201) && !is_sound(&runs, 197));
        for length in 0..bytes.len() {
            assert_eq!(decode::<Vec<(u32, Needs)>>(&bytes[..length]), None);
        }
    }
}
