//! Matrices of the program that are functions of its camera. Each view has its own values of them.
//!
//! Some stages use the projection, or an inverse, in addition to the matrix of the position: for
//! positions from depth, screen-space effects, deferred lights and skies. The text of such a stage
//! gets a choice at each use of a matrix ([`text`]). Before a draw goes to a view ([`upload`]), the
//! matrices are compared with the lenses of the frame
//! ([`CameraFunction`](crate::geom::reprojection::CameraFunction)). Matrices that are functions of
//! a lens are replaced by their values for the view.
//!
//! Eye coordinates remain those of the program, as images of its scene and positions of its lights
//! may use them. A pass that samples no image of the scene gets the eye coordinates of the view, if
//! it has projection and view matrix separately
//! ([`eye_axes`](crate::geom::reprojection::eye_axes)).
//!
//! A vertex shader keeps the matrices of its position, which is re-projected. In draws of the scene
//! it keeps all others too, so that its outputs match its position.

pub mod text;
pub mod upload;

use crate::backend::gl::driver::api::Gl;
use crate::intercept::gl::shader::camera_matrices::text::Named;
use crate::intercept::gl::shader::uniforms;
use crate::intercept::gl::state::driver::profile::Profile;
use crate::intercept::gl::state::shader::camera_matrices::{CameraMatrices, MatrixStage, Substitute};
use crate::intercept::gl::state::shader::position_names::PositionNames;
use crate::intercept::gl::state::shader::uniforms::Uniforms;
use std::collections::HashMap;

/// Returns the matrices of a linked program whose stages can choose between the program's matrices
/// and those of Cupola, in this order.
pub fn of_program(gl: &Gl, profile: &Profile, program: u32, stages: &[(MatrixStage, Vec<Named>)]) -> CameraMatrices {
    let all: Vec<String> = stages.iter().flat_map(|(_, matrices)| matrices).map(|matrix| matrix.name.clone()).collect();
    let uniforms = uniforms_called(gl, profile, program, &all);
    let mut found = CameraMatrices { uniforms, ..Default::default() };
    for (stage, matrices) in stages {
        let ours = stage.names();
        for (number, Named { name, inverted }) in matrices.iter().enumerate() {
            let at = |array: &str| uniforms::location(gl, program, &format!("{array}[{number}]"));
            let (location, chosen_location) = (at(ours.matrices), at(ours.chosen));
            if let (Some(matrix), true) = (found.uniforms.number(name), location >= 0 && chosen_location >= 0) {
                found.substitutes.push(Substitute {
                    matrix,
                    stage: *stage,
                    inverted: *inverted,
                    location,
                    chosen_location,
                    function: None,
                    view_matrix: None,
                    of_views: Default::default(),
                    uploaded: None,
                    chosen: false,
                });
            }
        }
    }
    found
}

/// Reads the matrices again after the program may have bound blocks to other buffers.
pub fn read_again(gl: &Gl, profile: &Profile, program: u32, matrices: &mut CameraMatrices) {
    let names: Vec<String> = matrices.uniforms.names().map(str::to_owned).collect();
    matrices.uniforms = uniforms_called(gl, profile, program, &names);
    // Forces a new search for the functions.
    matrices.seen = None;
}

fn uniforms_called(gl: &Gl, profile: &Profile, program: u32, names: &[String]) -> Uniforms {
    let words = names.iter().map(|name| name.rsplit('.').next().unwrap_or(name).to_owned());
    let wanted = PositionNames::new(words.collect(), HashMap::new());
    uniforms::read(gl, profile, program, Some(&wanted)).0
}
