//! Changes of the viewer.

use crate::error::{Error, ErrorKind, Result};
use crate::rig::model::camera::ANGLE;
use crate::rig::reading::allowed::Allowed;
use crate::rig::reading::one_line::OneLine;
use crate::rig::reading::problems::Problems;
use crate::rig::{Rig, Viewer, validate};

const METRES: Allowed = Allowed::closed(-1e6, 1e6, "metres from the dome's centre");

impl Rig {
    /// Returns the same rig with the viewer's values in `text` in place of its own. The form is
    /// `position=0,-0.5,1,yaw=90`: keys of a rig file's `[viewer]` in any order, metres and
    /// degrees, each at most once. Empty text changes nothing.
    ///
    /// # Errors
    /// [`ErrorKind::InvalidArgument`] for unknown or repeated keys, for numbers missing, unreadable
    /// or out of range, and as [`Self::with_viewer`].
    pub fn with_viewer_override(&self, text: &str) -> Result<Self> {
        let mut viewer = self.viewer;
        let line = OneLine { what: "viewer", example: "position=0,-0.5,1,yaw=90,pitch=0,roll=0", text };
        for entry in line.entries()? {
            match entry.key {
                "position" => viewer.position = entry.vector(&METRES)?,
                "yaw" => viewer.yaw = entry.number(&ANGLE)?.to_radians(),
                "pitch" => viewer.pitch = entry.number(&ANGLE)?.to_radians(),
                "roll" => viewer.roll = entry.number(&ANGLE)?.to_radians(),
                key => return Err(line.unknown(key, &["position", "yaw", "pitch", "roll"])),
            }
        }
        self.with_viewer(viewer)
    }

    /// Returns the same rig with another viewer.
    ///
    /// # Errors
    /// [`ErrorKind::InvalidArgument`] for numbers that are not finite, and for a position from
    /// which the rig could not be shown: outside the dome, or next to the screen.
    pub fn with_viewer(&self, viewer: Viewer) -> Result<Self> {
        let Viewer { position, yaw, pitch, roll } = viewer;
        if !(position.is_finite() && [yaw, pitch, roll].iter().all(|angle| angle.is_finite())) {
            let message = format!("a viewer at {position}, turned by {yaw}, {pitch}, {roll}: expected finite numbers");
            return Err(Error::new(ErrorKind::InvalidArgument, message));
        }
        let moved = Self { viewer, ..self.clone() };
        let mut problems = Problems::new("");
        validate::check(&moved, &mut problems);
        match problems.is_empty() {
            true => Ok(moved),
            false => Err(Error::new(ErrorKind::InvalidArgument, problems.message(&self.name))),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;

    #[test]
    fn moves_within_the_dome_only() {
        let rig = crate::rig::load("planetarium-6").expect("a preset");
        let at = |x: f64| Viewer { position: DVec3::new(x, 0.5, 0.0), ..rig.viewer };
        let moved = rig.with_viewer(at(1.0)).expect("inside");
        assert_eq!((moved.viewer.position.x, &moved.outputs), (1.0, &rig.outputs));
        let refused = rig.with_viewer(at(10.0 * rig.dome.radius)).expect_err("outside");
        assert!(refused.message.contains("viewer.position"), "{refused}");
        let line = rig.with_viewer_override("position=1, 0.5,0 ,yaw=90").expect("inside").viewer;
        assert_eq!((line.position, line.yaw), (DVec3::new(1.0, 0.5, 0.0), std::f64::consts::FRAC_PI_2));
        assert_eq!(rig.with_viewer_override("").expect("nothing"), rig);
        for (text, word) in
            [("positon=0,0,0", "did you mean"), ("position=1", "three numbers"), ("position=0,99,0", "inside")]
        {
            let refused = rig.with_viewer_override(text).expect_err(text);
            assert!(refused.message.contains(word), "{refused}");
        }
        assert_eq!(rig.with_viewer(at(f64::NAN)).expect_err("no number").kind, ErrorKind::InvalidArgument);
    }
}
