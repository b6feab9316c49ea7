//! What blocks need as bytes: where nothing is known between pixels, finding it looks at them all.

use crate::cache::{Cache, Reader, Writer};
use crate::correct::plan::blocks::{Examiner, Needs};
use crate::views::View;
use std::convert::Infallible;

/// [`Examiner::all`] for an output with these views, or what `cache` kept of it.
pub(super) fn needs(examiner: &Examiner<'_>, views: &[&View], cache: &Cache) -> Vec<Needs> {
    let Examiner { source, size, filter, flip, views: _, neighbours: _ } = examiner;
    let found: Result<_, Infallible> = cache.kept(
        "blocks",
        |key| key.debug(source).debug(size).debug(filter).debug(flip).debug(&views),
        |reader| read(reader, examiner.blocks()),
        |needs, writer| write(needs, writer),
        || Ok(examiner.all()),
    );
    let Ok(needs) = found;
    needs
}

/// Runs of blocks that need the same.
fn write(needs: &[Needs], to: &mut Writer) -> bool {
    for run in needs.chunk_by(|one, other| one == other) {
        to.u32(run.len() as u32);
        let Needs { views, neighbours, dark, lit } = run[0];
        to.bytes(&views.to_le_bytes());
        to.bytes(&neighbours.to_le_bytes());
        to.bool(dark);
        to.bool(lit);
    }
    true
}

/// So many blocks.
fn read(from: &mut Reader<'_>, blocks: usize) -> Option<Vec<Needs>> {
    let mut needs = Vec::with_capacity(blocks);
    while needs.len() < blocks {
        let run = from.u32()? as usize;
        let views = u64::from_le_bytes(from.bytes(8)?.try_into().ok()?);
        let neighbours = u128::from_le_bytes(from.bytes(16)?.try_into().ok()?);
        let (dark, lit) = (from.bool()?, from.bool()?);
        if run == 0 || run > blocks - needs.len() {
            return None;
        }
        needs.resize(needs.len() + run, Needs { views, neighbours, dark, lit });
    }
    Some(needs)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_kept_is_what_was_found() {
        let of = |number: u64| Needs {
            views: number << 62 | number,
            neighbours: u128::from(number) << 126 | u128::from(number),
            dark: number.is_multiple_of(3),
            lit: number.is_multiple_of(2),
        };
        let needs: Vec<Needs> = (0..200).map(|block| of(block / 7 % 5)).collect();
        let mut writer = Writer::default();
        assert!(write(&needs, &mut writer));
        let bytes = writer.finish();
        assert!(bytes.len() < 200 * 7, "runs: {}", bytes.len());
        assert_eq!(read(&mut Reader::new(&bytes), 200).as_ref(), Some(&needs));
        assert_eq!(read(&mut Reader::new(&bytes), 201), None);
        assert_eq!(read(&mut Reader::new(&bytes), 197), None);
        for length in 0..bytes.len() {
            assert_eq!(read(&mut Reader::new(&bytes[..length]), 200), None);
        }
    }
}
