//! Parts of views that no output samples. They are closed by their depth, so that no fragment is
//! shaded there.
//!
//! A program that clears the depth of its window starts a picture. Right after that these parts get
//! the nearest depth, so drawing there fails the depth test before it is shaded. No pixel of an
//! output changes, since no output samples these parts. This is independent of the program's depth
//! function, range and clear value. With `GL_ALWAYS`, without a depth test, or if the function is
//! reversed in the middle of a frame, these parts are drawn as before. Reads of the program come
//! from its own picture, which is not closed. Its occlusion queries then count only samples that
//! the audience can see. Copies of the program's own framebuffers are not closed: the program may
//! process them (a blur, for example) and read beyond the border of the sampled part.

use crate::backend::gl::GlBackend;
use crate::backend::gl::driver::api::{self, Gl};
use crate::correct::{self, Plan};
use crate::intercept::gl::context::errors::take_own_errors;
use crate::intercept::gl::context::gl_context::Context;
use crate::intercept::gl::state::app::AppState;
use crate::intercept::gl::state::drawable::Drawable;
use crate::intercept::gl::state::driver::Driver;
use crate::intercept::gl::state::frame::Frame;
use crate::intercept::process::log;
use crate::intercept::process::settings::{self, Mask};
use crate::runtime::cache;
use crate::views::Tile;

/// Parts of the window's framebuffer that a program clears.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cleared {
    /// Colour.
    pub color: bool,
    /// Depth, to this value.
    pub depth: Option<f32>,
}

impl Cleared {
    /// Parts that `glClear` clears.
    pub fn by_mask(ctx: &Context, mask: u32) -> Self {
        let depth = mask & api::GL_DEPTH_BUFFER_BIT != 0;
        let value = || if ctx.redirected() { ctx.driver.known_state.clear_depth(ctx.driver.gl) } else { 1.0 };
        Self { color: mask & api::GL_COLOR_BUFFER_BIT != 0, depth: depth.then(value) }
    }

    /// Parts that `glClearBufferfv` clears.
    ///
    /// # Safety
    /// `value` must be null or point at the clear value, as the program promises OpenGL.
    pub unsafe fn by_floats(buffer: u32, _index: i32, value: *const f32) -> Self {
        // SAFETY: as promised; a depth is one number.
        let depth = if buffer == api::GL_DEPTH && !value.is_null() { Some(unsafe { *value }) } else { None };
        Self { color: buffer == api::GL_COLOR, depth }
    }

    /// Parts that `glClearBufferiv` and `glClearBufferuiv` clear.
    pub fn by_integers<T>(buffer: u32, _index: i32, _value: *const T) -> Self {
        Self { color: buffer == api::GL_COLOR, depth: None }
    }

    /// Parts that `glClearBufferfi` clears.
    pub fn by_pair(buffer: u32, _index: i32, depth: f32, _stencil: i32) -> Self {
        Self { color: false, depth: (buffer == api::GL_DEPTH_STENCIL).then_some(depth) }
    }
}

/// Closing is useful only if at least this share of all views' texels is unsampled.
const LEAST_PART: f64 = 0.04;

/// Closing is useful only from this number of texels on: it costs as much as shading some ten
/// thousand simple texels.
const LEAST_TEXELS: u64 = 1 << 17;

/// Gives the backend the areas of a plan that are to be closed. Returns the number of their texels
/// in each view; empty if nothing is closed.
pub fn prepare(gl: &Gl, backend: &mut GlBackend, plan: &Plan) -> Vec<u64> {
    let mask = settings::settings().map_or(Mask::Never, |settings| settings.mask);
    let unsampled =
        if mask == Mask::Never { Vec::new() } else { correct::cached_unsampled_areas(plan, cache::of_process()) };
    let texels: Vec<u64> = unsampled.iter().map(|tiles| tiles.iter().map(Tile::area).sum()).collect();
    let all = plan.views.views.iter().map(|view| view.tile.area()).sum();
    if !worthwhile(mask, texels.iter().sum(), all) {
        return Vec::new();
    }
    match backend.prepare_unsampled(gl, &unsampled.concat(), plan.views.atlas) {
        Ok(()) => texels,
        Err(error) => {
            log::once(&format!("areas that no output samples are drawn, too: {error}"));
            Vec::new()
        }
    }
}

/// True if `unsampled` of `all` texels are to be closed.
fn worthwhile(mask: Mask, unsampled: u64, all: u64) -> bool {
    match mask {
        Mask::Always => unsampled > 0,
        Mask::Auto => unsampled >= LEAST_TEXELS && unsampled as f64 >= LEAST_PART * all as f64,
        Mask::Never => false,
    }
}

/// Closes the unsampled areas after the program has cleared all of its window's depth to `cleared`.
pub fn close(driver: &mut Driver, app: &AppState, drawable: &Drawable, frame: &mut Frame, cleared: f32) {
    // Transform feedback without a pause would record Cupola's rectangles.
    if drawable.target().is_none_or(|t| t.closed().is_empty())
        || app.feedback() && !driver.gl.has_pause_transform_feedback()
    {
        return;
    }
    driver.take_errors();
    if let Some(target) = drawable.target() {
        let texels = target.backend().close_unsampled(driver.gl, cleared, &driver.known_state);
        if texels > 0 {
            frame.note_closing();
        }
    }
    take_own_errors(driver);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_small_part_is_not_closed_unless_asked_for() {
        assert!(worthwhile(Mask::Auto, 140_000, 2_000_000));
        assert!(!worthwhile(Mask::Auto, 140_000, 4_000_000) && !worthwhile(Mask::Auto, 100_000, 200_000));
        assert!(worthwhile(Mask::Always, 10, 2_000_000) && !worthwhile(Mask::Always, 0, 2_000_000));
        assert!(!worthwhile(Mask::Never, 100_000, 200_000));
    }
}
