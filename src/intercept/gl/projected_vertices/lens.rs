//! Methods `vertex` and `primitive`: a view that is an output's own picture, to which the vertices of the program are
//! projected in its last stage before rasterisation.
//!
//! `correct::projection` is what that stage computes. For `primitive` there are [`variants`] of the program, which hand what [`interface`]
//! finds to a stage that divides ([`stage`]) and get the values of its uniforms ([`mirror`]). Where a program cannot be
//! served, [`fallback`] gives its window views.

use crate::error::Result;
use crate::intercept::gl::context::gl_context::Context;
use crate::intercept::gl::draw::wide_primitives::Shape;
use crate::intercept::gl::projected_vertices::fixed_function::substitute::Processor;
use crate::intercept::gl::projected_vertices::geometry_stage::Input;
use crate::intercept::gl::projected_vertices::variants::{self, InUse, Kind, Variant};
use crate::intercept::{live, log};
use crate::rig::{Divider, Method, Rig};
use crate::runtime::session::{Division, Extras, Session};
use std::sync::Arc;

/// Whether primitives have to be divided for a view with this lens.
pub(super) fn divides(lens: &[f32; 16]) -> bool {
    lens[13] > 0.0
}

/// What divides the draw that is being issued, the best first; points need not be divided.
fn kinds(ctx: &Context) -> [Option<Kind>; 2] {
    let patch = ctx.outlines.patch.filter(|_| tessellation_asked_for());
    let input = match ctx.outlines.drawn {
        Shape::Triangles => Some(Input::Triangles),
        Shape::Lines => Some(Input::Lines),
        _ => None,
    };
    [patch.map(Kind::Tessellation), input.map(Kind::Geometry)]
}

/// A variant of the program that draws that divides what is drawn.
pub(super) fn variant(ctx: &mut Context) -> Option<Arc<Variant>> {
    kinds(ctx).into_iter().flatten().find_map(|kind| variants::of(ctx, kind))
}

/// Puts a variant of the program that draws in use that divides what is drawn, for a view with these rows and lens, unless
/// nothing has to be divided or the processor does it. `division`: how the view's primitives are divided.
pub fn begin(
    ctx: &mut Context,
    rows: &[f32; 16],
    lens: Option<&[f32; 16]>,
    division: Option<Division>,
) -> Option<(Arc<Variant>, InUse)> {
    let (lens, division) = (lens?, division?);
    if ctx.fixed.processor == Processor::Divides {
        ctx.fixed.view = Some((division, *rows));
        return None;
    }
    // Feedback records what the program's own stages make.
    if ctx.feedback {
        return None;
    }
    let variant = variant(ctx)?;
    let in_use = variant.begin(ctx, rows, lens);
    Some((variant, in_use))
}

/// How a rig is planned for a window: rig, size, outputs at their own resolution, greatest texture, more tiles.
pub type Planner = fn(&Rig, (u32, u32), bool, u32, Extras) -> Result<Session>;

/// How windows of a context are planned for `rig`: shaders were patched for lenses from the start, or never. What outputs lose is
/// told.
pub fn planner(ctx: &Context, rig: &Rig) -> Planner {
    if !asked_for() && rig.outputs.iter().any(|output| output.method.projects_vertices()) {
        log::once(
            "vertices are projected after a new start: outputs that ask for it are made by method \"fragment\" instead",
        );
    }
    if asked_for() && !ctx.views_only { Session::projecting } else { Session::new }
}

/// Whether some output of the rig has a method of this kind.
fn any_method(wanted: impl Fn(&Method) -> bool) -> bool {
    let rig = crate::intercept::settings::settings().map(|settings| &settings.rig);
    rig.is_some_and(|rig| rig.outputs.iter().any(|output| wanted(&output.method)))
}

/// Whether an output of the rig is one for which primitives are divided.
pub fn division_asked_for() -> bool {
    any_method(|method| matches!(method, Method::Primitive { .. }))
}

/// Whether primitives are to be divided by tessellation shaders where possible, as the rig is now.
fn tessellation_asked_for() -> bool {
    let by = |method: &Method| matches!(method, Method::Primitive { by: Divider::Tessellation, .. });
    live::rig().is_some_and(|live| live.rig.outputs.iter().any(|output| by(&output.method)))
}

/// Whether an output of the rig is one to which vertices are projected.
pub fn asked_for() -> bool {
    any_method(Method::projects_vertices)
}
