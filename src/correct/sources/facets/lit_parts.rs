//! Rectangles of the pixels that show something. Shaders without a test for rims draw only there.

use crate::correct::passes::output_pass::Batch;
use crate::correct::passes::source::Source;
use crate::geom::rectangle::PixelRect;

/// Returns the batch without the pixels that show nothing.
pub(in crate::correct) fn only_lit(batch: Batch, source: &Source, size: (u32, u32)) -> Batch {
    if !batch.edge {
        return batch;
    }
    let lit = |x: u32, y: u32| {
        let (x, y) = source.normalised(size, f64::from(x) + 0.5, f64::from(y) + 0.5);
        source.direction(x, y).is_some()
    };
    let rects = batch.rects.iter().flat_map(|rect| lit_parts(rect, &lit)).collect();
    Batch { rects, edge: false, ..batch }
}

/// Returns the pixels of `rect` for which `lit` is true, as rectangles: runs, joined where they lie
/// below each other.
fn lit_parts(rect: &PixelRect, lit: &impl Fn(u32, u32) -> bool) -> Vec<PixelRect> {
    let mut parts: Vec<PixelRect> = Vec::new();
    // Indices in `parts` of the rectangles that end at the row above.
    let mut above: Vec<usize> = Vec::new();
    for y in rect.y..rect.y + rect.height {
        let mut here = Vec::new();
        let mut x = rect.x;
        while x < rect.x + rect.width {
            let start = x;
            while x < rect.x + rect.width && lit(x, y) {
                x += 1;
            }
            let width = x - start;
            if width > 0 {
                let same = |&&index: &&usize| (parts[index].x, parts[index].width) == (start, width);
                match above.iter().find(same).copied() {
                    Some(index) => {
                        parts[index].height += 1;
                        here.push(index);
                    }
                    None => {
                        parts.push(PixelRect { x: start, y, width, height: 1 });
                        here.push(parts.len() - 1);
                    }
                }
            } else {
                x += 1;
            }
        }
        above = here;
    }
    parts
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::random::Random;

    #[test]
    fn each_lit_pixel_is_in_one_rectangle_and_no_other() {
        let mut random = Random::new(3);
        for blur in [1, 2, 5] {
            let noise: Vec<bool> = (0..40).map(|_| random.unit() < 0.6).collect();
            let lit = |x: u32, y: u32| noise[(x / blur * 7 + y / blur * 3) as usize % noise.len()];
            let rect = PixelRect { x: 3, y: 5, width: 21, height: 17 };
            let parts = lit_parts(&rect, &lit);
            for (x, y) in (0..32).flat_map(|y| (0..32).map(move |x| (x, y))) {
                let inside = |r: &PixelRect| x >= r.x && x < r.x + r.width && y >= r.y && y < r.y + r.height;
                let expected = usize::from(inside(&rect) && lit(x, y));
                assert_eq!(parts.iter().filter(|part| inside(part)).count(), expected, "({x}, {y}): {parts:?}");
            }
        }
    }
}
