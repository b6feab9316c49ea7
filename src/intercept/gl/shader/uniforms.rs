//! Finds the projection among a program's 4×4 matrices.

use crate::backend::gl::driver::api::{self, Gl};
use crate::correct::projected::projection;
use crate::intercept::gl::context::gl_context::Context;
use crate::intercept::gl::context::hooks::hooks;
use crate::intercept::gl::shader::{program_pipelines, programs};
use crate::intercept::gl::state::driver::profile::Profile;
use crate::intercept::gl::state::shader::position_names::{Choice, Elements, PositionNames, Uses};
use crate::intercept::gl::state::shader::programs::{FragCoord, Program};
use crate::intercept::gl::state::shader::uniforms::{ChosenFrom, IndexLocation, Matrix, MatrixLocation, Uniforms};
use crate::intercept::lens::{Order, rank, transposed};
use crate::lock::Lock;
use std::collections::BTreeSet;
use std::ffi::{CStr, c_char};

/// Of longer arrays of matrices, which are bones or instances, only the first is looked at, and those that the shader names
/// by their numbers.
const LONGEST: u32 = 8;

/// Uniforms that Cupola adds to shaders.
const OWN: [&str; 2] = [projection::UNIFORM, FragCoord::UNIFORM];

/// More matrices of an array are not looked at.
const MOST_NAMED: usize = 64;

/// The 4×4 matrices of a linked program that may flow into its position, all if that is not known, and the indices of
/// Cupola's own uniforms.
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
        if OWN.contains(&shown.strip_suffix("[0]").unwrap_or(&shown)) {
            own_uniforms.push(index);
            continue;
        }
        if shown.starts_with("gl_") || position.is_some_and(|names| !names.contain(&shown)) {
            continue;
        }
        // SAFETY: a NUL-terminated name.
        let location = unsafe { gl.get_uniform_location(program, name.as_ptr()) };
        let size = u32::try_from(size).unwrap_or(0).max(1);
        reader.uniform(&Active { name: &shown, index, location, size, kind });
    }
    reader.find_indices();
    (reader.uniforms, own_uniforms)
}

/// An active uniform of a program.
struct Active<'a> {
    name: &'a str,
    index: u32,
    /// −1: in a block.
    location: i32,
    size: u32,
    kind: u32,
}

struct Reader<'a> {
    gl: &'a Gl,
    profile: &'a Profile,
    program: u32,
    position: Option<&'a PositionNames>,
    uniforms: Uniforms,
    /// Integers, which may be numbers of elements.
    integers: Vec<(String, IndexLocation)>,
}

