//! Copies of the values of one program's uniforms to another program with uniforms of the same
//! names.

use crate::backend::gl::driver::api::{self, Gl};
use std::ffi::{CStr, CString, c_char};

/// Uniforms and blocks that two programs have in common.
#[derive(Default)]
pub struct Mirror {
    uniforms: Vec<Uniform>,
    /// Index of each common block in the first program and in the second one.
    blocks: Vec<[u32; 2]>,
}

/// A uniform, or an element of an array of them.
struct Uniform {
    from: i32,
    to: i32,
    kind: u32,
}

const NAME: usize = 256;

impl Mirror {
    /// Finds the uniforms and blocks of program `to` that program `from` has, too.
    pub fn new(gl: &Gl, from: u32, to: u32) -> Self {
        let mut mirror = Self::default();
        let mut counts = [0; 2];
        // SAFETY: writes an integer each.
        unsafe {
            gl.get_programiv(to, api::GL_ACTIVE_UNIFORMS, &mut counts[0]);
            gl.get_programiv(to, api::GL_ACTIVE_UNIFORM_BLOCKS, &mut counts[1]);
        }
        let [uniforms, blocks] = counts.map(|count| u32::try_from(count).unwrap_or(0));
        for index in 0..uniforms {
            let mut text: [c_char; NAME] = [0; NAME];
            let (mut length, mut size, mut kind) = (0, 0, 0);
            // SAFETY: writes at most `NAME` characters with their NUL.
            let name = unsafe {
                gl.get_active_uniform(to, index, NAME as i32, &mut length, &mut size, &mut kind, text.as_mut_ptr());
                CStr::from_ptr(text.as_ptr()).to_string_lossy()
            };
            let base = name.strip_suffix("[0]").unwrap_or(&name);
            for element in 0..size {
                let element = if size > 1 { format!("{base}[{element}]") } else { base.to_owned() };
                let Ok(element) = CString::new(element) else { continue };
                // SAFETY: names that end with NUL.
                let locations = [from, to].map(|program| unsafe { gl.get_uniform_location(program, element.as_ptr()) });
                let [from, to] = locations;
                if from >= 0 && to >= 0 {
                    mirror.uniforms.push(Uniform { from, to, kind });
                }
            }
        }
        for index in 0..blocks {
            let mut text: [c_char; NAME] = [0; NAME];
            // SAFETY: as above.
            let other = unsafe {
                gl.get_active_uniform_block_name(to, index, NAME as i32, &mut 0, text.as_mut_ptr());
                gl.get_uniform_block_index(from, text.as_ptr())
            };
            if other != api::GL_INVALID_INDEX {
                mirror.blocks.push([other, index]);
            }
        }
        mirror
    }

    /// Copies all values from program `from` to program `to`, which is in use. Allocates nothing.
    pub fn copy(&self, gl: &Gl, from: u32, to: u32) {
        for uniform in &self.uniforms {
            // SAFETY: both programs have a uniform of this kind there, and the room is for the
            // largest, a 4×4 matrix.
            unsafe { uniform.copy(gl, from) };
        }
        for [own, other] in &self.blocks {
            let mut binding = 0;
            // SAFETY: writes one integer; both indices are of blocks.
            unsafe {
                gl.get_active_uniform_blockiv(from, *own, api::GL_UNIFORM_BLOCK_BINDING, &mut binding);
                gl.uniform_block_binding(to, *other, binding as u32);
            }
        }
    }
}

impl Uniform {
    /// # Safety
    /// The program to copy to must be in use, and both programs must have a uniform of this kind at
    /// the two locations.
    unsafe fn copy(&self, gl: &Gl, from: u32) {
        // SAFETY: as promised.
        unsafe {
            match self.kind {
                api::GL_FLOAT | api::GL_FLOAT_VEC2 | api::GL_FLOAT_VEC3 | api::GL_FLOAT_VEC4 => {
                    self.copy_floats(gl, from);
                }
                api::GL_FLOAT_MAT2
                | api::GL_FLOAT_MAT3
                | api::GL_FLOAT_MAT4
                | api::GL_FLOAT_MAT2x3
                | api::GL_FLOAT_MAT2x4
                | api::GL_FLOAT_MAT3x2
                | api::GL_FLOAT_MAT3x4
                | api::GL_FLOAT_MAT4x2
                | api::GL_FLOAT_MAT4x3 => self.copy_matrix(gl, from),
                api::GL_UNSIGNED_INT
                | api::GL_UNSIGNED_INT_VEC2
                | api::GL_UNSIGNED_INT_VEC3
                | api::GL_UNSIGNED_INT_VEC4 => self.copy_unsigned(gl, from),
                _ => self.copy_integers(gl, from),
            }
        }
    }

