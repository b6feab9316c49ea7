//! The conventional arrays of a draw, read so that the processor can divide the primitives.
//!
//! Triangles and lines from buffers are left to a geometry stage if there is one: the processor
//! would have to wait for a read-back.

use crate::backend::gl::driver::api::{self, Gl};
use crate::correct::single;
use crate::intercept::gl::context::gl_context::Context;
use crate::intercept::gl::context::gl_context::ShareGroup;
use crate::intercept::gl::context::methods;
use crate::intercept::gl::projected_vertices::fixed_function::vertices::{Attribute, Vertices};
use crate::intercept::gl::projected_vertices::fixed_function::{assembly, substitute};
use crate::intercept::gl::state::driver::Driver;
use crate::intercept::gl::state::projected_vertices::fixed_pipeline;
use crate::intercept::gl::state::vertex_input::VertexInput;
use crate::intercept::gl::state::vertex_input::vertex_arrays::width;
pub use crate::intercept::gl::state::vertex_input::vertex_ranges::Vertices as Range;
use crate::intercept::gl::vertex_input::position_layout::number;
use crate::intercept::gl::vertex_input::ranges::{self, index_at, index_width};
use crate::intercept::gl::vertex_input::vertex_arrays;
use crate::intercept::scene::obstacle::Obstacle;
use std::ffi::c_void;

/// Greatest number of bytes of an array that is read.
const MOST_BYTES: usize = ranges::MOST_BYTES;

/// An enabled array.
struct Array {
    attribute: Option<Attribute>,
    buffer: u32,
    /// Address, or offset in the buffer.
    start: usize,
    stride: usize,
    kind: u32,
    components: usize,
    /// True if integers are fractions of 1.
    normalised: bool,
}

/// OpenGL's names of the state of an array.
struct Names {
    switch: u32,
    pointer: u32,
    kind: u32,
    stride: u32,
    buffer: u32,
    /// `None` if the array always has one component, or always three.
    size: Option<u32>,
    components: usize,
    normalised: bool,
}

const POSITION: Names = Names {
    switch: api::GL_VERTEX_ARRAY,
    pointer: api::GL_VERTEX_ARRAY_POINTER,
    kind: api::GL_VERTEX_ARRAY_TYPE,
    stride: api::GL_VERTEX_ARRAY_STRIDE,
    buffer: api::GL_VERTEX_ARRAY_BUFFER_BINDING,
    size: Some(api::GL_VERTEX_ARRAY_SIZE),
    components: 4,
    normalised: false,
};

const TEXTURE: Names = Names {
    switch: api::GL_TEXTURE_COORD_ARRAY,
    pointer: api::GL_TEXTURE_COORD_ARRAY_POINTER,
    kind: api::GL_TEXTURE_COORD_ARRAY_TYPE,
    stride: api::GL_TEXTURE_COORD_ARRAY_STRIDE,
    buffer: api::GL_TEXTURE_COORD_ARRAY_BUFFER_BINDING,
    size: Some(api::GL_TEXTURE_COORD_ARRAY_SIZE),
    components: 4,
    normalised: false,
};

/// Attributes with one array each.
const OTHERS: [(Attribute, Names); 4] = [
    (
        Attribute::Color,
        Names {
            switch: api::GL_COLOR_ARRAY,
            pointer: api::GL_COLOR_ARRAY_POINTER,
            kind: api::GL_COLOR_ARRAY_TYPE,
            stride: api::GL_COLOR_ARRAY_STRIDE,
            buffer: api::GL_COLOR_ARRAY_BUFFER_BINDING,
            size: Some(api::GL_COLOR_ARRAY_SIZE),
            components: 4,
            normalised: true,
        },
    ),
    (
        Attribute::SecondaryColor,
        Names {
            switch: api::GL_SECONDARY_COLOR_ARRAY,
            pointer: api::GL_SECONDARY_COLOR_ARRAY_POINTER,
            kind: api::GL_SECONDARY_COLOR_ARRAY_TYPE,
            stride: api::GL_SECONDARY_COLOR_ARRAY_STRIDE,
            buffer: api::GL_SECONDARY_COLOR_ARRAY_BUFFER_BINDING,
            size: Some(api::GL_SECONDARY_COLOR_ARRAY_SIZE),
            components: 3,
            normalised: true,
        },
    ),
    (
        Attribute::Normal,
        Names {
            switch: api::GL_NORMAL_ARRAY,
            pointer: api::GL_NORMAL_ARRAY_POINTER,
            kind: api::GL_NORMAL_ARRAY_TYPE,
            stride: api::GL_NORMAL_ARRAY_STRIDE,
            buffer: api::GL_NORMAL_ARRAY_BUFFER_BINDING,
            size: None,
            components: 3,
            normalised: true,
        },
    ),
    (
        Attribute::Fog,
        Names {
            switch: api::GL_FOG_COORD_ARRAY,
            pointer: api::GL_FOG_COORD_ARRAY_POINTER,
            kind: api::GL_FOG_COORD_ARRAY_TYPE,
            stride: api::GL_FOG_COORD_ARRAY_STRIDE,
            buffer: api::GL_FOG_COORD_ARRAY_BUFFER_BINDING,
            size: None,
            components: 1,
            normalised: false,
        },
    ),
];

