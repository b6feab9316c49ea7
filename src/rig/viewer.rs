//! A viewer who moves.

use super::problems::Problems;
use super::{Rig, Viewer, validate};
use crate::error::{Error, ErrorKind, Result};

impl Rig {
    /// The same rig with the viewer elsewhere.
    ///
    /// # Errors
    /// [`ErrorKind::InvalidArgument`] for numbers that are not finite, and for a place from which the rig could not be
    /// shown: outside the dome, or next to the screen.
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
        assert_eq!(rig.with_viewer(at(f64::NAN)).expect_err("no number").kind, ErrorKind::InvalidArgument);
    }
}
