//! Results in words and as JSON.

use super::Found;
use cupola::calibrate::{Camera, CameraLens, Quality, light};
use cupola::rig::Rig;
use serde_json::json;
use std::fmt::Write;
use std::path::Path;

/// Converts an angle to minutes of arc, for the text.
fn minutes(radians: f64) -> f64 {
    60.0 * radians.to_degrees()
}

/// One line about the residuals and standard errors of an output.
pub fn summary(quality: &Quality) -> String {
    let [x, y, z] = (1000.0 * quality.position).to_array();
    format!(
        "{} of {} marks, {:.3} px rms, {:.2}' on the dome; standard errors: position {x:.1}, {y:.1}, {z:.1} mm, \
         aim {:.2}', roll {:.2}', picture {:.3} px",
        quality.used.iter().filter(|used| **used).count(),
        quality.used.len(),
        quality.rms,
        minutes(quality.rms_angle),
        minutes(quality.aim.x.hypot(quality.aim.y)),
        minutes(quality.aim.z),
        quality.expected,
    )
}

/// Lines of marks that were left out, with their distances.
fn wrong(found: &Found) -> impl Iterator<Item = (usize, f64)> + '_ {
    let quality = &found.solved.quality;
    let marks = found.lines.iter().zip(&quality.distances).zip(&quality.used);
    marks.filter(|(_, used)| !**used).map(|((line, distance), _)| (*line, *distance))
}

/// Describes the result for an output.
pub fn words(rig: &Rig, found: &Found, marks: Option<&Path>) -> String {
    let marks = marks.unwrap_or(Path::new(""));
    let name = &rig.outputs[found.output].name;
    let mut words = format!("{name}: {}\n", summary(&found.solved.quality));
    for (line, distance) in wrong(found) {
        // Writing into a string cannot fail.
        let _ = writeln!(words, "  {}:{line}: left out, {distance:.1} px from where it should be", marks.display());
    }
    words
}

/// The results for all outputs as JSON; lengths in metres, angles in degrees.
pub fn json(
    rig: &Rig,
    found: &[Found],
    camera: Option<&Camera>,
    light: Option<&light::Found>,
    out: &Path,
) -> serde_json::Value {
    let outputs: Vec<_> = found
        .iter()
        .map(|found| {
            let quality = &found.solved.quality;
            let left_out: Vec<_> =
                wrong(found).map(|(line, pixels)| json!({ "line": line, "pixels": pixels })).collect();
            json!({
                "name": rig.outputs[found.output].name,
                "marks": quality.used.len(),
                "used": quality.used.iter().filter(|used| **used).count(),
                "left_out": left_out,
                "rms_pixels": quality.rms,
                "rms_arcmin": minutes(quality.rms_angle),
                "standard_errors": {
                    "position": quality.position.to_array(),
                    "aim": quality.aim.x.hypot(quality.aim.y).to_degrees(),
                    "roll": quality.aim.z.to_degrees(),
                    "picture_pixels": quality.expected,
                },
                // Position in metres, rotations about the right, up and backward axes in radians.
                "covariance": quality.covariance,
            })
        })
        .collect();
    let camera = camera.map(|camera| {
        json!({
            "lens": lens(camera),
            "position": camera.pose.position.to_array(),
            "focal_pixels": camera.focal,
            "center": camera.center.to_array(),
            "radial": camera.radial,
        })
    });
    let light = light.map(|light| {
        let lit = |lit: &light::Lit| {
            json!({ "name": rig.outputs[lit.output].name, "contrast": lit.contrast, "response": lit.response })
        };
        let outputs: Vec<_> = light.outputs.iter().map(lit).collect();
        json!({ "rms": light.rms, "brightest_to_darkest": light.range, "outputs": outputs })
    });
    json!({ "file": out.display().to_string(), "outputs": outputs, "camera": camera, "light": light })
}

fn lens(camera: &Camera) -> &'static str {
    match camera.lens {
        CameraLens::Fisheye => "fisheye",
        CameraLens::Pinhole => "pinhole",
    }
}

/// Describes the result for the camera.
pub fn camera_words(camera: &Camera) -> String {
    let [x, y, z] = camera.pose.position.to_array();
    format!(
        "camera: {} of {:.0} pixels focal length, axis at {:.1}, {:.1}, standing at {x:.3}, {y:.3}, {z:.3} m",
        lens(camera),
        camera.focal,
        camera.center.x,
        camera.center.y
    )
}

/// Describes the results about the light.
pub fn light_words(rig: &Rig, light: &light::Found) -> String {
    let mut words = format!(
        "light: brightest to darkest place {:.2}, now as the darkest; photographs differ from this by {:.2} % rms\n",
        light.range,
        100.0 * light.rms
    );
    for lit in &light.outputs {
        let contrast = lit
            .contrast
            .map_or("black too dark to be measured".to_owned(), |contrast| format!("contrast {contrast:.0}"));
        let half =
            lit.response.iter().find(|[value, _]| *value >= 0.5).map_or(0.0, |[value, light]| light.ln() / value.ln());
        // Writing into a string cannot fail.
        let _ = writeln!(words, "  {}: about gamma {half:.2}, {contrast}", rig.outputs[lit.output].name);
    }
    words
}
