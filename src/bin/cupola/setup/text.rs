//! Text of a first rig.

use super::places::{Place, Pose, Room};
use crate::convert::quoted;
use std::fmt::Write;

/// An output of the rig.
pub struct Output {
    /// Kind of the output.
    pub kind: Kind,
    /// Width and height in pixels.
    pub size: Option<(u32, u32)>,
    /// Rectangle in the program's window.
    pub window: Option<[i64; 4]>,
    /// Name of its monitor.
    pub monitor: Option<String>,
}

/// Kinds of outputs of a first rig.
pub enum Kind {
    /// A fisheye picture of the whole dome.
    Fisheye,
    /// A projector, with its description.
    Projector(Place, Pose),
}

/// The rig file.
pub fn rig(name: &str, room: &Room, outputs: &[Output]) -> String {
    let [x, y, z] = room.seat.map(rounded);
    let mut text = format!(
        "# Written by `cupola setup`. Metres and degrees; x is right, y up, z backward from the dome's centre.\n\
         name = {}\n\n[dome]\nradius = {}\ntilt = {} # from the zenith to the pole, towards the front\ncoverage = {}\n\n\
         [viewer]\nposition = [{x}, {y}, {z}]\n",
        quoted(name),
        rounded(room.radius),
        rounded(room.tilt),
        rounded(room.coverage)
    );
    for output in outputs {
        text.push_str("\n[[output]]\n");
        match &output.kind {
            Kind::Fisheye => {
                let _ = writeln!(text, "name = \"fisheye\"\nkind = \"domemaster\"");
            }
            Kind::Projector(place, pose) => text.push_str(&projector(place, pose, output.size)),
        }
        if let Some((width, height)) = output.size {
            let _ = writeln!(text, "size = [{width}, {height}]");
        }
        if let Some([x, y, width, height]) = output.window {
            let monitor =
                output.monitor.as_ref().map_or(String::new(), |name| format!(" # monitor {}", harmless(name)));
            let _ = writeln!(text, "window = [{x}, {y}, {width}, {height}]{monitor}");
        }
    }
    text
}

fn projector(place: &Place, pose: &Pose, size: Option<(u32, u32)>) -> String {
    let (width, height) = size.unwrap_or((16, 9));
    let across = place.fov.unwrap_or_default();
    let half = (across.to_radians() / 2.0).tan() * f64::from(height) / f64::from(width);
    let [x, y, z] = pose.position.to_array().map(rounded);
    format!(
        "name = {}\nkind = \"projector\"\nposition = [{x}, {y}, {z}]\nyaw = {}\npitch = {}\nfov = [{}, {}]\n",
        quoted(place.name.as_deref().unwrap_or_default()),
        rounded(pose.yaw),
        rounded(pose.pitch),
        rounded(across),
        rounded(2.0 * half.atan().to_degrees()),
    )
}

/// Rounds a number to three digits after the point: measures by hand are not finer than a
/// millimetre.
fn rounded(number: f64) -> String {
    let number = (number * 1000.0).round() / 1000.0;
    format!("{:?}", if number == 0.0 { 0.0 } else { number })
}

fn harmless(name: &str) -> String {
    name.chars().filter(|c| !c.is_control()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_short_and_have_no_negative_zero() {
        assert_eq!([rounded(-0.0001), rounded(4.0), rounded(-3.60049)], ["0.0", "4.0", "-3.6"]);
    }
}
