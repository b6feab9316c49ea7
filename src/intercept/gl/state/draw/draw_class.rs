//! What a draw is.

/// What of the program's state a draw changes that the next view's draw must see unchanged.
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

/// Where a draw belongs.
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
