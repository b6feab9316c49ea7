//! Textures of pictures, and places to draw.

use crate::backend::gl::driver::api::*;
pub use crate::backend::tests::picture::Picture;
use crate::correct::LowerLeftRect;

impl Picture {
    pub fn texture(&self, gl: &Gl, format: u32) -> u32 {
        let mut texture = 0;
        let data = self.pixels.as_ptr().cast();
        // SAFETY: a context is current; the array holds the whole picture.
        unsafe {
            gl.gen_textures(1, &mut texture);
            gl.bind_texture(GL_TEXTURE_2D, texture);
            let (width, height) = (self.size.0 as i32, self.size.1 as i32);
            gl.tex_image2_d(GL_TEXTURE_2D, 0, format as i32, width, height, 0, GL_RGBA, GL_UNSIGNED_BYTE, data);
            gl.tex_parameteri(GL_TEXTURE_2D, GL_TEXTURE_MAX_LEVEL, 0);
            gl.bind_texture(GL_TEXTURE_2D, 0);
        }
        texture
    }
}

/// A framebuffer with one RGBA8 texture, filled with a colour that no test expects to stay.
pub struct Canvas {
    pub framebuffer: u32,
    pub size: (u32, u32),
}

impl Canvas {
    pub fn new(gl: &Gl, size: (u32, u32)) -> Self {
        let picture = Picture::new(size, |_, _| [255, 0, 255, 77]);
        let texture = picture.texture(gl, GL_RGBA8);
        let mut framebuffer = 0;
        // SAFETY: a context is current.
        unsafe {
            gl.gen_framebuffers(1, &mut framebuffer);
            gl.bind_framebuffer(GL_FRAMEBUFFER, framebuffer);
            gl.framebuffer_texture2_d(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, texture, 0);
            assert_eq!(gl.check_framebuffer_status(GL_FRAMEBUFFER), GL_FRAMEBUFFER_COMPLETE);
            gl.bind_framebuffer(GL_FRAMEBUFFER, 0);
        }
        Self { framebuffer, size }
    }

    pub fn viewport(&self) -> LowerLeftRect {
        LowerLeftRect::of_size(self.size)
    }

    /// Reads its pixels.
    pub fn read(&self, gl: &Gl) -> Picture {
        let mut picture = Picture::new(self.size, |_, _| [0; 4]);
        let data = picture.pixels.as_mut_ptr().cast();
        // SAFETY: a context is current; the array holds the whole picture.
        unsafe {
            gl.bind_framebuffer(GL_READ_FRAMEBUFFER, self.framebuffer);
            gl.read_pixels(0, 0, self.size.0 as i32, self.size.1 as i32, GL_RGBA, GL_UNSIGNED_BYTE, data);
            gl.bind_framebuffer(GL_READ_FRAMEBUFFER, 0);
            assert_eq!(gl.get_error(), GL_NO_ERROR);
        }
        picture
    }
}
