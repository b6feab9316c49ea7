//! Finds the projection among a program's 4×4 matrices.

use crate::backend::gl::driver::api::{self, Gl};
use crate::correct::projected::projection;
use crate::intercept::gl::state::driver::profile::Profile;
use crate::intercept::gl::state::shader::camera_matrices::MatrixStage;
use crate::intercept::gl::state::shader::position_names::{Choice, Elements, PositionNames, Uses};
use crate::intercept::gl::state::shader::programs::FragCoord;
use crate::intercept::gl::state::shader::uniforms::{
    Block, ChosenFrom, IndexLocation, Matrix, MatrixLocation, Uniforms,
};
use crate::intercept::scene::lens::{Order, rank};
use glam::{DMat4, Mat4};
use std::collections::BTreeSet;
use std::ffi::{CStr, CString, c_char};
use std::ops::Range;

/// Greatest length of an array of matrices that is examined completely. Longer arrays are bones or
/// instances: only their first matrix is examined, and those that the shader uses by number.
const LONGEST: u32 = 8;

/// True if Cupola adds this uniform to shaders.
fn is_own(name: &str) -> bool {
    let array = name.strip_suffix("[0]").unwrap_or(name);
    let of_cameras =
        MatrixStage::ALL.map(MatrixStage::names).iter().any(|names| array == names.matrices || array == names.chosen);
    of_cameras || array == projection::UNIFORM || array == FragCoord::UNIFORM
}

/// Greatest number of matrices of an array that are examined.
pub const MOST_NAMED: usize = 64;

/// Returns the 4×4 matrices of a linked program that may flow into its position (all matrices if
/// that is not known), and the indices of Cupola's own uniforms.
pub fn read(gl: &Gl, profile: &Profile, program: u32, position: Option<&PositionNames>) -> (Uniforms, Vec<u32>) {
    let mut reader = Reader { gl, profile, program, position, uniforms: Uniforms::default(), integers: Vec::new() };
    reader.uniforms.generation = u64::MAX;
    reader.uniforms.program = program;
    let mut own_uniforms = Vec::new();
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
        if is_own(&shown) {
            own_uniforms.push(index);
            continue;
        }
        if shown.starts_with("gl_") || position.is_some_and(|names| !names.contain(&shown)) {
            continue;
        }
        // SAFETY: a NUL-terminated name.
        let location = unsafe { gl.get_uniform_location(program, name.as_ptr()) };
        let size = u32::try_from(size).unwrap_or(0).max(1);
        let array = shown.strip_suffix("[0]").unwrap_or(&shown);
        let place = if location < 0 { reader.uniform_block(index) } else { Some(Place::Location(location)) };
        if let Some(place) = place {
            reader.variable(&Active { name: &shown, array, size, kind, place });
        }
    }
    reader.storage_blocks();
    reader.find_indices();
    (reader.uniforms, own_uniforms)
}

/// Returns the locations of the uniforms of these indices.
pub fn locations(gl: &Gl, program: u32, indices: &[u32]) -> Vec<Range<i32>> {
    let of = |index: &u32| {
        let mut name = [0; 256];
        let (mut length, mut size, mut kind) = (0, 0, 0);
        // SAFETY: writes one number each, and no more characters than the buffer can hold.
        let first = unsafe {
            gl.get_active_uniform(program, *index, 256, &mut length, &mut size, &mut kind, name.as_mut_ptr());
            gl.get_uniform_location(program, name.as_ptr())
        };
        (first >= 0).then(|| first..first.saturating_add(size))
    };
    indices.iter().filter_map(of).collect()
}

/// Returns the location of a uniform; −1 = there is none.
pub fn location(gl: &Gl, program: u32, uniform: &str) -> i32 {
    let name = CString::new(uniform).unwrap_or_default();
    // SAFETY: a NUL-terminated name.
    unsafe { gl.get_uniform_location(program, name.as_ptr()) }
}

/// An active variable of a program.
struct Active<'a> {
    name: &'a str,
    /// Name of the array, without numbers.
    array: &'a str,
    /// Number of elements; 0 = the buffer's size determines it.
    size: u32,
    kind: u32,
    place: Place,
}

#[derive(Clone, Copy)]
enum Place {
    /// Location of a uniform.
    Location(i32),
    /// Part of a block: offset, distance between elements and distance between columns, in bytes.
    Block { block: Block, offset: usize, between: usize, stride: usize, row_major: bool },
}

impl Active<'_> {
    fn holds(&self, number: u32) -> bool {
        self.size == 0 || number < self.size
    }

    /// Returns the number of groups of `length` elements to examine if the text names no element.
    fn looked_at(&self, length: u32) -> u32 {
        match self.size / length {
            _ if self.size == 0 => LONGEST,
            count if count <= LONGEST => count,
            _ => 1,
        }
    }
}

struct Reader<'a> {
    gl: &'a Gl,
    profile: &'a Profile,
    program: u32,
    position: Option<&'a PositionNames>,
    uniforms: Uniforms,
    /// Integer variables, which may be indices of elements.
    integers: Vec<(String, IndexLocation)>,
}

