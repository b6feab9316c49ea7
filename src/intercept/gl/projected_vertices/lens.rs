//! Methods `vertex` and `primitive`: a view is the picture of an output. The program's last stage
//! before rasterisation projects the vertices to it.
//!
//! `correct::projected::projection` has the text for that stage. For `primitive` there are
//! [`variants`] of the program. They pass the outputs of its shaders (`interface`) to a stage that
//! divides primitives (`geometry_stage`), and get the values of its uniforms (`mirror`). If a
//! program does not allow this, `fallback` makes its window use views.

use crate::correct::projected::division::Input;
use crate::correct::projected::matrices::{LensConstants, ReprojectionMatrix};
use crate::intercept::gl::context::gl_context::Context;
use crate::intercept::gl::context::methods::tessellation_asked_for;
use crate::intercept::gl::projected_vertices::variants;
use crate::intercept::gl::state::draw::DrawState;
use crate::intercept::gl::state::draw::primitives::Shape;
use crate::intercept::gl::state::projected_vertices::fixed_function::Processor;
use crate::intercept::gl::state::shader::variants::{InUse, Kind, Variant};
use crate::runtime::session::Division;
use std::sync::Arc;

/// Returns the kinds of stages that can divide the present draw, the best first. Points need no
/// division.
fn kinds(draw: &DrawState) -> [Option<Kind>; 2] {
    let patch = draw.patch().filter(|_| tessellation_asked_for());
    let input = match draw.drawn_shape() {
        Shape::Triangles => Some(Input::Triangles),
        Shape::Lines => Some(Input::Lines),
        _ => None,
    };
    [patch.map(Kind::Tessellation), input.map(Kind::Geometry)]
}

/// Returns a variant of the program in use that divides the primitives of the present draw.
pub fn variant(ctx: &mut Context) -> Option<Arc<Variant>> {
    kinds(&ctx.draw).into_iter().flatten().find_map(|kind| variants::of(ctx, kind))
}

/// Uses a variant of the program that divides the primitives of the present draw, for a view with
/// this reprojection matrix and lens. Does nothing if no division is needed or the processor divides. `division`:
/// how the view's primitives are divided.
pub fn begin(
    ctx: &mut Context,
    reprojection: &ReprojectionMatrix,
    lens: Option<&LensConstants>,
    division: Option<Division>,
) -> Option<(Arc<Variant>, InUse)> {
    let (lens, division) = (lens?, division?);
    if *ctx.projected.processor() == Processor::Divides {
        ctx.projected.divide_view(division, *reprojection);
        return None;
    }
    // Transform feedback must record the outputs of the program's own stages.
    if ctx.app.feedback() {
        return None;
    }
    let variant = variant(ctx)?;
    let in_use = variant.begin(ctx, reprojection, lens);
    Some((variant, in_use))
}
