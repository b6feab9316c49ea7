//! Number of samples of the views that show what the program sees, for queries.

use crate::geom::lenses::picture_map::Place;
use crate::geom::reprojection::Intrinsics;
use crate::runtime::session::{Session, camera_rotation};
use glam::DVec3;

impl Session {
    /// Returns the number of samples of all views that show what the program sees through `lens`,
    /// to a few per cent. `own` is the number of samples of the program's own picture. A view with
    /// the program's lens has the same number; with `off_screen` every view has.
    ///
    /// The number is added up over a grid on the program's picture. A view has `D / cos³ θ` samples
    /// per steradian at θ off its axis, where D is its number of samples per unit of tangents
    /// squared. A picture to which vertices are projected has the area that the grid's cells take
    /// there.
    pub fn samples(&self, lens: &Intrinsics, own: f64, off_screen: bool) -> f64 {
        const GRID: u32 = 16;
        let camera = self.program_camera();
        let rotation = camera_rotation(&camera);
        // A cell of the grid, in tangents of the program's own axis.
        let cell = (camera.zoom * 2.0 / f64::from(GRID)).powi(2) / (lens.a * lens.c).abs();
        let mut sum = 0.0;
        for index in 0..GRID * GRID {
            let towards = |right: f64, up: f64| {
                let place = |i: u32, part: f64| (f64::from(i) + part) * 2.0 / f64::from(GRID) - 1.0;
                let (x, y) = (place(index % GRID, right), place(index / GRID, up));
                rotation * DVec3::new(camera.zoom * (x + lens.b) / lens.a, camera.zoom * (y + lens.d) / lens.c, -1.0)
            };
            let direction = towards(0.5, 0.5);
            for view in self.views() {
                let tile = f64::from(view.tile.width) * f64::from(view.tile.height);
                let samples = if off_screen { own } else { tile };
                let seen = view.rotation * direction;
                let (right, up) = (seen.x / -seen.z, seen.y / -seen.z);
                let owned = &view.owned;
                if view.program_lens {
                    sum += own / f64::from(GRID * GRID);
                } else if let Some(map) = &view.curved {
                    let at = |right, up| match map.place(view.rotation * towards(right, up)) {
                        _ if map.shown(seen).is_none() => None,
                        Place::At(at) => Some(at),
                        Place::Beyond(_) => None,
                    };
                    if let [Some(a), Some(b), Some(c), Some(d)] =
                        [at(0.0, 0.0), at(1.0, 0.0), at(1.0, 1.0), at(0.0, 1.0)]
                    {
                        // Area of the cell there; that of the whole picture is 4.
                        let area = 0.5 * (c - a).perp_dot(d - b).abs();
                        sum += samples * area / 4.0;
                    }
                } else if seen.z < 0.0
                    && (owned.left..=owned.right).contains(&right)
                    && (owned.bottom..=owned.top).contains(&up)
                {
                    // cos³ of the angle to the program's axis divided by that of the angle to the
                    // view's.
                    sum += samples / (view.frustum.width() * view.frustum.height()) * cell / (-seen.z).powi(3);
                }
            }
        }
        sum
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::runtime::session::Extras;
    use std::path::Path;

    /// A domemaster to which vertices are projected, with the program's axis on the fisheye's: an
    /// equidistant picture of side N has (N/π)² θ/sin θ pixels per steradian.
    #[test]
    fn samples_of_a_projected_picture_are_its_pixels() {
        let text = "[dome]\ntilt = 0\ncoverage = 180\n[[output]]\nkind = \"domemaster\"\naperture = 180\ntilt = 90\nmethod = \"vertex\"\n";
        let rig = crate::rig::parse(text, "rig.toml", Path::new("")).expect("a rig");
        let session = Session::projecting(&rig, (600, 600), false, 16384, Extras::default()).expect("a session");
        let [half_width, half_height] = [0.8f64, 0.5];
        let lens = Intrinsics { a: 1.0 / half_width, b: 0.0, c: 1.0 / half_height, d: 0.0, e: -1.0, f: None };
        let steps = 400;
        let middle = |i: i32, half: f64| ((f64::from(i) + 0.5) * 2.0 / f64::from(steps) - 1.0) * half;
        let cell = 4.0 * half_width * half_height / f64::from(steps * steps);
        let mut expected = 0.0;
        for (i, j) in (0..steps).flat_map(|i| (0..steps).map(move |j| (i, j))) {
            let (x, y) = (middle(i, half_width), middle(j, half_height));
            let length = (1.0 + x * x + y * y).sqrt();
            let angle = (x * x + y * y).sqrt().atan();
            let density = (600.0 / std::f64::consts::PI).powi(2) * angle / angle.sin();
            expected += density * cell / length.powi(3);
        }
        let found = session.samples(&lens, 1e9, false);
        let view = &session.views()[0];
        assert_eq!((session.views().len(), view.curved.is_some()), (1, true));
        let scale = f64::from(view.tile.width) * f64::from(view.tile.height) / 360_000.0;
        assert!((found / (expected * scale) - 1.0).abs() < 0.01, "{found} for {}", expected * scale);
    }
}
