//! `[dome]`: the screen.

use super::{OPENING, TILT};
use crate::rig::Dome;
use crate::rig::problems::Problems;
use crate::rig::reader::{Allowed, Section};

pub(super) fn dome(section: Option<Section>, problems: &mut Problems) -> Dome {
    let mut dome = Dome { radius: 5.0, tilt: 0.0, coverage: std::f64::consts::PI };
    let Some(mut section) = section else { return dome };
    dome.radius = section.number("radius", &Allowed::above(0.0, 1e6, "a radius in metres"), 5.0, problems);
    dome.tilt = section.number("tilt", &TILT, 0.0, problems).to_radians();
    dome.coverage = section.number("coverage", &OPENING, 180.0, problems).to_radians();
    section.finish(&[], problems);
    dome
}
