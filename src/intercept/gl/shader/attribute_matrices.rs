//! Matrices that shaders get from vertex attributes, such as a camera for each instance.
//!
//! They are examined if no uniform has a lens. The lens of the first instance is used for all
//! instances. Four vectors of each instance, at consecutive locations, may be a matrix, too.

use crate::backend::gl::driver::api::{self, Gl};
use crate::intercept::gl::context::gl_context::Context;
use crate::intercept::gl::state::shader::attribute_matrices::AttributeMatrix;
use crate::intercept::gl::state::shader::position_names::PositionNames;
use crate::intercept::gl::state::vertex_input::vertex_ranges::Layout;
use crate::intercept::gl::vertex_input::{buffers, ranges, vertex_arrays};
use crate::intercept::scene::lens::{self, Candidate, Told, rank};
use glam::{DMat4, Mat4};
use std::collections::BTreeMap;
use std::ffi::{CStr, c_char};

/// Result of the search for a lens in the attributes of a program.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum FoundLens {
    /// A lens.
    Lens(Told),
    /// None of them has a lens.
    Nothing,
    /// One of them cannot be read.
    Unreadable,
}

/// Returns the matrices of a linked program that may flow into its position; all matrices if that
/// is not known.
pub fn of_program(gl: &Gl, program: u32, position: Option<&PositionNames>) -> Vec<AttributeMatrix> {
    let (mut found, mut vectors) = (Vec::new(), BTreeMap::new());
    let mut count = 0;
    // SAFETY: writes one integer.
    unsafe { gl.get_programiv(program, api::GL_ACTIVE_ATTRIBUTES, &mut count) };
    for index in 0..u32::try_from(count).unwrap_or(0) {
        let mut text: [c_char; 256] = [0; 256];
        let (mut length, mut size, mut kind) = (0, 0, 0);
        // SAFETY: writes at most 256 characters with their NUL, which are the name of an attribute.
        let (name, location) = unsafe {
            gl.get_active_attrib(program, index, 256, &mut length, &mut size, &mut kind, text.as_mut_ptr());
            (CStr::from_ptr(text.as_ptr()).to_string_lossy(), gl.get_attrib_location(program, text.as_ptr()))
        };
        let flows = position.is_none_or(|names| names.contain(&name));
        let Some(location) = u32::try_from(location).ok().filter(|_| size == 1 && flows) else { continue };
        let rank = rank(&name);
        match kind {
            api::GL_FLOAT_MAT4 => found.push(AttributeMatrix::new(location, rank, true)),
            api::GL_FLOAT_VEC4 => drop(vectors.insert(location, rank)),
            _ => {}
        }
    }
    let locations: Vec<u32> = vectors.keys().copied().collect();
    found.extend(lens::fours(&locations).into_iter().map(|first| {
        let rank = vectors.range(first..first + 4).map(|(_, rank)| *rank).min().unwrap_or_default();
        AttributeMatrix::new(first, rank, false)
    }));
    found
}

/// Returns the lens of the present draw.
pub fn lens(ctx: &mut Context, matrices: &mut [AttributeMatrix]) -> FoundLens {
    let mut readable = true;
    for matrix in &mut *matrices {
        if matrix.declared {
            readable &= read(ctx, matrix).is_some();
        } else if matrix.is_due() {
            match read(ctx, matrix) {
                Some(Read::Anew) => matrix.examine_vectors(),
                Some(Read::Before) => {}
                None => (matrix.value, matrix.read) = (DMat4::ZERO, None),
            }
        }
    }
    match lens::find(matrices.iter().map(|matrix| Candidate::either(matrix.rank, &matrix.value))) {
        _ if !readable => FoundLens::Unreadable,
        Some((told, _)) => FoundLens::Lens(told),
        None => FoundLens::Nothing,
    }
}

/// Time when the value of a matrix was read.
enum Read {
    /// Now.
    Anew,
    /// Before; it did not change since.
    Before,
}

/// Reads a matrix again if it may have changed. `None`: the matrix cannot be read.
fn read(ctx: &mut Context, matrix: &mut AttributeMatrix) -> Option<Read> {
    let (gl, profile) = (ctx.driver.gl, ctx.driver.profile);
    if !vertex_arrays::is_on(&ctx.driver, &mut ctx.vertex_input, matrix.location) {
        if !matrix.declared {
            return None;
        }
        // In the compatibility profile attribute 0 has no current value, only values of vertices.
        if matrix.location == 0 && profile.compatibility() {
            return None;
        }
        let mut value = Mat4::ZERO;
        for (location, column) in (matrix.location..).zip(value.as_mut().chunks_mut(4)) {
            // SAFETY: four floats; the locations are those of a matrix of a linked program.
            unsafe { gl.get_vertex_attribfv(location, api::GL_CURRENT_VERTEX_ATTRIB, column.as_mut_ptr()) };
        }
        (matrix.value, matrix.read) = (value.as_dmat4(), None);
        return Some(Read::Anew);
    }
    let instance = ctx.draw.first_instance() as usize;
    let mut layouts = [None; 4];
    for (location, layout) in (matrix.location..).zip(&mut layouts) {
        *layout = Some(Layout::of_instances(&ctx.driver, &mut ctx.vertex_input, location, instance)?);
    }
    let layouts = layouts.map(Option::unwrap_or_default);
    // Memory and buffers whose changes Cupola does not see are read again for each draw.
    let version = buffers::of(&ctx.share).content(layouts[0].buffer).map(|content| content.0);
    let same_buffer = layouts.iter().all(|layout| layout.buffer == layouts[0].buffer);
    let read = version.filter(|_| same_buffer).map(|version| (layouts, version));
    if read.is_some() && matrix.read == read {
        return Some(Read::Before);
    }
    for (number, layout) in layouts.iter().enumerate() {
        let position = if layout.buffer == 0 {
            // SAFETY: the program promises OpenGL that its array holds what the draw reads.
            unsafe { layout.position(layout.start as *const u8) }
        } else {
            let bytes = ranges::read(gl, &profile, layout.buffer, layout.start, layout.size())?;
            // SAFETY: `bytes` has the size of the vector.
            unsafe { layout.position(bytes.as_ptr()) }
        };
        *matrix.value.col_mut(number) = position.into();
    }
    matrix.read = read;
    Some(Read::Anew)
}