impl Reader<'_> {
    fn variable(&mut self, active: &Active<'_>) {
        match active.kind {
            api::GL_FLOAT_MAT4 | api::GL_DOUBLE_MAT4 => self.matrices(active),
            api::GL_FLOAT_VEC4 if active.holds(3) => self.vectors(active),
            api::GL_INT | api::GL_UNSIGNED_INT if active.size == 1 => {
                let place = match active.place {
                    Place::Location(location) => IndexLocation::Uniform(location),
                    Place::Block { block, offset, .. } => IndexLocation::Block { block, offset },
                };
                self.integers.push((active.name.rsplit('.').next().unwrap_or(active.name).to_owned(), place));
            }
            _ => {}
        }
    }

    /// Returns the known elements of an array with this name. Numbers in the name are ignored.
    fn elements(&self, name: &str) -> Option<&Elements> {
        let array = name.split('[').next().unwrap_or(name);
        self.position.and_then(|names| names.elements(array))
    }

    /// Reads a matrix, or an array of matrices.
    fn matrices(&mut self, active: &Active<'_>) {
        let known = self.elements(active.array);
        let named =
            known.into_iter().flat_map(|known| known.numbers.keys().copied()).filter(|number| active.holds(*number));
        let mut numbers: BTreeSet<u32> = named.take(MOST_NAMED).collect();
        let chosen = active.size != 1 && known.is_none_or(|known| known.others.is_some());
        if chosen || numbers.is_empty() {
            numbers.extend(0..active.looked_at(1));
        }
        let array = if chosen { Some((self.array(active.array), None)) } else { self.array_of_structures(active.name) };
        for number in numbers {
            let element = array.map(|(array, outer)| (array, outer.unwrap_or(number)));
            self.matrix(active, number, 1, Order::Either, element);
        }
    }

    /// Reads an array of vectors, of which four may be a matrix.
    fn vectors(&mut self, active: &Active<'_>) {
        let known = self.elements(active.array);
        let mut fours: Vec<(u32, Order)> = known.into_iter().flat_map(Elements::fours).take(MOST_NAMED).collect();
        let uses = known.map_or(Some(Uses::default()), |known| known.others.as_ref().map(|(_, uses)| *uses));
        let mut array = None;
        if let Some(uses) = uses.filter(|_| fours.is_empty()) {
            fours.extend((0..active.looked_at(4)).map(|number| (4 * number, uses.order())));
            array = Some(self.array(active.array));
        }
        for (first, order) in fours.into_iter().filter(|(first, _)| active.holds(first + 3)) {
            self.matrix(active, first, 4, order, array.map(|array| (array, first)));
        }
    }

    /// Reads one matrix that begins at the element `first` and has this number of elements.
    fn matrix(&mut self, active: &Active<'_>, first: u32, elements: i32, order: Order, element: Option<(usize, u32)>) {
        let double = active.kind == api::GL_DOUBLE_MAT4;
        let mut value = DMat4::ZERO;
        let place = match active.place {
            Place::Block { block, offset, between, stride, row_major } => {
                let offset = offset + first as usize * between;
                let (stride, row_major) = if elements > 1 { (between, false) } else { (stride, row_major) };
                MatrixLocation::Block { block, offset, stride, row_major, double }
            }
            Place::Location(location) => {
                // The elements of an array have consecutive locations.
                let location = location.saturating_add(first as i32);
                // SAFETY: reads sixteen numbers. For vectors these are four numbers at each of four
                // locations.
                unsafe {
                    if double {
                        self.gl.get_uniformdv(self.program, location, value.as_mut().as_mut_ptr());
                    } else {
                        let mut single = Mat4::ZERO;
                        let width = 16 / elements as usize;
                        for (number, part) in single.as_mut().chunks_mut(width).enumerate() {
                            self.gl.get_uniformfv(self.program, location + number as i32, part.as_mut_ptr());
                        }
                        value = single.as_dmat4();
                    }
                }
                if elements > 1 { MatrixLocation::Vectors(location) } else { MatrixLocation::Uniform(location) }
            }
        };
        let rank = rank(active.name);
        let name = active.name.into();
        self.uniforms.matrices.push(Matrix { place, rank, order, value, name, read: None, element });
    }

    /// Returns the place of a uniform in a block.
    fn uniform_block(&self, index: u32) -> Option<Place> {
        let (gl, profile) = (self.gl, self.profile);
        if profile.version < if profile.es { 30 } else { 31 } {
            return None;
        }
        let ask = |what: u32| {
            let mut answer = -1;
            // SAFETY: one index in, one integer out.
            unsafe { gl.get_active_uniformsiv(self.program, 1, &index, what, &mut answer) };
            answer
        };
        let number = u32::try_from(ask(api::GL_UNIFORM_BLOCK_INDEX)).ok()?;
        let mut binding = 0;
        // SAFETY: writes one integer.
        unsafe { gl.get_active_uniform_blockiv(self.program, number, api::GL_UNIFORM_BLOCK_BINDING, &mut binding) };
        let distance = |what: u32| usize::try_from(ask(what)).unwrap_or(0);
        Some(Place::Block {
            block: Block { binding: u32::try_from(binding).ok()?, storage: false },
            offset: usize::try_from(ask(api::GL_UNIFORM_OFFSET)).ok()?,
            between: distance(api::GL_UNIFORM_ARRAY_STRIDE),
            stride: distance(api::GL_UNIFORM_MATRIX_STRIDE),
            row_major: ask(api::GL_UNIFORM_IS_ROW_MAJOR) == 1,
        })
    }

    /// Reads the variables of storage blocks.
    fn storage_blocks(&mut self) {
        let profile = self.profile;
        if profile.version < if profile.es { 31 } else { 43 } {
            return;
        }
        let mut count = 0;
        // SAFETY: writes one integer.
        unsafe {
            let resources = api::GL_ACTIVE_RESOURCES;
            self.gl.get_program_interfaceiv(self.program, api::GL_BUFFER_VARIABLE, resources, &mut count);
        }
        for index in 0..u32::try_from(count).unwrap_or(0) {
            self.storage_variable(index);
        }
    }

    /// Reads a variable of a storage block. `None`: it cannot be a matrix.
    fn storage_variable(&mut self, index: u32) -> Option<()> {
        let (gl, program) = (self.gl, self.program);
        let ask = |interface: u32, index: u32, what: u32| {
            let (mut answer, length) = (-1, std::ptr::null_mut());
            // SAFETY: one property in, one integer out.
            unsafe { gl.get_program_resourceiv(program, interface, index, 1, &what, 1, length, &mut answer) };
            usize::try_from(answer).ok()
        };
        let variable = |what: u32| ask(api::GL_BUFFER_VARIABLE, index, what);
        let mut text: [c_char; 256] = [0; 256];
        // SAFETY: writes at most 256 characters with their NUL.
        let name = unsafe {
            let length = std::ptr::null_mut();
            gl.get_program_resource_name(program, api::GL_BUFFER_VARIABLE, index, 256, length, text.as_mut_ptr());
            CStr::from_ptr(text.as_ptr()).to_string_lossy()
        };
        if self.position.is_some_and(|names| !names.contain(&name.replacen("[0].", ".", 1))) {
            return None;
        }
        let kind = variable(api::GL_TYPE)? as u32;
        // For an array of structures OpenGL lists only the members of its first structure.
        let structures = variable(api::GL_TOP_LEVEL_ARRAY_STRIDE).filter(|stride| *stride > 0);
        let (array, size, between) = match (name.split_once("[0]."), structures) {
            (Some(_), Some(_)) if kind == api::GL_FLOAT_VEC4 => return None,
            (Some((array, member)), Some(stride)) => {
                (format!("{array}[].{member}"), variable(api::GL_TOP_LEVEL_ARRAY_SIZE)?, stride)
            }
            _ => {
                let array = name.strip_suffix("[0]").unwrap_or(&name).to_owned();
                (array, variable(api::GL_ARRAY_SIZE)?, variable(api::GL_ARRAY_STRIDE)?)
            }
        };
        let block = variable(api::GL_BLOCK_INDEX)? as u32;
        let binding = ask(api::GL_SHADER_STORAGE_BLOCK, block, api::GL_BUFFER_BINDING)? as u32;
        let place = Place::Block {
            block: Block { binding, storage: true },
            offset: variable(api::GL_OFFSET)?,
            between,
            stride: variable(api::GL_MATRIX_STRIDE)?,
            row_major: variable(api::GL_IS_ROW_MAJOR)? == 1,
        };
        let size = u32::try_from(size).ok()?;
        self.variable(&Active { name: &name, array: &array, size, kind, place });
        Some(())
    }

    /// Returns the array of structures that has `name` as a member, and the number of the
    /// structure. `None`: no structure of it is chosen by an index.
    fn array_of_structures(&mut self, name: &str) -> Option<(usize, Option<u32>)> {
        let (before, member) = name.rsplit_once("].")?;
        let (array, number) = before.rsplit_once('[')?;
        if self.elements(array).is_some_and(|known| known.others.is_none()) {
            return None;
        }
        let number = number.parse().ok()?;
        Some((self.array(&format!("{array}[].{member}")), Some(number)))
    }

    /// Returns the index of the array called `name`, from which an element is chosen.
    fn array(&mut self, name: &str) -> usize {
        let arrays = &mut self.uniforms.arrays;
        arrays.iter().position(|known| *known.name == *name).unwrap_or_else(|| {
            arrays.push(ChosenFrom { name: name.into(), index: IndexLocation::Unknown, chosen: None });
            arrays.len() - 1
        })
    }

    /// Finds the variables that choose elements of arrays.
    fn find_indices(&mut self) {
        let mut arrays = std::mem::take(&mut self.uniforms.arrays);
        for array in &mut arrays {
            if let Some(Elements { others: Some((Choice::ByUniform(index), _)), .. }) = self.elements(&array.name) {
                let place = self.integers.iter().find(|(name, _)| name == index).map(|(_, place)| *place);
                array.index = place.unwrap_or(IndexLocation::Unknown);
            }
        }
        self.uniforms.arrays = arrays;
    }
}