    /// # Safety
    /// As for [`Uniform::copy`]; the kind is a float or a vector of floats.
    unsafe fn copy_floats(&self, gl: &Gl, from: u32) {
        let mut values = [0.0f32; 4];
        // SAFETY: as promised; no value is larger than its room.
        unsafe {
            gl.get_uniformfv(from, self.from, values.as_mut_ptr());
            match self.kind {
                api::GL_FLOAT_VEC2 => gl.uniform2fv(self.to, 1, values.as_ptr()),
                api::GL_FLOAT_VEC3 => gl.uniform3fv(self.to, 1, values.as_ptr()),
                api::GL_FLOAT_VEC4 => gl.uniform4fv(self.to, 1, values.as_ptr()),
                _ => gl.uniform1fv(self.to, 1, values.as_ptr()),
            }
        }
    }

    /// # Safety
    /// As for [`Uniform::copy`]; the kind is a matrix of floats.
    unsafe fn copy_matrix(&self, gl: &Gl, from: u32) {
        let mut values = [0.0f32; 16];
        // SAFETY: as promised; no value is larger than its room.
        unsafe {
            gl.get_uniformfv(from, self.from, values.as_mut_ptr());
            let values = values.as_ptr();
            match self.kind {
                api::GL_FLOAT_MAT2 => gl.uniform_matrix2fv(self.to, 1, 0, values),
                api::GL_FLOAT_MAT3 => gl.uniform_matrix3fv(self.to, 1, 0, values),
                api::GL_FLOAT_MAT2x3 => gl.uniform_matrix2x3fv(self.to, 1, 0, values),
                api::GL_FLOAT_MAT2x4 => gl.uniform_matrix2x4fv(self.to, 1, 0, values),
                api::GL_FLOAT_MAT3x2 => gl.uniform_matrix3x2fv(self.to, 1, 0, values),
                api::GL_FLOAT_MAT3x4 => gl.uniform_matrix3x4fv(self.to, 1, 0, values),
                api::GL_FLOAT_MAT4x2 => gl.uniform_matrix4x2fv(self.to, 1, 0, values),
                api::GL_FLOAT_MAT4x3 => gl.uniform_matrix4x3fv(self.to, 1, 0, values),
                _ => gl.uniform_matrix4fv(self.to, 1, 0, values),
            }
        }
    }

    /// # Safety
    /// As for [`Uniform::copy`]; the kind is an unsigned integer or a vector of them.
    unsafe fn copy_unsigned(&self, gl: &Gl, from: u32) {
        let mut values = [0u32; 4];
        // SAFETY: as promised; no value is larger than its room.
        unsafe {
            gl.get_uniformuiv(from, self.from, values.as_mut_ptr());
            match self.kind {
                api::GL_UNSIGNED_INT => gl.uniform1uiv(self.to, 1, values.as_ptr()),
                api::GL_UNSIGNED_INT_VEC2 => gl.uniform2uiv(self.to, 1, values.as_ptr()),
                api::GL_UNSIGNED_INT_VEC3 => gl.uniform3uiv(self.to, 1, values.as_ptr()),
                _ => gl.uniform4uiv(self.to, 1, values.as_ptr()),
            }
        }
    }

    /// # Safety
    /// As for [`Uniform::copy`]; the kind is an integer, a boolean, a vector of these, or opaque.
    unsafe fn copy_integers(&self, gl: &Gl, from: u32) {
        let mut values = [0i32; 4];
        // SAFETY: as promised; no value is larger than its room.
        unsafe {
            gl.get_uniformiv(from, self.from, values.as_mut_ptr());
            match self.kind {
                api::GL_INT_VEC2 | api::GL_BOOL_VEC2 => gl.uniform2iv(self.to, 1, values.as_ptr()),
                api::GL_INT_VEC3 | api::GL_BOOL_VEC3 => gl.uniform3iv(self.to, 1, values.as_ptr()),
                api::GL_INT_VEC4 | api::GL_BOOL_VEC4 => gl.uniform4iv(self.to, 1, values.as_ptr()),
                _ => gl.uniform1iv(self.to, 1, values.as_ptr()),
            }
        }
    }
}
