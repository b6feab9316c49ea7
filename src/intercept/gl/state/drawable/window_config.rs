//! Configuration of the window's own framebuffer, so that the stand-in can have the same.

use crate::backend::gl::driver::api::{self, Gl};
use crate::intercept::gl::state::drawable::window::Window;
use crate::intercept::gl::state::driver::profile::Profile;

/// The window's own framebuffer, as the program's configuration made it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Config {
    /// True if the framebuffer has a back buffer.
    pub double_buffered: bool,
    /// Samples per pixel; 0 = not multisampled.
    pub samples: i32,
    /// True if the framebuffer converts to sRGB when the program asks for it.
    pub srgb: bool,
    /// Bits of red. The other colours have the same number, or one more or less.
    pub red_bits: i32,
    /// Bits of alpha.
    pub alpha_bits: i32,
    /// Bits of depth.
    pub depth_bits: i32,
    /// Bits of stencil.
    pub stencil_bits: i32,
    /// Bits of each colour in the accumulation buffer; 0 = there is none.
    pub accumulation_bits: i32,
}

impl Config {
    /// Asks the driver about the window's framebuffer. The program's binding is put back.
    pub fn of_window(gl: &Gl, profile: &Profile, window: &Window) -> Self {
        // SAFETY: queries about the window's framebuffer; the binding is put back.
        unsafe {
            let mut bound = 0;
            gl.get_integerv(api::GL_DRAW_FRAMEBUFFER_BINDING, &mut bound);
            gl.bind_framebuffer(api::GL_DRAW_FRAMEBUFFER, 0);
            let double_buffered = window.double_buffered(gl, profile);
            let back = match (profile.es, double_buffered) {
                (true, _) => api::GL_BACK,
                (false, true) => api::GL_BACK_LEFT,
                (false, false) => api::GL_FRONT_LEFT,
            };
            let ask = |attachment: u32, what: u32| {
                let mut answer = 0;
                gl.get_framebuffer_attachment_parameteriv(api::GL_DRAW_FRAMEBUFFER, attachment, what, &mut answer);
                answer
            };
            let mut samples = 0;
            gl.get_integerv(api::GL_SAMPLES, &mut samples);
            let mut accumulation_bits = 0;
            if profile.compatibility() {
                gl.get_integerv(api::GL_ACCUM_RED_BITS, &mut accumulation_bits);
            }
            let config = Self {
                accumulation_bits,
                double_buffered,
                samples,
                srgb: ask(back, api::GL_FRAMEBUFFER_ATTACHMENT_COLOR_ENCODING) as u32 == api::GL_SRGB,
                red_bits: ask(back, api::GL_FRAMEBUFFER_ATTACHMENT_RED_SIZE),
                alpha_bits: ask(back, api::GL_FRAMEBUFFER_ATTACHMENT_ALPHA_SIZE),
                depth_bits: ask(api::GL_DEPTH, api::GL_FRAMEBUFFER_ATTACHMENT_DEPTH_SIZE),
                stencil_bits: ask(api::GL_STENCIL, api::GL_FRAMEBUFFER_ATTACHMENT_STENCIL_SIZE),
            };
            // If a window has no depth or stencil, the questions about them cause errors.
            while gl.get_error() != api::GL_NO_ERROR {}
            gl.bind_framebuffer(api::GL_DRAW_FRAMEBUFFER, bound as u32);
            config
        }
    }
}
