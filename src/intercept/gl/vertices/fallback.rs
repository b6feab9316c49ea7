//! Programs whose vertices cannot be projected straight to an output get views, as with the method `fragment`.

use super::super::context::Context;
use super::super::default_framebuffer;
use crate::intercept::log;
use crate::runtime::session::MatrixClass;

/// Looks whether the next draw can be served where vertices are projected; gives the window views where not.
pub fn look(ctx: &mut Context) {
    let projects = ctx.target.as_ref().is_some_and(|target| !target.lenses.is_empty());
    if !projects || ctx.program.as_ref().is_some_and(|program| program.draws_vertices()) || !ctx.profile.compatibility()
    {
        return;
    }
    super::super::matrices::refresh(ctx);
    if matches!(ctx.projection.class, MatrixClass::Perspective(_)) {
        use_views(ctx, "the program's vertices go through the fixed-function pipeline");
    }
}

/// From now on this context's windows have views. The frame that is being drawn begins anew with the next draw.
pub fn use_views(ctx: &mut Context, reason: &str) {
    if ctx.views_only {
        return;
    }
    ctx.views_only = true;
    log::once(&format!("{reason}: the outputs are made by method \"fragment\" instead"));
    let Some(target) = ctx.target.take() else { return };
    let extras = target.extras();
    super::super::duplicate::clear(ctx);
    target.destroy(ctx.gl);
    default_framebuffer::attach(ctx, extras);
}
