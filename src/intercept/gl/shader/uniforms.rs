//! Finds the projection among a program's 4×4 matrices.

use crate::backend::gl::api::{self, Gl};
use crate::intercept::gl::context::gl_context::{Context, Profile};
use crate::intercept::gl::context::hooks::hooks;
use crate::intercept::gl::shader::programs::Lens;
use crate::intercept::gl::vertex_input::buffers::Buffers;
use crate::intercept::lens::{self, rank, transposed};
use std::ffi::{CStr, c_char};
use std::sync::PoisonError;

/// The 4×4 matrices of a program.
#[derive(Default)]
pub struct Uniforms {
    matrices: Vec<Matrix>,
    lens: Option<Lens>,
    generation: u64,
    /// A block's buffer is mapped for good: the program may write to it at any time, and no call tells.
    live: bool,
}

struct Matrix {
    place: Place,
    /// How much its name promises: the lower, the sooner it is believed.
    rank: u8,
    value: [f64; 16],
    name: Box<str>,
    /// The buffer that a block's value was read from, and its version then; `None` where it may change unseen.
    read: Option<(u32, u64)>,
}

enum Place {
    /// Its location.
    Uniform(i32),
    /// Binding point of its block, offset in bytes, distance between columns in bytes, row by row.
    Block { binding: u32, offset: usize, stride: usize, row_major: bool },
}

impl Uniforms {
    /// The lens that the matrices hold now.
    pub fn lens(&mut self, gl: &Gl, generation: u64, buffers: &Buffers) -> Lens {
        if self.generation != generation || self.live {
            self.generation = generation;
            if self.read_blocks(gl, buffers) {
                self.lens = None;
            }
        }
        if self.lens.is_none() {
            self.lens = Some(self.find());
        }
        self.lens.unwrap_or(Lens::Flat)
    }

    /// Whether there is a 4×4 matrix at all.
    pub fn any(&self) -> bool {
        !self.matrices.is_empty()
    }

    /// The number of the matrix that OpenGL calls `name`.
    pub fn number(&self, name: &str) -> Option<usize> {
        self.matrices.iter().position(|matrix| *matrix.name == *name)
    }

    /// The matrix of this number, as [`Uniforms::lens`] saw it; `None` where it may have changed since.
    pub fn matrix(&self, number: usize, buffers: &Buffers) -> Option<[f64; 16]> {
        let matrix = self.matrices.get(number)?;
        match (&matrix.place, matrix.read) {
            (Place::Uniform(_), _) => Some(matrix.value),
            (Place::Block { .. }, Some((buffer, version))) => {
                buffers.content(buffer).filter(|content| content.0 == version).map(|_| matrix.value)
            }
            (Place::Block { .. }, None) => None,
        }
    }

    fn find(&self) -> Lens {
        match lens::find(self.matrices.iter().map(|matrix| (matrix.rank, &matrix.value))) {
            Some((intrinsics, how)) => Lens::Perspective(intrinsics, how),
            None => Lens::Flat,
        }
    }

    /// Reads the matrices in uniform blocks again; whether any changed.
    fn read_blocks(&mut self, gl: &Gl, buffers: &Buffers) -> bool {
        let mut changed = false;
        self.live = false;
        for matrix in &mut self.matrices {
            matrix.read = None;
            if let Place::Block { binding, offset, stride, row_major } = matrix.place
                && let Some((value, mapped, buffer)) = block_matrix(gl, binding, offset, stride)
            {
                self.live |= mapped;
                matrix.read = buffers.content(buffer).map(|content| (buffer, content.0));
                let value = if row_major { transposed(&value) } else { value };
                changed |= value != matrix.value;
                matrix.value = value;
            }
        }
        changed
    }

    /// A matrix was set by its location.
    fn set(&mut self, location: i32, value: &[f64; 16]) {
        for matrix in &mut self.matrices {
            if matches!(matrix.place, Place::Uniform(at) if at == location) && matrix.value != *value {
                matrix.value = *value;
                self.lens = None;
            }
        }
    }
}

