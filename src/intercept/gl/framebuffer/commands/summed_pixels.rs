//! Pictures that a program loads into textures, in the checksum of a frame's calls.

use crate::backend::gl::driver::api::{self, Gl};
use crate::correct::Size;
use crate::intercept::gl::state::driver::Driver;
use crate::intercept::process::call_sum;
use std::ffi::c_void;

/// Adds the pixels of a picture of this size, format and type that the program hands over. Nothing
/// is added for formats that are rare, and for pixels in a buffer, which were summed when it was
/// filled.
///
/// # Safety
/// `pixels` must be null or point at the picture in the layout that the program has set, as it
/// promises OpenGL.
pub unsafe fn add(driver: &Driver, size: Size, (format, kind): (u32, u32), pixels: *const c_void) {
    if !call_sum::is_on() || pixels.is_null() {
        return;
    }
    let (Ok(width), Ok(height)) = (usize::try_from(size.width), usize::try_from(size.height)) else { return };
    let Some((pixel, unit)) = pixel(format, kind) else { return };
    let rows = Rows::of(driver.gl, has_buffers(driver), width, pixel, unit);
    let Some(rows) = rows else { return };
    for row in 0..height {
        // SAFETY: the row lies in the picture, as promised.
        unsafe { call_sum::add_values(pixels.cast::<u8>().add(rows.first + row * rows.pitch), width * pixel) };
    }
}

/// Adds the layers of a picture, as [`add`] does. Nothing is added if layers lie apart.
///
/// # Safety
/// As for [`add`], with all layers.
pub unsafe fn add_layers(driver: &Driver, (size, layers): (Size, i32), format: (u32, u32), pixels: *const c_void) {
    if !call_sum::is_on() {
        return;
    }
    let apart = [api::GL_UNPACK_IMAGE_HEIGHT, api::GL_UNPACK_SKIP_IMAGES];
    if !has_buffers(driver) || apart.iter().all(|name| integer(driver, *name) == 0) {
        // SAFETY: as promised.
        unsafe { add(driver, Size::new(size.width, size.height.saturating_mul(layers)), format, pixels) };
    }
}

/// True if the program's pixels come from a buffer.
pub fn in_buffer(driver: &Driver) -> bool {
    has_buffers(driver) && integer(driver, api::GL_PIXEL_UNPACK_BUFFER_BINDING) != 0
}

/// True if the context has buffers of pixels, and layouts of pictures with gaps.
fn has_buffers(driver: &Driver) -> bool {
    driver.profile.version >= 30 || !driver.profile.es
}

fn integer(driver: &Driver, name: u32) -> i32 {
    let mut value = 0;
    // SAFETY: writes one integer.
    unsafe { driver.gl.get_integerv(name, &mut value) };
    value
}

/// Layout of a picture in memory, bytes.
struct Rows {
    first: usize,
    pitch: usize,
}

impl Rows {
    /// The layout that the program has set; `None` if the pixels are in a buffer.
    fn of(gl: &Gl, has_buffers: bool, width: usize, pixel: usize, unit: usize) -> Option<Self> {
        let value = |name: u32| {
            let mut value = 0;
            // SAFETY: writes one integer.
            unsafe { gl.get_integerv(name, &mut value) };
            usize::try_from(value).unwrap_or(0)
        };
        let [length, skipped_rows, skipped, buffer] = match has_buffers {
            true => [
                api::GL_UNPACK_ROW_LENGTH,
                api::GL_UNPACK_SKIP_ROWS,
                api::GL_UNPACK_SKIP_PIXELS,
                api::GL_PIXEL_UNPACK_BUFFER_BINDING,
            ]
            .map(value),
            false => [0; 4],
        };
        let pitch = pitch(if length > 0 { length } else { width }, pixel, unit, value(api::GL_UNPACK_ALIGNMENT));
        (buffer == 0).then(|| Self { first: skipped_rows * pitch + skipped * pixel, pitch })
    }
}

/// Distance of rows of `length` pixels. Rows begin at multiples of `alignment`, unless a unit of a
/// pixel is as long.
fn pitch(length: usize, pixel: usize, unit: usize, alignment: usize) -> usize {
    if unit >= alignment { length * pixel } else { (length * pixel).next_multiple_of(alignment.max(1)) }
}

/// Number of bytes of a pixel, and of the unit that its type describes.
fn pixel(format: u32, kind: u32) -> Option<(usize, usize)> {
    let components = match format {
        api::GL_RED | api::GL_ALPHA | api::GL_LUMINANCE | api::GL_DEPTH_COMPONENT | api::GL_RED_INTEGER => 1,
        api::GL_RG | api::GL_LUMINANCE_ALPHA => 2,
        api::GL_RGB | api::GL_BGR => 3,
        api::GL_RGBA | api::GL_BGRA => 4,
        _ => return None,
    };
    let unit = match kind {
        api::GL_UNSIGNED_BYTE | api::GL_BYTE => 1,
        api::GL_UNSIGNED_SHORT | api::GL_SHORT | api::GL_HALF_FLOAT => 2,
        api::GL_UNSIGNED_INT | api::GL_INT | api::GL_FLOAT => 4,
        // One unit has all components.
        api::GL_UNSIGNED_INT_8_8_8_8 | api::GL_UNSIGNED_INT_8_8_8_8_REV => return Some((4, 4)),
        api::GL_UNSIGNED_SHORT_5_6_5 => return Some((2, 2)),
        _ => return None,
    };
    Some((components * unit, unit))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The example of the specification: rows of three bytes a pixel begin at multiples of four.
    #[test]
    fn rows_begin_at_multiples_of_the_alignment() {
        assert_eq!(pixel(api::GL_RGB, api::GL_UNSIGNED_BYTE), Some((3, 1)));
        assert_eq!([1, 2, 4, 8].map(|alignment| pitch(5, 3, 1, alignment)), [15, 16, 16, 16]);
        assert_eq!(pixel(api::GL_RGBA, api::GL_FLOAT), Some((16, 4)));
        assert_eq!([1, 4, 8].map(|alignment| pitch(3, 4, 4, alignment)), [12, 12, 16]);
        assert_eq!(pixel(api::GL_BGRA, api::GL_UNSIGNED_INT_8_8_8_8_REV), Some((4, 4)));
        assert_eq!(pixel(api::GL_RGBA, api::GL_BITMAP), None);
    }
}
