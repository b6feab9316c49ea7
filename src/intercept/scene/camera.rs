//! The program's cameras: the lenses that it draws with, and the transform of each view for them.

use crate::correct::projected::matrices::ReprojectionMatrix;
use crate::intercept::scene::lens::same;
use crate::runtime::Session;
use crate::runtime::session::{CameraFunction, Intrinsics, MatrixClass, classify};
use glam::DMat4;

/// A lens of the program and its reprojection matrix for each view.
pub struct Camera {
    /// The lens.
    pub intrinsics: Intrinsics,
    /// Reprojection matrices of all views, as the patched shaders take them.
    pub reprojections: Vec<ReprojectionMatrix>,
    used: bool,
    /// Number of frames, including this one, for which the views are known to be drawn with this
    /// lens.
    shown: u8,
}

/// The lenses of recent draws. Draws with the same lens must use bit-identical matrices. Otherwise
/// equal depths of two passes would fight.
#[derive(Default)]
pub struct Cameras {
    list: Vec<Camera>,
    /// Memory of forgotten cameras, reused for new ones, so that a lens that changes in every frame
    /// allocates nothing.
    spare: Vec<Vec<ReprojectionMatrix>>,
    /// Lens of the fixed-function pipeline that the views are drawn with, and the number of frames
    /// for which this is known. It is not in the list, because other code takes the first lenses of
    /// the list.
    fixed: Option<(Intrinsics, u8)>,
    /// Number of times that the lenses of [`Cameras::shown`] changed.
    changes: u64,
    /// Number of times that the adaptation of the program's camera changed.
    adjustments: u64,
}

/// A lens counts as shown in the frame that is drawn with it and in the next one.
const FRAMES_SHOWN: u8 = 2;

/// Greatest number of lenses; with more in a frame, all are forgotten.
const GREATEST: usize = 16;

impl Cameras {
    /// Returns the index of the camera with `intrinsics`, which is made if it is new.
    pub fn index(&mut self, intrinsics: &Intrinsics, session: &Session) -> usize {
        if let Some(found) = self.list.iter().position(|c| same(&c.intrinsics, intrinsics)) {
            self.list[found].used = true;
            return found;
        }
        if self.list.len() >= GREATEST {
            self.clear();
        }
        let mut reprojections = self.spare.pop().unwrap_or_default();
        reprojections.extend(session.rows(intrinsics).map(|reprojection| ReprojectionMatrix::of(&reprojection)));
        self.list.push(Camera { intrinsics: *intrinsics, reprojections, used: true, shown: 0 });
        self.list.len() - 1
    }

    /// The camera at `index`.
    pub fn get(&self, index: usize) -> Option<&Camera> {
        self.list.get(index)
    }

    /// Notes that the views are drawn with the camera at `index`. The lens of a lamp, which draws a
    /// shadow map, is never noted here.
    pub fn show(&mut self, index: usize) {
        if let Some(camera) = self.list.get_mut(index) {
            self.changes += u64::from(camera.shown == 0);
            camera.shown = FRAMES_SHOWN;
        }
    }

    /// Notes that the views are drawn with this lens of the fixed-function pipeline.
    pub fn show_fixed(&mut self, lens: &Intrinsics) {
        self.changes += u64::from(self.fixed.is_none_or(|(known, _)| known != *lens));
        self.fixed = Some((*lens, FRAMES_SHOWN));
    }

    /// All lenses of this frame and the last one.
    pub fn lenses(&self) -> impl Iterator<Item = &Intrinsics> {
        self.list.iter().map(|camera| &camera.intrinsics)
    }

    /// The lenses that the views of this frame or of the last one are drawn with.
    pub fn shown(&self) -> impl Iterator<Item = &Intrinsics> {
        let list = self.list.iter().filter(|camera| camera.shown > 0).map(|camera| &camera.intrinsics);
        list.chain(self.fixed.iter().map(|(lens, _)| lens))
    }

    /// Returns the dependence of a matrix on one of the cameras that are shown. If none is shown,
    /// returns the dependence on the camera that the matrix itself contains. `inverted`: the shader
    /// computes the inverse of the matrix.
    pub fn function_of(&self, matrix: &DMat4, inverted: bool) -> Option<(CameraFunction, Intrinsics)> {
        let mut known = self.shown().peekable();
        if known.peek().is_none() {
            return match classify(matrix) {
                MatrixClass::Perspective(lens) if inverted => Some((CameraFunction::of(matrix, &lens)?, lens)),
                _ => CameraFunction::of_inverse(matrix),
            };
        }
        known.find_map(|lens| Some((CameraFunction::of(matrix, lens)?, *lens)))
    }

    /// Number of times that [`Cameras::shown`] changed.
    pub fn changes(&self) -> u64 {
        self.changes
    }

    /// Ends a frame: forgets lenses that it did not use.
    pub fn end_frame(&mut self) {
        let Self { list, spare, fixed, changes, .. } = self;
        if let Some((_, frames)) = fixed {
            *frames -= 1;
            if *frames == 0 {
                *fixed = None;
                *changes += 1;
            }
        }
        list.retain_mut(|camera| {
            let was_shown = camera.shown > 0;
            camera.shown = camera.shown.saturating_sub(1);
            *changes += u64::from(was_shown && camera.shown == 0);
            let used = std::mem::take(&mut camera.used);
            if !used {
                forget(camera, spare);
            }
            used
        });
    }

    /// Computes the matrices of all lenses again, because the adaptation of the program's camera
    /// changed.
    pub fn adjust(&mut self, session: &Session) {
        self.changes += 1;
        self.adjustments += 1;
        for Camera { intrinsics, reprojections, .. } in &mut self.list {
            reprojections.clear();
            reprojections.extend(session.rows(intrinsics).map(|rows| ReprojectionMatrix::of(&rows)));
        }
    }

    /// Number of times that [`Cameras::adjust`] was called.
    pub fn adjustments(&self) -> u64 {
        self.adjustments
    }

    /// Forgets everything, because the views changed.
    pub fn clear(&mut self) {
        self.changes += 1;
        self.fixed = None;
        for mut camera in self.list.drain(..) {
            forget(&mut camera, &mut self.spare);
        }
    }
}

fn forget(camera: &mut Camera, spare: &mut Vec<Vec<ReprojectionMatrix>>) {
    let mut reprojections = std::mem::take(&mut camera.reprojections);
    reprojections.clear();
    spare.push(reprojections);
}