/// Sixteen floats at `offset` of the buffer bound to a uniform block's binding point, whether it is mapped for good, and
/// its name.
fn block_matrix(gl: &Gl, binding: u32, offset: usize, stride: usize) -> Option<([f64; 16], bool, u32)> {
    // SAFETY: maps or copies only bytes that lie in the buffer, and unmaps them; the binding that is borrowed
    // for it is put back.
    unsafe {
        let mut buffer = 0;
        gl.get_integeri_v(api::GL_UNIFORM_BUFFER_BINDING, binding, &mut buffer);
        let mut start = 0i64;
        gl.get_integer64i_v(api::GL_UNIFORM_BUFFER_START, binding, &mut start);
        if buffer == 0 {
            return None;
        }
        let mut previous = 0;
        gl.get_integerv(api::GL_COPY_READ_BUFFER_BINDING, &mut previous);
        gl.bind_buffer(api::GL_COPY_READ_BUFFER, buffer as u32);
        let (mut size, mut mapped) = (0, 0);
        gl.get_buffer_parameteriv(api::GL_COPY_READ_BUFFER, api::GL_BUFFER_SIZE, &mut size);
        gl.get_buffer_parameteriv(api::GL_COPY_READ_BUFFER, api::GL_BUFFER_MAPPED, &mut mapped);
        let first = usize::try_from(start).ok()? + offset;
        let length = 3 * stride + 16;
        let mut flags = 0;
        if mapped != 0 {
            gl.get_buffer_parameteriv(api::GL_COPY_READ_BUFFER, api::GL_BUFFER_ACCESS_FLAGS, &mut flags);
        }
        let for_good = flags as u32 & api::GL_MAP_PERSISTENT_BIT != 0;
        let mut result = None;
        let inside = first + length <= usize::try_from(size).unwrap_or(0);
        let matrix = |bytes: &[u8]| {
            let float = |at: usize| bytes[at..at + 4].try_into().map_or(0.0, f32::from_ne_bytes);
            std::array::from_fn(|i| f64::from(float(i / 4 * stride + i % 4 * 4)))
        };
        if for_good && inside && length <= MOST_BYTES {
            let mut bytes = [0; MOST_BYTES];
            gl.get_buffer_sub_data(
                api::GL_COPY_READ_BUFFER,
                first as isize,
                length as isize,
                bytes.as_mut_ptr().cast(),
            );
            result = Some((matrix(&bytes), true, buffer as u32));
        } else if mapped == 0 && inside {
            let pointer =
                gl.map_buffer_range(api::GL_COPY_READ_BUFFER, first as isize, length as isize, api::GL_MAP_READ_BIT);
            if !pointer.is_null() {
                let bytes = std::slice::from_raw_parts(pointer.cast::<u8>().cast_const(), length);
                result = Some((matrix(bytes), false, buffer as u32));
                gl.unmap_buffer(api::GL_COPY_READ_BUFFER);
            }
        }
        gl.bind_buffer(api::GL_COPY_READ_BUFFER, previous as u32);
        result
    }
}

/// A matrix with gaps between its columns is not longer than this in bytes.
const MOST_BYTES: usize = 256;

/// Of longer arrays of matrices, which are bones or instances, only the first is looked at.
const LONGEST: i32 = 8;

/// The 4×4 matrices of a linked program, and the index of the uniform called `ours`.
pub fn read(gl: &Gl, profile: &Profile, program: u32, ours: &str) -> (Uniforms, Option<u32>) {
    let mut uniforms = Uniforms { generation: u64::MAX, ..Uniforms::default() };
    let mut hidden = None;
    let mut count = 0;
    // SAFETY: writes one integer.
    unsafe { gl.get_programiv(program, api::GL_ACTIVE_UNIFORMS, &mut count) };
    for index in 0..u32::try_from(count).unwrap_or(0) {
        let mut text: [c_char; 256] = [0; 256];
        let (mut length, mut size, mut kind) = (0, 0, 0);
        // SAFETY: writes at most 256 characters with their NUL.
        let name = unsafe {
            gl.get_active_uniform(program, index, 256, &mut length, &mut size, &mut kind, text.as_mut_ptr());
            CStr::from_ptr(text.as_ptr())
        };
        let shown = name.to_string_lossy();
        if shown.strip_suffix("[0]").unwrap_or(&shown) == ours {
            hidden = Some(index);
        }
        if kind != api::GL_FLOAT_MAT4 || shown.starts_with("gl_") {
            continue;
        }
        // SAFETY: a NUL-terminated name.
        let location = unsafe { gl.get_uniform_location(program, name.as_ptr()) };
        let place = if location >= 0 {
            Some(Place::Uniform(location))
        } else if profile.version >= 31 || (profile.es && profile.version >= 30) {
            block_place(gl, program, index)
        } else {
            None
        };
        let Some(place) = place else { continue };
        // The elements of an array have locations that follow each other.
        let elements = if location >= 0 && size <= LONGEST { size.max(1) } else { 1 };
        let mut place = Some(place);
        for element in 0..elements {
            let mut value = [0f32; 16];
            if location >= 0 {
                // SAFETY: a 4×4 matrix is sixteen floats.
                unsafe { gl.get_uniformfv(program, location + element, value.as_mut_ptr()) };
            }
            let place = place.take().unwrap_or(Place::Uniform(location + element));
            let value = value.map(f64::from);
            uniforms.matrices.push(Matrix { place, rank: rank(&shown), value, name: (*shown).into(), read: None });
        }
    }
    (uniforms, hidden)
}