impl Reader<'_> {
    fn uniform(&mut self, active: &Active<'_>) {
        match active.kind {
            api::GL_FLOAT_MAT4 | api::GL_DOUBLE_MAT4 => self.matrices(active),
            api::GL_FLOAT_VEC4 if active.size >= 4 => self.vectors(active),
            api::GL_INT | api::GL_UNSIGNED_INT if active.size == 1 => {
                let place = match active.location {
                    -1 => self.block(active).map(|(binding, offset)| IndexLocation::Block { binding, offset }),
                    location => Some(IndexLocation::Uniform(location)),
                };
                let name = active.name.rsplit('.').next().unwrap_or(active.name).to_owned();
                self.integers.extend(place.map(|place| (name, place)));
            }
            _ => {}
        }
    }

    fn elements(&self, name: &str) -> Option<&Elements> {
        self.position.and_then(|names| names.elements(name))
    }

    /// A matrix, or an array of them.
    fn matrices(&mut self, active: &Active<'_>) {
        let known = self.elements(active.name);
        let named = known.into_iter().flat_map(|known| known.numbers.keys().copied()).filter(|n| *n < active.size);
        let mut numbers: BTreeSet<u32> = named.take(MOST_NAMED).collect();
        let chosen = active.size > 1 && known.is_none_or(|known| known.others.is_some());
        if chosen || numbers.is_empty() {
            numbers.extend(0..if active.size <= LONGEST { active.size } else { 1 });
        }
        let array = if chosen { Some(self.array(active.name)) } else { self.array_of_structures(active.name) };
        for number in numbers {
            let element = array.map(|(array, outer)| (array, outer.unwrap_or(number)));
            self.matrix(active, number, 1, Order::Either, element);
        }
    }

    /// An array of vectors, of which four may be a matrix.
    fn vectors(&mut self, active: &Active<'_>) {
        let known = self.elements(active.name);
        let mut fours: Vec<(u32, Order)> = known.into_iter().flat_map(Elements::fours).take(MOST_NAMED).collect();
        let uses = known.map_or(Some(Uses::default()), |known| known.others.as_ref().map(|(_, uses)| *uses));
        let mut array = None;
        if let Some(uses) = uses.filter(|_| fours.is_empty()) {
            let count = if active.size <= 4 * LONGEST { active.size / 4 } else { 1 };
            fours.extend((0..count).map(|number| (4 * number, uses.order())));
            array = Some(self.array(active.name).0);
        }
        for (first, order) in fours.into_iter().filter(|(first, _)| first + 4 <= active.size) {
            self.matrix(active, first, 4, order, array.map(|array| (array, first)));
        }
    }

    /// One matrix from the element `first` on, which has so many elements.
    fn matrix(&mut self, active: &Active<'_>, first: u32, elements: i32, order: Order, element: Option<(usize, u32)>) {
        let location = active.location.saturating_add(first as i32);
        let double = active.kind == api::GL_DOUBLE_MAT4;
        let mut value = [0.0; 16];
        let place = if active.location < 0 {
            let Some((binding, offset)) = self.block(active) else { return };
            let stride = |what: u32| usize::try_from(self.ask(active.index, what)).unwrap_or(0);
            let between = if active.size > 1 { stride(api::GL_UNIFORM_ARRAY_STRIDE) } else { 0 };
            let stride = if elements > 1 { between } else { stride(api::GL_UNIFORM_MATRIX_STRIDE) };
            let row_major = elements == 1 && self.ask(active.index, api::GL_UNIFORM_IS_ROW_MAJOR) == 1;
            let offset = offset + first as usize * between;
            MatrixLocation::Block { binding, offset, stride, row_major, double }
        } else {
            // The elements of an array have locations that follow each other.
            // SAFETY: sixteen numbers, four at each of four locations if these are of vectors.
            unsafe {
                if double {
                    self.gl.get_uniformdv(self.program, location, value.as_mut_ptr());
                } else {
                    let mut single = [0f32; 16];
                    let width = 16 / elements as usize;
                    for (number, part) in single.chunks_mut(width).enumerate() {
                        self.gl.get_uniformfv(self.program, location + number as i32, part.as_mut_ptr());
                    }
                    value = single.map(f64::from);
                }
            }
            if elements > 1 { MatrixLocation::Vectors(location) } else { MatrixLocation::Uniform(location) }
        };
        let rank = rank(active.name);
        let name = active.name.into();
        self.uniforms.matrices.push(Matrix { place, rank, order, value, name, read: None, element });
    }

    fn ask(&self, index: u32, what: u32) -> i32 {
        let mut answer = -1;
        // SAFETY: one index in, one integer out.
        unsafe { self.gl.get_active_uniformsiv(self.program, 1, &index, what, &mut answer) };
        answer
    }

    /// Binding point of a uniform's block, and its offset there.
    fn block(&self, active: &Active<'_>) -> Option<(u32, usize)> {
        let profile = self.profile;
        if profile.version < if profile.es { 30 } else { 31 } {
            return None;
        }
        let block = u32::try_from(self.ask(active.index, api::GL_UNIFORM_BLOCK_INDEX)).ok()?;
        let mut binding = 0;
        // SAFETY: writes one integer.
        unsafe {
            self.gl.get_active_uniform_blockiv(self.program, block, api::GL_UNIFORM_BLOCK_BINDING, &mut binding);
        }
        let offset = self.ask(active.index, api::GL_UNIFORM_OFFSET);
        Some((u32::try_from(binding).ok()?, usize::try_from(offset).ok()?))
    }

    /// The array called `name`, of which an element is chosen; no number in a structure.
    fn array(&mut self, name: &str) -> (usize, Option<u32>) {
        (self.array_by_name(name.strip_suffix("[0]").unwrap_or(name)), None)
    }

    /// The array of structures that `name` is a member of, if one of them is chosen, and its number there.
    fn array_of_structures(&mut self, name: &str) -> Option<(usize, Option<u32>)> {
        let (before, member) = name.rsplit_once("].")?;
        let (array, number) = before.rsplit_once('[')?;
        if self.elements(array).is_some_and(|known| known.others.is_none()) {
            return None;
        }
        let number = number.parse().ok()?;
        Some((self.array_by_name(&format!("{array}[].{member}")), Some(number)))
    }

    fn array_by_name(&mut self, name: &str) -> usize {
        let arrays = &mut self.uniforms.arrays;
        arrays.iter().position(|known| *known.name == *name).unwrap_or_else(|| {
            arrays.push(ChosenFrom { name: name.into(), index: IndexLocation::Unknown, chosen: None });
            arrays.len() - 1
        })
    }

    /// Finds what chooses elements of arrays.
    fn find_indices(&mut self) {
        let mut arrays = std::mem::take(&mut self.uniforms.arrays);
        for array in &mut arrays {
            let name = array.name.split('[').next().unwrap_or(&array.name);
            if let Some(Elements { others: Some((Choice::ByUniform(index), _)), .. }) = self.elements(name) {
                let place = self.integers.iter().find(|(name, _)| name == index).map(|(_, place)| *place);
                array.index = place.unwrap_or(IndexLocation::Unknown);
            }
        }
        self.uniforms.arrays = arrays;
    }
}

