//! Matrices of a program that may be functions of its camera.

use crate::backend::gl::driver::api::Gl;
use crate::intercept::gl::state::shader::uniforms::Uniforms;
use crate::intercept::gl::state::vertex_input::buffers::Buffers;
use crate::intercept::scene::camera::Cameras;
use crate::intercept::scene::eye::{self, Eye};
use crate::runtime::session::{CameraFunction, Direction, Intrinsics, ViewMatrix};
use glam::Mat4;

/// A shader stage whose matrices can be replaced in each view.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MatrixStage {
    /// The vertex shader, for values that do not become a position.
    Vertex,
    /// The fragment shader, or a compute shader.
    Fragment,
}

/// Names of Cupola's uniforms in a stage.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Names {
    /// Name of an array of matrices.
    pub matrices: &'static str,
    /// Name of an array of numbers: 1 if the matrix at this index is to be used.
    pub chosen: &'static str,
}

impl MatrixStage {
    /// All stages.
    pub const ALL: [Self; 2] = [Self::Vertex, Self::Fragment];

    /// Returns the names of Cupola's uniforms.
    pub const fn names(self) -> Names {
        match self {
            Self::Vertex => Names { matrices: "cupola_vertex_cameras", chosen: "cupola_vertex_chosen" },
            Self::Fragment => Names { matrices: "cupola_cameras", chosen: "cupola_chosen" },
        }
    }
}

/// 4×4 matrices of a program that do not flow into its position, or that its fragment shader names.
#[derive(Default)]
pub struct CameraMatrices {
    /// Their values.
    pub(in crate::intercept::gl) uniforms: Uniforms,
    pub(in crate::intercept::gl) substitutes: Vec<Substitute>,
    /// Lens of a projection matrix, or of its inverse, that shaders use beside a view matrix. True
    /// if these matrices are written for row vectors.
    pub(in crate::intercept::gl) eye: Option<(Intrinsics, bool)>,
    /// Numbers of changes of the values and of the cameras at the last search for functions.
    pub(in crate::intercept::gl) seen: Option<(u64, u64)>,
}

/// A matrix of a stage, and the matrix of Cupola that may replace it.
pub(in crate::intercept::gl) struct Substitute {
    /// Index of the matrix among the uniforms.
    pub(in crate::intercept::gl) matrix: usize,
    pub(in crate::intercept::gl) stage: MatrixStage,
    /// True if the shader computes the inverse of the matrix.
    pub(in crate::intercept::gl) inverted: bool,
    /// Location of Cupola's matrix.
    pub(in crate::intercept::gl) location: i32,
    /// Location of the uniform that chooses Cupola's matrix.
    pub(in crate::intercept::gl) chosen_location: i32,
    /// Function of a camera that gives the matrix, and the lens of that camera.
    pub(in crate::intercept::gl) function: Option<(CameraFunction, Intrinsics)>,
    /// Present if the matrix leads to or from the eye, according to its name.
    pub(in crate::intercept::gl) view_matrix: Option<ViewMatrix>,
    /// True if the eye is turned, and the matrix in each view, as far as it was computed.
    pub(in crate::intercept::gl) of_views: (bool, Vec<Option<Mat4>>),
    pub(in crate::intercept::gl) uploaded: Option<Mat4>,
    pub(in crate::intercept::gl) chosen: bool,
}

impl CameraMatrices {
    /// Determines which matrices are functions of the frame's cameras now. If the frame has no
    /// camera, a matrix may show one itself. Returns true if a matrix, or the inverse that the
    /// shader computes, leads from clip coordinates.
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
