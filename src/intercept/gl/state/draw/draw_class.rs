//! Class of a draw.

/// State of the program that a draw changes, and that the next view's draw must see unchanged.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Changes {
    /// Nothing.
    Nothing,
    /// State, in the same way each time and before the first vertex: nothing has to be put back.
    Alike,
    /// Current vertex attributes and material (Begin/End).
    Attributes,
    /// Anything that a display list may set.
    Anything,
}

/// Class of a draw, which decides its target.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DrawClass {
    /// The scene, with the fixed-function projection.
    FixedScene,
    /// The scene, with the camera of this index.
    Scene(usize),
    /// The flat panel.
    Flat,
    /// Flat, behind the scene.
    Background,
    /// A pass over the picture whose shader computes places of the scene from pixels: into each
    /// view as it is, with the matrices of the view.
    Screen,
}
