//! How the shaders of a device process vertices.

use crate::intercept::scene::obstacle::Obstacle;
use crate::rig::{Method, Rig};

/// Kind of vertex processing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum VertexProcessing {
    /// Vertices are reprojected to views.
    Views,
    /// Vertices can also be projected to the pictures of outputs.
    Projected,
    /// In addition, primitives between the vertices can be divided.
    Divided,
}

impl VertexProcessing {
    /// Returns the rig with methods that are served: the others become `fragment`.
    pub fn rig(self, rig: &Rig) -> Rig {
        match self {
            Self::Views => rig.with_views_for(Method::projects_vertices),
            Self::Projected => rig.with_views_for(Method::divides),
            Self::Divided => rig.clone(),
        }
    }
}

/// Vertex processing of a device's shaders, with reasons.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct VertexDecision {
    /// Kind of vertex processing.
    pub vertices: VertexProcessing,
    /// Reason why primitives are not divided; `None` if they are.
    pub undivided: Option<Obstacle>,
    /// True if the dividing stage can count primitives that it does not divide enough.
    pub counts: bool,
}
