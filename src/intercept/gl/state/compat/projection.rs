//! The fixed-function projection of the program and of each view.

use crate::backend::gl::driver::api::{self, Gl};
use crate::runtime::Session;
use crate::runtime::session::{MatrixClass, classify};
use glam::DMat4;

/// The program's `GL_PROJECTION`, its class, and the projections of the views.
pub struct Projection {
    /// True if the matrix may have changed since it was read.
    changed: bool,
    /// The matrix as the program set it.
    matrix: DMat4,
    /// Class of the matrix.
    class: MatrixClass,
    /// Projection of each view, in the order of the views.
    per_view: Vec<DMat4>,
    /// Value of `GL_MODELVIEW`; `None` if it may have changed since it was read.
    model_view: Option<DMat4>,
}

impl Default for Projection {
    fn default() -> Self {
        Self { changed: true, matrix: DMat4::ZERO, class: MatrixClass::Other, per_view: Vec::new(), model_view: None }
    }
}

impl Projection {
    fn update(&mut self, matrix: DMat4, session: &Session) {
        self.changed = false;
        if matrix == self.matrix && !self.per_view.is_empty() {
            return;
        }
        self.matrix = matrix;
        self.class = classify(&matrix);
        self.per_view.clear();
        if let MatrixClass::Perspective(intrinsics) = &self.class {
            self.per_view.extend(session.rows(intrinsics).map(|reprojection| reprojection.matrix() * matrix));
        }
    }

    /// Reads the matrix and computes what depends on it. Asks the driver only after a change.
    pub fn refresh(&mut self, gl: &Gl, session: Option<&Session>) {
        if let Some(session) = session.filter(|_| self.changed) {
            let mut matrix = DMat4::ZERO;
            // SAFETY: writes sixteen doubles; the context has a fixed-function pipeline.
            unsafe { gl.get_doublev(api::GL_PROJECTION_MATRIX, matrix.as_mut().as_mut_ptr()) };
            self.update(matrix, session);
        }
    }

    /// Returns the matrix as the program set it.
    pub fn matrix(&self) -> &DMat4 {
        &self.matrix
    }

    /// Returns the class of the matrix.
    pub fn class(&self) -> &MatrixClass {
        &self.class
    }

    /// Returns the projection of a view.
    pub fn of_view(&self, view: usize) -> Option<&DMat4> {
        self.per_view.get(view)
    }

    /// Copies the projections of all views to `views`, whose memory is used again.
    pub fn copy_views_to(&self, views: &mut Vec<DMat4>) {
        views.clone_from(&self.per_view);
    }

    /// Returns `GL_MODELVIEW`. Asks the driver only after a change.
    pub fn model_view(&mut self, gl: &Gl) -> DMat4 {
        *self.model_view.get_or_insert_with(|| {
            let mut matrix = DMat4::ZERO;
            // SAFETY: writes sixteen doubles; the context has a fixed-function pipeline.
            unsafe { gl.get_doublev(api::GL_MODELVIEW_MATRIX, matrix.as_mut().as_mut_ptr()) };
            matrix
        })
    }

    /// Notes that the program may have changed the matrix of `mode`.
    pub fn touch(&mut self, mode: u32) {
        match mode {
            api::GL_PROJECTION => self.changed = true,
            api::GL_MODELVIEW => self.model_view = None,
            _ => {}
        }
    }

    /// Forgets the projections, as the views have changed.
    pub fn clear(&mut self) {
        self.changed = true;
        self.per_view.clear();
    }
}

/// Loads `matrix` into `GL_PROJECTION`; the matrix mode `mode` stays.
pub fn load(gl: &Gl, mode: u32, matrix: &DMat4) {
    // SAFETY: reads sixteen doubles; the matrix mode is put back.
    unsafe {
        if mode != api::GL_PROJECTION {
            gl.matrix_mode(api::GL_PROJECTION);
        }
        gl.load_matrixd(matrix.as_ref().as_ptr());
        if mode != api::GL_PROJECTION {
            gl.matrix_mode(mode);
        }
    }
}
