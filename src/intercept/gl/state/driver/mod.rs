//! The driver of a context: its functions, its version, the state that is set in it.
//!
//! [`profile`] tells version and profile, [`window_space`] viewport and scissor.

pub mod profile;
pub mod window_space;

use crate::backend::gl::KnownState;
use crate::backend::gl::api::{self, Gl};
use crate::intercept::gl::state::driver::profile::{Profile, is_endless, profile};
use crate::intercept::gl::state::driver::window_space::DriverState;
use std::sync::atomic::{AtomicU64, Ordering};

/// The driver's side of a context.
pub struct Driver {
    /// Its functions.
    pub(in crate::intercept::gl) gl: &'static Gl,
    /// A number of the context's own, among all contexts of the process.
    pub(in crate::intercept::gl) id: u64,
    /// Which OpenGL.
    pub(in crate::intercept::gl) profile: Profile,
    /// Viewport and scissor that are really set.
    pub(in crate::intercept::gl) window_space: DriverState,
    /// State that need not be asked for.
    pub(in crate::intercept::gl) known_state: KnownState,
    /// An error of the program's that was taken out of the driver.
    pending_error: u32,
    /// Its anisotropic filtering may never end.
    pub(in crate::intercept::gl) endless_anisotropy: bool,
}

impl Driver {
    /// The driver of a context that has just become current for the first time.
    pub fn new(gl: &'static Gl) -> Self {
        static CONTEXTS: AtomicU64 = AtomicU64::new(0);
        Self {
            gl,
            id: CONTEXTS.fetch_add(1, Ordering::Relaxed),
            profile: profile(gl),
            window_space: DriverState::default(),
            known_state: KnownState::of_new_context(),
            pending_error: 0,
            endless_anisotropy: is_endless(gl),
        }
    }

    /// Notes an error of the program's for its `glGetError`, unless one is noted already.
    pub fn note_error(&mut self, error: u32) {
        if self.pending_error == api::GL_NO_ERROR {
            self.pending_error = error;
        }
    }

    /// `glGetError`. The first error counts until it is asked for; later ones are forgotten, as
    /// drivers do.
    pub fn error(&mut self) -> u32 {
        // SAFETY: asks for the error flag.
        let later = unsafe { self.gl.get_error() };
        match std::mem::take(&mut self.pending_error) {
            api::GL_NO_ERROR => later,
            error => error,
        }
    }
}
