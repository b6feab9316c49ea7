//! Matrices of a program that may be functions of its camera.

use crate::backend::gl::driver::api::Gl;
use crate::intercept::camera::Cameras;
use crate::intercept::gl::state::shader::uniforms::Uniforms;
use crate::intercept::gl::state::vertex_input::buffers::Buffers;
use crate::intercept::scene::eye::{self, Eye};
use crate::runtime::session::{CameraFunction, Direction, Intrinsics, ViewMatrix};

/// A stage whose matrices are chosen.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MatrixStage {
    /// The vertex shader, where it computes what does not become a position.
    Vertex,
    /// The fragment shader, or a compute shader.
    Fragment,
}

/// Uniforms of Cupola in a stage.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Names {
    /// An array of matrices.
    pub matrices: &'static str,
    /// An array of numbers: 1 where the matrix is to be used.
    pub chosen: &'static str,
}

impl MatrixStage {
    /// Both.
    pub const ALL: [Self; 2] = [Self::Vertex, Self::Fragment];

    /// Names of our uniforms.
    pub const fn names(self) -> Names {
        match self {
            Self::Vertex => Names { matrices: "cupola_vertex_cameras", chosen: "cupola_vertex_chosen" },
            Self::Fragment => Names { matrices: "cupola_cameras", chosen: "cupola_chosen" },
        }
    }
}

/// 4×4 matrices that do not flow into the position of a program, or are named by its fragment
/// shader.
#[derive(Default)]
pub struct CameraMatrices {
    /// Their values.
    pub(in crate::intercept::gl) uniforms: Uniforms,
    pub(in crate::intercept::gl) substitutes: Vec<Substitute>,
    /// The lens of a projection alone, or of its inverse, that shaders use beside a view matrix,
    /// and whether these are written for row vectors.
    pub(in crate::intercept::gl) eye: Option<(Intrinsics, bool)>,
    /// The changes of the values and of the cameras when functions were last looked for.
    pub(in crate::intercept::gl) seen: Option<(u64, u64)>,
}

/// A matrix of a stage, and ours that may be in its place.
pub(in crate::intercept::gl) struct Substitute {
    /// Its number among the uniforms.
    pub(in crate::intercept::gl) matrix: usize,
    pub(in crate::intercept::gl) stage: MatrixStage,
    /// The shader computes its inverse.
    pub(in crate::intercept::gl) inverted: bool,
    /// Location of Cupola.
    pub(in crate::intercept::gl) location: i32,
    /// Location of the uniform that chooses ours.
    pub(in crate::intercept::gl) chosen_location: i32,
    /// Its dependence on a camera, and that camera.
    pub(in crate::intercept::gl) function: Option<(CameraFunction, Intrinsics)>,
    /// It leads to or from the eye, as its name says.
    pub(in crate::intercept::gl) view_matrix: Option<ViewMatrix>,
    /// True if the eye is turned, and the matrix in each view, as far as it was computed.
    pub(in crate::intercept::gl) of_views: (bool, Vec<Option<[f32; 16]>>),
    pub(in crate::intercept::gl) uploaded: Option<[f32; 16]>,
    pub(in crate::intercept::gl) chosen: bool,
}

impl CameraMatrices {
    /// Looks which matrices are functions of the frame's cameras now, or, where there is none, of
    /// one that they tell themselves. Whether one leads from clip coordinates, or its inverse does.
    pub fn recognise(&mut self, gl: &Gl, generation: u64, buffers: &Buffers, cameras: &Cameras) -> bool {
        self.uniforms.refresh(gl, generation, buffers);
        let now = (self.uniforms.changes(), cameras.changes());
        if self.seen != Some(now) {
            self.seen = Some(now);
            for substitute in &mut self.substitutes {
                let value = self.uniforms.value(substitute.matrix);
                substitute.of_views.1.clear();
                substitute.function = value.and_then(|value| cameras.function_of(value, substitute.inverted));
            }
            self.find_eye();
        }
        self.substitutes.iter().any(|substitute| {
            let function = substitute.function.map(|(function, _)| function);
            function.is_some_and(|function| substitute.inverted || function.direction() == Direction::FromClip)
        })
    }
}

impl CameraMatrices {
    /// Looks for projections beside view matrices.
    fn find_eye(&mut self) {
        let Self { uniforms, substitutes, eye, .. } = self;
        let values: Vec<_> = substitutes.iter().map(|known| uniforms.value(known.matrix).copied()).collect();
        let functions: Vec<_> = substitutes.iter().map(|known| known.function).collect();
        let called = |index: usize| uniforms.name(substitutes[index].matrix).and_then(eye::view_matrix_called);
        let found = Eye::of(&values, &functions, called);
        for (index, substitute) in substitutes.iter_mut().enumerate() {
            substitute.view_matrix = found.as_ref().and_then(|found| found.views[index]);
        }
        *eye = found.map(|found| (found.lens, found.transposed));
    }
}
