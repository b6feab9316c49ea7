//! Internal reads of pixels.

use crate::backend::gl::driver::api::{self, Gl};
use crate::correct::LowerLeftRect;
use crate::runtime::run_results::Picture;

/// Reads a rectangle of a framebuffer. Bindings and pixel storage are put back.
pub fn read_back(gl: &Gl, framebuffer: u32, name: &str, rect: LowerLeftRect) -> Picture {
    let [x, y, width, height] = rect.to_array().map(|v| v.max(0));
    let mut rgba = vec![0; width as usize * height as usize * 4];
    while_reading(gl, framebuffer, || {
        // SAFETY: reads exactly the bytes that `rgba` has room for.
        unsafe { gl.read_pixels(x, y, width, height, api::GL_RGBA, api::GL_UNSIGNED_BYTE, rgba.as_mut_ptr().cast()) };
    });
    Picture { name: name.to_owned(), width: width as u32, height: height as u32, rgba }
}

/// Runs `work`, which reads a framebuffer into memory without gaps between rows. Bindings and pixel
/// storage are put back.
pub fn while_reading(gl: &Gl, framebuffer: u32, work: impl FnOnce()) {
    const STORE: [u32; 4] =
        [api::GL_PACK_ALIGNMENT, api::GL_PACK_ROW_LENGTH, api::GL_PACK_SKIP_ROWS, api::GL_PACK_SKIP_PIXELS];
    // SAFETY: plain state and bindings; all is put back.
    unsafe {
        let (mut bound, mut buffer) = (0, 0);
        let mut store = [0; 4];
        gl.get_integerv(api::GL_READ_FRAMEBUFFER_BINDING, &mut bound);
        gl.get_integerv(api::GL_PIXEL_PACK_BUFFER_BINDING, &mut buffer);
        for (value, name) in store.iter_mut().zip(STORE) {
            gl.get_integerv(name, value);
            gl.pixel_storei(name, i32::from(name == api::GL_PACK_ALIGNMENT));
        }
        gl.bind_framebuffer(api::GL_READ_FRAMEBUFFER, framebuffer);
        gl.bind_buffer(api::GL_PIXEL_PACK_BUFFER, 0);
        work();
        gl.bind_buffer(api::GL_PIXEL_PACK_BUFFER, buffer as u32);
        gl.bind_framebuffer(api::GL_READ_FRAMEBUFFER, bound as u32);
        for (value, name) in store.iter().zip(STORE) {
            gl.pixel_storei(name, *value);
        }
    }
}
