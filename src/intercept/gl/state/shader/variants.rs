//! Variants of a program: programs of Cupola that divide primitives.

use crate::backend::gl::CurrentProgram;
use crate::backend::gl::driver::api::Gl;
use crate::correct::projected::division::Input;
use crate::intercept::gl::state::draw::primitives::Patch;
use crate::intercept::gl::state::shader::division_counter::Before;
use crate::intercept::gl::state::shader::uniform_mirror::Mirror;
use std::sync::Arc;

/// A program that divides primitives.
pub struct Variant {
    pub(in crate::intercept::gl) name: u32,
    /// Locations of the reprojection matrix and of the lens constants.
    pub(in crate::intercept::gl) locations: [i32; 2],
    pub(in crate::intercept::gl) mirror: Mirror,
    /// True if it counts primitives that are not divided far enough.
    pub(in crate::intercept::gl) counts: bool,
    /// Number of vertices of a patch, if it draws patches.
    pub(in crate::intercept::gl) patch: Option<i32>,
}

/// State before a variant was put in use.
pub struct InUse {
    /// Buffer that was bound before the counter.
    pub(in crate::intercept::gl) counter: Option<Before>,
    /// Number of vertices of a patch.
    pub(in crate::intercept::gl) vertices: i32,
    /// Program object that was in use before, if it has subroutines.
    pub(in crate::intercept::gl) own: Option<CurrentProgram>,
}

/// Primitives that a variant divides, and the stages that do so.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Primitives that a geometry stage divides.
    Geometry(Input),
    /// Primitives that tessellation stages divide.
    Tessellation(Patch),
}

/// The variants of a program.
#[derive(Default)]
pub struct Variants(Vec<(Kind, State)>);

#[derive(Clone, Default)]
pub(in crate::intercept::gl) enum State {
    /// No draw has needed the variant.
    #[default]
    Untried,
    /// The variant cannot be made.
    Refused,
    /// The variant exists.
    Made(Arc<Variant>),
}

impl Variants {
    pub(in crate::intercept::gl) fn state(&self, kind: Kind) -> State {
        self.0.iter().find(|known| known.0 == kind).map_or(State::Untried, |known| known.1.clone())
    }

    pub(in crate::intercept::gl) fn set(&mut self, kind: Kind, state: State) {
        self.0.retain(|known| known.0 != kind);
        self.0.push((kind, state));
    }

    /// Deletes the variants.
    pub fn destroy(&mut self, gl: &Gl) {
        for (_, state) in self.0.drain(..) {
            if let State::Made(variant) = state {
                // SAFETY: a program of Cupola; the context shares objects with the one that made
                // it.
                unsafe { gl.delete_program(variant.name) };
            }
        }
    }
}
