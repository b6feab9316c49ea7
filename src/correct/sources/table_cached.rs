//! Cached tables. At a start with tables, tracing a ray for each pixel is most of the work.

use crate::cache::{self, Cache, RawBytes};
use crate::correct::passes::table::Table;
use crate::error::Result;
use crate::rig::Rig;
use glam::DMat3;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// Returns the table of output `index` of `rig`, whose outputs have `sizes` pixels, from `cache` or
/// made by `make`.
///
/// # Errors
/// Those of `make`.
pub(in crate::correct) fn cached(
    rig: &Rig,
    index: usize,
    sizes: &[(u32, u32)],
    cache: &Cache,
    make: impl FnOnce() -> Result<Table>,
) -> Result<Table> {
    let size = sizes.get(index).copied().unwrap_or_default();
    cache.cached_as("table", &(rig, index, sizes), |bytes| read(bytes, size), write, make)
}

/// A table in a file. Pixels and numbers are raw bytes, which are copied in large pieces.
#[derive(Serialize, Deserialize)]
struct CachedTable<'bytes> {
    size: (u32, u32),
    step: u32,
    entries: (u32, u32),
    axes: DMat3,
    weighted: bool,
    error: f64,
    /// A bit for each pixel that shows something, the first one lowest.
    #[serde(borrow)]
    lit: RawBytes<'bytes>,
    /// Four f32, little end first, of each entry that is stored.
    #[serde(borrow)]
    texels: RawBytes<'bytes>,
}

/// True if an entry is stored: of a table of all pixels only those that show something.
fn is_stored(step: u32, lit: &[bool], entry: usize) -> bool {
    step > 1 || lit.get(entry).is_none_or(|lit| *lit)
}

fn write(table: &Table) -> Option<Vec<u8>> {
    let bits = |eight: &[bool]| eight.iter().rev().fold(0, |byte, lit| (byte << 1) | u8::from(*lit));
    let lit: Vec<u8> = table.lit.chunks(8).map(bits).collect();
    let stored = table.texels.iter().enumerate().filter(|(entry, _)| is_stored(table.step, &table.lit, *entry));
    let mut texels = Vec::with_capacity(16 * table.texels.len());
    for (_, texel) in stored {
        texel.iter().for_each(|part| texels.extend_from_slice(&part.to_le_bytes()));
    }
    cache::encode(&CachedTable {
        size: table.size,
        step: table.step,
        entries: table.entries,
        axes: table.axes,
        weighted: table.weighted,
        error: table.error,
        lit: RawBytes(&lit),
        texels: RawBytes(&texels),
    })
}