fn block_place(gl: &Gl, program: u32, index: u32) -> Option<Place> {
    let ask = |what: u32| {
        let mut answer = -1;
        // SAFETY: one index in, one integer out.
        unsafe { gl.get_active_uniformsiv(program, 1, &index, what, &mut answer) };
        answer
    };
    let block = u32::try_from(ask(api::GL_UNIFORM_BLOCK_INDEX)).ok()?;
    let mut binding = 0;
    // SAFETY: writes one integer.
    unsafe { gl.get_active_uniform_blockiv(program, block, api::GL_UNIFORM_BLOCK_BINDING, &mut binding) };
    Some(Place::Block {
        binding: u32::try_from(binding).ok()?,
        offset: usize::try_from(ask(api::GL_UNIFORM_OFFSET)).ok()?,
        stride: usize::try_from(ask(api::GL_UNIFORM_MATRIX_STRIDE)).ok()?,
        row_major: ask(api::GL_UNIFORM_IS_ROW_MAJOR) == 1,
    })
}

/// Notes a matrix that the program sets.
///
/// # Safety
/// `value` must point at `count` matrices, as the program promises OpenGL.
unsafe fn note<T: Copy + Into<f64>>(
    program: Option<&crate::intercept::gl::shader::programs::Program>,
    location: i32,
    count: i32,
    transpose: u8,
    value: *const T,
) {
    let Some(program) = program else { return };
    if location < 0 || count < 1 || value.is_null() {
        return;
    }
    let mut uniforms = program.uniforms.lock().unwrap_or_else(PoisonError::into_inner);
    for element in 0..count.min(LONGEST) {
        // SAFETY: as promised above.
        let matrix = std::array::from_fn(|i| unsafe { (*value.add(16 * element as usize + i)).into() });
        let matrix = if transpose != 0 { transposed(&matrix) } else { matrix };
        uniforms.set(location + element, &matrix);
    }
}

/// A buffer changed. Where it may be a uniform block its matrices are read back, which is a wait for the driver; a
/// program that streams vertices must not have it.
pub fn buffer_changed(ctx: &mut Context, buffer: u32) {
    ctx.buffer_generation += u64::from(ctx.block_buffers.contains(&buffer));
}

/// A buffer was bound to an indexed binding point; 0: it was taken away.
pub fn buffer_bound(ctx: &mut Context, target: u32, buffer: u32) {
    if target == api::GL_UNIFORM_BUFFER {
        ctx.buffer_generation += 1;
        ctx.block_buffers.insert(buffer);
    }
}

hooks! {
    "glUniformMatrix4fv" uniform_matrix4fv(location: i32, count: i32, transpose: u8, value: *const f32) = |ctx, gl| {
        gl.uniform_matrix4fv(location, count, transpose, value);
        if ctx.pipelines.used != 0 {
            note(ctx.program.as_deref(), location, count, transpose, value);
        } else {
            note(crate::intercept::gl::shader::program_pipelines::active(ctx).as_deref(), location, count, transpose, value);
        }
    };
    "glProgramUniformMatrix4fv" program_uniform_matrix4fv(program: u32, location: i32, count: i32, transpose: u8, value: *const f32) = |ctx, gl| {
        gl.program_uniform_matrix4fv(program, location, count, transpose, value);
        note(crate::intercept::gl::shader::programs::record(ctx, program).as_deref(), location, count, transpose, value);
    };
    "glUniformBlockBinding" uniform_block_binding(program: u32, block: u32, binding: u32) = |ctx, gl| {
        gl.uniform_block_binding(program, block, binding);
        crate::intercept::gl::shader::programs::read_again(ctx, program);
    };
}
