//! Position of a program, proven from the text of its vertex shader.

use crate::backend::gl::driver::api::Gl;
use crate::intercept::gl::shader::source::prover::{self, PositionArray, Proof};
use crate::intercept::gl::state::shader::programs::{Array, Factor, Position};
use crate::intercept::gl::state::shader::uniforms::Uniforms;
use std::ffi::CString;

impl Position {
    /// Returns the position of a linked program whose only stage before rasterisation is the vertex
    /// shader `source`; `None` if the text proves none.
    pub fn of_shader(gl: &Gl, program: u32, source: &str, es_context: bool, uniforms: &Uniforms) -> Option<Self> {
        let Proof { factors, attribute, components } = prover::prove(source, es_context)?;
        let array = match attribute {
            PositionArray::Conventional => Array::Conventional,
            PositionArray::Named(name) => {
                let name = CString::new(name).ok()?;
                // SAFETY: a name that ends with NUL.
                let location = unsafe { gl.get_attrib_location(program, name.as_ptr()) };
                Array::Generic(u32::try_from(location).ok()?)
            }
        };
        let factor = |factor: prover::Factor| match factor {
            prover::Factor::ModelView => Some(Factor::ModelView),
            prover::Factor::Projection => Some(Factor::Projection),
            prover::Factor::Uniform(name) => uniforms.number(&name).map(Factor::Uniform),
        };
        let factors = factors.into_iter().map(factor).collect::<Option<_>>()?;
        Some(Self { array, components, factors })
    }
}
