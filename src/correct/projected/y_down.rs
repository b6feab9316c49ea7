//! Rows and lenses for Vulkan, whose clip coordinates have y down.

/// The rows of [`clip_rows`](crate::correct::projected::matrices::clip_rows) that take clip coordinates whose y points down to such ones.
pub fn rows_down(rows: &[f32; 16]) -> [f32; 16] {
    std::array::from_fn(|i| {
        let (row, column) = (i / 4, i % 4);
        let turned = row < 3 && ((row == 1) != (column == 1));
        if turned { 0.0 - rows[i] } else { rows[i] }
    })
}

/// The lens of [`picture_lens`](crate::correct::projected::matrices::picture_lens) behind such rows, whose directions have y down: viewer, lens and
/// offset are mirrored.
pub fn lens_down(lens: &[f32; 16]) -> [f32; 16] {
    std::array::from_fn(|i| if [1, 5, 11].contains(&i) { 0.0 - lens[i] } else { lens[i] })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::correct::projected::matrices::picture_lens;
    use crate::geom::{Frustum, PictureLens, PictureMap};
    use glam::{DVec2, DVec3};
    use std::f64::consts::PI;

    #[test]
    fn turned_rows_do_with_turned_coordinates_what_the_rows_do() {
        let rows: [f32; 16] = std::array::from_fn(|i| (i * 7 % 11) as f32 - 4.0);
        // The shader's formula.
        let apply = |rows: &[f32; 16], [x, y, z, w]: [f32; 4]| {
            let q = z + rows[12] * w;
            let dot = |row: usize| rows[row] * x + rows[row + 1] * y + rows[row + 2] * w + rows[row + 3] * q;
            let new_w = dot(8);
            [dot(0), dot(4), rows[13] * (q - rows[12] * new_w) + rows[14] * new_w, new_w]
        };
        let [x, y, z, w] = apply(&rows, [0.5, -1.5, 0.25, 2.0]);
        assert_eq!(apply(&rows_down(&rows), [0.5, 1.5, 0.25, 2.0]), [x, -y, z, w]);
    }

    /// The lens as numbers is the mirrored map's.
    #[test]
    fn a_turned_lens_is_that_of_the_mirrored_map() {
        let (viewer, position) = (DVec3::new(0.1, -0.2, 0.3), DVec3::new(-0.4, 0.5, 0.1));
        let fisheye = PictureLens::Fisheye { aperture: PI, circle: DVec2::ONE, pixels: DVec2::splat(512.0) };
        let pinhole = |[bottom, top]: [f64; 2]| PictureLens::Pinhole(Frustum { left: -0.8, right: 1.1, bottom, top });
        let mirror = DVec3::new(1.0, -1.0, 1.0);
        for (lens, mirrored) in [(fisheye, fisheye), (pinhole([-0.5, 0.7]), pinhole([-0.7, 0.5]))] {
            let map = PictureMap { viewer, position, lens };
            let other = PictureMap { viewer: viewer * mirror, position: position * mirror, lens: mirrored };
            let numbers = |map: &PictureMap| picture_lens(map, DVec2::splat(512.0), 0.5);
            let (found, expected) = (lens_down(&numbers(&map)), numbers(&other));
            assert!(found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-6), "{found:?} {expected:?}");
            assert_ne!(found, numbers(&map));
        }
    }
}
