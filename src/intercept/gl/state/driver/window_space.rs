//! Viewport and scissor of the driver.

use crate::backend::gl::driver::api;
use crate::correct::LowerLeftRect;

/// State that is set in the driver, if it is known. It saves redundant calls.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct DriverState {
    pub(super) viewport: Option<LowerLeftRect>,
    pub(super) scissor: Option<LowerLeftRect>,
    pub(super) scissor_test: Option<bool>,
}

impl DriverState {
    /// Forgets the values that the groups of `mask` (of `glPopAttrib`) may have changed.
    pub(super) fn forget(&mut self, mask: u32) {
        if mask & api::GL_VIEWPORT_BIT != 0 {
            self.viewport = None;
        }
        if mask & api::GL_SCISSOR_BIT != 0 {
            self.scissor = None;
        }
        if mask & (api::GL_SCISSOR_BIT | api::GL_ENABLE_BIT) != 0 {
            self.scissor_test = None;
        }
    }
}
