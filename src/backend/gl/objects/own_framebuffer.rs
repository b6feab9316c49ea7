//! A framebuffer of Cupola with one texture.

use crate::backend::gl::driver::api::{self, Gl};
use crate::backend::gl::driver::own_names;

/// A framebuffer with one texture of 8 bits.
pub struct OwnFramebuffer {
    /// Its OpenGL name.
    pub framebuffer: u32,
    texture: u32,
}

impl OwnFramebuffer {
    /// Makes a framebuffer of this size in pixels, with 8 bits for each colour.
    pub fn new(gl: &Gl, width: i32, height: i32) -> Self {
        Self::with_format(gl, (width, height), api::GL_RGBA8)
    }

    /// Makes a framebuffer of this size in pixels and this format.
    pub fn with_format(gl: &Gl, (width, height): (i32, i32), format: u32) -> Self {
        let canvas = Self { framebuffer: own_names::framebuffer(gl), texture: own_names::texture(gl) };
        // SAFETY: makes objects of Cupola; the bindings that change are restored.
        unsafe {
            let (mut bound, mut texture) = (0, 0);
            gl.get_integerv(api::GL_DRAW_FRAMEBUFFER_BINDING, &mut bound);
            gl.get_integerv(api::GL_TEXTURE_BINDING_2D, &mut texture);
            gl.bind_texture(api::GL_TEXTURE_2D, canvas.texture);
            gl.tex_storage2_d(api::GL_TEXTURE_2D, 1, format, width, height);
            gl.bind_framebuffer(api::GL_DRAW_FRAMEBUFFER, canvas.framebuffer);
            gl.framebuffer_texture2_d(
                api::GL_DRAW_FRAMEBUFFER,
                api::GL_COLOR_ATTACHMENT0,
                api::GL_TEXTURE_2D,
                canvas.texture,
                0,
            );
            gl.bind_framebuffer(api::GL_DRAW_FRAMEBUFFER, bound as u32);
            gl.bind_texture(api::GL_TEXTURE_2D, texture as u32);
        }
        canvas
    }

    /// Deletes the objects in their context, which must be current.
    pub fn destroy(self, gl: &Gl) {
        // SAFETY: objects of Cupola.
        unsafe {
            gl.delete_framebuffers(1, &self.framebuffer);
            gl.delete_textures(1, &self.texture);
        }
    }
}
