//! A rig in a window of a given size.

use super::cache;
use super::turns::Turns;
use crate::correct;
use crate::correct::projected::matrices::LensConstants;
use crate::correct::{LowerLeftRect, PixelRect, Plan, UpperLeftRect};
use crate::error::Result;
pub use crate::geom::Frustum;
pub use crate::geom::division::{Division, Outcome, Weights};
use crate::geom::lenses::picture_map::Place;
use crate::geom::pose;
pub use crate::geom::reprojection::ClipRows;
pub use crate::geom::reprojection::eye_axes::{self, ViewMatrix};
use crate::geom::reprojection::{CameraAdjustment, clip_rows};
pub use crate::geom::reprojection::{CameraFunction, Direction, Intrinsics, MatrixClass, classify};
use crate::rig::{Camera, Favour, Method, Rig};
use crate::views::{Request, Tile, View};
use glam::{DMat3, DVec2, DVec3};

/// Needs of a program, as far as Cupola has seen them: tiles beside the views, and the number of
/// draws, which decides how many views are worth their cost.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Extras {
    /// True if the flat panel is needed.
    pub panel: bool,
    /// True if the primary view is needed.
    pub primary: bool,
    /// Number of draws in a frame, once it is known.
    pub draws: Option<u32>,
}

/// A rig that is planned for a window.
pub struct Session {
    rig: Rig,
    draws: Option<u32>,
    request: Request,
    plan: Plan,
    /// Rectangles of the outputs in the window.
    rects: Vec<PixelRect>,
    /// Names of outputs that lost their own method.
    refused: Vec<String>,
    /// Set if the program draws one view in each of its frames.
    turns: Option<Turns>,
    /// Views that outputs of this machine sample, one bit for each.
    needed: u64,
}

/// Views that outputs of this machine sample, one bit for each.
fn needed(rig: &Rig, plan: &Plan) -> u64 {
    if plan.views.output_views.is_empty() {
        return u64::MAX;
    }
    let outputs = rig.outputs.iter().chain(&rig.beside).zip(&plan.views.output_views);
    let views = outputs.filter(|(output, _)| output.here).flat_map(|(_, views)| views);
    views.filter(|view| **view < 64).fold(0, |bits, view| bits | 1 << view)
}

/// Free rows between a view and the panel, if views are drawn in turn.
const TURN_GUTTER: u32 = 1;

/// Greatest number of parts of a primitive that is divided on the processor: enough for a triangle
/// around half of the sphere in a picture of 4096² pixels at a twentieth of a pixel, and a tenth of
/// a second of work.
const MOST_PARTS: usize = 1 << 14;

/// Width and height of a view in pixels.
fn pixels(view: &View) -> DVec2 {
    DVec2::new(f64::from(view.tile.width), f64::from(view.tile.height))
}

impl Session {
    /// Plans `rig` for a `window` (width, height in pixels).
    ///
    /// `off_screen`: outputs have their own resolution (`size`), not that of their rectangle in the
    /// window. `max_atlas`: greatest width and height of a texture.
    ///
    /// All views are perspective. Outputs to which vertices should be projected get the method
    /// `fragment`, and the plan's notes say so.
    ///
    /// # Errors
    /// Errors of the planner: no set of views can serve the rig, or the atlas is too small.
    pub fn new(rig: &Rig, window: (u32, u32), off_screen: bool, max_atlas: u32, extras: Extras) -> Result<Self> {
        Self::refusing(Method::projects_vertices, rig, window, off_screen, max_atlas, extras)
    }

    /// As [`Session::projecting`], for a caller that does not divide primitives. The plan's notes
    /// name the outputs that get the method `fragment` for that reason.
    ///
    /// # Errors
    /// As for [`Session::new`].
    pub fn undivided(rig: &Rig, window: (u32, u32), off_screen: bool, max_atlas: u32, extras: Extras) -> Result<Self> {
        Self::refusing(Method::divides, rig, window, off_screen, max_atlas, extras)
    }

    fn refusing(
        refused: fn(&Method) -> bool,
        rig: &Rig,
        window: (u32, u32),
        off_screen: bool,
        max_atlas: u32,
        extras: Extras,
    ) -> Result<Self> {
        let mut session = Self::projecting(&rig.with_views_for(refused), window, off_screen, max_atlas, extras)?;
        let outputs = rig.outputs.iter().filter(|output| refused(&output.method));
        let notes = outputs.map(|output| format!("output {}: method \"fragment\" instead of its own", output.name));
        session.refused = notes.collect();
        session.plan.views.notes.extend_from_slice(&session.refused);
        Ok(session)
    }

