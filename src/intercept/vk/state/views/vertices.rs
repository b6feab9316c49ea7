//! Work of a device's shaders on vertices.

/// Kind of work of a device's shaders on vertices.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum VertexProcessing {
    /// They re-project them to views.
    Views,
    /// They can project them to outputs' pictures, too.
    Projected,
    /// And divide what lies between them.
    Divided,
}

/// Work of a device's shaders on vertices.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct VertexDecision {
    /// The work.
    pub vertices: VertexProcessing,
    /// Reason why it does not divide, for messages.
    pub undivided: &'static str,
    /// The dividing stage can count primitives that it does not divide enough.
    pub counts: bool,
}
