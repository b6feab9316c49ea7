//! Viewports and scissors of the driver.

use crate::backend::gl::driver::api;
use crate::correct::LowerLeftRect;
use crate::intercept::gl::context::gl_context::Context;
use crate::intercept::gl::state::app::window_arrays::WindowArrays;

impl Context {
    /// Sets the driver's viewport.
    pub fn set_viewport(&mut self, rect: LowerLeftRect) {
        if self.compiling() {
            // The command would become a part of the program's list.
            self.driver.forget_window_space(api::GL_VIEWPORT_BIT);
        } else {
            self.driver.set_viewport(rect);
        }
    }

    /// Sets the driver's scissor test and, if the test is on, its rectangle.
    pub fn set_scissor(&mut self, rect: Option<LowerLeftRect>) {
        if self.compiling() {
            self.driver.forget_window_space(api::GL_SCISSOR_BIT);
            return;
        }
        self.driver.set_scissor_test(rect.is_some());
        if let Some(rect) = rect {
            self.driver.set_scissor(rect);
        }
    }

    /// Sets the driver's viewports and scissors by their index.
    pub fn set_arrays(&mut self, arrays: &WindowArrays) {
        if self.compiling() {
            self.driver.forget_window_space(api::GL_VIEWPORT_BIT | api::GL_SCISSOR_BIT);
        } else {
            self.driver.set_arrays(arrays);
        }
    }

    /// Puts the program's own viewports and scissors into the driver, for its own framebuffers.
    pub fn restore_window_space(&mut self) {
        if let Some(arrays) = self.app.arrays().cloned() {
            self.set_arrays(&arrays);
            return;
        }
        self.set_viewport(self.app.viewport());
        let (test, rect) = (self.app.scissor_test(), self.app.scissor());
        if !self.compiling() {
            self.driver.set_scissor(rect);
        }
        self.set_scissor(test.then_some(rect));
    }
}
