//! Merging the blocks of an output into few rectangles.

use crate::geom::rectangle::PixelRect;

/// Side of a block in pixels. Blocks are squares, except those at the right and the bottom border.
pub(in crate::correct) const BLOCK: u32 = 16;

/// Returns rectangles that cover exactly the blocks of each class, without overlap. `classes` holds
/// a class per block of `block` × `block` pixels, row by row. The result has an entry for each of
/// the classes `0..count`.
///
/// The method is greedy: equal blocks in a row form runs, and equal runs below each other are
/// joined.
pub(in crate::correct) fn merge(
    classes: &[Option<usize>],
    block: u32,
    size: (u32, u32),
    count: usize,
) -> Vec<Vec<PixelRect>> {
    let columns = size.0.div_ceil(block);
    let mut merged: Vec<Vec<PixelRect>> = vec![Vec::new(); count];
    // Rectangles that end at the row above: first block, number of blocks, class, place in
    // `merged`.
    let mut open: Vec<(u32, u32, usize, usize)> = Vec::new();
    for (row, blocks) in (0u32..).zip(classes.chunks(columns.max(1) as usize)) {
        let (top, bottom) = (row * block, ((row + 1) * block).min(size.1));
        let mut still_open = Vec::with_capacity(open.len());
        let mut column = 0u32;
        for run in blocks.chunk_by(|a, b| a == b) {
            let (first, length) = (column, run.len() as u32);
            column += length;
            let Some(class) = run[0] else { continue };
            let above = open.binary_search_by_key(&first, |rectangle| rectangle.0).ok().map(|index| open[index]);
            let place = match above {
                Some((_, same_length, same_class, place)) if same_length == length && same_class == class => {
                    merged[class][place].height = bottom - merged[class][place].y;
                    place
                }
                _ => {
                    let (left, right) = (first * block, ((first + length) * block).min(size.0));
                    merged[class].push(PixelRect { x: left, y: top, width: right - left, height: bottom - top });
                    merged[class].len() - 1
                }
            };
            still_open.push((first, length, class, place));
        }
        open = still_open;
    }
    merged
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::random::Random;

    #[test]
    fn covers_each_block_once_with_its_own_class() {
        let size = (16 * 7 + 5u32, 16 * 9 + 1u32);
        let (columns, rows) = (size.0.div_ceil(BLOCK), size.1.div_ceil(BLOCK));
        let mut random = Random::new(12345);
        let mut class = None;
        for blur in [1, 3, 8] {
            let classes: Vec<Option<usize>> = (0..columns * rows)
                .map(|index| {
                    if index % blur == 0 {
                        class = (random.below(4) != 0).then(|| random.below(3));
                    }
                    class
                })
                .collect();
            let merged = merge(&classes, BLOCK, size, 3);
            let mut painted = vec![None; (size.0 * size.1) as usize];
            for (class, rectangle) in
                merged.iter().enumerate().flat_map(|(class, all)| all.iter().map(move |r| (class, r)))
            {
                for y in rectangle.y..rectangle.y + rectangle.height {
                    for x in rectangle.x..rectangle.x + rectangle.width {
                        let pixel = &mut painted[(y * size.0 + x) as usize];
                        assert_eq!(*pixel, None, "painted twice at {x}, {y}");
                        *pixel = Some(class);
                    }
                }
            }
            for y in 0..size.1 {
                for x in 0..size.0 {
                    let block = classes[(y / BLOCK * columns + x / BLOCK) as usize];
                    assert_eq!(painted[(y * size.0 + x) as usize], block, "at {x}, {y}");
                }
            }
        }
    }

    #[test]
    fn one_class_is_one_rectangle() {
        let merged = merge(&[Some(0); 12], BLOCK, (60, 40), 1);
        assert_eq!(merged, [vec![PixelRect { x: 0, y: 0, width: 60, height: 40 }]]);
    }
}
