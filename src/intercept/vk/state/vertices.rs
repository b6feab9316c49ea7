//! What the shaders of a device do with vertices.

/// What the shaders of a device do with vertices.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Vertices {
    /// They re-project them to views.
    Views,
    /// They can project them to outputs' pictures, too.
    Projected,
    /// And divide what lies between them.
    Divided,
}

/// What a device is to do with vertices.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Decision {
    /// What it does.
    pub vertices: Vertices,
    /// Why it does not divide, for people.
    pub undivided: &'static str,
    /// What divides can count what it does not divide far enough.
    pub counts: bool,
}
