//! Scalable Display's EasyBlend meshes (`.ol`): text with a key on each line, then nodes, then
//! triangles.
//!
//! A node is `x y intensity s t`: x and y in pixels of the projector, the intensity 0…255 on
//! displayed values, s and t in the picture of a perspective camera that the file describes. The
//! file does not define the picture's orientation, and readers differ in it. Two orientations are
//! in use; s follows x in one, t in the other, which tells them apart.

use super::camera::Camera;
use super::grid::{Grid, MOST_NODES, Mesh, Node};
use crate::error::Result;
use crate::formats::reading::input::{Noted, checked_size, invalid};
use crate::formats::reading::text::{Lines, shown};
use crate::geom::Frustum;
use glam::{DMat3, DVec2, DVec3};

/// Known keys that do not change the result.
const WITHOUT_EFFECT: [&str; 10] = [
    "SUBVERSION",
    "LABEL",
    "FRUSTUM_EULER_ANGLES",
    "FRUSTUM_EULER_YAW",
    "FRUSTUM_EULER_PITCH",
    "FRUSTUM_EULER_ROLL",
    "APPLY_MASK",
    "APPLY_BLACK_LEVEL",
    "APPLY_COLOR",
    "USE_SPHERE_SAMPLE_COORDINATE_SYSTEM",
];
/// Greatest angle of a side of the camera's opening, degrees.
const WIDEST: f64 = 89.5;

/// Greatest number of lines with a note.
const MOST_NOTES: usize = 64;

/// A projector's mesh.
#[derive(Clone, Debug, PartialEq)]
pub struct EasyBlend {
    /// The projector's resolution.
    pub size: (u32, u32),
    /// Camera whose picture is shown, if the file describes it.
    pub camera: Option<Camera>,
    /// Mesh; values are (u, v, 0), parts of the camera's picture from the bottom left.
    pub grid: Grid,
}

/// Values of a file's keys.
#[derive(Default)]
struct Keys {
    vertices: Option<usize>,
    faces: Option<usize>,
    size: [Option<usize>; 2],
    /// Left, right, bottom, top.
    ortho: [Option<f64>; 4],
    /// Left, right, bottom, top, degrees.
    sides: [Option<f64>; 4],
    /// Yaw, pitch, roll, degrees.
    angles: [f64; 3],
    offset: [f64; 3],
}

/// Reads a mesh. `name` is the file's, for messages.
///
/// Notes name the picture's orientation, unknown keys, and parts that are not taken over.
///
/// # Errors
/// [`InvalidRig`](crate::ErrorKind::InvalidRig) with the line and the reason.
pub fn read(name: &str, bytes: &[u8]) -> Result<Noted<EasyBlend>> {
    let mut lines = Lines::new(name, bytes)?;
    let (mut keys, mut notes) = (Keys::default(), Vec::new());
    let (mut nodes, mut triangles) = (Vec::new(), Vec::new());
    let mut begun = false;
    while let Some(line) = lines.next() {
        let mut words = line.split_whitespace();
        let first = words.next().unwrap_or_default();
        let rest: Vec<&str> = words.collect();
        begun |= first == "OPENMESH";
        if !begun {
            return Err(lines.wrong(format!("{} begins no EasyBlend mesh; expected OPENMESH", shown(first))));
        }
        if first == "[" {
            triangles.push(triangle(&lines, &rest)?);
        } else if first.parse::<f64>().is_ok() {
            nodes.push(node(&lines, first, &rest)?);
        } else {
            notes.extend(keys.take(&lines, first, &rest)?.map(|note| format!("{name}: {note}")));
            if notes.len() > MOST_NOTES {
                return Err(lines.wrong("is one unknown key too many; expected an EasyBlend mesh"));
            }
        }
        if nodes.len() > MOST_NODES || triangles.len() > 3 * MOST_NODES {
            return Err(lines.wrong(format!("is one node or triangle too many; expected at most {MOST_NODES} nodes")));
        }
    }
    for (what, promised, found) in [("nodes", keys.vertices, nodes.len()), ("triangles", keys.faces, triangles.len())] {
        if promised != Some(found) {
            let promised = promised.map_or("no number of them".to_owned(), |number| number.to_string());
            return Err(invalid(name, format!("has {found} {what}, its header says {promised}")));
        }
    }
    let [Some(width), Some(height)] = keys.size else {
        return Err(invalid(name, "does not say the projector's resolution; expected NATIVEXRES and NATIVEYRES"));
    };
    let size = checked_size(name, width as u64, height as u64)?;
    let transposed = follows(&nodes, 4) > follows(&nodes, 3);
    notes.push(format!(
        "{name}: {}",
        if transposed {
            "t follows x: pictures are taken as (1 − t, 1 − s), with y from the bottom"
        } else {
            "s follows x: pictures are taken as (s, t), with y from the top"
        }
    ));
    let place = keys.placing(name, size)?;
    let placed = |[x, y, intensity, s, t]: [f64; 5]| {
        let at = place(x, y);
        let (position, value) = if transposed {
            (at, DVec3::new(1.0 - t, 1.0 - s, 0.0))
        } else {
            (DVec2::new(at.x, -at.y), DVec3::new(s, t, 0.0))
        };
        Node { position, value, intensity: (intensity / 255.0).clamp(0.0, 1.0) }
    };
    let mesh = Mesh::new(name, nodes.into_iter().map(placed).collect(), triangles)?;
    let camera = keys.camera(name)?;
    Ok(Noted { value: EasyBlend { size, camera, grid: Grid::Stretched(mesh) }, notes })
}

