//! Results in words and as JSON.

use super::Found;
use cupola::calibrate::{Camera, CameraLens, Quality, joint, light};
use cupola::rig::Rig;
use serde_json::json;
use std::fmt::Write;
use std::path::Path;

/// A mark beside photographs, with its line in the file of marks.
pub struct Fitted {
    pub line: usize,
    /// True for a place in the photographs, false for one in the picture of an output.
    pub in_photograph: bool,
    pub fitted: joint::Fitted,
}

/// Root mean square of the distances of the used marks in the photographs, pixels, and the numbers
/// of these marks and of all in the photographs.
fn in_photographs(marks: &[Fitted]) -> (f64, usize, usize) {
    let all = || marks.iter().filter(|mark| mark.in_photograph);
    let used = || all().filter(|mark| mark.fitted.used);
    let squares: f64 = used().map(|mark| mark.fitted.distance.powi(2)).sum();
    ((squares / used().count().max(1) as f64).sqrt(), used().count(), all().count())
}

/// Describes the marks beside photographs: how well they fit, and which were left out.
pub fn marks_words(marks: &[Fitted], file: Option<&Path>) -> String {
    let file = file.unwrap_or(Path::new("")).display();
    let (rms, used, all) = in_photographs(marks);
    let mut words = String::new();
    // Writing into a string cannot fail.
    if all > 0 {
        let _ = writeln!(words, "photographs: {used} of {all} marks, {rms:.3} px rms");
    }
    for mark in marks.iter().filter(|mark| !mark.fitted.used) {
        let _ = writeln!(words, "  {file}:{}: left out, {}", mark.line, away(mark.fitted.distance));
    }
    words
}

/// Describes the distance of a mark that was left out.
pub fn away(pixels: f64) -> String {
    match pixels.is_finite() {
        true => format!("{pixels:.1} px from where it should be"),
        false => "its direction is not in the picture".to_owned(),
    }
}

/// The marks beside photographs as JSON.
pub fn marks_json(marks: &[Fitted]) -> serde_json::Value {
    let (rms, used, all) = in_photographs(marks);
    let left_out = marks.iter().filter(|mark| !mark.fitted.used);
    let left_out = left_out.map(|mark| json!({ "line": mark.line, "pixels": mark.fitted.distance }));
    let left_out: Vec<_> = left_out.collect();
    json!({ "in_photographs": all, "used": used, "rms_pixels": rms, "left_out": left_out })
}

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

/// Lines of marks that were left out, with their distances. `lines` are those of all marks.
pub fn left_out<'a>(lines: &'a [usize], quality: &'a Quality) -> impl Iterator<Item = (usize, f64)> + 'a {
    let marks = lines.iter().zip(&quality.distances).zip(&quality.used);
    marks.filter(|(_, used)| !**used).map(|((line, distance), _)| (*line, *distance))
}

/// Describes the result for an output.
pub fn words(rig: &Rig, found: &Found, marks: Option<&Path>) -> String {
    let marks = marks.unwrap_or(Path::new(""));
    let name = &rig.outputs[found.output].name;
    let mut words = format!("{name}: {}\n", summary(&found.solved.quality));
    for (line, distance) in left_out(&found.lines, &found.solved.quality) {
        // Writing into a string cannot fail.
        let _ = writeln!(words, "  {}:{line}: left out, {}", marks.display(), away(distance));
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
            let left_out: Vec<_> = self::left_out(&found.lines, quality)
                .map(|(line, pixels)| json!({ "line": line, "pixels": pixels }))
                .collect();
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
