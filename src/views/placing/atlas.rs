//! Packing tiles into the atlas.

use crate::views::view_plan::Tile;

/// Returns places for rectangles of the given sizes, and the width and height that hold them all.
/// The first lies at the origin. At least `gutter` texels stay free between any two.
///
/// Skyline packing, bottom-left rule, tallest first, for a series of widths; the smallest area
/// wins. `None` if nothing that was tried fits into `limit × limit`. Deterministic. Takes O(n³) for
/// n tiles, of which there are about twenty at most.
pub(crate) fn pack(sizes: &[(u32, u32)], gutter: u32, limit: u32) -> Option<(Vec<Tile>, (u32, u32))> {
    if sizes.is_empty() {
        return Some((Vec::new(), (0, 0)));
    }
    let widest = sizes.iter().map(|size| size.0).max()?;
    let total: u64 = sizes.iter().map(|size| u64::from(size.0 + gutter)).sum();
    let most = u32::try_from(total.min(u64::from(limit))).ok()?;
    if widest > limit || sizes.iter().any(|size| size.1 > limit) {
        return None;
    }
    let mut order: Vec<usize> = (1..sizes.len()).collect();
    order.sort_by_key(|&index| (std::cmp::Reverse(sizes[index].1), std::cmp::Reverse(sizes[index].0), index));
    order.insert(0, 0);

    let mut best: Option<(Vec<Tile>, (u32, u32))> = None;
    for width in widths(sizes, gutter, widest, most) {
        let (tiles, used) = skyline(sizes, &order, gutter, width);
        let area = |size: (u32, u32)| u64::from(size.0) * u64::from(size.1);
        let longest = |size: (u32, u32)| size.0.max(size.1);
        let better =
            best.as_ref().is_none_or(|(_, other)| (area(used), longest(used)) < (area(*other), longest(*other)));
        if used.0 <= limit && used.1 <= limit && better {
            best = Some((tiles, used));
        }
    }
    best
}

/// Returns the widths worth trying: sums of a few tiles' widths, and even steps between.
fn widths(sizes: &[(u32, u32)], gutter: u32, widest: u32, most: u32) -> Vec<u32> {
    const STEPS: u32 = 32;
    let mut widths: Vec<u32> = (0..=STEPS)
        .map(|step| widest + (most.saturating_sub(widest) as u64 * u64::from(step) / u64::from(STEPS)) as u32)
        .collect();
    for (index, a) in sizes.iter().enumerate() {
        for (other, b) in sizes.iter().enumerate().skip(index + 1) {
            widths.push(a.0 + gutter + b.0);
            widths.extend(sizes.iter().skip(other + 1).map(|c| a.0 + b.0 + c.0 + 2 * gutter));
        }
    }
    widths.retain(|&width| width >= widest && width <= most.max(widest));
    widths.sort_unstable();
    widths.dedup();
    widths
}

/// One piece of the skyline: everything below `y` between `x` and `x + width` is taken.
#[derive(Clone, Copy)]
struct Step {
    x: u32,
    y: u32,
    width: u32,
}

/// Places the tiles in `order` into a strip of the given width.
fn skyline(sizes: &[(u32, u32)], order: &[usize], gutter: u32, width: u32) -> (Vec<Tile>, (u32, u32)) {
    let mut tiles = vec![Tile { x: 0, y: 0, width: 0, height: 0 }; sizes.len()];
    // The strip is one gutter wider, since a gutter lies to the right of each tile.
    let mut steps = vec![Step { x: 0, y: 0, width: width + gutter }];
    let mut used = (0, 0);
    for &index in order {
        let (tile_width, tile_height) = sizes[index];
        let needed = tile_width + gutter;
        let place = (0..steps.len())
            .filter(|&first| steps[first].x + needed <= width + gutter)
            .map(|first| (height_over(&steps[first..], needed), steps[first].x))
            .min();
        // The strip is at least as wide as the widest tile, so that there is always a place.
        let Some((y, x)) = place else { continue };
        tiles[index] = Tile { x, y, width: tile_width, height: tile_height };
        used = (used.0.max(x + tile_width), used.1.max(y + tile_height));
        raise(&mut steps, x, needed, y + tile_height + gutter);
    }
    (tiles, used)
}

/// Returns the greatest height of the skyline from the start of `steps` over `width`.
fn height_over(steps: &[Step], width: u32) -> u32 {
    let end = steps[0].x + width;
    steps.iter().take_while(|step| step.x < end).map(|step| step.y).max().unwrap_or(0)
}

/// Raises the skyline to `top` between `x` and `x + width`.
fn raise(steps: &mut Vec<Step>, x: u32, width: u32, top: u32) {
    let end = x + width;
    let mut raised = Vec::with_capacity(steps.len() + 2);
    for step in steps.iter() {
        if step.x < x {
            raised.push(Step { width: step.width.min(x - step.x), ..*step });
        }
    }
    raised.push(Step { x, y: top, width });
    for step in steps.iter() {
        let right = step.x + step.width;
        if right > end {
            let left = step.x.max(end);
            raised.push(Step { x: left, y: step.y, width: right - left });
        }
    }
    *steps = raised;
}