/// Notes a matrix that the program sets.
///
/// # Safety
/// `value` must point at `count` matrices, as the program promises OpenGL.
unsafe fn note<T: Copy + Into<f64>>(
    program: Option<&Program>,
    location: i32,
    count: i32,
    transpose: u8,
    value: *const T,
) {
    let Some(program) = program else { return };
    if location < 0 || count < 1 || value.is_null() {
        return;
    }
    let mut uniforms = program.uniforms.locked();
    for element in 0..count.min(MOST_NAMED as i32) {
        // SAFETY: as promised above.
        let matrix = std::array::from_fn(|i| unsafe { (*value.add(16 * element as usize + i)).into() });
        let matrix = if transpose != 0 { transposed(&matrix) } else { matrix };
        uniforms.set(location.saturating_add(element), &matrix);
    }
}

/// Notes vectors that the program sets.
///
/// # Safety
/// `value` must point at `count` vectors, as the program promises OpenGL.
unsafe fn note_vectors(program: Option<&Program>, location: i32, count: i32, value: *const f32) {
    let Some(program) = program else { return };
    if location < 0 || count < 1 || value.is_null() {
        return;
    }
    let mut uniforms = program.uniforms.locked();
    if uniforms.has_vectors() {
        for number in 0..count {
            // SAFETY: as promised above.
            let vector = unsafe { value.cast::<[f32; 4]>().add(number as usize).read_unaligned() };
            uniforms.set_vector(location.saturating_add(number), vector);
        }
    }
}

/// The program that `glUniform` sets.
fn with_current<T>(ctx: &Context, note: impl FnOnce(Option<&Program>) -> T) -> T {
    if ctx.shaders.pipelines.used != 0 {
        note(ctx.shaders.program.as_deref())
    } else {
        note(program_pipelines::active(ctx).as_deref())
    }
}

hooks! {
    "glUniformMatrix4fv" uniform_matrix4fv(location: i32, count: i32, transpose: u8, value: *const f32) = |ctx, gl| {
        gl.uniform_matrix4fv(location, count, transpose, value);
        with_current(ctx, |program| note(program, location, count, transpose, value));
    };
    "glUniformMatrix4dv" uniform_matrix4dv(location: i32, count: i32, transpose: u8, value: *const f64) = |ctx, gl| {
        gl.uniform_matrix4dv(location, count, transpose, value);
        with_current(ctx, |program| note(program, location, count, transpose, value));
    };
    "glUniform4fv" uniform4fv(location: i32, count: i32, value: *const f32) = |ctx, gl| {
        gl.uniform4fv(location, count, value);
        with_current(ctx, |program| note_vectors(program, location, count, value));
    };
    "glUniform4f" uniform4f(location: i32, x: f32, y: f32, z: f32, w: f32) = |ctx, gl| {
        gl.uniform4f(location, x, y, z, w);
        with_current(ctx, |program| note_vectors(program, location, 1, [x, y, z, w].as_ptr()));
    };
    "glProgramUniform4fv" program_uniform4fv(program: u32, location: i32, count: i32, value: *const f32) = |ctx, gl| {
        gl.program_uniform4fv(program, location, count, value);
        note_vectors(programs::record(&ctx.share, program).as_deref(), location, count, value);
    };
    "glProgramUniform4f" program_uniform4f(program: u32, location: i32, x: f32, y: f32, z: f32, w: f32) = |ctx, gl| {
        gl.program_uniform4f(program, location, x, y, z, w);
        note_vectors(programs::record(&ctx.share, program).as_deref(), location, 1, [x, y, z, w].as_ptr());
    };
    "glProgramUniformMatrix4dv" program_uniform_matrix4dv(program: u32, location: i32, count: i32, transpose: u8, value: *const f64) = |ctx, gl| {
        gl.program_uniform_matrix4dv(program, location, count, transpose, value);
        note(programs::record(&ctx.share, program).as_deref(), location, count, transpose, value);
    };
    "glProgramUniformMatrix4fv" program_uniform_matrix4fv(program: u32, location: i32, count: i32, transpose: u8, value: *const f32) = |ctx, gl| {
        gl.program_uniform_matrix4fv(program, location, count, transpose, value);
        note(programs::record(&ctx.share, program).as_deref(), location, count, transpose, value);
    };
    "glUniformBlockBinding" uniform_block_binding(program: u32, block: u32, binding: u32) = |ctx, gl| {
        gl.uniform_block_binding(program, block, binding);
        programs::read_again(ctx, program);
    };
}
