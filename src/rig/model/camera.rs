//! The program's camera: defaults, and the one-line form of the command line and the environment.

use crate::error::Result;
use crate::rig::Camera;
use crate::rig::reading::allowed::Allowed;
use crate::rig::reading::one_line::OneLine;
use glam::DVec3;

pub(in crate::rig) const ZOOM: Allowed = Allowed::closed(1e-3, 1e3, "a factor on the size of what the program draws");
pub(in crate::rig) const MOVE: Allowed =
    Allowed::closed(-1e9, 1e9, "[right, up, backward] in the program's own units, along its camera's axes");
pub(in crate::rig) const LENS: Allowed =
    Allowed::closed(0.1, 179.0, "[horizontal, vertical] opening of the program's own lens in degrees");
pub(in crate::rig) const ANGLE: Allowed = Allowed::closed(-360.0, 360.0, "an angle in degrees");

impl Default for Camera {
    /// Leaves the program's camera as it is.
    fn default() -> Self {
        Self {
            zoom: 1.0,
            shift: DVec3::ZERO,
            units_per_meter: 1.0,
            yaw: 0.0,
            pitch: 0.0,
            roll: 0.0,
            lens: None,
            answer_wide: false,
        }
    }
}

impl Camera {
    /// Returns this camera with the values of `text` in place of its own. The form is
    /// `zoom=4,move=0,0,-20,yaw=90`: keys of a rig file's `[camera]` in any order, degrees, each at
    /// most once. Empty text changes nothing.
    ///
    /// # Errors
    /// [`ErrorKind::InvalidArgument`](crate::ErrorKind::InvalidArgument) for unknown or repeated
    /// keys and for numbers missing, unreadable or out of range.
    pub fn apply_override(&self, text: &str) -> Result<Self> {
        let mut camera = *self;
        let example = "zoom=4,move=0,0,-20,yaw=90,pitch=0,roll=0";
        let line = OneLine { what: "camera", example, text };
        for entry in line.entries()? {
            match entry.key {
                "zoom" => camera.zoom = entry.number(&ZOOM)?,
                "yaw" => camera.yaw = entry.number(&ANGLE)?.to_radians(),
                "pitch" => camera.pitch = entry.number(&ANGLE)?.to_radians(),
                "roll" => camera.roll = entry.number(&ANGLE)?.to_radians(),
                "move" => camera.shift = entry.vector(&MOVE)?,
                key => return Err(line.unknown(key, &["zoom", "move", "yaw", "pitch", "roll"])),
            }
        }
        Ok(camera)
    }
}
