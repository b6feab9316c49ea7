//! The 4×4 matrices of a program.

use crate::backend::gl::driver::api::{self, Gl};
use crate::intercept::gl::state::shader::programs::ProgramLens;
use crate::intercept::gl::state::vertex_input::buffers::Buffers;
use crate::intercept::process::log;
use crate::intercept::scene::lens::{self, Candidate, Order};
use glam::{DMat4, DVec4};

/// The 4×4 matrices of a program.
#[derive(Default)]
pub struct Uniforms {
    /// Matrices that are followed.
    pub(in crate::intercept::gl) matrices: Vec<Matrix>,
    /// Arrays of which some of the matrices are elements.
    pub(in crate::intercept::gl) arrays: Vec<ChosenFrom>,
    /// The program's name.
    pub(in crate::intercept::gl) program: u32,
    pub(in crate::intercept::gl) lens: Option<ProgramLens>,
    pub(in crate::intercept::gl) generation: u64,
    /// True if the buffer of a block is mapped permanently. The program may then write to it at any
    /// time, without a call.
    pub(in crate::intercept::gl) live: bool,
    /// True if it is not known with which of several lenses the program draws.
    pub(in crate::intercept::gl) unclear: bool,
    /// Number of times that a value changed.
    changes: u64,
}

pub(in crate::intercept::gl) struct Matrix {
    pub(in crate::intercept::gl) place: MatrixLocation,
    /// Rank of its name: the lower, the higher its priority.
    pub(in crate::intercept::gl) rank: u8,
    pub(in crate::intercept::gl) order: Order,
    pub(in crate::intercept::gl) value: DMat4,
    pub(in crate::intercept::gl) name: Box<str>,
    /// Buffer from which the value in a block was read, and its version at that time; `None` if the
    /// value may change without a call that Cupola sees.
    pub(in crate::intercept::gl) read: Option<(u32, u64)>,
    /// Index of its array among those of which a shader chooses an element, and the number of the
    /// element.
    pub(in crate::intercept::gl) element: Option<(usize, u32)>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::intercept::gl) enum MatrixLocation {
    /// Its location.
    Uniform(i32),
    /// The first location of four vectors.
    Vectors(i32),
    /// A matrix in a block. `offset` and `stride`, the distance between columns, are in bytes;
    /// `double`: the numbers have 64 bits.
    Block { block: Block, offset: usize, stride: usize, row_major: bool, double: bool },
}

/// A uniform block or a storage block, by its binding point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::intercept::gl) struct Block {
    pub(in crate::intercept::gl) binding: u32,
    pub(in crate::intercept::gl) storage: bool,
}

/// An array of which a shader chooses an element while it runs.
pub(in crate::intercept::gl) struct ChosenFrom {
    /// Its name, without numbers.
    pub(in crate::intercept::gl) name: Box<str>,
    pub(in crate::intercept::gl) index: IndexLocation,
    /// The element that is chosen now, if that is known.
    pub(in crate::intercept::gl) chosen: Option<u32>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::intercept::gl) enum IndexLocation {
    Unknown,
    /// The location of an integer.
    Uniform(i32),
    /// An integer in a block; `offset` is in bytes.
    Block {
        block: Block,
        offset: usize,
    },
}

impl Matrix {
    /// Returns the matrix as a candidate in the search for the lens.
    pub fn candidate(&self) -> Candidate<'_> {
        Candidate { rank: self.rank, value: &self.value, order: self.order }
    }
}

impl Uniforms {
    /// Returns the lens that the matrices hold now.
    pub fn lens(&mut self, gl: &Gl, generation: u64, buffers: &Buffers) -> ProgramLens {
        self.refresh(gl, generation, buffers);
        for array in &mut self.arrays {
            if let IndexLocation::Uniform(location) = array.index {
                let mut number = -1;
                // SAFETY: writes one integer; the uniform is an integer in the program, too.
                unsafe { gl.get_uniformiv(self.program, location, &mut number) };
                let chosen = u32::try_from(number).ok();
                if array.chosen != chosen {
                    array.chosen = chosen;
                    self.lens = None;
                }
            }
        }
        if self.lens.is_none() {
            self.lens = Some(self.find());
        }
        self.lens.unwrap_or(ProgramLens::Flat)
    }

    /// Reads the blocks again if `generation` has changed since the last time, or if a buffer may
    /// change at any time.
    pub fn refresh(&mut self, gl: &Gl, generation: u64, buffers: &Buffers) {
        if self.generation != generation || self.live {
            self.generation = generation;
            if self.read_blocks(gl, buffers) {
                self.changed();
            }
        }
    }

    fn changed(&mut self) {
        self.lens = None;
        self.changes += 1;
    }

    /// Returns the number of times that a value changed.
    pub fn changes(&self) -> u64 {
        self.changes
    }

