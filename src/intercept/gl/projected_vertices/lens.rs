//! Methods `vertex` and `primitive`: a view that is an output's own picture, to which the vertices
//! of the program are projected in its last stage before rasterisation.
//!
//! `correct::projected::projection` is what that stage computes. For `primitive` there are
//! [`variants`] of the program: they hand the outputs of its shaders (`interface`) to a stage that
//! divides (`geometry_stage`) and get the values of its uniforms (`mirror`). Where a program cannot
//! be served, `fallback` gives its window views.

use crate::correct::projected::division::Input;
use crate::correct::projected::matrices::{LensConstants, ReprojectionMatrix};
use crate::intercept::gl::context::gl_context::Context;
use crate::intercept::gl::context::methods::tessellation_asked_for;
use crate::intercept::gl::projected_vertices::variants;
use crate::intercept::gl::state::draw::primitives::Shape;
use crate::intercept::gl::state::projected_vertices::fixed_function::Processor;
use crate::intercept::gl::state::shader::variants::{InUse, Kind, Variant};
use crate::runtime::session::Division;
use std::sync::Arc;

/// Returns the kinds of stages that divide the draw that is being issued, the best first. Points
/// need not be divided.
fn kinds(ctx: &Context) -> [Option<Kind>; 2] {
    let patch = ctx.draw.wide_primitives.patch.filter(|_| tessellation_asked_for());
    let input = match ctx.draw.wide_primitives.drawn {
        Shape::Triangles => Some(Input::Triangles),
        Shape::Lines => Some(Input::Lines),
        _ => None,
    };
    [patch.map(Kind::Tessellation), input.map(Kind::Geometry)]
}

/// A variant of the program that draws that divides what is drawn.
pub fn variant(ctx: &mut Context) -> Option<Arc<Variant>> {
    kinds(ctx).into_iter().flatten().find_map(|kind| variants::of(ctx, kind))
}

/// Puts a variant of the program that draws in use that divides what is drawn, for a view with
/// these rows and lens, unless nothing has to be divided or the processor does it. `division`: how
/// the view's primitives are divided.
pub fn begin(
    ctx: &mut Context,
    rows: &ReprojectionMatrix,
    lens: Option<&LensConstants>,
    division: Option<Division>,
) -> Option<(Arc<Variant>, InUse)> {
    let (lens, division) = (lens?, division?);
    if ctx.projected.fixed_function.processor == Processor::Divides {
        ctx.projected.fixed_function.view = Some((division, *rows));
        return None;
    }
    // Feedback records what the program's own stages make.
    if ctx.app.feedback {
        return None;
    }
    let variant = variant(ctx)?;
    let in_use = variant.begin(ctx, rows, lens);
    Some((variant, in_use))
}
