//! Methods that the outputs of the rig ask for.

use crate::error::Result;
use crate::intercept::gl::state::projected_vertices::ProjectedVertices;
use crate::intercept::process::{live, log};
use crate::rig::{Divider, Method, Rig};
use crate::runtime::session::{Extras, Session};

/// Function that plans a rig for a window. Its parameters are the rig, the size of the window,
/// whether outputs are drawn at their own resolution, the greatest texture size, and the needs of
/// the program.
pub type Planner = fn(&Rig, (u32, u32), bool, u32, Extras) -> Result<Session>;

/// Returns the function that plans the windows of a context for `rig`. Shaders can be patched for
/// lenses only from the start of the program. The log says if outputs lose their method.
pub fn planner(projected: &ProjectedVertices, rig: &Rig) -> Planner {
    if !asked_for() && rig.outputs.iter().any(|output| output.method.projects_vertices()) {
        log::once(
            "vertices are projected after a new start: outputs that ask for it are made by method \"fragment\" instead",
        );
    }
    if asked_for() && !projected.views_only() { Session::projecting } else { Session::new }
}

/// True if `wanted` accepts the method of an output of the rig with which the program was started.
pub(in crate::intercept::gl) fn any_method(wanted: impl Fn(&Method) -> bool) -> bool {
    let rig = crate::intercept::process::settings::settings().map(|settings| &settings.rig);
    rig.is_some_and(|rig| rig.outputs.iter().any(|output| wanted(&output.method)))
}

/// True if the method of an output of the rig divides primitives.
pub fn division_asked_for() -> bool {
    any_method(|method| matches!(method, Method::Primitive { .. }))
}

/// True if the present rig asks for the division of primitives by tessellation shaders.
pub(in crate::intercept::gl) fn tessellation_asked_for() -> bool {
    let by = |method: &Method| matches!(method, Method::Primitive { by: Divider::Tessellation, .. });
    live::rig().is_some_and(|live| live.rig.outputs.iter().any(|output| by(&output.method)))
}

/// True if the method of an output of the rig projects vertices to the output.
pub fn asked_for() -> bool {
    any_method(Method::projects_vertices)
}
