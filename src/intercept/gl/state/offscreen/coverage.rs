//! Flat draws to the window that sample followed images, and flat draws into such images.

use crate::backend::gl::driver::api::{self, Gl};
use crate::correct::LowerLeftRect;
use crate::intercept::gl::state::offscreen::images::Set;

/// Flat draws to the window that sample followed images, and flat draws into such images.
#[derive(Default)]
pub struct Coverage(pub(in crate::intercept::gl) Vec<Kind>);

/// Properties that draws of equal coverage have in common.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::intercept::gl) struct Signature {
    pub(in crate::intercept::gl) program: u32,
    pub(in crate::intercept::gl) sampled: Set,
    pub(in crate::intercept::gl) viewport: LowerLeftRect,
}

pub(in crate::intercept::gl) struct Kind {
    pub(in crate::intercept::gl) signature: Signature,
    pub(in crate::intercept::gl) state: State,
}

pub(in crate::intercept::gl) enum State {
    /// Not measured yet.
    New,
    /// Name of the query, and number of samples of the whole window or image.
    Measured(u32, i64),
    Known(bool),
}

/// The measurement of one draw.
#[derive(Clone, Copy)]
pub struct Measure {
    /// Index of the draw's kind in the list.
    pub(in crate::intercept::gl) kind: usize,
    /// Number of samples of the whole window or image.
    pub(in crate::intercept::gl) all: i64,
}

impl Coverage {
    /// Forgets all kinds, as images have other indices in the list or the window has another size.
    pub fn clear(&mut self, gl: &Gl) {
        for kind in self.0.drain(..) {
            kind.destroy(gl);
        }
    }

    /// Ends a frame and reads the results. Returns true if there were any.
    pub fn end_frame(&mut self, gl: &Gl, mut found: impl FnMut(Set)) -> bool {
        let mut any = false;
        for kind in &mut self.0 {
            let State::Measured(query, all) = kind.state else { continue };
            let mut samples = 0;
            // SAFETY: a query of Cupola that has ended; writes one integer.
            unsafe {
                gl.get_query_objectuiv(query, api::GL_QUERY_RESULT, &mut samples);
                gl.delete_queries(1, &query);
            }
            let fills = 10 * i64::from(samples) >= 9 * all;
            kind.state = State::Known(fills);
            any = true;
            if fills {
                found(kind.signature.sampled);
            }
        }
        any
    }
}

impl Kind {
    pub(in crate::intercept::gl) fn destroy(&self, gl: &Gl) {
        if let State::Measured(query, _) = self.state {
            // SAFETY: an object of Cupola.
            unsafe { gl.delete_queries(1, &query) };
        }
    }
}
