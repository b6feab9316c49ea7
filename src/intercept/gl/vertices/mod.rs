//! Methods `vertex` and `primitive`: a view that is an output's own picture, to which the vertices of the program are
//! projected in its last stage before rasterisation.
//!
//! [`text`] is what that stage computes. For `primitive` there are [`variants`] of the program, which hand what [`interface`]
//! finds to a stage that divides ([`stage`]) and get the values of its uniforms ([`mirror`]). Where a program cannot be
//! served, [`fallback`] gives its window views.

pub mod counter;
pub mod fallback;
pub mod fixed;
pub mod interface;
pub mod mirror;
pub mod stage;
pub mod text;
pub mod variants;

use super::context::Context;
use super::outlines::Shape;
use crate::error::Result;
use crate::rig::Rig;
use crate::runtime::session::{Extras, Session};
use stage::Input;
use std::sync::Arc;
use variants::{InUse, Variant};

/// Whether primitives have to be divided for a view with this lens.
fn divides(lens: &[f32; 16]) -> bool {
    lens[13] > 0.0
}

/// What of the draw that is being issued can be divided; points need not be.
fn input(ctx: &Context) -> Option<Input> {
    match ctx.outlines.drawn {
        Shape::Triangles => Some(Input::Triangles),
        Shape::Lines => Some(Input::Lines),
        _ => None,
    }
}

/// Puts a variant of the program that draws in use that divides what is drawn, if a view with these rows and lens needs it.
pub fn begin(ctx: &mut Context, rows: &[f32; 16], lens: Option<&[f32; 16]>) -> Option<(Arc<Variant>, InUse)> {
    let lens = lens.filter(|lens| divides(lens))?;
    // Feedback records what the program's own stages make.
    let input = input(ctx).filter(|_| !ctx.feedback)?;
    let variant = variants::of(ctx, input)?;
    let in_use = variant.begin(ctx, rows, lens);
    Some((variant, in_use))
}

/// How a rig is planned for a window: rig, size, outputs at their own resolution, greatest texture, more tiles.
pub type Planner = fn(&Rig, (u32, u32), bool, u32, Extras) -> Result<Session>;

/// How windows of a context are planned: shaders were patched for lenses from the start, or never.
pub fn planner(ctx: &Context) -> Planner {
    if asked_for() && !ctx.views_only { Session::projecting } else { Session::new }
}

/// Whether an output of the rig is one to which vertices are projected.
pub fn asked_for() -> bool {
    let rig = crate::intercept::settings::settings().map(|settings| &settings.rig);
    rig.is_some_and(|rig| rig.outputs.iter().any(|output| output.method.projects_vertices()))
}
