//! Layout in memory of the array of positions.

use crate::backend::gl::driver::api;
use crate::intercept::gl::state::driver::Driver;
use crate::intercept::gl::state::shader::programs::Array;
use crate::intercept::gl::state::vertex_input::VertexInput;
use crate::intercept::gl::state::vertex_input::vertex_arrays::{Pointer, Source, width};
use crate::intercept::gl::state::vertex_input::vertex_ranges::Layout;
use crate::intercept::gl::vertex_input::vertex_arrays;

impl Layout {
    /// Returns the layout that the program has set for `array`, with at most `components`
    /// components. `None`: the format or source of the array is not supported.
    pub fn of(driver: &Driver, vertex_input: &mut VertexInput, array: Array, components: usize) -> Option<Self> {
        let layout = match array {
            Array::Conventional => conventional(driver, vertex_input)?,
            Array::Generic(location) => generic(driver, vertex_input, location)?,
        };
        let profile = &driver.profile;
        let given = layout.components;
        let signed = matches!(layout.kind, api::GL_BYTE | api::GL_SHORT | api::GL_INT);
        // Older versions convert signed integers by another rule.
        let one_rule = profile.version >= if profile.es { 30 } else { 42 };
        let usable = (2..=4).contains(&given)
            && (layout.buffer != 0 || layout.start != 0)
            && !(layout.normalised && signed && !one_rule)
            && layout.stride > 0;
        usable.then_some(Self { components: given.min(components), ..layout })
    }

    /// Returns the layout of a generic attribute's value for an instance. `None`: the attribute is
    /// not an array with values per instance.
    pub fn of_instances(
        driver: &Driver,
        vertex_input: &mut VertexInput,
        location: u32,
        instance: usize,
    ) -> Option<Self> {
        if !vertex_arrays::is_on(driver, vertex_input, location) {
            return None;
        }
        let (format, source, divisor) = vertex_arrays::generic(driver, vertex_input, location)?;
        width(format.kind).filter(|_| divisor > 0 && !format.integer && (1..=4).contains(&format.components))?;
        let layout = Self::at(source, format.components, format.kind, format.normalised);
        let start = if source.buffer == 0 {
            let mut start = std::ptr::null_mut();
            // SAFETY: writes one pointer.
            unsafe {
                driver.gl.get_vertex_attrib_pointerv(location, api::GL_VERTEX_ATTRIB_ARRAY_POINTER, &mut start);
            }
            Some(start as usize).filter(|start| *start != 0)?
        } else {
            source.start
        };
        Some(Self { start: start.checked_add(instance.checked_mul(source.stride)?)?, ..layout })
    }

    fn at(Source { buffer, start, stride }: Source, components: usize, kind: u32, normalised: bool) -> Self {
        Self { buffer, start, stride, components, kind, normalised }
    }

    /// Returns the number of bytes of one position.
    pub fn size(&self) -> usize {
        self.components * width(self.kind).unwrap_or_default()
    }

    /// Returns the position at `at`.
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

/// Returns the layout of `glVertexPointer`. `None` also if generic attribute 0 is an array, since
/// that is the position then.
fn conventional(driver: &Driver, vertex_input: &mut VertexInput) -> Option<Layout> {
    let Pointer { components, kind, source } = vertex_arrays::conventional(driver, vertex_input)?;
    width(kind)?;
    (!vertex_arrays::is_on(driver, vertex_input, 0)).then_some(Layout::at(source, components, kind, false))
}

/// Returns the layout of a generic attribute.
fn generic(driver: &Driver, vertex_input: &mut VertexInput, location: u32) -> Option<Layout> {
    if !vertex_arrays::is_on(driver, vertex_input, location) {
        return None;
    }
    let (format, source, divisor) = vertex_arrays::generic(driver, vertex_input, location)?;
    width(format.kind)?;
    // If attributes have bindings, OpenGL returns the offset as an integer that is too small for an
    // address.
    let has_source = source.buffer != 0 || !vertex_arrays::has_bindings(&driver.profile);
    let usable = has_source && divisor == 0 && !format.integer;
    usable.then_some(Layout::at(source, format.components, format.kind, format.normalised))
}

/// Returns the integer that means 1 if integers are normalised.
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

/// Returns a number of the type `kind`.
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

/// Returns a number of 16 bits: sign, five bits of exponent, ten of mantissa (IEEE 754).
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
        assert!(read(layout(api::GL_INT_2_10_10_10_REV, 1, false), &[0; 4])[0].is_nan(), "packed formats are not read");
    }
}
