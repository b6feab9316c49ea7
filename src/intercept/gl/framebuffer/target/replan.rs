//! What the program draws in a frame decides the plan.
//!
//! The number of draws decides the number of views, since each draw is issued once per view. The
//! first plan is for a program with a thousand draws. When the number has been steady for some
//! frames, the views are planned again for it. The number includes draws that are left out of
//! views, since they never change a picture.
//!
//! Many programs draw something flat before their first scene: a picture while they load, or a frame
//! before they know the window's size. Then the panel is not used any more, and costs the
//! correction time. It is removed once; a later use makes it for good.
//!
//! Both happen once, at a clear that begins a frame, so no drawing is lost.

use crate::backend::gl::driver::api;
use crate::intercept::gl::context::gl_context::Context;
use crate::intercept::gl::context::own_calls::OwnCalls;
use crate::intercept::gl::framebuffer::target::attach::plan_for;
use crate::intercept::gl::framebuffer::target::unsampled_areas::Cleared;
use crate::intercept::gl::state::app::AppState;
use crate::intercept::gl::state::drawable::default_framebuffer::DefaultFramebuffer;
use crate::intercept::gl::state::driver::Driver;

/// Plans again at a clear of the window, if the clear removes everything that was drawn before.
pub fn look(ctx: &mut Context, cleared: Cleared, stencil: bool) {
    let begins = !ctx.frame.begun() && ctx.redirected() && !ctx.app.picking() && !ctx.app.scissor_test();
    let whole = cleared.color && cleared.depth.is_some() && (stencil || !ctx.frame.draw_count().tests_stencil());
    let kept = ctx.queries.is_conditional() || ctx.app.discard() || ctx.drawable.accumulates();
    let is_useless = |target: &DefaultFramebuffer| target.panel().is_some() && target.session.turns().is_none();
    let without_panel = ctx.frame.panel_use().is_over() && ctx.drawable.target().is_some_and(is_useless);
    let is_settled = ctx.frame.draw_count().is_planned() && !without_panel;
    if !begins || !whole || kept || is_settled || !writes_all(&ctx.driver, &ctx.app) {
        return;
    }
    let draws = ctx.frame.draws_to_plan_for();
    if without_panel {
        ctx.frame.panel_use().note_removed();
    }
    if draws.is_some() || without_panel {
        plan_for(&mut OwnCalls::begin(ctx), draws, without_panel);
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
