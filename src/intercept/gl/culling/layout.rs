//! How the array of positions lies in memory.

use super::super::context::{Context, Profile};
use super::position::Array;
use crate::backend::gl::api::{self, Gl};
use std::ffi::c_void;

/// The array of positions.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Layout {
    /// 0 = the program's memory.
    pub buffer: u32,
    /// Address in the program's memory, or offset in the buffer.
    pub start: usize,
    /// Bytes from one position to the next.
    pub stride: usize,
    components: usize,
    kind: u32,
    /// Integers stand for −1…1 or 0…1.
    normalised: bool,
}

/// One integer that the driver knows.
type Ask<'a> = &'a dyn Fn(u32) -> i32;

impl Layout {
    /// What the program has set for `array`, of which `components` count; `None` where that is not all there is to a
    /// position.
    pub fn of(ctx: &Context, array: Array, components: usize) -> Option<Self> {
        let (gl, profile) = (ctx.gl, &ctx.profile);
        let layout = match array {
            Array::Conventional => conventional(gl)?,
            Array::Generic(location) => generic(gl, profile, location)?,
        };
        let given = layout.components;
        let signed = matches!(layout.kind, api::GL_BYTE | api::GL_SHORT | api::GL_INT);
        // Older versions have another rule for signed integers.
        let one_rule = profile.version >= if profile.es { 30 } else { 42 };
        let usable = (2..=4).contains(&given)
            && (layout.buffer != 0 || layout.start != 0)
            && !(layout.normalised && signed && !one_rule)
            && layout.stride > 0;
        usable.then_some(Self { components: given.min(components), ..layout })
    }

    /// Bytes of one position.
    pub fn size(&self) -> usize {
        self.components * width(self.kind).unwrap_or_default()
    }

    /// The position at `at`.
    ///
    /// # Safety
    /// [`Layout::size`] bytes from `at` on must be readable.
    pub unsafe fn position(&self, at: *const u8) -> [f64; 4] {
        let width = width(self.kind).unwrap_or_default();
        let mut position = [0.0, 0.0, 0.0, 1.0];
        for (k, coordinate) in position.iter_mut().enumerate().take(self.components) {
            // SAFETY: as promised.
            let value = unsafe { number(at.add(k * width), self.kind) };
            *coordinate = match greatest(self.kind).filter(|_| self.normalised) {
                Some(greatest) => (value / greatest).max(-1.0),
                None => value,
            };
        }
        position
    }
}

/// `glVertexPointer`.
fn conventional(gl: &Gl) -> Option<Layout> {
    let mut generic = 0;
    let mut start = std::ptr::null_mut::<c_void>();
    let get = |name: u32| {
        let mut value = 0;
        // SAFETY: writes one integer.
        unsafe { gl.get_integerv(name, &mut value) };
        value
    };
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
    let stride = match usize::try_from(get(api::GL_VERTEX_ARRAY_STRIDE)).ok()? {
        0 => components * width(kind)?,
        stride => stride,
    };
    let buffer = get(api::GL_VERTEX_ARRAY_BUFFER_BINDING) as u32;
    width(kind)?;
    (generic == 0).then_some(Layout { buffer, start: start as usize, stride, components, kind, normalised: false })
}

/// A generic attribute.
fn generic(gl: &Gl, profile: &Profile, location: u32) -> Option<Layout> {
    let get = |name: u32| {
        let mut value = 0;
        // SAFETY: writes one integer; the location is one of a linked program's.
        unsafe { gl.get_vertex_attribiv(location, name, &mut value) };
        value
    };
    let integers = profile.version >= 30;
    if get(api::GL_VERTEX_ATTRIB_ARRAY_ENABLED) == 0 || integers && get(api::GL_VERTEX_ATTRIB_ARRAY_INTEGER) != 0 {
        return None;
    }
    let kind = get(api::GL_VERTEX_ATTRIB_ARRAY_TYPE) as u32;
    let components = usize::try_from(get(api::GL_VERTEX_ATTRIB_ARRAY_SIZE)).ok()?;
    let normalised = get(api::GL_VERTEX_ATTRIB_ARRAY_NORMALIZED) != 0;
    let packed = components * width(kind)?;
    let bindings = profile.version >= if profile.es { 31 } else { 43 };
    let (buffer, start, stride, divisor) =
        if bindings { binding(gl, &get) } else { pointer(gl, profile, location, &get, packed) }?;
    (divisor == 0).then_some(Layout { buffer, start, stride, components, kind, normalised })
}

/// Buffer, start, stride and divisor where attributes have bindings: these count, whatever call set them.
fn binding(gl: &Gl, get: Ask) -> Option<(u32, usize, usize, i32)> {
    let index = get(api::GL_VERTEX_ATTRIB_BINDING) as u32;
    let of_binding = |name: u32| {
        let mut value = 0;
        // SAFETY: writes one integer; the binding is the attribute's.
        unsafe { gl.get_integeri_v(name, index, &mut value) };
        value
    };
    let start = usize::try_from(of_binding(api::GL_VERTEX_BINDING_OFFSET)).ok()?;
    let start = start + usize::try_from(get(api::GL_VERTEX_ATTRIB_RELATIVE_OFFSET)).ok()?;
    let buffer = of_binding(api::GL_VERTEX_BINDING_BUFFER) as u32;
    let stride = usize::try_from(of_binding(api::GL_VERTEX_BINDING_STRIDE)).ok()?;
    // An address has no room in these answers.
    (buffer != 0).then_some((buffer, start, stride, of_binding(api::GL_VERTEX_BINDING_DIVISOR)))
}

