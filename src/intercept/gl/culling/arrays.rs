//! Where the vertices of draws from arrays are, with the fixed-function pipeline.
//!
//! Arrays in the program's memory are looked through at every draw, since they may change without a call. Arrays
//! in buffers are read only when a list is compiled, which happens once; otherwise their place is not known.

use super::super::context::Context;
use super::super::draw::draw_command;
use super::super::hook::hooks;
use super::super::outlines::Shape;
use super::bounds::Bounds;
use crate::backend::gl::api::{self, Gl};
use std::ffi::c_void;

/// The most bytes of a buffer that are read for a list.
const MOST_BYTES: usize = 64 << 20;

/// The array of positions.
struct Positions {
    /// In the program's memory, or in the buffer.
    start: *const u8,
    /// 0 = the program's memory.
    buffer: u32,
    stride: usize,
    components: usize,
    kind: u32,
}

impl Positions {
    /// What the program has set; `None` where that is not all there is to a position.
    fn of(gl: &Gl) -> Option<Self> {
        let get = |name: u32| -> i32 {
            let mut value = 0;
            // SAFETY: writes one integer.
            unsafe { gl.get_integerv(name, &mut value) };
            value
        };
        let mut generic = 0;
        let mut start = std::ptr::null_mut::<c_void>();
        // SAFETY: writes one integer and one pointer; the context has a fixed-function pipeline.
        unsafe {
            if gl.is_enabled(api::GL_VERTEX_ARRAY) == 0 {
                return None;
            }
            // Generic attribute 0 is the position where it is an array.
            gl.get_vertex_attribiv(0, api::GL_VERTEX_ATTRIB_ARRAY_ENABLED, &mut generic);
            gl.get_pointerv(api::GL_VERTEX_ARRAY_POINTER, &mut start);
        }
        let kind = get(api::GL_VERTEX_ARRAY_TYPE) as u32;
        let components = usize::try_from(get(api::GL_VERTEX_ARRAY_SIZE)).ok()?;
        let packed = components * width(kind)?;
        let stride = match usize::try_from(get(api::GL_VERTEX_ARRAY_STRIDE)).ok()? {
            0 => packed,
            stride => stride,
        };
        let buffer = get(api::GL_VERTEX_ARRAY_BUFFER_BINDING) as u32;
        let usable = generic == 0 && (2..=4).contains(&components) && (buffer != 0 || !start.is_null());
        usable.then_some(Self { start: start.cast(), buffer, stride, components, kind })
    }

    /// A box around the vertices of these numbers.
    ///
    /// # Safety
    /// The program's arrays must hold them, as it promises OpenGL with a draw.
    unsafe fn around(&self, gl: &Gl, indices: impl Iterator<Item = usize> + Clone) -> Bounds {
        let Some(greatest) = indices.clone().max() else { return Bounds::UNKNOWN };
        let mut bytes = Vec::new();
        let mut start = self.start;
        if self.buffer != 0 {
            let size = greatest.saturating_mul(self.stride).saturating_add(self.components * size_of::<f64>());
            if size > MOST_BYTES {
                return Bounds::UNKNOWN;
            }
            let Some(read) = read(gl, self.buffer, self.start as usize, size) else { return Bounds::UNKNOWN };
            bytes = read;
            start = bytes.as_ptr();
        }
        let mut bounds = Bounds::EMPTY;
        for index in indices {
            let mut position = [0.0, 0.0, 0.0, 1.0];
            for (k, coordinate) in position.iter_mut().enumerate().take(self.components) {
                let offset = index * self.stride + k * width(self.kind).unwrap_or_default();
                if self.buffer != 0 && offset + width(self.kind).unwrap_or_default() > bytes.len() {
                    return Bounds::UNKNOWN;
                }
                // SAFETY: inside the program's array, or inside the bytes that were read.
                *coordinate = unsafe { number(start.add(offset), self.kind) };
            }
            bounds.add(position);
            if bounds.known().is_none() {
                break;
            }
        }
        bounds
    }
}

/// Bytes of a coordinate; `None` for types that are not looked through.
fn width(kind: u32) -> Option<usize> {
    match kind {
        api::GL_SHORT => Some(2),
        api::GL_INT | api::GL_FLOAT => Some(4),
        api::GL_DOUBLE => Some(8),
        _ => None,
    }
}

/// A coordinate.
///
/// # Safety
/// `at` must point at a number of the type `kind`.
unsafe fn number(at: *const u8, kind: u32) -> f64 {
    // SAFETY: as promised; unaligned numbers are allowed here.
    unsafe {
        match kind {
            api::GL_SHORT => at.cast::<i16>().read_unaligned().into(),
            api::GL_INT => at.cast::<i32>().read_unaligned().into(),
            api::GL_FLOAT => at.cast::<f32>().read_unaligned().into(),
            api::GL_DOUBLE => at.cast::<f64>().read_unaligned(),
            _ => f64::NAN,
        }
    }
}