/// Returns the vertices of a draw of `mode` if the processor has to divide it; an error if it
/// cannot.
///
/// # Safety
/// The program's arrays must hold `range`, as it promises OpenGL.
pub unsafe fn read(ctx: &mut Context, mode: u32, range: Range) -> Option<Result<Vertices, Obstacle>> {
    if matches!(range, Range::Range { count: ..=0, .. } | Range::Elements { count: ..=0, .. }) {
        return None;
    }
    let apart = ctx.compiling() && !ctx.projected.views_only() && methods::division_asked_for();
    if !apart && !substitute::reads(&ctx.app, &ctx.drawable, &ctx.shaders, mode)
        || !ctx.driver.profile.compatibility()
        || ctx.shaders.program().is_some()
    {
        return None;
    }
    let mut arrays = vec![array(ctx.driver.gl, &POSITION, None)?];
    // The geometry stage handles these primitives directly.
    let taken = mode <= api::GL_TRIANGLE_FAN && ctx.driver.profile.version >= 32 && !ctx.compiling();
    if arrays[0].buffer != 0 && taken {
        return None;
    }
    arrays.extend(OTHERS.iter().filter_map(|(attribute, names)| array(ctx.driver.gl, names, Some(*attribute))));
    textures(ctx.driver.gl, &mut arrays);
    // SAFETY: as promised.
    let read = unsafe { vertices(&ctx.share, &ctx.driver, &mut ctx.vertex_input, mode, &arrays, range) };
    Some(read.ok_or_else(|| "a program's vertex arrays cannot be read".into()))
}

fn array(gl: &Gl, names: &Names, attribute: Option<Attribute>) -> Option<Array> {
    let get = |name: u32| {
        let mut value = 0;
        // SAFETY: writes one integer.
        unsafe { gl.get_integerv(name, &mut value) };
        value
    };
    let mut start = std::ptr::null_mut::<c_void>();
    // SAFETY: asks for a switch; writes one pointer.
    unsafe {
        if gl.is_enabled(names.switch) == 0 {
            return None;
        }
        gl.get_pointerv(names.pointer, &mut start);
    }
    let kind = get(names.kind) as u32;
    let components = names.size.map_or(names.components, |size| usize::try_from(get(size)).unwrap_or(0));
    let stride = match usize::try_from(get(names.stride)).unwrap_or(0) {
        0 => components * width(kind).unwrap_or(0),
        stride => stride,
    };
    let buffer = get(names.buffer) as u32;
    let normalised = names.normalised && !matches!(kind, api::GL_FLOAT | api::GL_DOUBLE | api::GL_HALF_FLOAT);
    Some(Array { attribute, buffer, start: start as usize, stride, kind, components, normalised })
}

/// Adds the arrays of texture coordinates, one for each unit.
fn textures(gl: &Gl, arrays: &mut Vec<Array>) {
    let (mut active, mut units) = (0, 0);
    // SAFETY: writes one integer each; the active unit is put back.
    unsafe {
        gl.get_integerv(api::GL_CLIENT_ACTIVE_TEXTURE, &mut active);
        gl.get_integerv(api::GL_MAX_TEXTURE_COORDS, &mut units);
        for unit in 0..u32::try_from(units).unwrap_or(0).min(fixed_pipeline::UNITS as u32) {
            gl.client_active_texture(api::GL_TEXTURE0 + unit);
            arrays.extend(array(gl, &TEXTURE, Some(Attribute::Texture(unit))));
        }
        gl.client_active_texture(active as u32);
    }
}