    /// As [`Session::new`] for a caller that projects vertices by
    /// [`View::curved`](crate::views::View::curved).
    ///
    /// # Errors
    /// As for [`Session::new`].
    pub fn projecting(rig: &Rig, window: (u32, u32), off_screen: bool, max_atlas: u32, extras: Extras) -> Result<Self> {
        let rects = rig.layout(window);
        // Outputs of other machines without a size are planned with the size of this machine's
        // outputs.
        let usual = rects.iter().find(|rect| rect.width > 0).map_or(window, |rect| (rect.width, rect.height));
        let output_sizes = rig
            .outputs
            .iter()
            .zip(&rects)
            .map(|(output, rect)| match output.here {
                true => output.size.filter(|_| off_screen).unwrap_or((rect.width, rect.height)),
                false => output.size.unwrap_or(usual),
            })
            .chain(rig.beside.iter().filter_map(|output| output.size))
            .collect();
        let Extras { panel, primary, draws } = extras;
        let request = Request { output_sizes, window, panel, primary, max_atlas };
        let plan = plan(rig, draws, &request)?;
        let needed = needed(rig, &plan);
        Ok(Self { rig: rig.clone(), draws, request, plan, rects, refused: Vec::new(), turns: None, needed })
    }

    /// The same rig and window with other tiles beside the views.
    ///
    /// # Errors
    /// As for [`Session::new`].
    pub fn with(&self, extras: Extras) -> Result<Self> {
        let Extras { panel, primary, draws } = extras;
        let request = Request { panel, primary, ..self.request.clone() };
        let mut plan = plan(&self.rig, draws, &request)?;
        let refused = self.refused.clone();
        plan.views.notes.extend_from_slice(&refused);
        let needed = needed(&self.rig, &plan);
        let (rig, rects) = (self.rig.clone(), self.rects.clone());
        let session = Self { rig, draws, request, plan, rects, refused, turns: None, needed };
        Ok(if self.turns.is_some() { session.in_turn() } else { session })
    }

    /// Makes the program draw one view in each of its frames, with the size of its window, instead
    /// of all views in each. The atlas then only collects the views.
    pub fn in_turn(mut self) -> Self {
        self.turns = Some(Turns::new(self.views().len(), self.rig.views.warm_up));
        self
    }

    /// Views that outputs of this machine sample, one bit for each of the first 64. Views of other
    /// machines alone need not be drawn.
    pub fn needed(&self) -> u64 {
        self.needed
    }

    /// View that the program draws in this frame; `None` if it draws all of them.
    pub fn turn(&self) -> Option<usize> {
        Some(self.turns.as_ref()?.view())
    }

    /// Turns, if the program draws one view in each of its frames.
    pub fn turns(&self) -> Option<&Turns> {
        self.turns.as_ref()
    }

    /// Rig of the session.
    pub fn rig(&self) -> &Rig {
        &self.rig
    }

    /// Plan of the session.
    pub fn plan(&self) -> &Plan {
        &self.plan
    }

    /// Returns the needs of the program, as far as they were seen.
    pub fn extras(&self) -> Extras {
        Extras { panel: self.request.panel, primary: self.request.primary, draws: self.draws }
    }

    /// Size of the window in pixels.
    pub fn window(&self) -> (u32, u32) {
        self.request.window
    }

    /// Views of the plan.
    pub fn views(&self) -> &[View] {
        &self.plan.views.views
    }

    /// Returns the rectangle of a view, and whether flat drawing goes there as well.
    pub fn tile(&self, index: usize) -> (LowerLeftRect, bool) {
        match (self.views().get(index), &self.turns) {
            (None, _) => (LowerLeftRect::new(0, 0, 1, 1), true),
            (Some(_), Some(_)) => (LowerLeftRect::of_size(self.request.window), true),
            (Some(view), None) => (rect(&view.tile), view.program_lens),
        }
    }

    /// Tile of a view in the atlas.
    pub fn atlas_tile(&self, index: usize) -> Option<LowerLeftRect> {
        self.views().get(index).map(|view| rect(&view.tile))
    }

    /// Tile of the panel in the atlas.
    pub fn atlas_panel(&self) -> Option<LowerLeftRect> {
        self.plan.views.panel.as_ref().map(|panel| rect(&panel.tile))
    }

