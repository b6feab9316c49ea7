//! Fallback to views, as with the method `fragment`, for programs whose vertices cannot be
//! projected straight to an output.

use crate::correct::projected::matrices::LensConstants;
use crate::intercept::gl::context::gl_context::Context;
use crate::intercept::gl::framebuffer::target::attach::attach;
use crate::intercept::gl::offscreen::view_copies;
use crate::intercept::gl::projected_vertices;
use crate::intercept::gl::state::draw::draw_class::DrawClass;
use crate::intercept::gl::state::draw::primitives::Shape;
use crate::intercept::gl::state::projected_vertices::fixed_function::Processor;
use crate::intercept::process::log;
use crate::intercept::scene::obstacle::Obstacle;
use crate::runtime::session::MatrixClass;

/// Prepares the next draw if vertices are projected: a program of Cupola replaces the
/// fixed-function pipeline. If this draw cannot be projected, the window gets views.
pub fn look(ctx: &mut Context) {
    let projects = ctx.drawable.target().is_some_and(|target| !target.lenses.is_empty());
    if !projects
        || ctx.app.picking()
        || ctx.shaders.program().is_some_and(|program| program.draws_vertices())
        || !ctx.driver.profile.compatibility()
    {
        return;
    }
    if ctx.shaders.assembly().is_some() {
        use_views(ctx, "the program's vertices go through a program in assembly language");
        return;
    }
    ctx.compat.projection.refresh(ctx.driver.gl, ctx.drawable.session());
    if matches!(ctx.compat.projection.class(), MatrixClass::Perspective(_))
        && let Err(why) = projected_vertices::begin_stand_in(ctx)
    {
        use_views(ctx, why);
    }
}

/// Does the same for a draw of `class` whose primitives have to be divided. Returns true if the
/// window gets views by that.
pub fn look_divided(ctx: &mut Context, class: DrawClass) -> bool {
    let divides = ctx.drawable.target().is_some_and(|target| target.lenses.iter().any(LensConstants::divides));
    let in_program = ctx.shaders.program().is_some_and(|program| program.draws_vertices());
    if !divides || !in_program || !matches!(class, DrawClass::Scene(_) | DrawClass::Behind) {
        return false;
    }
    if let Processor::Cannot(why) = ctx.projected.processor() {
        let why = why.clone();
        use_views(ctx, why);
        return true;
    }
    let drawn = ctx.draw.drawn_shape();
    match drawn {
        Shape::Points => return false,
        _ if *ctx.projected.processor() == Processor::Divides || projected_vertices::variant(ctx).is_some() => {
            return false;
        }
        Shape::Triangles | Shape::Lines => use_views(ctx, "a program's primitives cannot be divided"),
        _ => use_views(ctx, "a program draws quadrilaterals, patches or lists in a way that cannot be divided"),
    }
    true
}

/// Gives the window views for a pass whose shader computes points of the scene from pixels.
pub fn look_screen(ctx: &mut Context) {
    if ctx.drawable.target().is_some_and(|target| !target.lenses.is_empty()) {
        use_views(ctx, "a shader computes directions from the program's pixels");
    }
}

/// Gives this context's windows views from now on, and logs why. The frame in progress starts again
/// with the next draw.
pub fn use_views(ctx: &mut Context, why: impl Into<Obstacle>) {
    if ctx.projected.views_only() {
        return;
    }
    ctx.projected.use_views_only();
    if let Some(reason) = why.into().reason() {
        log::once(&format!("{reason}: the outputs are made by method \"fragment\" instead"));
    }
    let Some(target) = ctx.drawable.take_target() else { return };
    let extras = target.extras();
    view_copies::clear(ctx);
    target.destroy(ctx.driver.gl);
    attach(ctx, extras);
}
