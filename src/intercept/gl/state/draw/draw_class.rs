//! Class of a draw.

/// State of the program that a draw changes, and that the next view's draw must see unchanged.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Changes {
    /// Nothing.
    Nothing,
    /// State that each repetition sets in the same way, before its first vertex. Nothing has to be
    /// put back.
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
    Behind,
    /// A pass over the whole picture whose shader computes positions in the scene from pixels. It
    /// goes into each view unchanged, with the matrices of the view.
    Screen,
}
