//! Reprojection matrices and lenses for Vulkan, whose clip coordinates have y down.

use crate::correct::projected::matrices::{LensConstants, ReprojectionMatrix};

impl ReprojectionMatrix {
    /// Returns the matrix for clip coordinates whose y points down, both before and after it.
    pub fn y_down(&self) -> Self {
        let of_y = |[x, y, w, q]: [f32; 4]| [x, mirrored(y), w, q];
        let [x, y, w, q] = self.y;
        Self { x: of_y(self.x), y: [mirrored(x), y, mirrored(w), mirrored(q)], w: of_y(self.w), depth: self.depth }
    }
}

impl LensConstants {
    /// Returns the lens behind a matrix of [`ReprojectionMatrix::y_down`], whose directions have y
    /// down: viewer, lens and offset are mirrored.
    pub fn y_down(&self) -> Self {
        let ([x, y, z], [a, b, c], [across, up]) = (self.viewer, self.position, self.offset);
        Self { viewer: [x, mirrored(y), z], position: [a, mirrored(b), c], offset: [across, mirrored(up)], ..*self }
    }
}

/// Returns the negative number, and 0 for 0.
fn mirrored(number: f32) -> f32 {
    0.0 - number
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::{Frustum, PictureLens, PictureMap};
    use glam::{DVec2, DVec3};
    use std::f64::consts::PI;

    #[test]
    fn turned_rows_do_with_turned_coordinates_what_the_rows_do() {
        let rows = ReprojectionMatrix::from_array(std::array::from_fn(|i| (i * 7 % 11) as f32 - 4.0));
        // The shader's formula.
        let apply = |rows: &ReprojectionMatrix, [x, y, z, w]: [f32; 4]| {
            let depth = rows.depth;
            let q = z + depth.pole * w;
            let dot = |[of_x, of_y, of_w, of_q]: [f32; 4]| of_x * x + of_y * y + of_w * w + of_q * q;
            let new_w = dot(rows.w);
            [dot(rows.x), dot(rows.y), depth.factor * (q - depth.pole * new_w) + depth.offset * new_w, new_w]
        };
        let [x, y, z, w] = apply(&rows, [0.5, -1.5, 0.25, 2.0]);
        assert_eq!(apply(&rows.y_down(), [0.5, 1.5, 0.25, 2.0]), [x, -y, z, w]);
    }

    /// The turned lens equals that of the mirrored map.
    #[test]
    fn a_turned_lens_is_that_of_the_mirrored_map() {
        let (viewer, position) = (DVec3::new(0.1, -0.2, 0.3), DVec3::new(-0.4, 0.5, 0.1));
        let fisheye = PictureLens::Fisheye { aperture: PI, circle: DVec2::ONE, pixels: DVec2::splat(512.0) };
        let pinhole = |[bottom, top]: [f64; 2]| PictureLens::Pinhole(Frustum { left: -0.8, right: 1.1, bottom, top });
        let mirror = DVec3::new(1.0, -1.0, 1.0);
        for (lens, mirrored) in [(fisheye, fisheye), (pinhole([-0.5, 0.7]), pinhole([-0.7, 0.5]))] {
            let map = PictureMap { viewer, position, lens };
            let other = PictureMap { viewer: viewer * mirror, position: position * mirror, lens: mirrored };
            let lens = |map: &PictureMap| LensConstants::of(map, DVec2::splat(512.0), 0.5);
            let (found, expected) = (lens(&map).y_down().to_array(), lens(&other).to_array());
            assert!(found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-6), "{found:?} {expected:?}");
            assert_ne!(found, lens(&map).to_array());
        }
    }
}
