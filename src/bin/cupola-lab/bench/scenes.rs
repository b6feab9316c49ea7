//! The scenes that are measured.

use crate::failure::Failure;
use cupola::rig::{Rig, parse};
use std::path::Path;

/// A scene: the first output of a rig.
pub struct Scene {
    /// Name of the scene.
    pub name: &'static str,
    /// The rig. Its first output is corrected.
    pub rig: Rig,
    /// Size of the output in pixels.
    pub size: (u32, u32),
}

impl Scene {
    /// The name as a part of file names.
    pub fn file_name(&self) -> String {
        self.name.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '-' }).collect()
    }

    /// True if the picture is a circle.
    pub fn is_fisheye(&self) -> bool {
        matches!(self.rig.outputs[0].kind, cupola::rig::OutputKind::Domemaster { .. })
    }
}

const DOMEMASTER: &str = "[dome]\ntilt = 90.0\n[[output]]\nkind = \"domemaster\"\n";
const PROJECTOR: &str =
    "[dome]\ntilt = 90.0\n[[output]]\nkind = \"projector\"\nposition = [0.0, 0.0, 3.0]\nfov = [60.0, 40.0]\n";
const OFF_CENTRE: &str = "[dome]\ntilt = 90.0\n[viewer]\nposition = [1.0, -1.0, 1.5]\n[[output]]\nkind = \"projector\"\n\
     position = [-1.0, -2.0, 4.0]\nyaw = -5.0\npitch = 15.0\nfov = [60.0, 40.0]\n";
const BLENDED: &str = "[dome]\ntilt = 90.0\n[[output]]\nkind = \"projector\"\nposition = [0.0, 0.0, 3.0]\nfov = [60.0, 40.0]\n\
     [[output]]\nkind = \"projector\"\nposition = [0.0, 0.0, 3.0]\nyaw = 40.0\nfov = [60.0, 40.0]\n\
     [[output]]\nkind = \"projector\"\nposition = [0.0, 0.0, 3.0]\nyaw = -40.0\nfov = [60.0, 40.0]\n";

/// All scenes. `quick`: with a quarter of the pixels.
pub fn all(quick: bool) -> Result<Vec<Scene>, Failure> {
    let (square, wide) = if quick { ((1024, 1024), (960, 540)) } else { ((2048, 2048), (1920, 1080)) };
    [
        ("fisheye 180", DOMEMASTER, square),
        ("projector at 0.6 R", PROJECTOR, wide),
        ("viewer off the centre", OFF_CENTRE, wide),
        ("blended on both sides", BLENDED, wide),
    ]
    .into_iter()
    .map(|(name, text, size)| Ok(Scene { name, rig: parse(text, name, Path::new(""))?, size }))
    .collect()
}
