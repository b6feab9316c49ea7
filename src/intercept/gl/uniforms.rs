//! Finds the projection among a program's 4×4 matrices.

use super::context::{Context, Profile};
use super::hook::hooks;
use super::programs::Lens;
use crate::backend::gl::api::{self, Gl};
use crate::intercept::lens::{self, rank, transposed};
use std::ffi::{CStr, c_char, c_void};
use std::sync::PoisonError;

/// The 4×4 matrices of a program.
#[derive(Default)]
pub struct Uniforms {
    matrices: Vec<Matrix>,
    lens: Option<Lens>,
    generation: u64,
}

struct Matrix {
    place: Place,
    /// How much its name promises: the lower, the sooner it is believed.
    rank: u8,
    value: [f64; 16],
}

enum Place {
    /// Its location.
    Uniform(i32),
    /// Binding point of its block, offset in bytes, distance between columns in bytes, row by row.
    Block { binding: u32, offset: usize, stride: usize, row_major: bool },
}

impl Uniforms {
    /// The lens that the matrices hold now.
    pub fn lens(&mut self, gl: &Gl, program: u32, generation: u64) -> Lens {
        if self.generation != generation {
            self.generation = generation;
            if self.read_blocks(gl, program) {
                self.lens = None;
            }
        }
        if self.lens.is_none() {
            self.lens = Some(self.find());
        }
        self.lens.unwrap_or(Lens::Flat)
    }

    fn find(&self) -> Lens {
        match lens::find(self.matrices.iter().map(|matrix| (matrix.rank, &matrix.value))) {
            Some((intrinsics, how)) => Lens::Perspective(intrinsics, how),
            None => Lens::Flat,
        }
    }