/// Reads a table of an output of `size` pixels.
fn read(bytes: &[u8], size: (u32, u32)) -> Option<Table> {
    let CachedTable { size: found, step, entries, axes, weighted, error, lit: RawBytes(bits), texels } =
        cache::decode(bytes)?;
    let area = |(width, height): (u32, u32)| usize::try_from(u64::from(width) * u64::from(height)).ok();
    let (pixels, count) = (area(size)?, area(entries)?);
    let is_sound = found == size && axes.is_finite() && error.is_finite() && bits.len() == pixels.div_ceil(8);
    // A table of all pixels has an entry for each.
    if !is_sound || step == 0 || (step == 1 && count != pixels) {
        return None;
    }
    let lit: Vec<bool> = (0..pixels).map(|pixel| bits[pixel / 8] >> (pixel % 8) & 1 == 1).collect();
    let stored = if step == 1 { lit.iter().filter(|lit| **lit).count() } else { count };
    let (values, []) = texels.0.as_chunks::<16>() else { return None };
    if values.len() != stored {
        return None;
    }
    let mut values = values.iter();
    let mut texels = vec![[0.0; 4]; count];
    let mut finite = true;
    for (_, texel) in texels.iter_mut().enumerate().filter(|(entry, _)| is_stored(step, &lit, *entry)) {
        let (parts, _) = values.next()?.as_chunks::<4>();
        *texel = std::array::from_fn(|part| f32::from_le_bytes(parts[part]));
        finite &= texel.iter().all(|value| value.is_finite());
    }
    finite.then_some(Table { size, step, entries, axes, texels, weighted, lit: Arc::new(lit), error })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::correct::passes::table::TablePixel;
    use crate::correct::sources::table_coarse::coarse;
    use crate::formats::{self, Levels, Node, Raster};
    use crate::geom::screen::{self, Faces};
    use crate::views::tests::{fisheye, lens, projector, rig};
    use glam::{DVec2, DVec3};

    fn sample(size: (u32, u32)) -> Table {
        Table::new(size, |column, row| {
            let direction = DVec3::new(f64::from(column) - 3.1, f64::from(row) - 2.2, -4.0);
            (column % 3 != 1).then_some(TablePixel { direction, weight: 0.1 * f64::from(row), dark: 0.01 })
        })
    }

    #[test]
    fn what_is_cached_is_the_table() {
        let one = rig(vec![projector("p", DVec3::new(0.5, 0.0, 1.0), [20.0, 10.0, 5.0], lens(60.0, 40.0))]);
        let shown = crate::correct::sources::surface_sample::SurfaceSampler::new(&one, 0, &[(160, 90)]).expect("a map");
        let coarse = coarse(&shown, 0.1);
        assert!(coarse.step() > 1, "a coarse table");
        for table in [sample((7, 5)), sample((0, 0)), sample((64, 1)), coarse] {
            let bytes = write(&table).expect("bytes");
            let size = table.size;
            assert_eq!(read(&bytes, size), Some(table));
            // Truncated data is refused. Changed data is refused or read as another table, without
            // asking for more bytes than there are.
            for length in 0..bytes.len().min(2000) {
                assert!(read(&bytes[..length], size).is_none(), "{length}");
            }
            for at in 0..bytes.len().min(300) {
                for change in [0xFF, 0x80, 1] {
                    let mut other = bytes.clone();
                    other[at] ^= change;
                    read(&other, size);
                }
            }
        }
    }

    /// Keys contain a checksum of large data. If the sum missed a change, an old result would be
    /// used.
    #[test]
    fn every_number_of_large_data_counts_in_keys() {
        fn differ<T: Serialize + std::fmt::Debug>(values: &[T]) {
            let texts = values.iter().map(|value| format!("{value:?}").into_bytes());
            let keys = values.iter().map(|value| cache::encode(value).expect("bytes"));
            for found in [texts.collect::<Vec<_>>(), keys.collect()] {
                for (index, one) in found.iter().enumerate() {
                    assert!(one.len() < 400, "the numbers themselves are left out: {one:?}");
                    assert!(!found[..index].contains(one), "{index}: {one:?}");
                }
            }
        }
        /// The numbers as they are, and with each of them changed in its last bit.
        fn nudged<const N: usize>(numbers: [f32; N]) -> Vec<[f32; N]> {
            let changed = (0..N).map(|at| {
                let mut other = numbers;
                other[at] = f32::from_bits(other[at].to_bits() ^ 1);
                other
            });
            std::iter::once(numbers).chain(changed).collect()
        }
        let pixels = nudged([0.1, 0.2, 0.3, 0.4, 0.5, 0.6]);
        let pair = |[a, b, c, d, e, f]: [f32; 6]| vec![[a, b, c], [d, e, f]];
        let raster = |values| Raster::new((2, 1), pair(values)).expect("two pixels");
        differ(&pixels.iter().copied().map(raster).collect::<Vec<_>>());
        differ(&pixels.iter().map(|values| Levels { size: (2, 1), values: pair(*values) }).collect::<Vec<_>>());

        let corners = nudged([0.0, 0.0, 1.0, 1.0, 0.0, 2.0, 0.0, 1.0, 3.0]).into_iter().map(|n| n.map(f64::from));
        let screens = corners.flat_map(|[a, b, c, d, e, f, g, h, i]| {
            let triangle = [DVec3::new(a, b, c), DVec3::new(d, e, f), DVec3::new(g, h, i)];
            [Faces::Front, Faces::Back].map(|faces| screen::Mesh::new(vec![triangle], faces).expect("a triangle"))
        });
        differ(&screens.collect::<Vec<_>>());

        let node = |x: f32, y: f32, value: [f32; 3], intensity: f32| Node {
            position: DVec2::new(x.into(), y.into()),
            value: DVec3::from_array(value.map(f64::from)),
            intensity: intensity.into(),
        };
        let mesh = |[x, y, a, b, c, intensity]: [f32; 6], turned: bool| {
            let nodes =
                vec![node(x, y, [a, b, c], intensity), node(1.0, 0.0, [1.0; 3], 1.0), node(0.0, 1.0, [2.0; 3], 1.0)];
            formats::Mesh::new("mesh", nodes, vec![if turned { [0, 2, 1] } else { [0, 1, 2] }]).expect("a mesh")
        };
        differ(&pixels.iter().flat_map(|n| [mesh(*n, false), mesh(*n, true)]).collect::<Vec<_>>());

        let table = sample((9, 9));
        let mut tables = vec![table.clone()];
        for (entry, part) in [(0, 0), (2, 1), (40, 2), (80, 3)] {
            let mut other = table.clone();
            other.texels[entry][part] = f32::from_bits(other.texels[entry][part].to_bits() ^ 1);
            tables.push(other);
        }
        for pixel in [0, 63, 64, 80] {
            let mut other = table.clone();
            let mut lit = other.lit.to_vec();
            lit[pixel] = !lit[pixel];
            other.lit = Arc::new(lit);
            tables.push(other);
        }
        differ(&tables);
    }

    #[test]
    fn a_table_of_another_rig_is_made_anew() {
        let cache = Cache::in_memory();
        let one = rig(vec![fisheye(180.0, 90.0)]);
        let mut other = one.clone();
        other.outputs[0].blend.gamma += f64::EPSILON * 2.0;
        let table = |rig: &Rig, size: (u32, u32)| {
            let made = cached(rig, 0, &[size], &cache, || Ok(sample(size))).expect("a table");
            assert_eq!(made, sample(size));
        };
        for _ in 0..3 {
            table(&one, (7, 5));
            table(&other, (7, 5));
            table(&one, (7, 6));
        }
        assert_eq!(cache.counts().missing, 3);
    }
}
