//! The window that a context draws to, and the stand-in for its framebuffer.
//!
//! [`window`] asks the window system for size and visibility, [`window_config`] asks the driver for
//! format and samples. [`default_framebuffer`] is the atlas, [`cleared_views`] notes which of its
//! views are cleared.

pub mod cleared_views;
pub mod default_framebuffer;
pub mod window;
pub mod window_config;

use crate::backend::gl::accumulation::Accumulation;
use crate::intercept::gl::state::drawable::default_framebuffer::{DefaultFramebuffer, OwnObjects};
use crate::intercept::gl::state::drawable::window::Window;
use crate::runtime::session::Session;
use std::sync::Arc;

/// Windows and framebuffers to which a context draws and from which it reads.
#[derive(Default)]
pub struct Drawable {
    /// Window that the context draws to.
    pub(in crate::intercept::gl) window: Option<Window>,
    /// Stand-in for the window's framebuffer; `None` = the window's own.
    target: Option<Box<DefaultFramebuffer>>,
    /// Plan of the window of another context in the group, for a context without a window. That
    /// window may show its off-screen drawing.
    pub(in crate::intercept::gl) borrowed_session: Option<Arc<Session>>,
    /// Stand-ins for other windows that the context drew to before.
    pub(in crate::intercept::gl) other_windows: Vec<(Window, Box<DefaultFramebuffer>)>,
    /// Objects of stand-ins that were given to other contexts.
    pub(in crate::intercept::gl) left_behind: Vec<OwnObjects>,
    /// True if the program reads from another drawable than it draws to.
    pub(in crate::intercept::gl) reads_elsewhere: bool,
    /// True if nothing of the window was visible after its last swap.
    pub(in crate::intercept::gl) occluded: bool,
    /// Number of times that Cupola gave the window the requested size after the program had given
    /// it another size.
    pub(in crate::intercept::gl) resized: u32,
    /// The accumulation buffer, once the program has used it.
    pub(in crate::intercept::gl) accumulation: Option<Accumulation>,
}

impl Drawable {
    /// Returns the stand-in for the window's framebuffer; `None` = the window's own.
    pub fn target(&self) -> Option<&DefaultFramebuffer> {
        self.target.as_deref()
    }

    /// Returns the stand-in, to be changed.
    pub fn target_mut(&mut self) -> Option<&mut DefaultFramebuffer> {
        self.target.as_deref_mut()
    }

    /// Takes the stand-in out, to work on it beside the context or to give it away.
    pub fn take_target(&mut self) -> Option<Box<DefaultFramebuffer>> {
        self.target.take()
    }

    /// Puts the stand-in in place of the window's framebuffer.
    pub fn put_target(&mut self, target: Box<DefaultFramebuffer>) {
        self.target = Some(target);
    }

    /// Returns the plan of the window that the context draws to. A context without a window has the
    /// plan of another context's window.
    pub fn session(&self) -> Option<&Session> {
        self.target.as_ref().map(|target| &*target.session).or(self.borrowed_session.as_deref())
    }

    /// Returns the framebuffer to which reads of the program's framebuffer 0 are bound.
    pub fn window_for_reading(&self) -> u32 {
        self.target.as_ref().filter(|_| !self.reads_elsewhere).map_or(0, |target| target.framebuffer())
    }
}
