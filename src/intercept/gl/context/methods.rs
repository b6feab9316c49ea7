//! Methods that the outputs of the rig ask for.

use crate::error::Result;
use crate::intercept::gl::context::gl_context::Context;
use crate::intercept::{live, log};
use crate::rig::{Divider, Method, Rig};
use crate::runtime::session::{Extras, Session};

/// Function that plans a rig for a window: rig, size, outputs at their own resolution, greatest
/// texture, more tiles.
pub type Planner = fn(&Rig, (u32, u32), bool, u32, Extras) -> Result<Session>;

/// Returns the function that plans the windows of a context for `rig`. Shaders were patched for
/// lenses from the start, or never. The log tells which outputs lose their method.
pub fn planner(ctx: &Context, rig: &Rig) -> Planner {
    if !asked_for() && rig.outputs.iter().any(|output| output.method.projects_vertices()) {
        log::once(
            "vertices are projected after a new start: outputs that ask for it are made by method \"fragment\" instead",
        );
    }
    if asked_for() && !ctx.projected.views_only { Session::projecting } else { Session::new }
}

/// True if some output of the rig has a method of this kind.
pub(in crate::intercept::gl) fn any_method(wanted: impl Fn(&Method) -> bool) -> bool {
    let rig = crate::intercept::settings::settings().map(|settings| &settings.rig);
    rig.is_some_and(|rig| rig.outputs.iter().any(|output| wanted(&output.method)))
}

/// True if an output of the rig is one for which primitives are divided.
pub fn division_asked_for() -> bool {
    any_method(|method| matches!(method, Method::Primitive { .. }))
}

/// True if primitives are to be divided by tessellation shaders where possible, as the rig is now.
pub(in crate::intercept::gl) fn tessellation_asked_for() -> bool {
    let by = |method: &Method| matches!(method, Method::Primitive { by: Divider::Tessellation, .. });
    live::rig().is_some_and(|live| live.rig.outputs.iter().any(|output| by(&output.method)))
}

/// True if an output of the rig is one to which vertices are projected.
pub fn asked_for() -> bool {
    any_method(Method::projects_vertices)
}
