//! Methods `vertex` and `primitive`: a view that is an output's own picture, to which the vertices of the program are
//! projected in its last stage before rasterisation.
//!
//! [`text`] is what that stage computes. Where a program cannot be served, [`fallback`] gives its window views.

pub mod fallback;
pub mod text;

/// Whether an output of the rig is one to which vertices are projected.
pub fn asked_for() -> bool {
    let rig = crate::intercept::settings::settings().map(|settings| &settings.rig);
    rig.is_some_and(|rig| rig.outputs.iter().any(|output| output.method.projects_vertices()))
}