    /// Size in texels of the surface that the program draws to: the atlas, or, in turn, a view and
    /// the panel above it.
    pub fn surface_size(&self) -> (u32, u32) {
        let (width, height) = self.request.window;
        if self.turns.is_some() { (width, 2 * height + TURN_GUTTER) } else { self.plan.views.atlas }
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

    /// View that is nearest to the forward direction of the program's camera.
    pub fn ahead(&self) -> usize {
        let forward = camera_rotation(&self.rig.camera) * DVec3::NEG_Z;
        let slant = |view: &View| (view.rotation * forward).z;
        let views = self.views().iter().enumerate();
        views.min_by(|a, b| slant(a.1).total_cmp(&slant(b.1))).map_or(0, |(index, _)| index)
    }

    /// Returns the rectangle of the flat panel.
    pub fn panel(&self) -> Option<LowerLeftRect> {
        let window = LowerLeftRect::of_size(self.request.window);
        let above = LowerLeftRect { y: window.height + TURN_GUTTER as i32, ..window };
        self.atlas_panel().map(|panel| if self.turns.is_some() { above } else { panel })
    }

    /// Tile of the primary view; `None` in turn.
    pub fn primary(&self) -> Option<LowerLeftRect> {
        self.plan.views.primary.as_ref().filter(|_| self.turns.is_none()).map(rect)
    }

    /// Returns the rectangle of each output in the window from the top left, `place` added.
    pub fn viewports_from_top(&self, place: (i32, i32)) -> Vec<UpperLeftRect> {
        let from_top = move |r: &PixelRect| {
            let (x, y) = (place.0.saturating_add(r.x as i32), place.1.saturating_add(r.y as i32));
            UpperLeftRect::new(x, y, r.width as i32, r.height as i32)
        };
        self.rects.iter().map(from_top).collect()
    }

    /// Returns the rectangle of each output in the window.
    pub fn viewports(&self) -> impl Iterator<Item = LowerLeftRect> + '_ {
        let height = self.request.window.1 as i32;
        let from_top = move |r: &PixelRect| {
            LowerLeftRect::new(r.x as i32, height - r.y as i32 - r.height as i32, r.width as i32, r.height as i32)
        };
        self.rects.iter().map(from_top)
    }

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
        let camera = &self.rig.camera;
        let rotation = camera_rotation(camera);
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

    /// Lens that the rig gives the program, for draws whose lens is not known. Its depth is that of
    /// a far plane at infinity, which keeps the order of depths for any other far plane.
    pub fn given_lens(&self) -> Option<Intrinsics> {
        let [a, c] = self.rig.camera.lens?.map(|opening| 1.0 / (opening / 2.0).tan());
        Some(Intrinsics { a, b: 0.0, c, d: 0.0, e: -1.0, f: None })
    }

    /// Returns the adaptation of the program's camera for a view: the rig's, from the view's eye.
    pub fn camera(&self, view: &View) -> CameraAdjustment {
        let camera = &self.rig.camera;
        let rotation = camera_rotation(camera);
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
}

/// Plans `rig` for a program with this number of draws in a frame, unless the rig itself sets its
/// preference.
fn plan(rig: &Rig, draws: Option<u32>, request: &Request) -> Result<Plan> {
    let (cache, rig) = (cache::of_process(), &*rig.with_all_outputs());
    match draws.filter(|_| rig.views.favour == Favour::Balanced) {
        None => correct::build_with(rig, request, cache),
        Some(draws) => {
            let mut rig = rig.clone();
            rig.views.favour = Favour::Draws(draws);
            correct::build_with(&rig, request, cache)
        }
    }
}

/// Rotation from the axes of the program's camera to those of the viewer.
pub fn camera_rotation(camera: &Camera) -> DMat3 {
    pose::rotation(camera.yaw, camera.pitch, camera.roll)
}

fn rect(tile: &Tile) -> LowerLeftRect {
    LowerLeftRect::new(tile.x as i32, tile.y as i32, tile.width as i32, tile.height as i32)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    const EYES: &str = "[camera]\nunits_per_meter = 100\nyaw = 40\n\
        [[output]]\nkind = \"perspective\"\nfov = [60, 40]\neye = -0.03\n\
        [[output]]\nkind = \"perspective\"\nfov = [60, 40]\neye = 0.03\n\
        [[output]]\nkind = \"perspective\"\nfov = [60, 40]\n";

    #[test]
    fn each_eye_has_its_own_views_from_its_own_place() {
        let rig = crate::rig::parse(EYES, "eyes.toml", Path::new("")).expect("valid");
        let session = Session::new(&rig, (900, 300), false, 8192, Extras::default()).expect("can be planned");
        assert_eq!(session.views().iter().map(|view| view.eye).collect::<Vec<_>>(), [-0.03, 0.03, 0.0]);
        assert_eq!(session.plan().views.output_views, [vec![0], vec![1], vec![2]]);
        // Takes a point of the program's eye space through the program's lens into each view.
        let frustum = Frustum { left: -0.8, right: 0.7, bottom: -0.5, top: 0.6 };
        let program = frustum.projection_matrix(1.0, 1000.0);
        let MatrixClass::Perspective(lens) = classify(&program.to_cols_array()) else { panic!("it is one") };
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

    /// Holds also after other tiles were requested.
    #[test]
    fn outputs_that_lose_their_method_are_told() {
        let text = "[[output]]\nname = \"one\"\nkind = \"domemaster\"\nmethod = \"primitive\"\n";
        let rig = crate::rig::parse(text, "rig.toml", Path::new("")).expect("a rig");
        let session = Session::undivided(&rig, (300, 300), false, 8192, Extras::default()).expect("a session");
        let more = session.with(Extras { primary: true, ..Extras::default() }).expect("a session");
        for session in [session, more] {
            let notes = &session.plan().views.notes;
            assert!(notes.iter().any(|note| note == "output one: method \"fragment\" instead of its own"), "{notes:?}");
        }
    }

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
