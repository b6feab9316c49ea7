//! The window that a context draws to, and what stands in for its framebuffer.
//!
//! [`window`] asks the window system for size and visibility, [`window_config`] tells format and
//! samples. [`default_framebuffer`] is the atlas, [`cleared_views`] tells what its views hold.

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
    /// The window that it draws to.
    pub(in crate::intercept::gl) window: Option<Window>,
    /// Stand-in for the window's framebuffer; `None` = the window's own.
    target: Option<Box<DefaultFramebuffer>>,
    /// The plan of a window that another context of the group draws, for a context without one:
    /// what it draws off screen may be shown there.
    pub(in crate::intercept::gl) borrowed_session: Option<Arc<Session>>,
    /// Stand-ins for other windows to which it drew lately.
    pub(in crate::intercept::gl) other_windows: Vec<(Window, Box<DefaultFramebuffer>)>,
    /// Objects of pictures that were given to other contexts.
    pub(in crate::intercept::gl) left_behind: Vec<OwnObjects>,
    /// The program reads from another drawable than it draws to.
    pub(in crate::intercept::gl) reads_elsewhere: bool,
    /// Nothing of the window could be seen after its last swap.
    pub(in crate::intercept::gl) occluded: bool,
    /// Number of times that the window got the size that was asked for after the program had given
    /// it another.
    pub(in crate::intercept::gl) resized: u32,
    /// The accumulation buffer, once the program used it.
    pub(in crate::intercept::gl) accumulation: Option<Accumulation>,
}

impl Drawable {
    /// Returns the stand-in for the window's framebuffer; `None` = the window's own.
    pub fn target(&self) -> Option<&DefaultFramebuffer> {
        self.target.as_deref()
    }

    /// The same, to be changed.
    pub fn target_mut(&mut self) -> Option<&mut DefaultFramebuffer> {
        self.target.as_deref_mut()
    }

    /// Takes it out, to be worked on beside the context, or to be given away.
    pub fn take_target(&mut self) -> Option<Box<DefaultFramebuffer>> {
        self.target.take()
    }

    /// Puts it in place of the window's framebuffer.
    pub fn put_target(&mut self, target: Box<DefaultFramebuffer>) {
        self.target = Some(target);
    }

    /// The plan of the window that is drawn, or for which is drawn.
    pub fn session(&self) -> Option<&Session> {
        self.target.as_ref().map(|target| &*target.session).or(self.borrowed_session.as_deref())
    }

    /// Returns the framebuffer to which reads of the program's framebuffer 0 are bound.
    pub fn window_for_reading(&self) -> u32 {
        self.target.as_ref().filter(|_| !self.reads_elsewhere).map_or(0, |target| target.framebuffer())
    }
}