/// The same where an attribute has a pointer only.
fn pointer(gl: &Gl, profile: &Profile, location: u32, get: Ask, packed: usize) -> Option<(u32, usize, usize, i32)> {
    let mut start = std::ptr::null_mut::<c_void>();
    // SAFETY: writes one pointer.
    unsafe { gl.get_vertex_attrib_pointerv(location, api::GL_VERTEX_ATTRIB_ARRAY_POINTER, &mut start) };
    let stride = match usize::try_from(get(api::GL_VERTEX_ATTRIB_ARRAY_STRIDE)).ok()? {
        0 => packed,
        stride => stride,
    };
    let divisors = profile.version >= if profile.es { 30 } else { 33 };
    let divisor = if divisors { get(api::GL_VERTEX_ATTRIB_ARRAY_DIVISOR) } else { 0 };
    Some((get(api::GL_VERTEX_ATTRIB_ARRAY_BUFFER_BINDING) as u32, start as usize, stride, divisor))
}

/// Bytes of a coordinate; `None` for types that are not looked through.
pub fn width(kind: u32) -> Option<usize> {
    match kind {
        api::GL_BYTE | api::GL_UNSIGNED_BYTE => Some(1),
        api::GL_SHORT | api::GL_UNSIGNED_SHORT | api::GL_HALF_FLOAT => Some(2),
        api::GL_INT | api::GL_UNSIGNED_INT | api::GL_FLOAT => Some(4),
        api::GL_DOUBLE => Some(8),
        _ => None,
    }
}

/// The integer that stands for 1 where integers are normalised.
fn greatest(kind: u32) -> Option<f64> {
    match kind {
        api::GL_BYTE => Some(i8::MAX.into()),
        api::GL_UNSIGNED_BYTE => Some(u8::MAX.into()),
        api::GL_SHORT => Some(i16::MAX.into()),
        api::GL_UNSIGNED_SHORT => Some(u16::MAX.into()),
        api::GL_INT => Some(i32::MAX.into()),
        api::GL_UNSIGNED_INT => Some(u32::MAX.into()),
        _ => None,
    }
}

/// A coordinate.
///
/// # Safety
/// `at` must point at a number of the type `kind`.
pub unsafe fn number(at: *const u8, kind: u32) -> f64 {
    // SAFETY: as promised; unaligned numbers are allowed here.
    unsafe {
        match kind {
            api::GL_BYTE => at.cast::<i8>().read().into(),
            api::GL_UNSIGNED_BYTE => at.read().into(),
            api::GL_SHORT => at.cast::<i16>().read_unaligned().into(),
            api::GL_UNSIGNED_SHORT => at.cast::<u16>().read_unaligned().into(),
            api::GL_HALF_FLOAT => half(at.cast::<u16>().read_unaligned()),
            api::GL_INT => at.cast::<i32>().read_unaligned().into(),
            api::GL_UNSIGNED_INT => at.cast::<u32>().read_unaligned().into(),
            api::GL_FLOAT => at.cast::<f32>().read_unaligned().into(),
            api::GL_DOUBLE => at.cast::<f64>().read_unaligned(),
            _ => f64::NAN,
        }
    }
}

/// A number of 16 bits: sign, five bits of exponent, ten of mantissa (IEEE 754).
fn half(bits: u16) -> f64 {
    let sign = if bits & 0x8000 == 0 { 1.0 } else { -1.0 };
    let (exponent, mantissa) = (i32::from(bits >> 10 & 0x1f), f64::from(bits & 0x3ff) / 1024.0);
    sign * match exponent {
        0 => mantissa * 2f64.powi(-14),
        31 if mantissa == 0.0 => f64::INFINITY,
        31 => f64::NAN,
        _ => (1.0 + mantissa) * 2f64.powi(exponent - 15),
    }
}

#[cfg(test)]
mod tests {
    use super::{Layout, api, half};

    #[test]
    fn halves_are_what_ieee_says() {
        assert_eq!([half(0x3c00), half(0xc000), half(0x7bff), half(1)], [1.0, -2.0, 65504.0, 2f64.powi(-24)]);
        assert!(half(0x7c00).is_infinite() && half(0x7e00).is_nan() && half(0x8000) == 0.0);
    }

    #[test]
    fn positions_of_every_kind_are_read() {
        let layout = |kind: u32, components: usize, normalised: bool| Layout {
            buffer: 0,
            start: 0,
            stride: 0,
            components,
            kind,
            normalised,
        };
        let read = |layout: Layout, bytes: &[u8]| {
            assert!(layout.size() <= bytes.len());
            // SAFETY: as many bytes as the position has.
            unsafe { layout.position(bytes.as_ptr()) }
        };
        let floats: Vec<u8> = [1.5f32, -2.0, 3.0, 0.5].iter().flat_map(|v| v.to_ne_bytes()).collect();
        assert_eq!(read(layout(api::GL_FLOAT, 4, false), &floats), [1.5, -2.0, 3.0, 0.5]);
        assert_eq!(read(layout(api::GL_FLOAT, 2, false), &floats), [1.5, -2.0, 0.0, 1.0]);
        let shorts: Vec<u8> = [i16::MIN, 0, i16::MAX].iter().flat_map(|v| v.to_ne_bytes()).collect();
        assert_eq!(read(layout(api::GL_SHORT, 3, true), &shorts), [-1.0, 0.0, 1.0, 1.0]);
        assert_eq!(read(layout(api::GL_SHORT, 3, false), &shorts), [-32768.0, 0.0, 32767.0, 1.0]);
        assert_eq!(read(layout(api::GL_UNSIGNED_BYTE, 3, true), &[255, 0, 51]), [1.0, 0.0, 0.2, 1.0]);
        assert!(read(layout(api::GL_INT_2_10_10_10_REV, 1, false), &[0; 4])[0].is_nan(), "not looked through");
    }
}
