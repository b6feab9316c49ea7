//! The app state: what the program has set, as it would read it.
//!
//! [`attribute_stack`] keeps what `glPushAttrib` keeps of it.

pub mod attribute_stack;

use crate::backend::gl::api;
use crate::correct::LowerLeftRect;
use crate::intercept::gl::state::app::attribute_stack::{ATTRIBUTE_DEPTH, Pushed, Saved};

/// What the program has set, as it would read it.
pub struct AppState {
    /// The program's draw framebuffer, 0 = its window.
    pub draw_framebuffer: u32,
    /// The program's read framebuffer.
    pub read_framebuffer: u32,
    /// `glViewport`.
    pub viewport: LowerLeftRect,
    /// `glScissor`.
    pub scissor: LowerLeftRect,
    /// `GL_SCISSOR_TEST`.
    pub scissor_test: bool,
    /// `glDrawBuffer` of its window.
    pub draw_buffer: u32,
    /// `glReadBuffer` of its window.
    pub read_buffer: u32,
    /// `glMatrixMode`.
    pub matrix_mode: u32,
    /// `glPushAttrib`.
    attribute_stack: Vec<Pushed>,
    /// `glRenderMode` is not `GL_RENDER`.
    pub(in crate::intercept::gl) picking: bool,
    /// `GL_RASTERIZER_DISCARD`.
    pub(in crate::intercept::gl) discard: bool,
    /// Transform feedback is recording.
    pub(in crate::intercept::gl) feedback: bool,
    /// A vertex program in assembly language was switched on: the fixed-function matrices may say nothing.
    pub(in crate::intercept::gl) assembly: bool,
}

impl Default for AppState {
    fn default() -> Self {
        Self {
            draw_framebuffer: 0,
            read_framebuffer: 0,
            viewport: LowerLeftRect::default(),
            scissor: LowerLeftRect::default(),
            scissor_test: false,
            draw_buffer: api::GL_BACK,
            read_buffer: api::GL_BACK,
            matrix_mode: api::GL_MODELVIEW,
            attribute_stack: Vec::new(),
            picking: false,
            discard: false,
            feedback: false,
            assembly: false,
        }
    }
}

impl AppState {
    /// Whether the driver's attribute stack has a place, with `own` attributes of ours beside the
    /// program's.
    pub fn can_push(&self, own: usize) -> bool {
        self.attribute_stack.len() + own < ATTRIBUTE_DEPTH
    }

    /// `glPushAttrib`, while there is a place.
    pub fn push(&mut self, pushed: Pushed) {
        self.attribute_stack.push(pushed);
    }

    /// `glPopAttrib`.
    pub fn pop(&mut self) -> Option<Pushed> {
        self.attribute_stack.pop()
    }

    /// State that `glPushAttrib` keeps.
    pub fn saved(&self) -> Saved {
        Saved {
            viewport: self.viewport,
            scissor: self.scissor,
            scissor_test: self.scissor_test,
            draw_buffer: self.draw_buffer,
            read_buffer: self.read_buffer,
            matrix_mode: self.matrix_mode,
        }
    }

    /// `glPopAttrib`: the groups of `mask` are what they were.
    pub fn restore(&mut self, mask: u32, saved: &Saved) {
        if mask & api::GL_VIEWPORT_BIT != 0 {
            self.viewport = saved.viewport;
        }
        if mask & api::GL_SCISSOR_BIT != 0 {
            self.scissor = saved.scissor;
        }
        if mask & (api::GL_SCISSOR_BIT | api::GL_ENABLE_BIT) != 0 {
            self.scissor_test = saved.scissor_test;
        }
        if mask & api::GL_TRANSFORM_BIT != 0 {
            self.matrix_mode = saved.matrix_mode;
        }
        if mask & api::GL_COLOR_BUFFER_BIT != 0 {
            self.draw_buffer = saved.draw_buffer;
        }
        if mask & api::GL_PIXEL_MODE_BIT != 0 {
            self.read_buffer = saved.read_buffer;
        }
    }
}
