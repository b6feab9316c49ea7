//! The program's cameras: which lenses it draws with, and each view's transform for them.

use crate::correct::projected::matrices::ReprojectionMatrix;
use crate::intercept::lens::same;
use crate::runtime::Session;
use crate::runtime::session::{CameraFunction, Intrinsics, MatrixClass, classify};

/// A lens of the program and the rows that take it to each view.
pub struct Camera {
    /// The lens.
    pub intrinsics: Intrinsics,
    /// Rows for every view, as the patched shaders take them.
    pub rows: Vec<ReprojectionMatrix>,
    used: bool,
    /// Number of frames, this one included, for which the views are known to be drawn with it.
    shown: u8,
}

/// The lenses seen lately. Draws with the same lens share bit-identical rows, or equal depths
/// of two passes would fight.
#[derive(Default)]
pub struct Cameras {
    list: Vec<Camera>,
    /// Memory of cameras that were forgotten, for new ones: a lens that changes in every frame
    /// allocates nothing.
    spare: Vec<Vec<ReprojectionMatrix>>,
    /// The lens of the fixed-function pipeline, with which the views are drawn, and for how many
    /// frames that is known. It is none of the list, whose first lenses others take over.
    fixed: Option<(Intrinsics, u8)>,
    /// Number of times that the lenses of [`Cameras::shown`] changed.
    changes: u64,
}

/// A lens is shown in the frame that is drawn with it, and known to be in the next.
const FRAMES_SHOWN: u8 = 2;

/// More lenses in a frame than this are not told apart from noise.
const GREATEST: usize = 16;

impl Cameras {
    /// Index of the camera with `intrinsics`, made if new.
    pub fn index(&mut self, intrinsics: &Intrinsics, session: &Session) -> usize {
        if let Some(found) = self.list.iter().position(|c| same(&c.intrinsics, intrinsics)) {
            self.list[found].used = true;
            return found;
        }
        if self.list.len() >= GREATEST {
            self.clear();
        }
        let mut rows = self.spare.pop().unwrap_or_default();
        rows.extend(session.rows(intrinsics).map(|rows| ReprojectionMatrix::of(&rows)));
        self.list.push(Camera { intrinsics: *intrinsics, rows, used: true, shown: 0 });
        self.list.len() - 1
    }

    /// The camera at `index`.
    pub fn get(&self, index: usize) -> Option<&Camera> {
        self.list.get(index)
    }

    /// The views are drawn with the camera at `index`. A lamp's lens, with which a shadow map is
    /// drawn, is none of these.
    pub fn show(&mut self, index: usize) {
        if let Some(camera) = self.list.get_mut(index) {
            self.changes += u64::from(camera.shown == 0);
            camera.shown = FRAMES_SHOWN;
        }
    }

    /// The views are drawn with this lens of the fixed-function pipeline.
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

    /// Returns the dependence of a matrix on one of the cameras that are shown, or, where there is
    /// none, on the camera that the matrix itself tells. `inverted`: the shader computes its
    /// inverse.
    pub fn function_of(&self, matrix: &[f64; 16], inverted: bool) -> Option<(CameraFunction, Intrinsics)> {
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

    /// A frame ended: lenses that it did not use are forgotten.
    pub fn end_frame(&mut self) {
        let Self { list, spare, fixed, changes } = self;
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

    /// The views changed: nothing is valid any more.
    pub fn clear(&mut self) {
        self.changes += 1;
        self.fixed = None;
        for mut camera in self.list.drain(..) {
            forget(&mut camera, &mut self.spare);
        }
    }
}

fn forget(camera: &mut Camera, spare: &mut Vec<Vec<ReprojectionMatrix>>) {
    let mut rows = std::mem::take(&mut camera.rows);
    rows.clear();
    spare.push(rows);
}
