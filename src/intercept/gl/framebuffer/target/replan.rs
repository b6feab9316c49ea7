//! Number of draws in a frame of the program. It decides the number of views, since each view costs
//! that many draws.
//!
//! The first plan is for a program of a thousand draws. Once the number has been steady for some
//! frames, the views are planned anew for it, at a clear that begins a frame, so that nothing that
//! was drawn is lost. It happens once. The number is that of the program's own draws, whether or
//! not some of them are left out of views: draws that are left out never change a picture.

use crate::backend::gl::driver::api;
use crate::intercept::gl::context::gl_context::Context;
use crate::intercept::gl::context::own_calls::OwnCalls;
use crate::intercept::gl::framebuffer::target::attach::plan_for;
use crate::intercept::gl::framebuffer::target::unsampled_areas::Cleared;
use crate::intercept::gl::state::app::AppState;
use crate::intercept::gl::state::driver::Driver;

/// The program clears its window. If nothing of what is there can be seen afterwards, this is the
/// moment for other views.
pub fn look(ctx: &mut Context, cleared: Cleared, stencil: bool) {
    let begins = !ctx.frame.begun && ctx.redirected() && !ctx.app.picking && !ctx.app.scissor_test;
    let whole = cleared.color && cleared.depth.is_some() && (stencil || !ctx.frame.draw_count.stencil);
    let kept = ctx.queries.condition.is_some() || ctx.app.discard || ctx.drawable.accumulation.is_some();
    if !begins || !whole || kept || ctx.frame.draw_count.draws.is_some() || !writes_all(&ctx.driver, &ctx.app) {
        return;
    }
    if let Some(draws) = ctx.frame.draw_count.take() {
        plan_for(&mut OwnCalls::begin(ctx), draws);
    }
}

/// True if a clear reaches all of colour and depth.
fn writes_all(driver: &Driver, app: &AppState) -> bool {
    let (mut color, mut depth) = ([0u8; 4], 0u8);
    // SAFETY: writes four values, and one.
    unsafe {
        driver.gl.get_booleanv(api::GL_COLOR_WRITEMASK, color.as_mut_ptr());
        driver.gl.get_booleanv(api::GL_DEPTH_WRITEMASK, &mut depth);
    }
    color[..3].iter().all(|on| *on != 0) && depth != 0 && app.draw_buffer != api::GL_NONE
}
