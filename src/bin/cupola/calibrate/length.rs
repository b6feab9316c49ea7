//! A measured length: angles and photographs do not determine the size of a dome.
//!
//! A factor on all lengths changes neither directions from the dome's centre nor photographs. So a
//! result that was solved with the radius of the rig becomes right by the factor of one length.

use super::Found;
use crate::failure::Failure;
use cupola::calibrate::Camera;
use cupola::rig::Rig;
use glam::DVec3;

/// Distance between two outputs, or between an output and the camera.
#[derive(Clone, Debug, PartialEq)]
pub struct Length {
    ends: [String; 2],
    metres: f64,
}

/// Name of the camera.
const CAMERA: &str = "camera";

/// Reads `FROM,TO,METRES`.
pub fn length(text: &str) -> Result<Length, String> {
    let expected = "expected two names of outputs and their distance in metres, for example left,right,3.25";
    let words: Vec<&str> = text.split(',').map(str::trim).collect();
    let [from, to, metres] = words[..] else { return Err(expected.to_owned()) };
    let metres = metres.parse::<f64>().ok().filter(|metres| metres.is_finite() && *metres > 0.0);
    let metres = metres.filter(|_| from != to).ok_or(expected)?;
    Ok(Length { ends: [from.to_owned(), to.to_owned()], metres })
}

impl Length {
    /// Multiplies all lengths of the result so that this one is right. Returns the radius of the
    /// dome.
    ///
    /// # Errors
    /// The rig contains known lengths, or an end was not solved.
    pub fn apply(&self, rig: &Rig, found: &mut [Found], camera: Option<&mut Camera>) -> Result<f64, Failure> {
        if rig.screen.is_some() {
            return Err(Failure::usage("--length finds the radius of a [dome]; this rig has a [screen] of its own"));
        }
        if let Some(found) = found.iter().find(|found| found.solved.optics.mirror.is_some()) {
            let name = &rig.outputs[found.output].name;
            return Err(Failure::usage(format!("--length: {name} has a mirror, whose radius is a known length")));
        }
        let place = |name: &String| -> Result<DVec3, Failure> {
            let own = found.iter().find(|found| rig.outputs[found.output].name == *name);
            let own = own.map(|found| found.solved.optics.pose.position);
            let seen_by = camera.as_ref().filter(|_| name == CAMERA).map(|camera| camera.pose.position);
            own.or(seen_by).ok_or_else(|| {
                Failure::usage(format!("--length: {name:?} is no output that was found, nor the {CAMERA}"))
            })
        };
        let (from, to) = (place(&self.ends[0])?, place(&self.ends[1])?);
        let solved = from.distance(to);
        if solved < 1e-6 * rig.dome.radius {
            return Err(Failure::usage("--length: both are at the same place"));
        }
        let factor = self.metres / solved;
        for found in found {
            found.solved.optics.pose.position *= factor;
            let quality = &mut found.solved.quality;
            quality.position *= factor;
            // Rows and columns of the position.
            for at in 0..3 {
                quality.covariance[at].iter_mut().for_each(|value| *value *= factor);
                quality.covariance.iter_mut().for_each(|row| row[at] *= factor);
            }
        }
        if let Some(camera) = camera {
            camera.pose.position *= factor;
        }
        Ok(factor * rig.dome.radius)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lengths_are_two_names_and_metres() {
        let read = length(" left, camera,3.5").expect("right");
        assert_eq!(read, Length { ends: ["left".into(), "camera".into()], metres: 3.5 });
        for wrong in ["", "left,right", "left,right,x", "left,right,-1", "left,left,1", "a,b,1,2", "a,b,nan"] {
            assert!(length(wrong).is_err(), "{wrong}");
        }
    }
}
