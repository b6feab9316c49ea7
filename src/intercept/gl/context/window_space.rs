//! Viewport and scissor of the driver.

use crate::backend::gl::api;
use crate::intercept::gl::context::gl_context::Context;
use crate::intercept::gl::state::window_space::Actual;

impl Context {
    /// Sets the real viewport.
    pub fn set_viewport(&mut self, rect: [i32; 4]) {
        if self.compiling() {
            // It would become a part of the program's list.
            self.actual.viewport = None;
            return;
        }
        if self.actual.viewport != Some(rect) {
            // SAFETY: a plain state command.
            unsafe { self.gl.viewport(rect[0], rect[1], rect[2], rect[3]) };
            self.actual.viewport = Some(rect);
        }
    }

    /// Sets the real scissor test and, if on, its rectangle.
    pub fn set_scissor(&mut self, rect: Option<[i32; 4]>) {
        if self.compiling() {
            self.actual = Actual { viewport: self.actual.viewport, ..Actual::default() };
            return;
        }
        if self.actual.scissor_test != Some(rect.is_some()) {
            // SAFETY: a plain state command.
            unsafe {
                if rect.is_some() {
                    self.gl.enable(api::GL_SCISSOR_TEST);
                } else {
                    self.gl.disable(api::GL_SCISSOR_TEST);
                }
            }
            self.actual.scissor_test = Some(rect.is_some());
        }
        if let Some(rect) = rect
            && self.actual.scissor != Some(rect)
        {
            // SAFETY: a plain state command.
            unsafe { self.gl.scissor(rect[0], rect[1], rect[2].max(0), rect[3].max(0)) };
            self.actual.scissor = Some(rect);
        }
    }

    /// Puts the program's own viewport and scissor into the driver, for its own framebuffers.
    pub fn restore_window_space(&mut self) {
        self.set_viewport(self.believed.viewport);
        let (test, rect) = (self.believed.scissor_test, self.believed.scissor);
        if !self.compiling() && self.actual.scissor != Some(rect) {
            // SAFETY: a plain state command.
            unsafe { self.gl.scissor(rect[0], rect[1], rect[2].max(0), rect[3].max(0)) };
            self.actual.scissor = Some(rect);
        }
        self.set_scissor(test.then_some(rect));
    }
}
