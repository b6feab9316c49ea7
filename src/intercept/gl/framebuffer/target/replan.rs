//! Number of draws in a frame of the program. It decides the number of views, since each draw is
//! issued once per view.
//!
//! The first plan is for a program with a thousand draws. When the number has been steady for some
//! frames, the views are planned again for it. This happens once, at a clear that begins a frame,
//! so no drawing is lost. The number includes draws that are left out of views, since they never
//! change a picture.

use crate::backend::gl::driver::api;
use crate::intercept::gl::context::gl_context::Context;
use crate::intercept::gl::context::own_calls::OwnCalls;
use crate::intercept::gl::framebuffer::target::attach::plan_for;
use crate::intercept::gl::framebuffer::target::unsampled_areas::Cleared;
use crate::intercept::gl::state::app::AppState;
use crate::intercept::gl::state::driver::Driver;

/// Plans again at a clear of the window, if the clear removes everything that was drawn before.
pub fn look(ctx: &mut Context, cleared: Cleared, stencil: bool) {
    let begins = !ctx.frame.begun() && ctx.redirected() && !ctx.app.picking() && !ctx.app.scissor_test();
    let whole = cleared.color && cleared.depth.is_some() && (stencil || !ctx.frame.draw_count().tests_stencil());
    let kept = ctx.queries.is_conditional() || ctx.app.discard() || ctx.drawable.accumulates();
    if !begins || !whole || kept || ctx.frame.draw_count().is_planned() || !writes_all(&ctx.driver, &ctx.app) {
        return;
    }
    if let Some(draws) = ctx.frame.draws_to_plan_for() {
        plan_for(&mut OwnCalls::begin(ctx), draws);
    }
}

/// True if a clear writes all of colour and depth.
fn writes_all(driver: &Driver, app: &AppState) -> bool {
    let (mut color, mut depth) = ([0u8; 4], 0u8);
    // SAFETY: writes four values, and one.
    unsafe {
        driver.gl.get_booleanv(api::GL_COLOR_WRITEMASK, color.as_mut_ptr());
        driver.gl.get_booleanv(api::GL_DEPTH_WRITEMASK, &mut depth);
    }
    color[..3].iter().all(|on| *on != 0) && depth != 0 && !app.buffers().draws_nothing()
}