/// Reads `x y intensity s t`.
fn node(lines: &Lines, first: &str, rest: &[&str]) -> Result<[f64; 5]> {
    let what = "a node: x y intensity s t";
    let [y, intensity, s, t] = rest[..] else {
        return Err(lines.wrong(format!("has {} numbers; expected {what}", 1 + rest.len())));
    };
    let number = |word| lines.number(word, what);
    Ok([number(first)?, number(y)?, number(intensity)?, number(s)?, number(t)?])
}

/// Reads `a b c ]`, after the opening bracket.
fn triangle(lines: &Lines, rest: &[&str]) -> Result<[u32; 3]> {
    let [a, b, c, "]"] = rest[..] else {
        return Err(lines.wrong("is no triangle; expected [ node node node ]"));
    };
    let corner = |word| lines.count(word, "the number of a node", 0, MOST_NODES).map(|number| number as u32);
    Ok([corner(a)?, corner(b)?, corner(c)?])
}

/// Returns a measure of how closely a node's `number`-th value follows x: the square of their
/// covariance.
fn follows(nodes: &[[f64; 5]], number: usize) -> f64 {
    let count = nodes.len().max(1) as f64;
    let mean = |i: usize| nodes.iter().map(|node| node[i]).sum::<f64>() / count;
    let (x, other) = (mean(0), mean(number));
    nodes.iter().map(|node| (node[0] - x) * (node[number] - other)).sum::<f64>().powi(2)
}