/// At most `size` bytes of a buffer from `start` on; `None` where it cannot be read now.
fn read(gl: &Gl, buffer: u32, start: usize, size: usize) -> Option<Vec<u8>> {
    let (mut bound, mut whole, mut mapped) = (0, 0, 0);
    // SAFETY: queries, and a read of bytes that the buffer has; the binding is put back.
    unsafe {
        gl.get_integerv(api::GL_ARRAY_BUFFER_BINDING, &mut bound);
        gl.bind_buffer(api::GL_ARRAY_BUFFER, buffer);
        gl.get_buffer_parameteriv(api::GL_ARRAY_BUFFER, api::GL_BUFFER_SIZE, &mut whole);
        gl.get_buffer_parameteriv(api::GL_ARRAY_BUFFER, api::GL_BUFFER_MAPPED, &mut mapped);
        let size = size.min(usize::try_from(whole).unwrap_or(0).saturating_sub(start));
        let mut bytes = vec![0u8; size];
        let readable = mapped == 0 && size > 0;
        if readable {
            gl.get_buffer_sub_data(api::GL_ARRAY_BUFFER, start as isize, size as isize, bytes.as_mut_ptr().cast());
        }
        gl.bind_buffer(api::GL_ARRAY_BUFFER, bound as u32);
        readable.then_some(bytes)
    }
}

/// Whether a box may spare a view something.
fn useful(ctx: &Context) -> bool {
    let fixed = ctx.target.is_some() && ctx.profile.compatibility() && !ctx.assembly;
    if !fixed || !crate::intercept::settings::settings().is_some_and(|s| s.cull) {
        return false;
    }
    let shaders = ctx.program.as_ref().is_some_and(|p| p.draws_vertices());
    ctx.compiling() || (ctx.redirected() && !ctx.picking && !shaders && ctx.widest.margin().is_finite())
}

/// The array, if its vertices are to be looked through now.
fn positions(ctx: &Context) -> Option<Positions> {
    if !useful(ctx) {
        return None;
    }
    Positions::of(ctx.gl).filter(|p| p.buffer == 0 || ctx.compiling())
}

/// Around the vertices of `glDrawArrays`.
///
/// # Safety
/// The arguments are the program's, who promises OpenGL that its arrays hold them.
unsafe fn around_range(ctx: &Context, first: i32, count: i32) -> Bounds {
    let (Ok(first), Ok(count)) = (usize::try_from(first), usize::try_from(count)) else { return Bounds::UNKNOWN };
    match positions(ctx) {
        // SAFETY: as promised.
        Some(positions) => unsafe { positions.around(ctx.gl, first..first + count) },
        None => Bounds::UNKNOWN,
    }
}

/// Around the vertices of `glDrawElements`.
///
/// # Safety
/// As for [`around_range`].
unsafe fn around_elements(ctx: &Context, count: i32, kind: u32, indices: *const c_void) -> Bounds {
    let Some(positions) = positions(ctx) else { return Bounds::UNKNOWN };
    let gl = ctx.gl;
    let mut buffer = 0;
    // SAFETY: writes one integer; asks for switches.
    let restarts = unsafe {
        gl.get_integerv(api::GL_ELEMENT_ARRAY_BUFFER_BINDING, &mut buffer);
        gl.is_enabled(api::GL_PRIMITIVE_RESTART) != 0
            || (ctx.profile.version >= 43 && gl.is_enabled(api::GL_PRIMITIVE_RESTART_FIXED_INDEX) != 0)
    };
    // An index that begins a new primitive is no vertex.
    if buffer != 0 || indices.is_null() || restarts || ctx.profile.version < 31 {
        return Bounds::UNKNOWN;
    }
    let numbers = 0..usize::try_from(count).unwrap_or(0);
    // SAFETY: as promised: `count` indices of the type `kind`, which may be unaligned.
    unsafe {
        match kind {
            api::GL_UNSIGNED_BYTE => positions.around(gl, numbers.map(|i| usize::from(*indices.cast::<u8>().add(i)))),
            api::GL_UNSIGNED_SHORT => {
                positions.around(gl, numbers.map(|i| usize::from(indices.cast::<u16>().add(i).read_unaligned())))
            }
            api::GL_UNSIGNED_INT => {
                positions.around(gl, numbers.map(|i| indices.cast::<u32>().add(i).read_unaligned() as usize))
            }
            _ => Bounds::UNKNOWN,
        }
    }
}

hooks! {
    "glDrawArrays" draw_arrays(mode: u32, first: i32, count: i32) = |ctx, _gl| {
        let bounds = around_range(ctx, first, count);
        draw_command(ctx, Shape::of_mode(mode), &bounds, |_, gl| gl.draw_arrays(mode, first, count));
    };
    "glDrawElements" draw_elements(mode: u32, count: i32, kind: u32, indices: *const c_void) = |ctx, _gl| {
        let bounds = around_elements(ctx, count, kind, indices);
        draw_command(ctx, Shape::of_mode(mode), &bounds, |_, gl| gl.draw_elements(mode, count, kind, indices));
    };
    "glDrawRangeElements" draw_range_elements(mode: u32, start: u32, end: u32, count: i32, kind: u32, indices: *const c_void) = |ctx, _gl| {
        let bounds = around_elements(ctx, count, kind, indices);
        draw_command(ctx, Shape::of_mode(mode), &bounds, |_, gl| gl.draw_range_elements(mode, start, end, count, kind, indices));
    };
}
