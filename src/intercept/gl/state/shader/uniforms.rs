//! The 4×4 matrices of a program.

use crate::backend::gl::driver::api::{self, Gl};
use crate::intercept::gl::state::shader::programs::Lens;
use crate::intercept::gl::state::vertex_input::buffers::Buffers;
use crate::intercept::lens::{self, transposed};
use std::collections::HashSet;

/// The 4×4 matrices of a program.
#[derive(Default)]
pub struct Uniforms {
    /// Those that may flow into the position.
    pub(in crate::intercept::gl) matrices: Vec<Matrix>,
    pub(in crate::intercept::gl) lens: Option<Lens>,
    pub(in crate::intercept::gl) generation: u64,
    /// A block's buffer is mapped for good: the program may write to it at any time, and no call tells.
    pub(in crate::intercept::gl) live: bool,
}

/// Names in shaders that may flow into a position.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct PositionNames(HashSet<String>);

impl PositionNames {
    /// These and no others.
    pub fn new(names: HashSet<String>) -> Self {
        Self(names)
    }

    /// Adds more names.
    pub fn add<'a>(&mut self, names: impl Iterator<Item = &'a str>) {
        self.0.extend(names.map(str::to_owned));
    }

    /// Whether the uniform that OpenGL calls `name` (`block.member`, `array[0]`) may flow into the position.
    pub fn contain(&self, name: &str) -> bool {
        let member = name.rsplit('.').next().unwrap_or(name);
        self.0.contains(member.split('[').next().unwrap_or(member))
    }
}

pub(in crate::intercept::gl) struct Matrix {
    pub(in crate::intercept::gl) place: MatrixLocation,
    /// How much its name promises: the lower, the sooner it is believed.
    pub(in crate::intercept::gl) rank: u8,
    pub(in crate::intercept::gl) value: [f64; 16],
    pub(in crate::intercept::gl) name: Box<str>,
    /// The buffer that a block's value was read from, and its version then; `None` where it may change unseen.
    pub(in crate::intercept::gl) read: Option<(u32, u64)>,
}

pub(in crate::intercept::gl) enum MatrixLocation {
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
            (MatrixLocation::Uniform(_), _) => Some(matrix.value),
            (MatrixLocation::Block { .. }, Some((buffer, version))) => {
                buffers.content(buffer).filter(|content| content.0 == version).map(|_| matrix.value)
            }
            (MatrixLocation::Block { .. }, None) => None,
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
            if let MatrixLocation::Block { binding, offset, stride, row_major } = matrix.place
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
    pub(in crate::intercept::gl) fn set(&mut self, location: i32, value: &[f64; 16]) {
        for matrix in &mut self.matrices {
            if matches!(matrix.place, MatrixLocation::Uniform(at) if at == location) && matrix.value != *value {
                matrix.value = *value;
                self.lens = None;
            }
        }
    }
}

/// Sixteen floats at `offset` of the buffer bound to a uniform block's binding point, whether it is mapped for good, and
/// its name.
pub(in crate::intercept::gl) fn block_matrix(
    gl: &Gl,
    binding: u32,
    offset: usize,
    stride: usize,
) -> Option<([f64; 16], bool, u32)> {
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
pub(in crate::intercept::gl) const MOST_BYTES: usize = 256;
