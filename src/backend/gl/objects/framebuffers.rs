//! Framebuffers as targets: bindings, state, copies.

use crate::backend::gl::driver::api::{self, Gl};
use crate::correct::BlitRect;

/// The bound framebuffers, so that they can be put back.
#[derive(Clone, Copy, Debug)]
pub struct FramebufferBindings {
    draw: i32,
    read: i32,
}

impl FramebufferBindings {
    /// Returns the present bindings.
    ///
    /// # Safety
    /// A context must be current.
    pub unsafe fn save(gl: &Gl) -> Self {
        let mut bindings = Self { draw: 0, read: 0 };
        // SAFETY: each writes one integer.
        unsafe {
            gl.get_integerv(api::GL_DRAW_FRAMEBUFFER_BINDING, &mut bindings.draw);
            gl.get_integerv(api::GL_READ_FRAMEBUFFER_BINDING, &mut bindings.read);
        }
        bindings
    }

    /// Returns the framebuffer that was bound for drawing.
    pub fn draw(&self) -> u32 {
        self.draw as u32
    }

    /// Puts the bindings back.
    ///
    /// # Safety
    /// The context of `save` must be current.
    pub unsafe fn restore(&self, gl: &Gl) {
        // SAFETY: binds what was bound.
        unsafe {
            gl.bind_framebuffer(api::GL_READ_FRAMEBUFFER, self.read as u32);
            gl.bind_framebuffer(api::GL_DRAW_FRAMEBUFFER, self.draw as u32);
        }
    }
}

/// Copies between the bound framebuffers, as `glBlitFramebuffer`.
///
/// # Safety
/// A context must be current.
pub unsafe fn blit(gl: &Gl, from: BlitRect, to: BlitRect, mask: u32, filter: u32) {
    let BlitRect { start: [x0, y0], end: [x1, y1] } = from;
    let BlitRect { start: [u0, v0], end: [u1, v1] } = to;
    // SAFETY: plain command; the driver checks the rectangles.
    unsafe { gl.blit_framebuffer(x0, y0, x1, y1, u0, v0, u1, v1, mask, filter) };
}

/// State of a framebuffer as a target of drawing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FramebufferState {
    /// The framebuffer can be drawn to.
    Complete,
    /// The context has no framebuffer of this name.
    Missing,
    /// The framebuffer is not complete; the value is OpenGL's status.
    Incomplete(u32),
}

/// Returns the state of a framebuffer of the current context; 0 = the window. Bindings are
/// restored.
pub fn framebuffer_state(gl: &Gl, framebuffer: u32) -> FramebufferState {
    // SAFETY: queries the context, which is current.
    if framebuffer != 0 && unsafe { gl.is_framebuffer(framebuffer) } == 0 {
        return FramebufferState::Missing;
    }
    let mut bound = 0;
    // SAFETY: writes one integer; the binding is restored.
    let status = unsafe {
        gl.get_integerv(api::GL_DRAW_FRAMEBUFFER_BINDING, &mut bound);
        gl.bind_framebuffer(api::GL_DRAW_FRAMEBUFFER, framebuffer);
        let status = gl.check_framebuffer_status(api::GL_DRAW_FRAMEBUFFER);
        gl.bind_framebuffer(api::GL_DRAW_FRAMEBUFFER, bound as u32);
        status
    };
    if status == api::GL_FRAMEBUFFER_COMPLETE {
        FramebufferState::Complete
    } else {
        FramebufferState::Incomplete(status)
    }
}
