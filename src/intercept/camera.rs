//! The program's cameras: which lenses it draws with, and each view's transform for them.

use crate::correct::projected::matrices::ReprojectionMatrix;
use crate::intercept::lens::same;
use crate::runtime::Session;
use crate::runtime::session::Intrinsics;

/// A lens of the program and the rows that take it to each view.
pub struct Camera {
    /// The lens.
    pub intrinsics: Intrinsics,
    /// Rows for every view, as the patched shaders take them.
    pub rows: Vec<ReprojectionMatrix>,
    used: bool,
}

/// The lenses seen lately. Draws with the same lens share bit-identical rows, or equal depths
/// of two passes would fight.
#[derive(Default)]
pub struct Cameras {
    list: Vec<Camera>,
    /// Memory of cameras that were forgotten, for new ones: a lens that changes in every frame allocates nothing.
    spare: Vec<Vec<ReprojectionMatrix>>,
}

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
        self.list.push(Camera { intrinsics: *intrinsics, rows, used: true });
        self.list.len() - 1
    }

    /// The camera at `index`.
    pub fn get(&self, index: usize) -> Option<&Camera> {
        self.list.get(index)
    }

    /// A frame ended: lenses that it did not use are forgotten.
    pub fn end_frame(&mut self) {
        let spare = &mut self.spare;
        self.list.retain_mut(|camera| {
            let used = std::mem::take(&mut camera.used);
            if !used {
                forget(camera, spare);
            }
            used
        });
    }

    /// The views changed: nothing is valid any more.
    pub fn clear(&mut self) {
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
