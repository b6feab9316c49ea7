//! The program's camera: defaults, and the one-line form of the command line and the environment.

use super::Camera;
use super::problems::closest;
use super::reader::Allowed;
use crate::error::{Error, ErrorKind, Result};
use glam::DVec3;

pub(super) const ZOOM: Allowed = Allowed::closed(1e-3, 1e3, "a factor on the size of what the program draws");
pub(super) const MOVE: Allowed =
    Allowed::closed(-1e9, 1e9, "[right, up, backward] in the program's own units, along its camera's axes");
const ANGLE: Allowed = Allowed::closed(-360.0, 360.0, "an angle in degrees");

impl Default for Camera {
    /// The program's camera as it is.
    fn default() -> Self {
        Self { zoom: 1.0, shift: DVec3::ZERO, units_per_meter: 1.0, yaw: 0.0, pitch: 0.0, roll: 0.0 }
    }
}

impl Camera {
    /// This camera with what `text` says replaced, in the form `zoom=4,move=0,0,-20,yaw=90`: keys of a
    /// rig file's `[camera]` in any order, degrees, each at most once; empty text changes nothing.
    ///
    /// # Errors
    /// [`ErrorKind::InvalidArgument`] for unknown or repeated keys and for numbers missing, unreadable or out of range.
    pub fn apply_override(&self, text: &str) -> Result<Self> {
        let mut camera = *self;
        let mut seen: Vec<&str> = Vec::new();
        for (key, numbers) in pairs(text)? {
            if seen.contains(&key) {
                return Err(wrong(text, format!("`{key}` stands there twice")));
            }
            seen.push(key);
            let one = |allowed| match numbers[..] {
                [number] => allowed_number(text, key, number, allowed),
                _ => Err(wrong(text, format!("`{key}` takes one number, not {}", numbers.len()))),
            };
            match key {
                "zoom" => camera.zoom = one(&ZOOM)?,
                "yaw" => camera.yaw = one(&ANGLE)?.to_radians(),
                "pitch" => camera.pitch = one(&ANGLE)?.to_radians(),
                "roll" => camera.roll = one(&ANGLE)?.to_radians(),
                "move" => {
                    let [x, y, z] = numbers[..] else {
                        return Err(wrong(text, format!("`move` takes three numbers, not {}", numbers.len())));
                    };
                    for number in [x, y, z] {
                        allowed_number(text, key, number, &MOVE)?;
                    }
                    camera.shift = DVec3::new(x, y, z);
                }
                _ => {
                    let known = ["zoom", "move", "yaw", "pitch", "roll"];
                    let hint = closest(key, &known).map_or_else(
                        || format!("possible are {}", known.join(", ")),
                        |meant| format!("did you mean `{meant}`?"),
                    );
                    return Err(wrong(text, format!("`{key}` is unknown; {hint}")));
                }
            }
        }
        Ok(camera)
    }
}

/// Splits `a=1,b=2,3` into keys and their numbers.
fn pairs(text: &str) -> Result<Vec<(&str, Vec<f64>)>> {
    let mut pairs: Vec<(&str, Vec<f64>)> = Vec::new();
    for part in text.split(',').map(str::trim) {
        if part.is_empty() && text.trim().is_empty() {
            continue;
        }
        let number = match part.split_once('=') {
            Some((key, number)) => {
                pairs.push((key.trim(), Vec::new()));
                number.trim()
            }
            None => part,
        };
        let value = number.parse().map_err(|_| wrong(text, format!("{number:?} is not a number")))?;
        match pairs.last_mut() {
            Some((_, numbers)) => numbers.push(value),
            None => return Err(wrong(text, format!("{part:?} has no key before it"))),
        }
    }
    Ok(pairs)
}

fn allowed_number(text: &str, key: &str, number: f64, allowed: &Allowed) -> Result<f64> {
    allowed.refuse(number).map_or(Ok(number), |why| Err(wrong(text, format!("`{key}`: {why}"))))
}

fn wrong(text: &str, why: String) -> Error {
    let message = format!("camera {text:?}: {why}; expected for example zoom=4,move=0,0,-20,yaw=90,pitch=0,roll=0");
    Error::new(ErrorKind::InvalidArgument, message)
}