impl Keys {
    /// Reads a line `key rest…`. Returns a note about it, if there is one.
    fn take(&mut self, lines: &Lines, key: &str, rest: &[&str]) -> Result<Option<String>> {
        let value = rest.first().copied().unwrap_or_default();
        let number = || lines.number(value, "a number");
        let count = |most| lines.count(value, "a number", 0, most);
        let side = |name: &str| ["LEFT", "RIGHT", "BOTTOM", "TOP"].iter().position(|side| *side == name);
        let expected = |expected: &str| {
            let said = rest.join(" ");
            (!said.eq_ignore_ascii_case(expected)).then(|| format!("{key} {said} was taken as {expected}"))
        };
        match key {
            "OPENMESH" => return Ok(expected("Version 1.1")),
            "MAPPING" => return Ok(expected("NORMALIZED")),
            "SAMPLING" => return Ok(expected("LINEAR")),
            "PROJECTION" => return Ok(expected("PERSPECTIVE")),
            "VERTICES" => self.vertices = Some(count(MOST_NODES)?),
            "FACES" => self.faces = Some(count(3 * MOST_NODES)?),
            "NATIVEXRES" => self.size[0] = Some(count(1 << 16)?),
            "NATIVEYRES" => self.size[1] = Some(count(1 << 16)?),
            "PERSPECTIVE_YAW" => self.angles[0] = number()?,
            "PERSPECTIVE_PITCH" => self.angles[1] = number()?,
            "PERSPECTIVE_ROLL" => self.angles[2] = number()?,
            "PERSPECTIVE_XOFFSET" => self.offset[0] = number()?,
            "PERSPECTIVE_YOFFSET" => self.offset[1] = number()?,
            "PERSPECTIVE_ZOFFSET" => self.offset[2] = number()?,
            "GAMMA" => return Ok(Some(format!("GAMMA {value} was not taken over; say it in the rig"))),
            "DO_NO_WARP" if value != "0" => {
                return Ok(Some("DO_NO_WARP was not followed: the mesh is read".to_owned()));
            }
            "DO_NO_WARP" => {}
            _ if WITHOUT_EFFECT.contains(&key) => {}
            _ => {
                let target = key.strip_prefix("ORTHO_").and_then(side).map(|side| &mut self.ortho[side]);
                let sides = &mut self.sides;
                match target.or_else(|| key.strip_prefix("PERSPECTIVE_").and_then(side).map(|side| &mut sides[side])) {
                    Some(target) => *target = Some(number()?),
                    None => return Ok(Some(format!("the key {} is not known and was left out", shown(key)))),
                }
            }
        }
        Ok(None)
    }

    /// Conversion from pixels to −1…1 over the output, by the file's flat projection.
    fn placing(&self, name: &str, size: (u32, u32)) -> Result<impl Fn(f64, f64) -> DVec2 + use<>> {
        let [left, right, bottom, top] = self.ortho;
        let low = DVec2::new(left.unwrap_or(0.0), bottom.unwrap_or(0.0));
        let high = DVec2::new(right.unwrap_or(1.0), top.unwrap_or(1.0));
        if !(high - low).abs().cmpgt(DVec2::splat(1e-9)).all() {
            return Err(invalid(name, "its flat projection (ORTHO_…) has no width or no height"));
        }
        let size = DVec2::new(f64::from(size.0), f64::from(size.1));
        Ok(move |x, y| 2.0 * (DVec2::new(x, y) / size - low) / (high - low) - 1.0)
    }