    /// Returns the value of the matrix of this number at the last time when blocks were read.
    pub fn value(&self, number: usize) -> Option<&DMat4> {
        self.matrices.get(number).map(|matrix| &matrix.value)
    }

    /// True if there is a 4×4 matrix at all.
    pub fn any(&self) -> bool {
        !self.matrices.is_empty()
    }

    /// Returns the names of the matrices, as OpenGL calls them.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.matrices.iter().map(|matrix| &*matrix.name)
    }

    /// Returns the name of the matrix of this number.
    pub fn name(&self, number: usize) -> Option<&str> {
        self.matrices.get(number).map(|matrix| &*matrix.name)
    }

    /// Returns the number of the matrix that OpenGL calls `name`.
    pub fn number(&self, name: &str) -> Option<usize> {
        self.matrices.iter().position(|matrix| *matrix.name == *name)
    }

    /// Returns the matrix of this number, as [`Uniforms::lens`] saw it; `None` if it may have
    /// changed since then.
    pub fn matrix(&self, number: usize, buffers: &Buffers) -> Option<DMat4> {
        let matrix = self.matrices.get(number)?;
        match (&matrix.place, matrix.read) {
            (MatrixLocation::Uniform(_) | MatrixLocation::Vectors(_), _) => Some(matrix.value),
            (MatrixLocation::Block { .. }, Some((buffer, version))) => {
                buffers.content(buffer).filter(|content| content.0 == version).map(|_| matrix.value)
            }
            (MatrixLocation::Block { .. }, None) => None,
        }
    }

    fn find(&mut self) -> ProgramLens {
        // An element that Cupola does not follow gives no information.
        let is_kept = |array: usize, number: u32| self.matrices.iter().any(|m| m.element == Some((array, number)));
        let chosen = |array: usize| self.arrays.get(array)?.chosen.filter(|number| is_kept(array, *number));
        let is_used = |matrix: &&Matrix| {
            matrix.element.is_none_or(|(array, number)| chosen(array).is_none_or(|chosen| chosen == number))
        };
        let used = || self.matrices.iter().filter(is_used);
        let found = lens::find(used().map(Matrix::candidate));
        let Some((told, number)) = found else {
            self.unclear = false;
            return ProgramLens::Flat;
        };
        let array = used().nth(number).and_then(|matrix| matrix.element).map(|(array, _)| array);
        let beside = used().filter(|matrix| array.is_some() && matrix.element.map(|(array, _)| array) == array);
        let unclear =
            beside.filter_map(|matrix| matrix.candidate().lens()).any(|lens| !lens::same(&lens, &told.intrinsics));
        self.unclear = unclear;
        if unclear {
            log::once(
                "a shader chooses between matrices with different lenses, and Cupola cannot see which one it takes: its \
                 draws are flat. If they show a scene, set camera.lens in the rig",
            );
            return ProgramLens::Flat;
        }
        ProgramLens::Perspective(told, told.how())
    }

    /// Reads the matrices in blocks again, and the numbers that choose among them. Returns true if
    /// any changed.
    fn read_blocks(&mut self, gl: &Gl, buffers: &Buffers) -> bool {
        let mut changed = false;
        self.live = false;
        for matrix in &mut self.matrices {
            matrix.read = None;
            if let MatrixLocation::Block { block, offset, stride, row_major, double } = matrix.place
                && let Some((value, mapped, buffer)) = block_matrix(gl, block, offset, stride, double)
            {
                self.live |= mapped;
                matrix.read = buffers.content(buffer).map(|content| (buffer, content.0));
                let value = if row_major { value.transpose() } else { value };
                changed |= value != matrix.value;
                matrix.value = value;
            }
        }
        for array in &mut self.arrays {
            if let IndexLocation::Block { block, offset } = array.index {
                let number = |bytes: &[u8]| bytes.try_into().map_or(u32::MAX, u32::from_ne_bytes);
                let read = block_bytes(gl, block, offset, size_of::<u32>(), number);
                self.live |= read.is_some_and(|(_, mapped, _)| mapped);
                let chosen = read.map(|(number, ..)| number);
                changed |= chosen != array.chosen;
                array.chosen = chosen;
            }
        }
        changed
    }

    /// Notes that a matrix was set by its location.
    pub(in crate::intercept::gl) fn set(&mut self, location: i32, value: &DMat4) {
        let mut changed = false;
        for matrix in self.matrices.iter_mut().filter(|matrix| matrix.place == MatrixLocation::Uniform(location)) {
            changed |= matrix.value != *value;
            matrix.value = *value;
        }
        if changed {
            self.changed();
        }
    }

    /// Notes that a vector was set by its location.
    pub(in crate::intercept::gl) fn set_vector(&mut self, location: i32, vector: [f32; 4]) {
        let vector = DVec4::from(vector.map(f64::from));
        let mut changed = false;
        for matrix in &mut self.matrices {
            let MatrixLocation::Vectors(first) = matrix.place else { continue };
            let number = usize::try_from(location.wrapping_sub(first)).unwrap_or(usize::MAX);
            if number < 4 {
                let column = matrix.value.col_mut(number);
                changed |= *column != vector;
                *column = vector;
            }
        }
        if changed {
            self.changed();
        }
    }

    /// True if some matrix is made of vectors that are set by their locations.
    pub(in crate::intercept::gl) fn has_vectors(&self) -> bool {
        self.matrices.iter().any(|matrix| matches!(matrix.place, MatrixLocation::Vectors(_)))
    }
}

