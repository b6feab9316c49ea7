//! The rig file with the results: everything else and its comments stay.

use super::{Found, report};
use crate::failure::Failure;
use crate::tune;
use cupola::calibrate::Part;
use cupola::geom::{Lens, Optics, pose};
use cupola::rig::{self, Rig};
use glam::DVec2;
use std::path::{Path, PathBuf};
use toml_edit::{Array, DocumentMut, Item, TableLike, Value};

/// Beginning of this command's comments, which the next calibration replaces.
const MARK: &str = "# calibrated:";

/// Writes the rig called `name` with the results to `out`.
///
/// # Errors
/// The file cannot be written, or the rig would be refused; then nothing is changed.
pub fn write(
    name: &str,
    rig: &Rig,
    parts: &[Part],
    found: &[Found],
    radius: Option<f64>,
    light: &[Changes],
    out: &Path,
) -> Result<(), Failure> {
    let text = match rig::presets().iter().find(|preset| preset.name == name) {
        Some(preset) => preset.text.to_owned(),
        None => rig::text_of_file(Path::new(name)).map_err(|error| Failure::usage(format!("{name}: {error}")))?,
    };
    let mut document: DocumentMut = text.parse().map_err(|error| Failure::usage(format!("{name}: {error}")))?;
    for found in found {
        let output = &rig.outputs[found.output];
        for (path, value) in keys(&document, &output.name, &found.solved.optics, parts) {
            tune::outputs(&mut document, &output.name, &path, &value)
                .map_err(|why| Failure::usage(format!("{name}: {why}")))?;
        }
        if let Some(table) = output_mut(&mut document, &output.name) {
            comment(table, &report::summary(&found.solved.quality));
        }
    }
    let folder = |path: &Path| std::path::absolute(path).ok().and_then(|path| path.parent().map(PathBuf::from));
    if let (Some(from), Some(to)) = (folder(Path::new(name)), folder(out))
        && from != to
    {
        tune::name_files_absolutely(document.as_table_mut(), &from);
    }
    if let Some(radius) = radius {
        tune::set(document.as_table_mut(), &["dome", "radius"], &number(radius))
            .map_err(|why| Failure::usage(format!("{name}: {why}")))?;
    }
    // The files of the light are beside the new rig.
    for changes in light {
        if let Some(table) = output_mut(&mut document, &changes.name) {
            changes.removed.iter().for_each(|path| remove(table, path));
        }
        for (path, value) in &changes.keys {
            tune::outputs(&mut document, &changes.name, path, value)
                .map_err(|why| Failure::usage(format!("{name}: {why}")))?;
        }
    }
    let text = document.to_string();
    rig::parse(&text, &out.display().to_string(), out.parent().unwrap_or(Path::new(""))).map_err(|error| {
        Failure::new(format!("the result is not a valid rig; nothing was written\n{}", error.message))
    })?;
    tune::replace(out, &text).map_err(|error| Failure::new(format!("{} cannot be written: {error}", out.display())))
}

/// Changes of an output's keys.
pub struct Changes {
    /// Name of the output.
    pub name: String,
    /// Keys that are removed.
    pub removed: Vec<Vec<&'static str>>,
    /// Keys with their values.
    pub keys: Vec<(Vec<&'static str>, Value)>,
}

/// Removes a key if it is there.
fn remove(table: &mut dyn TableLike, path: &[&str]) {
    match path {
        [key] => drop(table.remove(key)),
        [key, rest @ ..] => {
            if let Some(inner) = table.get_mut(key).and_then(Item::as_table_like_mut) {
                remove(inner, rest);
            }
        }
        [] => {}
    }
}

/// Returns the changes that write the results to the rig `text`, in the form for `cupola tune`.
///
/// # Errors
/// The text is not TOML.
pub fn changes(text: &str, name: &str, optics: &Optics, parts: &[Part]) -> Result<Vec<String>, String> {
    let document: DocumentMut = text.parse().map_err(|error| format!("{error}"))?;
    let keys = keys(&document, name, optics, parts).into_iter();
    Ok(keys.map(|(path, value)| format!("output.{name}.{}={value}", path.join("."))).collect())
}

/// Table of an output, which is called `output-N` if it has no name.
fn output_mut<'a>(document: &'a mut DocumentMut, name: &str) -> Option<&'a mut toml_edit::Table> {
    let outputs = document.get_mut("output").and_then(Item::as_array_of_tables_mut)?;
    let own = |(index, output): &(usize, &mut toml_edit::Table)| {
        output.get("name").and_then(Item::as_str).map_or(name == format!("output-{}", index + 1), |own| own == name)
    };
    outputs.iter_mut().enumerate().find(own).map(|(_, output)| output)
}

