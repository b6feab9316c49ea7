//! Internal pictures with one sample per pixel, for work that cannot be done in a view of another
//! size.

use crate::backend::gl::driver::api::{self, Gl};
use crate::backend::gl::driver::own_names;
use crate::backend::gl::objects::framebuffers::FramebufferBindings;
use crate::correct::Size;
use crate::intercept::gl::state::offscreen::images::{self, Name};

/// A framebuffer with colours only.
pub struct SingleSampleImage {
    framebuffer: u32,
    renderbuffer: u32,
    size: Size,
    format: u32,
}

impl SingleSampleImage {
    /// Returns a picture of this size and sized format. Bindings are put back;
    /// errors may be left. `None` if the driver gives none.
    pub fn new(gl: &Gl, size: Size, format: u32) -> Option<Self> {
        let mut canvas = Self { framebuffer: 0, renderbuffer: 0, size, format };
        // SAFETY: makes objects of Cupola; the bindings are put back.
        let complete = unsafe {
            let bindings = FramebufferBindings::save(gl);
            let mut bound = 0;
            gl.get_integerv(api::GL_RENDERBUFFER_BINDING, &mut bound);
            canvas.renderbuffer = own_names::renderbuffer(gl);
            gl.bind_renderbuffer(api::GL_RENDERBUFFER, canvas.renderbuffer);
            gl.renderbuffer_storage(api::GL_RENDERBUFFER, format, size.width, size.height);
            gl.bind_renderbuffer(api::GL_RENDERBUFFER, bound as u32);
            canvas.framebuffer = own_names::framebuffer(gl);
            gl.bind_framebuffer(api::GL_DRAW_FRAMEBUFFER, canvas.framebuffer);
            images::attach(gl, api::GL_COLOR_ATTACHMENT0, Name::Renderbuffer(canvas.renderbuffer));
            let status = gl.check_framebuffer_status(api::GL_DRAW_FRAMEBUFFER);
            bindings.restore(gl);
            status == api::GL_FRAMEBUFFER_COMPLETE
        };
        if complete {
            return Some(canvas);
        }
        canvas.destroy(gl);
        None
    }

    /// Returns the OpenGL name of the framebuffer.
    pub fn framebuffer(&self) -> u32 {
        self.framebuffer
    }

    /// True if the picture has this size and format.
    pub fn is(&self, size: Size, format: u32) -> bool {
        self.size == size && self.format == format
    }

    /// Deletes the framebuffer and the renderbuffer.
    pub fn destroy(&self, gl: &Gl) {
        // SAFETY: objects of Cupola; the name 0 is ignored.
        unsafe {
            gl.delete_framebuffers(1, &self.framebuffer);
            gl.delete_renderbuffers(1, &self.renderbuffer);
        }
    }
}
