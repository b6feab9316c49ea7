//! Viewport and scissor of the driver.

use crate::backend::gl::api;
use crate::correct::LowerLeftRect;
use crate::intercept::gl::context::gl_context::Context;
use crate::intercept::gl::state::driver::window_space::DriverState;

impl Context {
    /// Sets the real viewport.
    pub fn set_viewport(&mut self, rect: LowerLeftRect) {
        if self.compiling() {
            // It would become a part of the program's list.
            self.driver.window_space.viewport = None;
            return;
        }
        if self.driver.window_space.viewport != Some(rect) {
            // SAFETY: a plain state command.
            unsafe { self.driver.gl.viewport(rect.x, rect.y, rect.width, rect.height) };
            self.driver.window_space.viewport = Some(rect);
        }
    }

    /// Sets the real scissor test and, if on, its rectangle.
    pub fn set_scissor(&mut self, rect: Option<LowerLeftRect>) {
        if self.compiling() {
            self.driver.window_space =
                DriverState { viewport: self.driver.window_space.viewport, ..DriverState::default() };
            return;
        }
        if self.driver.window_space.scissor_test != Some(rect.is_some()) {
            // SAFETY: a plain state command.
            unsafe {
                if rect.is_some() {
                    self.driver.gl.enable(api::GL_SCISSOR_TEST);
                } else {
                    self.driver.gl.disable(api::GL_SCISSOR_TEST);
                }
            }
            self.driver.window_space.scissor_test = Some(rect.is_some());
        }
        if let Some(rect) = rect
            && self.driver.window_space.scissor != Some(rect)
        {
            // SAFETY: a plain state command.
            unsafe { self.driver.gl.scissor(rect.x, rect.y, rect.width.max(0), rect.height.max(0)) };
            self.driver.window_space.scissor = Some(rect);
        }
    }

    /// Puts the program's own viewport and scissor into the driver, for its own framebuffers.
    pub fn restore_window_space(&mut self) {
        self.set_viewport(self.app.viewport);
        let (test, rect) = (self.app.scissor_test, self.app.scissor);
        if !self.compiling() && self.driver.window_space.scissor != Some(rect) {
            // SAFETY: a plain state command.
            unsafe { self.driver.gl.scissor(rect.x, rect.y, rect.width.max(0), rect.height.max(0)) };
            self.driver.window_space.scissor = Some(rect);
        }
        self.set_scissor(test.then_some(rect));
    }
}
