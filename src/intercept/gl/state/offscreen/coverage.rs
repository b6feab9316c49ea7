//! Flat draws to the window that sample followed images, and flat draws into such images.

use crate::backend::gl::driver::api::{self, Gl};
use crate::correct::LowerLeftRect;
use crate::intercept::gl::state::offscreen::images::Set;
use crate::intercept::scene::viewport::parts::{ARMS, Filled, PROBES, Picture};

/// Flat draws to the window that sample followed images, and flat draws into such images.
#[derive(Default)]
pub struct Coverage(pub(in crate::intercept::gl) Vec<Kind>);

/// Properties that draws of equal coverage have in common.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::intercept::gl) struct Signature {
    pub(in crate::intercept::gl) program: u32,
    pub(in crate::intercept::gl) sampled: Set,
    pub(in crate::intercept::gl) viewport: LowerLeftRect,
    /// Number of a flat draw to the window among those behind the scene; 0 for other draws. It tells
    /// draws of the fixed-function pipeline apart, which have no program.
    pub(in crate::intercept::gl) number: u32,
}

pub(in crate::intercept::gl) struct Kind {
    pub(in crate::intercept::gl) signature: Signature,
    pub(in crate::intercept::gl) state: State,
}

pub(in crate::intercept::gl) enum State {
    /// Not measured yet.
    New,
    /// Name of the query, and the whole picture.
    Measured(u32, Picture),
    /// Number of samples of a draw that fills a large part of the picture. Its borders are to be
    /// measured.
    Large(i64, Picture),
    /// Queries of the four arms of a cross, and number of samples of the draw.
    Crossed([u32; ARMS], i64, Picture),
    /// Queries of the pixels that tell whether the draw fills the picture.
    Probed([u32; PROBES], Picture),
    /// The rectangle that such draws fill. `None`: they fill no large rectangle.
    Known(Option<LowerLeftRect>),
}

/// The measurement of one draw.
#[derive(Clone, Copy, PartialEq, Eq)]
pub struct Measure {
    /// Index of the draw's kind in the list.
    pub(in crate::intercept::gl) kind: usize,
    /// What is measured.
    pub(in crate::intercept::gl) what: Measured,
}

/// What is measured of a draw.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(in crate::intercept::gl) enum Measured {
    /// The number of samples that it draws in this picture.
    Samples(Picture),
    /// The borders of the rectangle that it fills.
    Borders,
    /// Whether it reaches certain pixels of this picture, as OpenGL ES cannot count samples.
    Probes(Picture),
}

impl Coverage {
    /// Forgets all kinds, as images have other indices in the list or the window has another size.
    pub fn clear(&mut self, gl: &Gl) {
        for kind in self.0.drain(..) {
            kind.destroy(gl);
        }
    }

    /// Reads the results of measurements. Calls `found` with the images that are shown, and with the
    /// large part of the window that they fill, if they do. Returns true if there are any results.
    pub fn take_results(&mut self, gl: &Gl, mut found: impl FnMut(Set, Option<LowerLeftRect>)) -> bool {
        let mut any = false;
        for kind in &mut self.0 {
            let state = match kind.state {
                State::Measured(query, picture) => {
                    let samples = take_result(gl, query);
                    match picture.filled(samples) {
                        Filled::Whole => State::Known(Some(picture.whole())),
                        Filled::Large if kind.signature.sampled != 0 => State::Large(samples, picture),
                        Filled::Large | Filled::Small => State::Known(None),
                    }
                }
                State::Crossed(queries, samples, picture) => {
                    State::Known(picture.rectangle(queries.map(|query| take_result(gl, query)), samples))
                }
                State::Probed(queries, picture) => {
                    let reached = queries.map(|query| take_result(gl, query)).iter().all(|any| *any != 0);
                    State::Known(reached.then(|| picture.whole()))
                }
                _ => continue,
            };
            if let State::Known(part) = state {
                found(kind.signature.sampled, part);
            }
            kind.state = state;
            any = true;
        }
        any
    }
}

/// Returns the result of a query, and deletes it.
fn take_result(gl: &Gl, query: u32) -> i64 {
    let mut samples = 0;
    // SAFETY: a query of Cupola that has ended; writes one integer.
    unsafe {
        gl.get_query_objectuiv(query, api::GL_QUERY_RESULT, &mut samples);
        gl.delete_queries(1, &query);
    }
    i64::from(samples)
}

impl Kind {
    pub(in crate::intercept::gl) fn destroy(&self, gl: &Gl) {
        let queries: &[u32] = match &self.state {
            State::Measured(query, _) => std::slice::from_ref(query),
            State::Crossed(queries, ..) => queries,
            State::Probed(queries, ..) => queries,
            _ => return,
        };
        // SAFETY: objects of Cupola.
        unsafe { gl.delete_queries(queries.len() as i32, queries.as_ptr()) };
    }
}
