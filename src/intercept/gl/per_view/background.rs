//! Flat drawing behind the scene ([`crate::intercept::scene::frame_order`]). It goes to the views
//! themselves, at the position of the panel. A flat clip position is a point of the panel. The
//! panel's opening is the lens.

use crate::correct::LowerLeftRect;
use crate::intercept::gl::context::gl_context::Context;
use crate::intercept::gl::per_view::classify;
use crate::intercept::gl::state::frame::background::PanelPart;

/// True if a flat draw with the present state goes behind the scene.
pub fn is_behind(ctx: &mut Context) -> bool {
    if !ctx.frame.is_behind() || !classify::main_viewport(&ctx.app, &ctx.frame) {
        return false;
    }
    let Some(target) = ctx.drawable.target() else { return false };
    let whole = ctx.app.scissor().contains(LowerLeftRect::of_size(target.size()));
    (whole || !ctx.app.scissor_test()) && prepare(ctx, PanelPart::default())
}

/// Computes the matrices from flat clip positions to the views. Returns false if there are none.
pub fn prepare(ctx: &mut Context, part: PanelPart) -> bool {
    let Some(session) = ctx.drawable.session() else { return false };
    ctx.frame.prepare_background(session, ctx.compat.projection.matrix(), part)
}
