//! A rig in a window of a given size.
//!
//! `places` of views and outputs, `matrices` for each view, `samples` of what a program sees, and
//! the `rough` correction of a rig that is being edited.

mod matrices;
mod places;
mod rough;
mod samples;

use super::cache;
use super::turns::Turns;
use crate::correct;
use crate::correct::{PixelRect, Plan};
use crate::error::Result;
pub use crate::geom::Frustum;
pub use crate::geom::division::{Division, Outcome, Weights};
use crate::geom::pose;
pub use crate::geom::reprojection::ClipRows;
pub use crate::geom::reprojection::eye_axes::{self, ViewMatrix};
pub use crate::geom::reprojection::{CameraFunction, Direction, Intrinsics, MatrixClass, classify};
use crate::lock::Lock;
use crate::rig::{Camera, Favour, Method, Rig};
use crate::views::{Request, View};
use glam::{DMat3, DVec3};
use std::sync::Mutex;

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
    /// Adaptation of the program's camera. It may change while frames are drawn.
    camera: Mutex<Camera>,
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
        let (rig, camera, refused) = (rig.clone(), Mutex::new(rig.camera), Vec::new());
        Ok(Self { rig, draws, request, plan, rects, refused, turns: None, needed, camera })
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
        let camera = Mutex::new(self.program_camera());
        let session = Self { rig, draws, request, plan, rects, refused, turns: None, needed, camera };
        Ok(if self.turns.is_some() { session.in_turn() } else { session })
    }

    /// Sets the adaptation of the program's camera, which has no effect on the plan.
    pub fn set_camera(&self, camera: Camera) {
        *self.camera.locked() = camera;
    }

    /// Adaptation of the program's camera.
    pub fn program_camera(&self) -> Camera {
        *self.camera.locked()
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

    /// Rig of the session. Its camera is that of the session's start; see
    /// [`Session::program_camera`].
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

    /// Remark for the user if the window has too few pixels for the outputs.
    pub fn too_small(&self) -> Option<String> {
        self.rig.too_small(self.request.window, &self.request.output_sizes)
    }

    /// Views of the plan.
    pub fn views(&self) -> &[View] {
        &self.plan.views.views
    }

    /// View that is nearest to the forward direction of the program's camera.
    pub fn ahead(&self) -> usize {
        let forward = camera_rotation(&self.program_camera()) * DVec3::NEG_Z;
        let slant = |view: &View| (view.rotation * forward).z;
        let views = self.views().iter().enumerate();
        views.min_by(|a, b| slant(a.1).total_cmp(&slant(b.1))).map_or(0, |(index, _)| index)
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

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

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
}
