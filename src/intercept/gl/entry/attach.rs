//! Attachment of a context to the window with which it becomes current.

use crate::backend::gl::driver::api;
use crate::correct::LowerLeftRect;
use crate::intercept::gl::context::gl_context::Context;
use crate::intercept::gl::context::registry;
use crate::intercept::gl::framebuffer::target::attach;
use crate::intercept::gl::offscreen::view_copies;
use crate::intercept::gl::state::app::window_buffers::WindowBuffers;
use crate::intercept::gl::state::drawable::default_framebuffer::DefaultFramebuffer;
use crate::intercept::gl::state::drawable::window::Window;
use crate::intercept::process::settings::settings;
use crate::runtime::session::Extras;
use std::sync::Arc;

impl Context {
    /// Attaches the context to `window`, with which it became current; `None`: it has no window.
    pub fn attach(&mut self, window: Option<Window>, reads_elsewhere: bool) {
        self.drawable.note_reads(reads_elsewhere);
        let unshown = window.as_ref().filter(|window| self.only_needs_a_window(window)).map(Window::handle);
        self.drawable.note_unshown(unshown);
        let window = window.filter(|_| unshown.is_none());
        for objects in self.drawable.take_left_behind() {
            objects.destroy(self.driver.gl);
        }
        let first =
            self.drawable.window().is_none() && window.is_some() && self.app.viewport() == LowerLeftRect::default();
        if self.drawable.window() != window.as_ref() {
            self.change_window(window);
        }
        view_copies::collect(self);
        let Some(window) = self.drawable.window().cloned() else {
            self.borrow();
            return;
        };
        self.drawable.borrow_session(None);
        if let Some(size) = settings().and_then(|s| s.window_size) {
            window.resize(size);
        }
        if first {
            self.app.set_viewport(LowerLeftRect::of_size(window.size()));
            self.app.set_scissor(self.app.viewport());
            if !window.double_buffered(self.driver.gl, &self.driver.profile) {
                *self.app.buffers_mut() = WindowBuffers::of_window(api::GL_FRONT);
            }
        }
        if self.drawable.target().is_none() {
            match registry::take_picture(&self.share, &window) {
                Some(picture) => attach::take_over(self, picture),
                None => attach::attach(self, Extras::default()),
            }
        } else if self.app.read_framebuffer() == 0 {
            // SAFETY: binds the framebuffer that the program reads from, which may be another one
            // now.
            unsafe { self.driver.gl.bind_framebuffer(api::GL_READ_FRAMEBUFFER, self.drawable.window_for_reading()) };
        }
    }

    /// True if `window` shows nothing, and the program draws off screen for the window of another
    /// context. Toolkits make such windows, as a context needs one to become current.
    fn only_needs_a_window(&self, window: &Window) -> bool {
        self.frame.last() == 0
            && !self.drawable.has_swapped_unshown()
            && registry::lend_session(&self.share).is_some_and(|(last, _)| last > 0)
            && window.look().occluded
    }

    /// Takes the plan of another context's window in the group, for a context without a window.
    fn borrow(&mut self) {
        let borrowed = registry::lend_session(&self.share).map(|(_, session)| session);
        if self.drawable.borrowed_session().map(Arc::as_ptr) != borrowed.as_ref().map(Arc::as_ptr) {
            self.drawable.borrow_session(borrowed);
            self.compat.projection.clear();
            self.frame.views_changed();
        }
        if self.app.viewport() == LowerLeftRect::default() {
            let (mut viewport, mut scissor) = ([0; 4], [0; 4]);
            // SAFETY: each writes four integers.
            unsafe {
                self.driver.gl.get_integerv(api::GL_VIEWPORT, viewport.as_mut_ptr());
                self.driver.gl.get_integerv(api::GL_SCISSOR_BOX, scissor.as_mut_ptr());
            }
            self.app.set_viewport(viewport.into());
            self.app.set_scissor(scissor.into());
        }
    }

    /// Gives away the stand-in for `window`. Its objects that belong to this context alone are
    /// deleted when this context is current again.
    pub fn give_picture(&mut self, window: &Window) -> Option<Box<DefaultFramebuffer>> {
        self.drawable.give_target(window)
    }

    /// Changes to another window or to none. The stand-in for the old window is stored, as the
    /// program may return to that window.
    fn change_window(&mut self, window: Option<Window>) {
        let old = self.drawable.change_window(window);
        if let (Some(old), Some(target)) = (old, self.drawable.take_target()) {
            if let Some(oldest) = self.drawable.put_aside(old, target) {
                oldest.destroy(self.driver.gl);
            }
            // SAFETY: binds the program's window in place of Cupola's framebuffer.
            unsafe {
                if self.app.draw_framebuffer() == 0 {
                    self.driver.gl.bind_framebuffer(api::GL_DRAW_FRAMEBUFFER, 0);
                }
                if self.app.read_framebuffer() == 0 {
                    self.driver.gl.bind_framebuffer(api::GL_READ_FRAMEBUFFER, 0);
                }
            }
            self.restore_window_space();
        }
        self.frame.window_changed();
        self.drawable.note_occluded(false);
        if let Some((window, target)) = self.drawable.take_back() {
            attach::resume(self, &window, target);
            attach::follow_size(self);
        }
    }
}
