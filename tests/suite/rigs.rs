//! Numbers of a rig file for the reference, read without Cupola's own reader.

use crate::reference::{Dome, Opening, Projector, Turn, Vector};
use std::path::Path;
use toml::{Table, Value};

/// A rig of projectors for the reference, and the rig as files with and without blending.
pub struct ProjectorRig {
    pub dome: Dome,
    pub projectors: Vec<Projector>,
    /// The rig as TOML. Each output has the given size and place.
    pub blended: String,
    /// The same without any blending.
    pub unblended: String,
}

fn number(table: &Table, key: &str, default: f64) -> f64 {
    table.get(key).map_or(default, |value| as_number(value, key))
}

fn as_number(value: &Value, key: &str) -> f64 {
    value.as_float().or(value.as_integer().map(|integer| integer as f64)).unwrap_or_else(|| panic!("{key} is a number"))
}

fn numbers<const N: usize>(table: &Table, key: &str) -> Option<[f64; N]> {
    let values = table.get(key)?.as_array().unwrap_or_else(|| panic!("{key} is an array"));
    let values: Vec<f64> = values.iter().map(|value| as_number(value, key)).collect();
    Some(values.try_into().unwrap_or_else(|_| panic!("{key} has {N} numbers")))
}

fn turn(table: &Table) -> Turn {
    Turn { yaw: number(table, "yaw", 0.0), pitch: number(table, "pitch", 0.0), roll: number(table, "roll", 0.0) }
}

fn opening(output: &Table) -> Opening {
    if let Some(angles) = output.get("angles").and_then(Value::as_table) {
        let side = |key: &str| number(angles, key, f64::NAN).to_radians().tan();
        return Opening { left: side("left"), right: side("right"), bottom: side("bottom"), top: side("top") };
    }
    let [horizontal, vertical] = numbers::<2>(output, "fov").expect("a projector has fov or angles");
    let [right, up] = numbers::<2>(output, "shift").unwrap_or_default();
    let (half_width, half_height) = ((0.5 * horizontal.to_radians()).tan(), (0.5 * vertical.to_radians()).tan());
    Opening {
        left: half_width * (2.0 * right - 1.0),
        right: half_width * (2.0 * right + 1.0),
        bottom: half_height * (2.0 * up - 1.0),
        top: half_height * (2.0 * up + 1.0),
    }
}

/// Reads the file of a preset. Gives every output `size` and a place in a grid of `columns`.
pub fn projectors(preset: &str, size: (usize, usize), columns: usize) -> ProjectorRig {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("src/rig/presets/{preset}.toml"));
    let text = std::fs::read_to_string(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    let mut rig: Table = text.parse().unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    let empty = Table::new();
    let section = |name: &str| rig.get(name).and_then(Value::as_table).unwrap_or(&empty);
    let viewer: Vector = numbers(section("viewer"), "position").unwrap_or_default();
    assert_eq!(number(section("camera"), "zoom", 1.0), 1.0, "the reference knows no zoom");
    let dome = Dome {
        radius: number(section("dome"), "radius", 5.0),
        tilt: number(section("dome"), "tilt", 0.0),
        coverage: number(section("dome"), "coverage", 180.0),
        viewer,
        viewer_turn: turn(section("viewer")),
        camera_turn: turn(section("camera")),
    };
    let mut projectors = Vec::new();
    let outputs = rig.get_mut("output").and_then(Value::as_array_mut).expect("the preset has outputs");
    for (index, output) in outputs.iter_mut().enumerate() {
        let output = output.as_table_mut().expect("an output is a table");
        assert_eq!(output["kind"].as_str(), Some("projector"), "{preset} has projectors only");
        projectors.push(Projector {
            name: output["name"].as_str().expect("an output has a name").to_owned(),
            width: size.0 as f64,
            height: size.1 as f64,
            position: numbers(output, "position").unwrap_or_default(),
            turn: turn(output),
            opening: opening(output),
        });
        output.remove("size");
        let place = [index % columns * size.0, index / columns * size.1, size.0, size.1];
        output
            .insert("window".into(), Value::Array(place.iter().map(|&pixels| Value::Integer(pixels as i64)).collect()));
    }
    let blended = rig.to_string();
    let outputs = rig.get_mut("output").and_then(Value::as_array_mut).into_iter().flatten();
    for output in outputs.filter_map(Value::as_table_mut) {
        let mut blend = Table::new();
        blend.insert("overlap".into(), Value::Boolean(false));
        output.insert("blend".into(), Value::Table(blend));
    }
    ProjectorRig { dome, projectors, blended, unblended: rig.to_string() }
}
