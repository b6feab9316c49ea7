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
    window: Option<Window>,
    /// Stand-in for the window's framebuffer; `None` = the window's own.
    target: Option<Box<DefaultFramebuffer>>,
    /// Plan of the window of another context in the group, for a context without a window. That
    /// window may show its off-screen drawing.
    borrowed_session: Option<Arc<Session>>,
    /// Window of the context that is not shown and was never swapped, so that the context counts as
    /// one without a window.
    unshown: Option<usize>,
    /// True if such a window was swapped after all.
    swaps_unshown: bool,
    /// Stand-ins for other windows that the context drew to before.
    other_windows: Vec<(Window, Box<DefaultFramebuffer>)>,
    /// Objects of stand-ins that were given to other contexts.
    left_behind: Vec<OwnObjects>,
    /// True if the program reads from another drawable than it draws to.
    reads_elsewhere: bool,
    /// True if nothing of the window was visible after its last swap.
    occluded: bool,
    /// Number of times that Cupola gave the window the requested size after the program had given
    /// it another size.
    resized: u32,
    /// The accumulation buffer, once the program has used it.
    accumulation: Option<Accumulation>,
}

/// Greatest number of stand-ins that are stored for windows that the context has left.
const MOST_OTHER_WINDOWS: usize = 4;

impl Drawable {
    /// Returns the window that the context draws to.
    pub fn window(&self) -> Option<&Window> {
        self.window.as_ref()
    }

    /// The context draws to another window from now on, or to none. Returns the old one.
    pub fn change_window(&mut self, window: Option<Window>) -> Option<Window> {
        self.resized = 0;
        std::mem::replace(&mut self.window, window)
    }

    /// Notes a window of the context that is not shown; `None`: there is none.
    pub fn note_unshown(&mut self, window: Option<usize>) {
        self.unshown = window;
    }

    /// Notes that a window was swapped. Returns true if it is the one that counted as not shown.
    pub fn swaps(&mut self, window: usize) -> bool {
        let is_it = self.unshown.take_if(|unshown| *unshown == window).is_some();
        self.swaps_unshown |= is_it;
        is_it
    }

    /// True if a window was swapped that counted as not shown.
    pub fn has_swapped_unshown(&self) -> bool {
        self.swaps_unshown
    }

    /// Stores the stand-in for a window that the context has left. Returns the oldest of the stored
    /// stand-ins if there are too many.
    pub fn put_aside(&mut self, window: Window, target: Box<DefaultFramebuffer>) -> Option<Box<DefaultFramebuffer>> {
        let full = self.other_windows.len() >= MOST_OTHER_WINDOWS;
        let oldest = full.then(|| self.other_windows.remove(0).1);
        self.other_windows.push((window, target));
        oldest
    }

    /// Returns the stored stand-in for the window that the context draws to, and that window.
    pub fn take_back(&mut self) -> Option<(Window, Box<DefaultFramebuffer>)> {
        let index = self.other_windows.iter().position(|(other, _)| Some(other) == self.window.as_ref())?;
        Some(self.other_windows.remove(index))
    }

    /// Gives away the stand-in for `window`. Its objects that belong to this context alone stay
    /// behind.
    pub fn give_target(&mut self, window: &Window) -> Option<Box<DefaultFramebuffer>> {
        let position = self.other_windows.iter().position(|(other, _)| other == window);
        let target = match position {
            Some(index) => Some(self.other_windows.remove(index).1),
            None if self.window.as_ref() == Some(window) => self.take_target(),
            None => None,
        }?;
        self.left_behind.push(target.own_objects());
        Some(target)
    }

    /// Returns the objects of stand-ins that were given away. They are to be deleted in this
    /// context.
    pub fn take_left_behind(&mut self) -> Vec<OwnObjects> {
        std::mem::take(&mut self.left_behind)
    }

    /// Returns the plan that was borrowed from another context's window.
    pub fn borrowed_session(&self) -> Option<&Arc<Session>> {
        self.borrowed_session.as_ref()
    }

    /// Borrows the plan of another context's window, or gives it back.
    pub fn borrow_session(&mut self, session: Option<Arc<Session>>) {
        self.borrowed_session = session;
    }

    /// Notes whether the program reads from another drawable than it draws to.
    pub fn note_reads(&mut self, elsewhere: bool) {
        self.reads_elsewhere = elsewhere;
    }

    /// True if the program reads from another drawable than it draws to.
    pub fn reads_elsewhere(&self) -> bool {
        self.reads_elsewhere
    }

    /// Notes whether nothing of the window is visible after its swap.
    pub fn note_occluded(&mut self, occluded: bool) {
        self.occluded = occluded;
    }

    /// True if nothing of the window was visible after its last swap.
    pub fn occluded(&self) -> bool {
        self.occluded
    }

    /// Notes that Cupola gave the window the requested size again.
    pub fn note_resized(&mut self) {
        self.resized += 1;
    }

    /// Number of times that Cupola gave the window the requested size again.
    pub fn resized(&self) -> u32 {
        self.resized
    }

    /// True if the program has used the accumulation buffer.
    pub fn accumulates(&self) -> bool {
        self.accumulation.is_some()
    }

    /// Takes the accumulation buffer out, to work on it beside the context.
    pub fn take_accumulation(&mut self) -> Option<Accumulation> {
        self.accumulation.take()
    }

    /// Puts the accumulation buffer back.
    pub fn put_accumulation(&mut self, buffer: Accumulation) {
        self.accumulation = Some(buffer);
    }

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
