//! Cached needs of blocks: where nothing is known between pixels, finding them looks at all pixels.

use crate::cache::Cache;
use crate::correct::plan::blocks::{Examiner, Needs};
use crate::views::View;
use std::convert::Infallible;

/// Returns [`Examiner::all`] for an output with these views, or what `cache` has of it.
pub(super) fn needs(examiner: &Examiner<'_>, views: &[&View], cache: &Cache) -> Vec<Needs> {
    let Examiner { source, size, filter, flip, views: _, neighbours: _ } = examiner;
    let key = (source, size, filter, flip, views);
    let is_sound = |runs: &Vec<(u32, Needs)>| is_sound(runs, examiner.blocks());
    let found: Result<_, Infallible> = cache.cached("blocks", &key, is_sound, || Ok(runs(&examiner.all())));
    let Ok(runs) = found;
    runs.iter().flat_map(|(length, needs)| std::iter::repeat_n(*needs, *length as usize)).collect()
}

/// Runs of blocks with the same needs, with their lengths.
fn runs(needs: &[Needs]) -> Vec<(u32, Needs)> {
    needs.chunk_by(|one, other| one == other).map(|run| (run.len() as u32, run[0])).collect()
}

/// Whether the runs are those of so many blocks.
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
