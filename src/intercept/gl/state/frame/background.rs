//! Flat drawing before the scene.

use crate::correct::projected::matrices::ReprojectionMatrix;
use crate::intercept::gl::state::compat::projection;
use crate::intercept::scene::frame_order::FrameOrder;
use crate::runtime::session::{ClipRows, Session};

/// What is known about flat drawing before the scene.
#[derive(Default)]
pub struct Background {
    pub(in crate::intercept::gl) order: FrameOrder,
    rows: Vec<ClipRows>,
    shader_rows: Vec<ReprojectionMatrix>,
    /// The fixed-function projection that `per_view` is made from.
    matrix: Option<[f64; 16]>,
    per_view: Vec<[f64; 16]>,
}

impl Background {
    /// Notes a draw of the scene.
    pub fn note_scene(&mut self) {
        self.order.note_scene();
    }

    /// Notes a flat draw.
    pub fn note_flat(&mut self) {
        self.order.note_flat();
    }

    /// Ends the frame.
    pub fn end_frame(&mut self) {
        self.order.end_frame();
    }

    /// The views changed: nothing is valid any more.
    pub fn clear(&mut self) {
        self.rows.clear();
        self.shader_rows.clear();
        self.matrix = None;
    }

    /// A view's rows, for the program's shaders.
    pub fn shader_rows(&self, view: usize) -> Option<&ReprojectionMatrix> {
        self.shader_rows.get(view)
    }

    /// A view's projection, for the fixed-function pipeline.
    pub fn projection(&self, view: usize) -> Option<&[f64; 16]> {
        self.per_view.get(view)
    }

    pub(in crate::intercept::gl) fn prepare(&mut self, session: &Session, projection: &[f64; 16]) -> bool {
        if self.rows.is_empty() {
            self.rows = session.panel_rows();
            self.shader_rows = self.rows.iter().map(ReprojectionMatrix::of).collect();
            self.matrix = None;
        }
        if self.matrix.as_ref() != Some(projection) {
            self.matrix = Some(*projection);
            self.per_view.clear();
            self.per_view.extend(self.rows.iter().map(|rows| projection::multiply(&rows.matrix(), projection)));
        }
        !self.rows.is_empty()
    }
}