    /// Camera, if all four sides of its opening are given.
    fn camera(&self, name: &str) -> Result<Option<Camera>> {
        let [Some(left), Some(right), Some(bottom), Some(top)] = self.sides else { return Ok(None) };
        let usable = [left, right, bottom, top].iter().all(|side| side.abs() <= WIDEST) && left < right && bottom < top;
        if !usable {
            return Err(invalid(
                name,
                format!(
                    "its camera opens from {left}° to {right}° and from {bottom}° to {top}°; expected angles within ±{WIDEST}, left and bottom below right and top"
                ),
            ));
        }
        let tangent = |degrees: f64| degrees.to_radians().tan();
        let [yaw, pitch, roll] = self.angles.map(f64::to_radians);
        Ok(Some(Camera {
            offset: DVec3::from_array(self.offset),
            // Right-handed turns about x, then y, then z.
            rotation: DMat3::from_rotation_z(roll) * DMat3::from_rotation_y(yaw) * DMat3::from_rotation_x(pitch),
            frustum: Frustum { left: tangent(left), right: tangent(right), bottom: tangent(bottom), top: tangent(top) },
        }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two triangles over 200 × 100 pixels, with the words before the nodes and the nodes
    /// themselves.
    fn text(keys: &str, nodes: [&str; 4]) -> String {
        let nodes = nodes.join("\n");
        format!(
            "OPENMESH Version 1.1\nVERTICES 4\nFACES 2\nMAPPING NORMALIZED\nNATIVEXRES 200\nNATIVEYRES 100\n{keys}\n{nodes}\n[ 0 1 2 ]\n[ 0 2 3 ]\n"
        )
    }

    const STRAIGHT: [&str; 4] = ["0 0 255 0.1 0.8", "200 0 255 0.9 0.8", "200 100 51 0.9 0.2", "0 100 255 0.1 0.2"];
    const TRANSPOSED: [&str; 4] = ["0 0 255 0.8 0.9", "200 0 255 0.8 0.1", "200 100 51 0.2 0.1", "0 100 255 0.2 0.9"];

    #[test]
    fn both_orientations_show_an_upright_picture() {
        // The first orientation counts y from the top, the second from the bottom.
        for (nodes, note, top) in [(STRAIGHT, "s follows x", 0.8), (TRANSPOSED, "t follows x", 0.8)] {
            let mesh = read("a.ol", text("", nodes).as_bytes()).unwrap();
            assert!(mesh.notes.iter().any(|text| text.contains(note)), "{:?}", mesh.notes);
            let at = |x: f64, y: f64| mesh.value.grid.sample(DVec2::new(x, y), (200, 100)).unwrap();
            assert!(at(0.0, 0.0).value.distance(DVec3::new(0.1, top, 0.0)) < 1e-12, "{:?}", at(0.0, 0.0));
            assert!(at(200.0, 100.0).value.distance(DVec3::new(0.9, 0.2, 0.0)) < 1e-12);
            assert!(mesh.value.camera.is_none());
        }
        let dim = read("a.ol", text("", STRAIGHT).as_bytes()).unwrap().value.grid;
        assert_eq!(dim.sample(DVec2::new(200.0, 100.0), (200, 100)).unwrap().intensity, 0.2);
    }

    #[test]
    fn the_camera_is_read() {
        let keys = "PERSPECTIVE_LEFT -45\nPERSPECTIVE_RIGHT 45\nPERSPECTIVE_BOTTOM -30\nPERSPECTIVE_TOP 30\nPERSPECTIVE_YAW 90\nPERSPECTIVE_ZOFFSET 2";
        let camera = read("a.ol", text(keys, STRAIGHT).as_bytes()).unwrap().value.camera.unwrap();
        // A right-handed turn about y takes the front to the left.
        assert!(camera.ray(DVec2::splat(0.5)).distance(DVec3::NEG_X) < 1e-12);
        assert!(camera.ray(DVec2::new(1.0, 0.5)).distance(DVec3::new(-1.0, 0.0, -1.0)) < 1e-12);
        assert_eq!(camera.offset, DVec3::new(0.0, 0.0, 2.0));
    }

    #[test]
    fn damaged_files_are_refused() {
        let good = text("", STRAIGHT);
        for (text, why) in [
            ("VERTICES 4\n".to_owned(), "a.ol:1: \"VERTICES\" begins no"),
            (good.replace("VERTICES 4", "VERTICES 5"), "has 4 nodes, its header says 5"),
            (good.replace("FACES 2", "FACES 4294967296"), "a.ol:3"),
            (good.replace("NATIVEXRES 200\n", ""), "resolution"),
            (good.replace("[ 0 2 3 ]", "[ 0 2 4 ]"), "node 4"),
            (good.replace("[ 0 2 3 ]", "[ 0 2 3"), "is no triangle"),
            (good.replace("0.9 0.8", "nan 0.8"), "\"nan\""),
            (text("ORTHO_LEFT 1", STRAIGHT), "no width"),
            (
                text("PERSPECTIVE_LEFT 45\nPERSPECTIVE_RIGHT -45\nPERSPECTIVE_BOTTOM -1\nPERSPECTIVE_TOP 1", STRAIGHT),
                "opens from",
            ),
        ] {
            let message = read("a.ol", text.as_bytes()).unwrap_err().message;
            assert!(message.contains(why), "{message}");
        }
        let noted = read("a.ol", text("GAMMA 2.4\nSOMETHING 3", STRAIGHT).as_bytes()).unwrap().notes;
        assert!(noted[0].contains("GAMMA 2.4") && noted[1].contains("\"SOMETHING\""), "{noted:?}");
    }
}