    /// Reads the matrices in uniform blocks again; whether any changed.
    fn read_blocks(&mut self, gl: &Gl, _program: u32) -> bool {
        let mut changed = false;
        for matrix in &mut self.matrices {
            if let Place::Block { binding, offset, stride, row_major } = matrix.place
                && let Some(value) = block_matrix(gl, binding, offset, stride)
            {
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

/// Sixteen floats at `offset` of the buffer bound to a uniform block's binding point.
fn block_matrix(gl: &Gl, binding: u32, offset: usize, stride: usize) -> Option<[f64; 16]> {
    // SAFETY: maps only bytes that lie in the buffer, for reading, and unmaps them; the binding
    // that is borrowed for it is put back.
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
        let mut result = None;
        if mapped == 0 && first + length <= usize::try_from(size).unwrap_or(0) {
            let pointer =
                gl.map_buffer_range(api::GL_COPY_READ_BUFFER, first as isize, length as isize, api::GL_MAP_READ_BIT);
            if !pointer.is_null() {
                let bytes = std::slice::from_raw_parts(pointer.cast::<u8>().cast_const(), length);
                let float = |at: usize| bytes[at..at + 4].try_into().map_or(0.0, f32::from_ne_bytes);
                result = Some(std::array::from_fn(|i| f64::from(float(i / 4 * stride + i % 4 * 4))));
                gl.unmap_buffer(api::GL_COPY_READ_BUFFER);
            }
        }
        gl.bind_buffer(api::GL_COPY_READ_BUFFER, previous as u32);
        result
    }
}

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
            uniforms.matrices.push(Matrix { place, rank: rank(&shown), value: value.map(f64::from) });
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
    program: Option<&super::programs::Program>,
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

/// What is bound at `target` changed. Where it may be a uniform block its matrices are read back, which is
/// a wait for the driver; a program that streams vertices must not have it.
fn changed(ctx: &mut Context, target: u32) {
    let binding = match target {
        api::GL_UNIFORM_BUFFER => api::GL_UNIFORM_BUFFER_BINDING,
        api::GL_ARRAY_BUFFER => api::GL_ARRAY_BUFFER_BINDING,
        api::GL_COPY_READ_BUFFER => api::GL_COPY_READ_BUFFER_BINDING,
        api::GL_COPY_WRITE_BUFFER => api::GL_COPY_WRITE_BUFFER_BINDING,
        _ => return,
    };
    if !ctx.block_buffers.is_empty() {
        let mut buffer = 0;
        // SAFETY: writes one integer; a program with uniform blocks has OpenGL 3.1 and with it these names.
        unsafe { ctx.gl.get_integerv(binding, &mut buffer) };
        named_changed(ctx, buffer as u32);
    }
}

/// A buffer changed.
fn named_changed(ctx: &mut Context, buffer: u32) {
    ctx.buffer_generation += u64::from(ctx.block_buffers.contains(&buffer));
}

/// A buffer was bound to an indexed binding point.
fn bound(ctx: &mut Context, target: u32, buffer: u32) {
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
            note(super::pipelines::active(ctx).as_deref(), location, count, transpose, value);
        }
    };
    "glProgramUniformMatrix4fv" program_uniform_matrix4fv(program: u32, location: i32, count: i32, transpose: u8, value: *const f32) = |ctx, gl| {
        gl.program_uniform_matrix4fv(program, location, count, transpose, value);
        note(super::programs::record(ctx, program).as_deref(), location, count, transpose, value);
    };
    "glUniformBlockBinding" uniform_block_binding(program: u32, block: u32, binding: u32) = |ctx, gl| {
        gl.uniform_block_binding(program, block, binding);
        super::programs::read_again(ctx, program);
    };
    "glBufferData" buffer_data(target: u32, size: isize, data: *const c_void, usage: u32) = |ctx, gl| {
        gl.buffer_data(target, size, data, usage);
        changed(ctx, target);
    };
    "glBufferSubData" buffer_sub_data(target: u32, offset: isize, size: isize, data: *const c_void) = |ctx, gl| {
        gl.buffer_sub_data(target, offset, size, data);
        changed(ctx, target);
    };
    "glNamedBufferData" named_buffer_data(buffer: u32, size: isize, data: *const c_void, usage: u32) = |ctx, gl| {
        gl.named_buffer_data(buffer, size, data, usage);
        named_changed(ctx, buffer);
    };
    "glNamedBufferSubData" named_buffer_sub_data(buffer: u32, offset: isize, size: isize, data: *const c_void) = |ctx, gl| {
        gl.named_buffer_sub_data(buffer, offset, size, data);
        named_changed(ctx, buffer);
    };
    "glUnmapBuffer" unmap_buffer(target: u32) -> u8 = |ctx, gl| {
        changed(ctx, target);
        gl.unmap_buffer(target)
    };
    "glUnmapNamedBuffer" unmap_named_buffer(buffer: u32) -> u8 = |ctx, gl| {
        named_changed(ctx, buffer);
        gl.unmap_named_buffer(buffer)
    };
    "glCopyBufferSubData" copy_buffer_sub_data(read: u32, write: u32, from: isize, to: isize, size: isize) = |ctx, gl| {
        gl.copy_buffer_sub_data(read, write, from, to, size);
        changed(ctx, write);
    };
    "glCopyNamedBufferSubData" copy_named_buffer_sub_data(read: u32, write: u32, from: isize, to: isize, size: isize) = |ctx, gl| {
        gl.copy_named_buffer_sub_data(read, write, from, to, size);
        named_changed(ctx, write);
    };
    "glBindBuffersBase" bind_buffers_base(target: u32, first: u32, count: i32, buffers: *const u32) = |ctx, gl| {
        gl.bind_buffers_base(target, first, count, buffers);
        for i in 0..usize::try_from(count).unwrap_or(0) {
            bound(ctx, target, if buffers.is_null() { 0 } else { *buffers.add(i) });
        }
    };
    "glBindBuffersRange" bind_buffers_range(target: u32, first: u32, count: i32, buffers: *const u32, offsets: *const isize, sizes: *const isize) = |ctx, gl| {
        gl.bind_buffers_range(target, first, count, buffers, offsets, sizes);
        for i in 0..usize::try_from(count).unwrap_or(0) {
            bound(ctx, target, if buffers.is_null() { 0 } else { *buffers.add(i) });
        }
    };
    "glBindBufferBase" bind_buffer_base(target: u32, index: u32, buffer: u32) = |ctx, gl| {
        gl.bind_buffer_base(target, index, buffer);
        bound(ctx, target, buffer);
    };
    "glBindBufferRange" bind_buffer_range(target: u32, index: u32, buffer: u32, offset: isize, size: isize) = |ctx, gl| {
        gl.bind_buffer_range(target, index, buffer, offset, size);
        bound(ctx, target, buffer);
    };
}
