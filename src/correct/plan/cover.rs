//! Part of an output that no rectangle covers.

use crate::geom::rectangle::PixelRect;

/// Returns disjoint rectangles that cover exactly the part of an output of `size` that is outside
/// `rects`.
pub(in crate::correct) fn uncovered(size: (u32, u32), rects: &[PixelRect]) -> Vec<PixelRect> {
    let (width, height) = size;
    let mut edges: Vec<u32> = rects.iter().flat_map(|r| [r.y, r.y.saturating_add(r.height)]).collect();
    edges.extend([0, height]);
    edges.retain(|y| *y <= height);
    edges.sort_unstable();
    edges.dedup();
    let mut found: Vec<PixelRect> = Vec::new();
    // Index in `found` of the first gap of the band above. Bands with the same gaps become one.
    let mut above = 0;
    for band in edges.windows(2) {
        let (top, bottom) = (band[0], band[1]);
        let gaps = gaps(width, rects.iter().filter(|r| r.y <= top && r.y.saturating_add(r.height) >= bottom));
        let same = found.len() - above == gaps.len()
            && found[above..].iter().zip(&gaps).all(|(r, g)| (r.x, r.width) == *g && r.y + r.height == top);
        if same {
            for rect in &mut found[above..] {
                rect.height += bottom - top;
            }
        } else {
            above = found.len();
            found.extend(gaps.iter().map(|&(x, width)| PixelRect { x, y: top, width, height: bottom - top }));
        }
    }
    found
}

/// Returns left edge and width of the gaps between rectangles that cross a whole band.
fn gaps<'a>(width: u32, rects: impl Iterator<Item = &'a PixelRect>) -> Vec<(u32, u32)> {
    let mut spans: Vec<(u32, u32)> = rects.map(|r| (r.x, r.x.saturating_add(r.width).min(width))).collect();
    spans.sort_unstable();
    let mut gaps = Vec::new();
    let mut reached = 0;
    for (start, end) in spans {
        if start > reached {
            gaps.push((reached, start.min(width) - reached));
        }
        reached = reached.max(end);
        if reached >= width {
            return gaps;
        }
    }
    gaps.push((reached, width - reached));
    gaps
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::random::Random;

    fn rect(x: u32, y: u32, width: u32, height: u32) -> PixelRect {
        PixelRect { x, y, width, height }
    }

    #[test]
    fn nothing_and_everything() {
        assert_eq!(uncovered((10, 7), &[]), [rect(0, 0, 10, 7)]);
        assert_eq!(uncovered((10, 7), &[rect(0, 0, 10, 7)]), []);
        assert_eq!(uncovered((10, 7), &[rect(2, 1, 3, 4), rect(2, 3, 3, 2)]).len(), 4);
    }

    #[test]
    fn covers_each_pixel_exactly_once() {
        let mut random = Random::new(7);
        let mut random = |end: u32| random.below(end as usize) as u32;
        for _ in 0..300 {
            let size = (1 + random(24), 1 + random(24));
            let rects: Vec<PixelRect> = (0..random(6))
                .map(|_| {
                    let (x, y) = (random(size.0), random(size.1));
                    rect(x, y, 1 + random(size.0 - x), 1 + random(size.1 - y))
                })
                .collect();
            let black = uncovered(size, &rects);
            for y in 0..size.1 {
                for x in 0..size.0 {
                    let inside = |r: &&PixelRect| x >= r.x && x < r.x + r.width && y >= r.y && y < r.y + r.height;
                    let expected = usize::from(!rects.iter().any(|r| inside(&r)));
                    assert_eq!(black.iter().filter(inside).count(), expected, "({x}, {y}) of {size:?}: {rects:?}");
                }
            }
        }
    }
}