/// # Safety
/// As for [`read`].
unsafe fn vertices(
    share: &ShareGroup,
    driver: &Driver,
    vertex_input: &mut VertexInput,
    mode: u32,
    arrays: &[Array],
    range: Range,
) -> Option<Vertices> {
    // SAFETY: as promised.
    let numbers = unsafe { numbers(share, driver, vertex_input, range) }?;
    let (least, greatest) = (*numbers.iter().min()?, *numbers.iter().max()?);
    let mut columns = Vec::new();
    for array in arrays {
        let size = array.components.checked_mul(width(array.kind)?)?;
        let bytes = (greatest - least).checked_mul(array.stride)?.checked_add(size)?;
        let start = array.start.checked_add(least.checked_mul(array.stride)?)?;
        let read = match array.buffer {
            _ if array.components == 0 || array.components > 4 || bytes > MOST_BYTES => return None,
            0 if array.start == 0 => return None,
            0 => None,
            buffer => Some(ranges::read(driver.gl, &driver.profile, buffer, start, bytes)?),
        };
        let first = read.as_ref().map_or(start as *const u8, |bytes| bytes.as_ptr());
        let column: Vec<[f32; 4]> = numbers
            .iter()
            .map(|number| {
                // SAFETY: inside the bytes that were read, or the program's array as it promises
                // OpenGL.
                unsafe { array.value(first.add((number - least) * array.stride)) }
            })
            .collect();
        columns.push(column);
    }
    let attributes = arrays.iter().filter_map(|array| array.attribute).collect();
    let values = (0..numbers.len()).flat_map(|row| columns.iter().map(move |column| column[row])).collect();
    (assembly::fills(mode) || mode <= api::GL_LINE_STRIP).then_some(Vertices { mode, attributes, values })
}

/// Returns the numbers of the vertices of a draw.
///
/// # Safety
/// As for [`read`].
unsafe fn numbers(
    share: &ShareGroup,
    driver: &Driver,
    vertex_input: &mut VertexInput,
    range: Range,
) -> Option<Vec<usize>> {
    match range {
        Range::Range { first, count } => {
            let first = usize::try_from(first).ok()?;
            Some((first..first.checked_add(usize::try_from(count).ok()?)?).collect())
        }
        Range::Elements { count, kind, indices, base } => {
            let (count, width) = (usize::try_from(count).ok()?, index_width(kind)?);
            if ranges::restarts(driver) {
                return None;
            }
            let read = match vertex_arrays::elements(share, driver, vertex_input) {
                0 if indices.is_null() => return None,
                0 => None,
                name => {
                    let bytes = count.checked_mul(width).filter(|bytes| *bytes <= MOST_BYTES)?;
                    Some(ranges::read(driver.gl, &driver.profile, name, indices as usize, bytes)?)
                }
            };
            let start = read.as_ref().map_or(indices.cast::<u8>(), |bytes| bytes.as_ptr());
            let number = |index: usize| {
                // SAFETY: the memory holds `count` indices of this type, as promised or as read.
                let number = i64::from(unsafe { index_at(start, kind, index) }) + i64::from(base);
                usize::try_from(number).ok()
            };
            (0..count).map(number).collect()
        }
    }
}

impl Array {
    /// Returns the value at `at`. Missing components have OpenGL's default values.
    ///
    /// # Safety
    /// All components at `at` must be readable.
    unsafe fn value(&self, at: *const u8) -> [f32; 4] {
        let mut value = [0.0, 0.0, 0.0, 1.0];
        let width = width(self.kind).unwrap_or(0);
        for (index, part) in value.iter_mut().enumerate().take(self.components) {
            // SAFETY: as promised.
            let read = unsafe { number(at.add(index * width), self.kind) };
            *part = if self.normalised { part_of_one(read, self.kind) } else { read };
        }
        single::values(value)
    }
}

/// Returns the fraction of 1 that an integer means in a colour or a normal (OpenGL 2.1, table 2.9).
fn part_of_one(value: f64, kind: u32) -> f64 {
    let signed = matches!(kind, api::GL_BYTE | api::GL_SHORT | api::GL_INT);
    let whole = 256f64.powi(width(kind).unwrap_or(1) as i32) - 1.0;
    if signed { (2.0 * value + 1.0) / whole } else { value / whole }
}
