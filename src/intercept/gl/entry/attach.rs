//! A context becomes current with a window.

use crate::backend::gl::api;
use crate::intercept::gl::context::gl_context::Context;
use crate::intercept::gl::entry::contexts;
use crate::intercept::gl::framebuffer::default_framebuffer;
use crate::intercept::gl::offscreen::view_copies;
use crate::intercept::gl::state::default_framebuffer::DefaultFramebuffer;
use crate::intercept::gl::state::window::Window;
use crate::intercept::settings::settings;
use crate::runtime::session::Extras;
use std::sync::Arc;

impl Context {
    /// The context became current with `window`.
    pub fn attach(&mut self, window: Option<Window>, reads_elsewhere: bool) {
        self.reads_elsewhere = reads_elsewhere;
        for objects in std::mem::take(&mut self.left_behind) {
            objects.destroy(self.gl);
        }
        let first = self.window.is_none() && window.is_some() && self.app.viewport == [0; 4];
        if self.window != window {
            self.change_window(window);
        }
        view_copies::collect(self);
        let Some(window) = self.window.clone() else {
            self.borrow();
            return;
        };
        self.lent = None;
        if let Some(size) = settings().and_then(|s| s.window_size) {
            window.resize(size);
        }
        if first {
            let (width, height) = window.size();
            self.app.viewport = [0, 0, width as i32, height as i32];
            self.app.scissor = self.app.viewport;
            if !window.double_buffered(self.gl, &self.profile) {
                self.app.draw_buffer = api::GL_FRONT;
                self.app.read_buffer = api::GL_FRONT;
            }
        }
        if self.target.is_none() {
            match contexts::take_picture(self, &window) {
                Some(picture) => default_framebuffer::take_over(self, picture),
                None => default_framebuffer::attach(self, Extras::default()),
            }
        } else if self.app.read_framebuffer == 0 {
            // SAFETY: what the program's reads come from, which may be another drawable now.
            unsafe { self.gl.bind_framebuffer(api::GL_READ_FRAMEBUFFER, self.window_for_reading()) };
        }
    }

    /// A context without a window draws for that of another in its group.
    fn borrow(&mut self) {
        let lent = contexts::lend_session(self);
        if self.lent.as_ref().map(Arc::as_ptr) != lent.as_ref().map(Arc::as_ptr) {
            self.lent = lent;
            self.projection.clear();
            self.cameras.clear();
        }
        if self.app.viewport == [0; 4] {
            // SAFETY: each writes four integers.
            unsafe {
                self.gl.get_integerv(api::GL_VIEWPORT, self.app.viewport.as_mut_ptr());
                self.gl.get_integerv(api::GL_SCISSOR_BOX, self.app.scissor.as_mut_ptr());
            }
        }
    }

    /// Gives away what stands for `window`. Its objects that belong to this context alone are deleted when it is
    /// current again.
    pub fn give_picture(&mut self, window: &Window) -> Option<Box<DefaultFramebuffer>> {
        let parked = self.parked.iter().position(|(parked, _)| parked == window);
        let target = match parked {
            Some(index) => Some(self.parked.remove(index).1),
            None if self.window.as_ref() == Some(window) => self.target.take(),
            None => None,
        }?;
        self.left_behind.push(target.own_objects());
        Some(target)
    }

    /// Another window, or none: what stood for the old one is kept for when the program comes back to it.
    fn change_window(&mut self, window: Option<Window>) {
        let old = std::mem::replace(&mut self.window, window);
        if let (Some(old), Some(target)) = (old, self.target.take()) {
            if self.parked.len() >= MOST_PARKED {
                self.parked.remove(0).1.destroy(self.gl);
            }
            self.parked.push((old, target));
            // SAFETY: the program's window is bound in place of ours.
            unsafe {
                if self.app.draw_framebuffer == 0 {
                    self.gl.bind_framebuffer(api::GL_DRAW_FRAMEBUFFER, 0);
                }
                if self.app.read_framebuffer == 0 {
                    self.gl.bind_framebuffer(api::GL_READ_FRAMEBUFFER, 0);
                }
            }
            self.restore_window_space();
        }
        self.frame_begun = false;
        self.occluded = false;
        if let Some(index) = self.parked.iter().position(|(parked, _)| Some(parked) == self.window.as_ref()) {
            let (window, target) = self.parked.remove(index);
            default_framebuffer::resume(self, &window, target);
            default_framebuffer::follow_size(self);
        }
    }
}

/// Windows that a context has left keep what stands in for them, but not more than these.
pub(in crate::intercept::gl) const MOST_PARKED: usize = 4;
