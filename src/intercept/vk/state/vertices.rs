//! What the shaders of a device do with vertices.

/// What the shaders of a device do with vertices.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum VertexProcessing {
    /// They re-project them to views.
    Views,
    /// They can project them to outputs' pictures, too.
    Projected,
    /// And divide what lies between them.
    DivisionStatistics,
}

/// What a device is to do with vertices.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct VertexDecision {
    /// What it does.
    pub vertices: VertexProcessing,
    /// Why it does not divide, for people.
    pub undivided: &'static str,
    /// What divides can count what it does not divide far enough.
    pub counts: bool,
}
