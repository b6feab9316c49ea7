//! Copies of depth from one format to another.

use crate::backend::gl::driver::api::{self, Gl};
use crate::backend::gl::driver::own_names;
use crate::backend::gl::objects::framebuffers::{FramebufferBindings, blit};
use crate::correct::{BlitRect, Size};
use crate::intercept::gl::state::offscreen::images::{self, Name, with_texture};

/// A depth texture of Cupola, and a framebuffer with this texture alone. `glBlitFramebuffer` copies
/// depth between equal formats only; `glCopyTexSubImage2D` converts.
pub struct DepthConverter {
    framebuffer: u32,
    texture: u32,
    size: Size,
    format: u32,
}

impl DepthConverter {
    /// Returns a converter for rectangles of this size of the read framebuffer,
    /// into this sized format. Bindings are put back; errors may be left. `None` if the driver
    /// gives none.
    pub fn new(gl: &Gl, size: Size, format: u32) -> Option<Self> {
        let mut converter = Self { framebuffer: 0, texture: own_names::texture(gl), size, format };
        let level = Name::Texture { name: converter.texture, target: api::GL_TEXTURE_2D, level: 0 };
        with_texture(gl, api::GL_TEXTURE_2D, api::GL_TEXTURE_BINDING_2D, converter.texture, || {
            // SAFETY: gives Cupola's texture storage. A copy reads no memory of the program,
            // whatever is bound there.
            unsafe { gl.copy_tex_image2_d(api::GL_TEXTURE_2D, 0, format, 0, 0, size.width, size.height, 0) };
        });
        // SAFETY: makes an object of Cupola; the bindings are put back.
        let complete = unsafe {
            let bindings = FramebufferBindings::save(gl);
            converter.framebuffer = own_names::framebuffer(gl);
            gl.bind_framebuffer(api::GL_FRAMEBUFFER, converter.framebuffer);
            images::attach(gl, api::GL_DEPTH_ATTACHMENT, level);
            gl.draw_buffers(1, &api::GL_NONE);
            gl.read_buffer(api::GL_NONE);
            let status = gl.check_framebuffer_status(api::GL_FRAMEBUFFER);
            bindings.restore(gl);
            status == api::GL_FRAMEBUFFER_COMPLETE
        };
        if complete {
            return Some(converter);
        }
        converter.destroy(gl);
        None
    }

    /// True if the converter is for this size and format.
    pub fn is(&self, size: Size, format: u32) -> bool {
        self.size == size && self.format == format
    }

    /// Returns the sized format.
    pub fn format(&self) -> u32 {
        self.format
    }

    /// Copies the rectangle `from` of the read framebuffer, which has the converter's size, to the
    /// rectangle `to` of the draw framebuffer. Bindings are put back.
    pub fn convert(&self, gl: &Gl, from: BlitRect, to: BlitRect) {
        let ([x, y], Size { width, height }) = (from.unmirrored().origin(), self.size);
        with_texture(gl, api::GL_TEXTURE_2D, api::GL_TEXTURE_BINDING_2D, self.texture, || {
            // SAFETY: Cupola's texture is bound.
            unsafe { gl.copy_tex_sub_image2_d(api::GL_TEXTURE_2D, 0, 0, 0, x, y, width, height) };
        });
        // SAFETY: a framebuffer of Cupola; the binding is put back.
        unsafe {
            let bindings = FramebufferBindings::save(gl);
            gl.bind_framebuffer(api::GL_READ_FRAMEBUFFER, self.framebuffer);
            let (mask, filter) = (api::GL_DEPTH_BUFFER_BIT, api::GL_NEAREST);
            blit(gl, from.moved(-x, -y), to, mask, filter);
            bindings.restore(gl);
        }
    }

    /// Deletes the texture and the framebuffer.
    pub fn destroy(&self, gl: &Gl) {
        // SAFETY: objects of Cupola; the name 0 is ignored.
        unsafe {
            gl.delete_framebuffers(1, &self.framebuffer);
            gl.delete_textures(1, &self.texture);
        }
    }
}