/// Returns the matrix at `offset` of the buffer bound to a block's binding point, true if the
/// buffer is mapped permanently, and its name.
fn block_matrix(gl: &Gl, block: Block, offset: usize, stride: usize, double: bool) -> Option<(DMat4, bool, u32)> {
    let width = if double { size_of::<f64>() } else { size_of::<f32>() };
    let entry = |bytes: &[u8], column: usize, row: usize| {
        let at = column * stride + row * width;
        match bytes.get(at..at + width) {
            Some(number) if double => number.try_into().map_or(0.0, f64::from_ne_bytes),
            Some(number) => f64::from(number.try_into().map_or(0.0, f32::from_ne_bytes)),
            None => 0.0,
        }
    };
    let column = |bytes: &[u8], column: usize| std::array::from_fn(|row| entry(bytes, column, row));
    let matrix = |bytes: &[u8]| DMat4::from_cols_array_2d(&std::array::from_fn(|number| column(bytes, number)));
    block_bytes(gl, block, offset, 3 * stride + 4 * width, matrix)
}

/// Returns the result of `read` for `length` bytes at `offset` of the buffer bound to a block's
/// binding point, true if the buffer is mapped permanently, and its name.
fn block_bytes<T>(
    gl: &Gl,
    block: Block,
    offset: usize,
    length: usize,
    read: impl FnOnce(&[u8]) -> T,
) -> Option<(T, bool, u32)> {
    // SAFETY: maps or copies only bytes that lie in the buffer, and unmaps them; the binding that
    // is used for this is put back.
    unsafe {
        let [name, first] = if block.storage {
            [api::GL_SHADER_STORAGE_BUFFER_BINDING, api::GL_SHADER_STORAGE_BUFFER_START]
        } else {
            [api::GL_UNIFORM_BUFFER_BINDING, api::GL_UNIFORM_BUFFER_START]
        };
        let mut buffer = 0;
        gl.get_integeri_v(name, block.binding, &mut buffer);
        let mut start = 0i64;
        gl.get_integer64i_v(first, block.binding, &mut start);
        if buffer == 0 {
            return None;
        }
        let first = usize::try_from(start).ok()?.checked_add(offset)?;
        let mut previous = 0;
        gl.get_integerv(api::GL_COPY_READ_BUFFER_BINDING, &mut previous);
        gl.bind_buffer(api::GL_COPY_READ_BUFFER, buffer as u32);
        let (mut size, mut mapped) = (0, 0);
        gl.get_buffer_parameteriv(api::GL_COPY_READ_BUFFER, api::GL_BUFFER_SIZE, &mut size);
        gl.get_buffer_parameteriv(api::GL_COPY_READ_BUFFER, api::GL_BUFFER_MAPPED, &mut mapped);
        let mut flags = 0;
        if mapped != 0 {
            gl.get_buffer_parameteriv(api::GL_COPY_READ_BUFFER, api::GL_BUFFER_ACCESS_FLAGS, &mut flags);
        }
        let for_good = flags as u32 & api::GL_MAP_PERSISTENT_BIT != 0;
        let mut result = None;
        let inside = first + length <= usize::try_from(size).unwrap_or(0);
        if for_good && inside && length <= MOST_BYTES {
            let mut bytes = [0; MOST_BYTES];
            gl.get_buffer_sub_data(
                api::GL_COPY_READ_BUFFER,
                first as isize,
                length as isize,
                bytes.as_mut_ptr().cast(),
            );
            result = Some((read(&bytes[..length]), true, buffer as u32));
        } else if mapped == 0 && inside {
            let pointer =
                gl.map_buffer_range(api::GL_COPY_READ_BUFFER, first as isize, length as isize, api::GL_MAP_READ_BIT);
            if !pointer.is_null() {
                let bytes = std::slice::from_raw_parts(pointer.cast::<u8>().cast_const(), length);
                result = Some((read(bytes), false, buffer as u32));
                gl.unmap_buffer(api::GL_COPY_READ_BUFFER);
            }
        }
        gl.bind_buffer(api::GL_COPY_READ_BUFFER, previous as u32);
        result
    }
}

/// Greatest length in bytes of a matrix with gaps between its columns.
const MOST_BYTES: usize = 256;
