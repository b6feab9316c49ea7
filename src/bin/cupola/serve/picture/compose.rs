//! All outputs of a frame in one square picture.

/// Rectangles of pictures of these sizes in a square, in rows, each as large as it fits: x, y,
/// width, height.
pub fn arrange(sizes: &[(u32, u32)], side: u32) -> Vec<(u32, u32, u32, u32)> {
    let widest = sizes.iter().map(|size| f64::from(size.0) / f64::from(size.1.max(1))).fold(0.01, f64::max);
    let most = sizes.len().max(1) as u32;
    // Takes the number of columns that makes the pictures largest.
    let scale = |columns: u32| {
        let rows = most.div_ceil(columns);
        (f64::from(side / columns)).min(f64::from(side / rows) * widest)
    };
    let columns = (1..=most).max_by(|a, b| scale(*a).total_cmp(&scale(*b))).unwrap_or(1);
    let (cell, row) = (side / columns, side / most.div_ceil(columns));
    let place = |(index, &(width, height)): (u32, &(u32, u32))| {
        let (width, height) = (f64::from(width.max(1)), f64::from(height.max(1)));
        let factor = (f64::from(cell) / width).min(f64::from(row) / height).min(1.0);
        let fit = |length: f64, most: u32| ((length * factor).round() as u32).clamp(1, most.max(1));
        (index % columns * cell, index / columns * row, fit(width, cell), fit(height, row))
    };
    (0..).zip(sizes).map(place).collect()
}

/// Writes means of a picture's pixels into a rectangle of a square of three bytes for each pixel.
pub fn shrink(rgba: &[u8], (width, height): (u32, u32), to: &mut [u8], side: u32, place: (u32, u32, u32, u32)) {
    let (x, y, columns, rows) = place;
    if rgba.len() < 4 * width as usize * height as usize || width == 0 || height == 0 {
        return;
    }
    let parts = |count: u32, length: u32| {
        let cut = move |index: u32| (u64::from(index) * u64::from(length) / u64::from(count)) as usize;
        (0..count).map(move |index| (cut(index), cut(index + 1).max(cut(index) + 1)))
    };
    // Divisions are slow, and the same in each row.
    let across: Vec<_> = parts(columns, width).collect();
    for (row, (top, bottom)) in (y..).zip(parts(rows, height)) {
        let at = 3 * (row as usize * side as usize + x as usize);
        for (to, &(left, right)) in to[at..at + 3 * columns as usize].chunks_exact_mut(3).zip(&across) {
            if (bottom - top, right - left) == (1, 1) {
                let from = 4 * (top * width as usize + left);
                to.copy_from_slice(&rgba[from..from + 3]);
                continue;
            }
            let mut sum = [0_u32; 3];
            for line in top..bottom {
                let pixels = &rgba[4 * (line * width as usize + left)..4 * (line * width as usize + right)];
                for pixel in pixels.chunks_exact(4) {
                    sum.iter_mut().zip(pixel).for_each(|(sum, value)| *sum += u32::from(*value));
                }
            }
            let count = ((bottom - top) * (right - left)) as u32;
            to.iter_mut().zip(sum).for_each(|(to, sum)| *to = ((sum + count / 2) / count) as u8);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_do_not_overlap_and_keep_shapes() {
        for sizes in
            [vec![(512, 512)], vec![(1920, 1080); 6], vec![(4096, 512), (100, 400), (1, 1)], vec![(640, 480); 17]]
        {
            let places = arrange(&sizes, 512);
            for (index, (&(x, y, width, height), size)) in places.iter().zip(&sizes).enumerate() {
                assert!(x + width <= 512 && y + height <= 512, "{sizes:?}: {places:?}");
                let shape = f64::from(width) / f64::from(height) * f64::from(size.1) / f64::from(size.0);
                assert!(width < 20 || height < 20 || (shape - 1.0).abs() < 0.05, "{sizes:?}: {places:?}");
                for &(x2, y2, width2, height2) in &places[..index] {
                    assert!(x >= x2 + width2 || x2 >= x + width || y >= y2 + height2 || y2 >= y + height);
                }
            }
        }
    }

    #[test]
    fn pixels_are_means_of_their_parts() {
        let colour = |x: u32, y: u32| [(x * 37 + y * 11) as u8, (x * y) as u8, (y * 53) as u8];
        for (size, place) in
            [((4, 3), (0, 0, 4, 3)), ((8, 6), (2, 1, 4, 3)), ((7, 5), (1, 2, 3, 2)), ((6, 5), (0, 3, 6, 2))]
        {
            let pixels = (0..size.1).flat_map(|y| (0..size.0).map(move |x| (x, y)));
            let rgba: Vec<u8> = pixels.flat_map(|(x, y)| [colour(x, y).as_slice(), &[255]].concat()).collect();
            let mut found = vec![0; 3 * 64];
            shrink(&rgba, size, &mut found, 8, place);
            for (x, y) in (0..8).flat_map(|y| (0..8).map(move |x| (x, y))) {
                let (left, top, columns, rows) = place;
                let is_inside = (left..left + columns).contains(&x) && (top..top + rows).contains(&y);
                let expected = match is_inside {
                    false => [0; 3],
                    true => {
                        let part = |at: u32, count: u32, length: u32| at * length / count..(at + 1) * length / count;
                        let (across, down) = (part(x - left, columns, size.0), part(y - top, rows, size.1));
                        let all: Vec<[u8; 3]> = down.flat_map(|y| across.clone().map(move |x| colour(x, y))).collect();
                        let mean = |i: usize| all.iter().map(|c| f64::from(c[i])).sum::<f64>() / all.len() as f64;
                        [0, 1, 2].map(|channel| mean(channel).round() as u8)
                    }
                };
                let at = 3 * (8 * y + x) as usize;
                assert_eq!(found[at..at + 3], expected, "{size:?} {place:?}: {x}, {y}");
            }
        }
    }
}
