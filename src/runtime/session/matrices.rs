//! Matrices and lens constants that a program gets for each view.

use crate::correct::projected::matrices::LensConstants;
use crate::geom::Frustum;
use crate::geom::division::Division;
use crate::geom::reprojection::{CameraAdjustment, ClipRows, Intrinsics, clip_rows};
use crate::runtime::session::{Session, camera_rotation};
use crate::views::View;
use glam::{DVec2, DVec3};

/// Width and height of a view in pixels.
fn pixels(view: &View) -> DVec2 {
    DVec2::new(f64::from(view.tile.width), f64::from(view.tile.height))
}

/// Greatest number of parts of a primitive that is divided on the processor: enough for a triangle
/// around half of the sphere in a picture of 4096² pixels at a twentieth of a pixel, and a tenth of
/// a second of work.
const MOST_PARTS: usize = 1 << 14;

impl Session {
    /// Reprojection matrices from the program's clip coordinates to those of each view.
    pub fn rows(&self, lens: &Intrinsics) -> impl Iterator<Item = ClipRows> + '_ {
        let lens = *lens;
        self.views().iter().map(move |view| {
            let camera = self.camera(view);
            let rows = clip_rows(&lens, &camera, view.rotation, &view.frustum);
            // Depth is the distance in any direction there: no corner is nearer than the middle.
            let frustum = if view.curved.is_some() { Frustum::POINT } else { view.frustum };
            ClipRows { curved: view.curved.is_some(), ..rows.widened(&lens, &camera, &frustum) }
        })
    }

    /// Lens that the rig gives the program, for draws whose lens is not known. Its depth is that of
    /// a far plane at infinity, which keeps the order of depths for any other far plane.
    pub fn given_lens(&self) -> Option<Intrinsics> {
        let [a, c] = self.program_camera().lens?.map(|opening| 1.0 / (opening / 2.0).tan());
        Some(Intrinsics { a, b: 0.0, c, d: 0.0, e: -1.0, f: None })
    }

    /// Returns the adaptation of the program's camera for a view: the rig's, from the view's eye.
    pub fn camera(&self, view: &View) -> CameraAdjustment {
        let camera = self.program_camera();
        let rotation = camera_rotation(&camera);
        let eye = rotation.transpose() * (DVec3::X * (view.eye * camera.units_per_meter));
        CameraAdjustment { zoom: camera.zoom, shift: camera.shift + eye, rotation }
    }

    /// Reprojection matrices from flat clip coordinates to each view, as points of the panel; empty
    /// without a panel.
    ///
    /// Their depth is half the program's: on the panel it stays between the planes of every view
    /// that shows a part of it (the distance along a view's axis is half the panel's at least up to
    /// 60° off it).
    pub fn panel_rows(&self) -> Vec<ClipRows> {
        let Some(panel) = &self.plan.views.panel else { return Vec::new() };
        let frustum = &panel.frustum;
        let lens = Intrinsics {
            a: 2.0 / frustum.width(),
            b: (frustum.right + frustum.left) / frustum.width(),
            c: 2.0 / frustum.height(),
            d: (frustum.top + frustum.bottom) / frustum.height(),
            e: 0.0,
            f: None,
        };
        let camera = CameraAdjustment { rotation: panel.rotation.transpose(), ..CameraAdjustment::NONE };
        let rows = |view: &View| ClipRows {
            depth: [0.5, 0.0],
            curved: view.curved.is_some(),
            ..clip_rows(&lens, &camera, view.rotation, &view.frustum)
        };
        self.views().iter().map(rows).collect()
    }

    /// Lens constants of each view, for patched shaders; zeros for perspective views. Empty if all
    /// views are perspective.
    pub fn lenses(&self) -> Vec<LensConstants> {
        if self.views().iter().all(|view| view.curved.is_none()) {
            return Vec::new();
        }
        let lens = |(index, view): (usize, &View)| {
            let Some(map) = &view.curved else { return LensConstants::default() };
            LensConstants::of(map, pixels(view), self.max_error(index).unwrap_or(0.0))
        };
        self.views().iter().enumerate().map(lens).collect()
    }

    /// Greatest error that the method of a view's output permits, pixels.
    fn max_error(&self, index: usize) -> Option<f64> {
        let output = self.plan.views.output_views.iter().position(|views| views.contains(&index))?;
        self.rig.outputs.iter().chain(&self.rig.beside).nth(output)?.method.max_error()
    }

    /// Returns the division of primitives for a view; `None` if they need not be divided.
    pub fn division(&self, index: usize) -> Option<Division> {
        let view = self.views().get(index)?;
        let max_error = self.max_error(index).filter(|max_error| *max_error > 0.0)?;
        Some(Division { map: view.curved?, pixels: pixels(view), max_error, most: MOST_PARTS })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::runtime::session::{Extras, MatrixClass, classify};
    use std::path::Path;

    const EYES: &str = "[camera]\nunits_per_meter = 100\nyaw = 40\n\
        [[output]]\nkind = \"perspective\"\nfov = [60, 40]\neye = -0.03\n\
        [[output]]\nkind = \"perspective\"\nfov = [60, 40]\neye = 0.03\n\
        [[output]]\nkind = \"perspective\"\nfov = [60, 40]\n";

    #[test]
    fn a_new_camera_needs_no_new_plan() {
        let rig = crate::rig::parse(EYES, "eyes.toml", Path::new("")).expect("valid");
        let mut other = rig.clone();
        other.camera.zoom = 1.5;
        other.camera.pitch = 0.3;
        let plan = |rig| Session::new(rig, (900, 300), false, 8192, Extras::default()).expect("can be planned");
        let (session, planned) = (plan(&rig), plan(&other));
        let frustum = Frustum { left: -0.8, right: 0.7, bottom: -0.5, top: 0.6 };
        let MatrixClass::Perspective(lens) = classify(&frustum.projection_matrix(1.0, 1000.0)) else {
            panic!("it is one")
        };
        let rows = |session: &Session| session.rows(&lens).collect::<Vec<_>>();
        assert_ne!(rows(&session), rows(&planned));
        session.set_camera(other.camera);
        assert_eq!(rows(&session), rows(&planned));
        assert_eq!(format!("{:?}", session.plan()), format!("{:?}", planned.plan()));
    }

    #[test]
    fn each_eye_has_its_own_views_from_its_own_place() {
        let rig = crate::rig::parse(EYES, "eyes.toml", Path::new("")).expect("valid");
        let session = Session::new(&rig, (900, 300), false, 8192, Extras::default()).expect("can be planned");
        assert_eq!(session.views().iter().map(|view| view.eye).collect::<Vec<_>>(), [-0.03, 0.03, 0.0]);
        assert_eq!(session.plan().views.output_views, [vec![0], vec![1], vec![2]]);
        // Takes a point of the program's eye space through the program's lens into each view.
        let frustum = Frustum { left: -0.8, right: 0.7, bottom: -0.5, top: 0.6 };
        let program = frustum.projection_matrix(1.0, 1000.0);
        let MatrixClass::Perspective(lens) = classify(&program) else { panic!("it is one") };
        let point = DVec3::new(3.0, 2.0, -20.0);
        let clip = program * point.extend(1.0);
        for (view, rows) in session.views().iter().zip(session.rows(&lens)) {
            // 3 cm are 3 units of the program, along the viewer's axes, against which its camera is
            // turned.
            let seen = view.rotation * (camera_rotation(&rig.camera) * point - DVec3::X * (view.eye * 100.0));
            let q = clip.z + rows.e * clip.w;
            let row = |r: [f64; 4]| r[0] * clip.x + r[1] * clip.y + r[2] * clip.w + r[3] * q;
            let (x, y) = (row(rows.x) / row(rows.w), row(rows.y) / row(rows.w));
            let at = view.frustum.picture() * seen;
            assert!((x - at.x / at.z).abs() < 1e-12 && (y - at.y / at.z).abs() < 1e-12, "{}: {x} {y} {at}", view.name);
        }
    }
}