/// Puts a comment before the position of an output, in place of an earlier one.
fn comment(table: &mut toml_edit::Table, text: &str) {
    let Some(mut key) = table.key_mut("position") else { return };
    let old = key.leaf_decor().prefix().and_then(|prefix| prefix.as_str()).unwrap_or_default();
    let mut kept: String = old.split_inclusive('\n').filter(|line| !line.trim_start().starts_with(MARK)).collect();
    kept += &format!("{MARK} {text}\n");
    key.leaf_decor_mut().set_prefix(kept);
}

/// Keys of a projector that were free, with their values.
fn keys(document: &DocumentMut, name: &str, optics: &Optics, parts: &[Part]) -> Vec<(Vec<&'static str>, Value)> {
    let mut keys = Vec::new();
    let mut add = |path: &[&'static str], value: Value| keys.push((path.to_vec(), value));
    let [yaw, pitch, roll] = pose::angles(&optics.pose.rotation).map(f64::to_degrees);
    add(&["position"], numbers(&optics.pose.position.to_array()));
    add(&["yaw"], number(yaw));
    add(&["pitch"], number(pitch));
    add(&["roll"], number(roll));
    let has = |part: Part| parts.contains(&part);
    match &optics.lens {
        Lens::Pinhole { frustum, distortion, .. } => {
            if (has(Part::Fov) || has(Part::Shift)) && has_angles(document, name) {
                let sides = [frustum.left, frustum.right, frustum.bottom, frustum.top];
                for (side, tangent) in ["left", "right", "bottom", "top"].into_iter().zip(sides) {
                    add(&["angles", side], number(tangent.atan().to_degrees()));
                }
            } else if has(Part::Fov) || has(Part::Shift) {
                let (width, height) = (frustum.width(), frustum.height());
                let (x, y) = frustum.middle();
                add(&["fov"], numbers(&[width, height].map(|side| 2.0 * (0.5 * side).atan().to_degrees())));
                add(&["shift"], numbers(&[x / width, y / height]));
            }
            if has(Part::Radial) {
                add(&["distortion", "radial"], numbers(&distortion.radial));
            }
            if has(Part::Tangential) {
                add(&["distortion", "tangential"], numbers(&distortion.tangential));
            }
        }
        Lens::Fisheye { circle, .. } if has(Part::Fov) || has(Part::Shift) => {
            // A placed circle does not depend on the aspect; an inscribed one has become a placed
            // one.
            let center = circle.to_picture(DVec2::ZERO, 1.0);
            add(&["fisheye", "size"], numbers(&(circle.to_picture(DVec2::ONE, 1.0) - center).to_array()));
            add(&["fisheye", "center"], numbers(&(0.5 * center).to_array()));
        }
        Lens::Fisheye { .. } => {}
    }
    if let Some(mirror) = optics.mirror.filter(|_| has(Part::Mirror)) {
        add(&["mirror", "center"], numbers(&mirror.center.to_array()));
        add(&["mirror", "radius"], number(mirror.radius));
    }
    keys
}

/// True if the rig gives the opening of an output by the angles of its sides.
fn has_angles(document: &DocumentMut, name: &str) -> bool {
    output_mut(&mut document.clone(), name).is_some_and(|table| TableLike::contains_key(table, "angles"))
}

/// Formats a number with nine decimal places: far below what can be measured.
pub fn number(value: f64) -> Value {
    Value::from((value * 1e9).round() / 1e9 + 0.0)
}

pub fn numbers(values: &[f64]) -> Value {
    Value::Array(values.iter().map(|value| number(*value)).collect::<Array>())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn comments_are_kept_and_the_own_one_is_replaced() {
        let text =
            "# mine\n[[output]]\nname = \"a.b\"\n# measured\nposition = [1, 2, 3] # metres\n\n[[output]]\nkind = 1\n";
        let mut document: DocumentMut = text.parse().expect("TOML");
        for words in ["first", "second"] {
            comment(output_mut(&mut document, "a.b").expect("there"), words);
        }
        let expected = text.replace("# measured\n", "# measured\n# calibrated: second\n");
        assert_eq!(document.to_string(), expected);
        assert!(output_mut(&mut document, "output-2").is_some() && output_mut(&mut document, "output-1").is_none());
    }
}
