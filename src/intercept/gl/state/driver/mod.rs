//! The driver of a context: its functions, its version, and the state that is set in it.
//!
//! [`profile`] tells version and profile, [`window_space`] viewport and scissor.

pub mod profile;
pub mod window_space;

use crate::backend::gl::KnownState;
use crate::backend::gl::driver::api::{self, Gl};
use crate::correct::LowerLeftRect;
use crate::intercept::gl::state::app::window_arrays::{self, WindowArrays};
use crate::intercept::gl::state::driver::profile::{Profile, is_endless, profile};
use crate::intercept::gl::state::driver::window_space::DriverState;
use std::sync::atomic::{AtomicU64, Ordering};

/// The driver's side of a context.
pub struct Driver {
    /// Functions of the driver.
    pub(in crate::intercept::gl) gl: &'static Gl,
    /// Number of the context, which no other context of the process has.
    pub(in crate::intercept::gl) id: u64,
    /// Version and profile of OpenGL.
    pub(in crate::intercept::gl) profile: Profile,
    /// Viewport and scissor that are set in the driver.
    window_space: DriverState,
    /// State that is known without asking the driver.
    pub(in crate::intercept::gl) known_state: KnownState,
    /// Error of the program that was taken out of the driver.
    pending_error: u32,
    /// Number of errors that Cupola caused.
    own_errors: u64,
    /// True if the driver's anisotropic filtering may never end.
    pub(in crate::intercept::gl) endless_anisotropy: bool,
}

impl Driver {
    /// Returns the driver of a context that has just become current for the first time.
    pub fn new(gl: &'static Gl) -> Self {
        static CONTEXTS: AtomicU64 = AtomicU64::new(0);
        Self {
            gl,
            id: CONTEXTS.fetch_add(1, Ordering::Relaxed),
            profile: profile(gl),
            window_space: DriverState::default(),
            known_state: KnownState::of_new_context(),
            pending_error: 0,
            own_errors: 0,
            endless_anisotropy: is_endless(gl),
        }
    }

    /// Notes an error for the program's `glGetError`, unless there is an earlier error, noted or in
    /// the driver.
    pub fn note_error(&mut self, error: u32) {
        self.take_errors();
        self.keep_first(error);
    }

    /// Takes the program's errors out of the driver and notes the first one.
    pub fn take_errors(&mut self) {
        // A driver has a handful of error flags at most.
        for _ in 0..8 {
            // SAFETY: asks for the error flag.
            match unsafe { self.gl.get_error() } {
                api::GL_NO_ERROR => break,
                error => self.keep_first(error),
            }
        }
    }

    /// Makes a call of the program, and returns whether the driver accepted it. Its error is noted for
    /// the program.
    pub fn accepts(&mut self, call: impl FnOnce(&Gl)) -> bool {
        self.take_errors();
        call(self.gl);
        // SAFETY: asks for the error flag.
        let error = unsafe { self.gl.get_error() };
        if error != api::GL_NO_ERROR {
            self.keep_first(error);
        }
        error == api::GL_NO_ERROR
    }

    fn keep_first(&mut self, error: u32) {
        if self.pending_error == api::GL_NO_ERROR {
            self.pending_error = error;
        }
    }

    /// Counts an error that Cupola caused.
    pub fn note_own_error(&mut self) {
        self.own_errors += 1;
    }

    /// Number of errors that Cupola caused.
    pub fn own_errors(&self) -> u64 {
        self.own_errors
    }

    /// Answers `glGetError`. The first error stays until the program asks for it. Later ones are
    /// forgotten, as in drivers.
    pub fn error(&mut self) -> u32 {
        // SAFETY: asks for the error flag.
        let later = unsafe { self.gl.get_error() };
        match std::mem::take(&mut self.pending_error) {
            api::GL_NO_ERROR => later,
            error => error,
        }
    }

    /// Sets all viewports, unless the driver has them already.
    pub fn set_viewport(&mut self, rect: LowerLeftRect) {
        if self.window_space.viewport != Some(rect) {
            self.issue_viewport(rect);
        }
    }

    /// Sets all viewports, as the program's own command does.
    pub fn issue_viewport(&mut self, rect: LowerLeftRect) {
        // SAFETY: a plain state command.
        unsafe { self.gl.viewport(rect.x, rect.y, rect.width, rect.height) };
        self.window_space.viewport = Some(rect);
    }

    /// Sets viewports and scissors by their index.
    pub fn set_arrays(&mut self, arrays: &WindowArrays) {
        let count = window_arrays::COUNT as i32;
        let (viewports, scissors) = (arrays.viewports.as_ptr().cast(), arrays.scissors.as_ptr().cast());
        // SAFETY: four numbers for each index; the program has set some of them by their index, so
        // the driver has these functions.
        unsafe {
            self.gl.viewport_arrayv(0, count, viewports);
            self.gl.scissor_arrayv(0, count, scissors);
            for index in 0..window_arrays::COUNT as u32 {
                match arrays.tests >> index & 1 {
                    0 => self.gl.disablei(api::GL_SCISSOR_TEST, index),
                    _ => self.gl.enablei(api::GL_SCISSOR_TEST, index),
                }
            }
        }
        self.forget_window_space(api::GL_VIEWPORT_BIT | api::GL_SCISSOR_BIT);
    }

    /// Sets the scissor rectangle, unless the driver has it already. The scissor test does not
    /// change.
    pub fn set_scissor(&mut self, rect: LowerLeftRect) {
        if self.window_space.scissor != Some(rect) {
            self.issue_scissor(rect);
        }
    }

    /// Sets the scissor rectangles of all viewports, as the program's own command does.
    pub fn issue_scissor(&mut self, rect: LowerLeftRect) {
        // SAFETY: a plain state command.
        unsafe { self.gl.scissor(rect.x, rect.y, rect.width.max(0), rect.height.max(0)) };
        self.window_space.scissor = Some(rect);
    }

    /// Switches the scissor test, unless the driver has this setting already.
    pub fn set_scissor_test(&mut self, on: bool) {
        if self.window_space.scissor_test != Some(on) {
            self.issue_scissor_test(on);
        }
    }

    /// Switches the scissor test of all viewports, as the program's own command does.
    pub fn issue_scissor_test(&mut self, on: bool) {
        // SAFETY: a plain state command.
        unsafe {
            if on {
                self.gl.enable(api::GL_SCISSOR_TEST);
            } else {
                self.gl.disable(api::GL_SCISSOR_TEST);
            }
        }
        self.window_space.scissor_test = Some(on);
    }

    /// Returns the scissor rectangle if the test is known to be on.
    pub fn scissor(&self) -> Option<LowerLeftRect> {
        self.window_space.scissor.filter(|_| self.window_space.scissor_test == Some(true))
    }

    /// Forgets viewport and scissor if they are in the groups of `mask` (of `glPopAttrib`), as they
    /// may have changed.
    pub fn forget_window_space(&mut self, mask: u32) {
        self.window_space.forget(mask);
    }
}
