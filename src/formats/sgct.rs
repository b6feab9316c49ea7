//! Configurations of SGCT (JSON): the computers of a cluster, their windows, and the contents of
//! the viewports.
//!
//! The geometry and the names of other files are read. SGCT's settings for synchronisation, buffers
//! and tracking are not. Its axes are those of Cupola: x right, y up, z backward; yaw to the right,
//! pitch up, roll clockwise.
//!
//! A window with `mirrorx` or `mirrory` is drawn without mirroring, as one picture. Then each
//! viewport's mesh, or its rectangle, is drawn at its usual place, but samples the mirrored place
//! *of the window*; each mask samples the mirrored place of its viewport. So a viewport shows the
//! picture of the viewport at its mirrored place (itself, if it is the only one). In a mesh only
//! the sampled places change.

use crate::error::Result;
use crate::formats::reading::input::{LONGEST_DOCUMENT, MOST_PIXELS_TOGETHER, Noted, invalid};
use crate::geom::{Frustum, pose};
use glam::{DMat3, DQuat, DVec3};
use serde_json::Value;
use std::f64::consts::{FRAC_PI_2, FRAC_PI_4};

/// Greatest number of computers, of a computer's windows, and of a computer's viewports: the same
/// as the outputs of a rig.
const MOST: usize = 64;
/// Greatest width and height of a viewport, pixels: the greatest texture of today's graphics
/// hardware.
const LARGEST: f64 = 16384.0;
/// Greatest angle of a side of a viewport's opening, degrees.
const WIDEST: f64 = 89.5;

/// Explains why a configuration has no viewports.
fn no_viewports(root: &Key) -> String {
    let windows = |node: &Value| node.get("windows").and_then(Value::as_array).cloned().unwrap_or_default();
    let nodes = root.value.get("nodes").and_then(Value::as_array);
    let mut windows = nodes.into_iter().flatten().flat_map(windows);
    match windows.find_map(|window| window.get("mpcdi").and_then(Value::as_str).map(str::to_owned)) {
        Some(file) => format!("takes its viewports from the archive {file}; convert that file itself"),
        None => "has no viewports; expected nodes[].windows[].viewports[]".to_owned(),
    }
}

/// A configuration.
#[derive(Clone, Debug, PartialEq)]
pub struct Config {
    /// Position of the eye point, metres.
    pub viewer: DVec3,
    /// Computers with their viewports.
    pub nodes: Vec<Node>,
}

/// A computer.
#[derive(Clone, Debug, PartialEq)]
pub struct Node {
    /// Address of the computer.
    pub address: String,
    /// Viewports, window by window.
    pub viewports: Vec<Viewport>,
}

/// A part of a window.
#[derive(Clone, Debug, PartialEq)]
pub struct Viewport {
    /// Rectangle on the desktop: x, y, width, height in pixels from the top left.
    pub place: [i64; 4],
    /// Content.
    pub projection: Projection,
    /// File of its warp mesh.
    pub mesh: Option<String>,
    /// File of its blend mask.
    pub mask: Option<String>,
    /// Eye to which it belongs, if it is for one eye.
    pub eye: Option<Eye>,
    /// Mirroring along x and along y: the picture and the mask are mirrored, the mesh samples
    /// mirrored places.
    pub mirrored: [bool; 2],
}

/// An eye.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Eye {
    /// Left eye.
    Left,
    /// Right eye.
    Right,
}

/// Content of a viewport.
#[derive(Clone, Debug, PartialEq)]
pub enum Projection {
    /// A flat picture seen from the eye point.
    Planar {
        /// Rotation from its axes to those of the configuration.
        rotation: DMat3,
        /// Opening of the picture.
        frustum: Frustum,
    },
    /// An equidistant fisheye picture around the eye point.
    Fisheye {
        /// Angle from rim to rim, radians.
        aperture: f64,
        /// Angle from straight up to the circle's centre, towards the front, radians.
        tilt: f64,
    },
    /// A picture for a spherical mirror: four faces of a cube, each through a warp mesh of its own.
    Mirror {
        /// Angle by which the cube is turned up less than 45°, radians.
        tilt: f64,
        /// Files of the meshes in the order in which they are drawn, later ones over earlier ones.
        meshes: [String; 4],
    },
    /// Another kind, with SGCT's name.
    Other(String),
}

/// Keys of a mirror's meshes in the order in which they are drawn. The face called bottom is the
/// one straight ahead, which a tilt of 0 turns up by 45°.
const MIRROR_MESHES: [&str; 4] = ["bottom", "left", "right", "top"];

/// Rotations from the axes of each of these faces to those of the configuration; a face is seen
/// along −z, 90° wide and high.
pub fn mirror_faces(tilt: f64) -> [DMat3; 4] {
    let up = DMat3::from_rotation_x(FRAC_PI_4 - tilt);
    let faces = [
        DMat3::IDENTITY,
        DMat3::from_rotation_y(FRAC_PI_2),
        DMat3::from_rotation_y(-FRAC_PI_2),
        DMat3::from_rotation_x(FRAC_PI_2),
    ];
    faces.map(|face| up * face)
}

/// Reads a configuration. `name` is the file's, for messages.
///
/// # Errors
/// [`InvalidRig`](crate::ErrorKind::InvalidRig) with the key and the reason.
pub fn read(name: &str, bytes: &[u8]) -> Result<Noted<Config>> {
    if bytes.len() > LONGEST_DOCUMENT {
        return Err(invalid(name, format!("is longer than {LONGEST_DOCUMENT} bytes, the limit for configurations")));
    }
    let root: Value =
        serde_json::from_slice(bytes).map_err(|error| invalid(name, format!("this is no JSON: {error}")))?;
    let root = Key { name, path: String::new(), value: &root };
    let mut notes = Vec::new();
    let users = root.list("users")?;
    if users.len() > 1 {
        notes.push(format!("{name}: only the first of {} users is taken", users.len()));
    }
    let viewer = match users.first().map(|user| user.optional("pos")) {
        Some(Some(position)) => position.vector()?,
        _ => DVec3::ZERO,
    };
    let mut nodes = Vec::new();
    let mut pixels = 0;
    for node in root.list("nodes")? {
        let address = node.optional("address").map(|address| address.text()).transpose()?.unwrap_or_default();
        let mut viewports = Vec::new();
        for window in node.list("windows")? {
            let of_window = viewports_of(&window, viewer, viewports.len(), &mut pixels)?;
            let flag = |name| window.optional(name).map_or(Ok(false), |flag| flag.truth());
            match [flag("mirrorx")?, flag("mirrory")?] {
                [false, false] => viewports.extend(of_window.into_iter().map(|(_, viewport)| viewport)),
                mirrored => viewports.extend(mirrored_viewports(&window, &of_window, mirrored, &mut notes)),
            }
        }
        nodes.push(Node { address, viewports });
    }
    if nodes.iter().all(|node| node.viewports.is_empty()) {
        return Err(match notes.is_empty() {
            true => invalid(name, no_viewports(&root)),
            false => invalid(name, format!("nothing of it can be shown: {}", notes.join("; "))),
        });
    }
    notes.extend(unread::line(root.value).map(|line| format!("{name}: {line}")));
    Ok(Noted { value: Config { viewer, nodes }, notes })
}

/// Reads the viewports of a window with their parts of it, after `before` others of the computer;
/// `pixels` counts the pixels of all.
fn viewports_of(window: &Key, viewer: DVec3, before: usize, pixels: &mut u64) -> Result<Vec<(Part, Viewport)>> {
    let position = window.optional("pos").map_or(Ok([0.0; 2]), |position| position.pair())?;
    let size = window.required("size")?.pair()?;
    let mut viewports = Vec::new();
    for key in window.list("viewports")? {
        let part = part(&key)?;
        let viewport = viewport(&key, part, position, size, viewer)?;
        let [_, _, width, height] = viewport.place;
        viewports.push((part, viewport));
        *pixels += width.unsigned_abs() * height.unsigned_abs();
        if before + viewports.len() > MOST || *pixels > MOST_PIXELS_TOGETHER {
            let most = format!("at most {MOST} for a computer, with {MOST_PIXELS_TOGETHER} pixels altogether");
            return Err(key.wrong(format!("is one viewport too many; expected {most}")));
        }
    }
    Ok(viewports)
}

/// Viewports of a mirrored window: each shows the picture at its mirrored place.
fn mirrored_viewports(
    window: &Key,
    of_window: &[(Part, Viewport)],
    mirrored: [bool; 2],
    notes: &mut Vec<String>,
) -> Vec<Viewport> {
    let mut viewports = Vec::new();
    for (number, (part, viewport)) in of_window.iter().enumerate() {
        let there = part.mirrored(mirrored);
        match of_window.iter().find(|(other, _)| other.is_at(&there)) {
            Some((_, shown)) => viewports.push(Viewport {
                projection: shown.projection.clone(),
                eye: shown.eye,
                mirrored,
                ..viewport.clone()
            }),
            None => notes.push(format!(
                "{}: {}.viewports[{number}] is left out: no viewport lies at its place in the mirrored window",
                window.name, window.path
            )),
        }
    }
    viewports
}

/// A part of a window, 0…1 from its bottom left.
#[derive(Clone, Copy)]
struct Part {
    low: [f64; 2],
    size: [f64; 2],
}

impl Part {
    fn mirrored(&self, along: [bool; 2]) -> Self {
        let low = |k: usize| if along[k] { 1.0 - self.low[k] - self.size[k] } else { self.low[k] };
        Self { low: [low(0), low(1)], size: self.size }
    }

    /// True if both are at the same place, within the precision of thirds as people write them.
    fn is_at(&self, other: &Self) -> bool {
        (0..2).all(|k| (self.low[k] - other.low[k]).abs() < 1e-3 && (self.size[k] - other.size[k]).abs() < 1e-3)
    }
}

/// Reads the rectangle of a viewport in its window.
fn part(key: &Key) -> Result<Part> {
    let low = key.optional("pos").map_or(Ok([0.0; 2]), |key| key.pair())?;
    let size = key.optional("size").map_or(Ok([1.0; 2]), |key| key.pair())?;
    Ok(Part { low, size })
}

/// Reads a viewport of a window at `position` with `size` pixels.
fn viewport(
    key: &Key,
    Part { low, size: part }: Part,
    position: [f64; 2],
    size: [f64; 2],
    viewer: DVec3,
) -> Result<Viewport> {
    let width = (part[0] * size[0]).round();
    let height = (part[1] * size[1]).round();
    let left = position[0] + (low[0] * size[0]).round();
    // Parts of a window count from its bottom, windows from the desktop's top.
    let top = position[1] + size[1] - (low[1] * size[1]).round() - height;
    let pixels = [left, top, width, height];
    let sized = |side: f64| (1.0..=LARGEST).contains(&side);
    if !(sized(width) && sized(height) && pixels.iter().all(|number| number.abs() <= 1e6)) {
        return Err(key.wrong("has a place that no screen has"));
    }
    let file = |what| key.optional(what).map(|file| file.text()).transpose();
    let eye = match file("eye")?.as_deref() {
        Some("left") => Some(Eye::Left),
        Some("right") => Some(Eye::Right),
        _ => None,
    };
    Ok(Viewport {
        place: pixels.map(|number| number as i64),
        projection: projection(&key.required("projection")?, viewer)?,
        mesh: file("mesh")?,
        mask: file("blendmask")?,
        eye,
        mirrored: [false; 2],
    })
}

fn projection(key: &Key, viewer: DVec3) -> Result<Projection> {
    let kind = key.required("type")?.text()?;
    Ok(match kind.as_str() {
        "PlanarProjection" => {
            let frustum = frustum(&key.required("fov")?)?;
            let rotation = key.optional("orientation").map_or(Ok(DMat3::IDENTITY), |key| orientation(&key))?;
            if key.optional("offset").map_or(Ok(DVec3::ZERO), |key| key.vector())? == DVec3::ZERO {
                Projection::Planar { rotation, frustum }
            } else {
                // The plane is moved and the eye is not, which changes the opening.
                let distance = key.optional("distance").map_or(Ok(10.0), |key| key.number(1e-6, 1e6))?;
                let offset = key.required("offset")?.vector()?;
                let corner = |x: f64, y: f64| rotation * (DVec3::new(x, y, -1.0) * distance) + offset;
                let (low, high) = ((frustum.left, frustum.bottom), (frustum.right, frustum.top));
                plane(key, [corner(low.0, low.1), corner(low.0, high.1), corner(high.0, high.1)])?
            }
        }
        "ProjectionPlane" => {
            let corner = |name| key.required(name).and_then(|key| key.vector()).map(|corner: DVec3| corner - viewer);
            plane(key, [corner("lowerleft")?, corner("upperleft")?, corner("upperright")?])?
        }
        "FisheyeProjection" => Projection::Fisheye {
            aperture: key.optional("fov").map_or(Ok(180.0), |key| key.number(1e-3, 360.0))?.to_radians(),
            tilt: key.optional("tilt").map_or(Ok(0.0), |key| key.number(-180.0, 180.0))?.to_radians(),
        },
        "SphericalMirrorProjection" => {
            let meshes = key.required("mesh")?;
            let file = |name| meshes.required(name).and_then(|file| file.text());
            let [ahead, left, right, top] = MIRROR_MESHES.map(file);
            Projection::Mirror {
                tilt: key.optional("tilt").map_or(Ok(0.0), |key| key.number(-180.0, 180.0))?.to_radians(),
                meshes: [ahead?, left?, right?, top?],
            }
        }
        _ => Projection::Other(kind),
    })
}

/// Flat picture in a rectangle, given by its lower left, upper left and upper right corner as seen
/// from the eye.
fn plane(key: &Key, [low, upper, right]: [DVec3; 3]) -> Result<Projection> {
    let flat = || key.wrong("its plane has no area or goes through the eye point");
    let x = (right - upper).try_normalize().ok_or_else(flat)?;
    let y = (upper - low).try_normalize().ok_or_else(flat)?;
    let z = x.cross(y).try_normalize().ok_or_else(flat)?;
    if x.dot(y).abs() > 1e-4 {
        return Err(key.wrong("its plane is no rectangle"));
    }
    let rotation = DMat3::from_cols(x, z.cross(x), z);
    let distance = -low.dot(z);
    if distance.is_nan() || distance <= 0.0 {
        return Err(flat());
    }
    let picture = |point: DVec3| rotation.transpose() * point / distance;
    let (low, high) = (picture(low), picture(right));
    let frustum = Frustum { left: low.x, right: high.x, bottom: low.y, top: high.y };
    Ok(Projection::Planar { rotation, frustum })
}

/// Reads an opening: whole angles, or the angles of the four sides. Each side's angle counts away
/// from the middle: `left` and `right` together are the field of view.
fn frustum(key: &Key) -> Result<Frustum> {
    let angle = |name| key.required(name)?.number(-WIDEST, WIDEST);
    let whole = |name| Ok(0.5 * key.required(name)?.number(1e-3, 2.0 * WIDEST)?);
    let [left, right, bottom, top] = if key.optional("hfov").is_some() {
        let (across, up) = (whole("hfov")?, whole("vfov")?);
        [-across, across, -up, up]
    } else {
        [-angle("left")?, angle("right")?, -angle("down")?, angle("up")?]
    };
    if !(left < right && bottom < top) {
        return Err(key.wrong(
            "left and right, or down and up, add up to no angle above 0; each counts away from the middle, so that \
             a picture around the middle has four positive angles",
        ));
    }
    let tangent = |degrees: f64| degrees.to_radians().tan();
    Ok(Frustum { left: tangent(left), right: tangent(right), bottom: tangent(bottom), top: tangent(top) })
}

/// Reads a rotation: three angles in degrees, or a quaternion.
fn orientation(key: &Key) -> Result<DMat3> {
    if key.optional("w").is_some() {
        let part = |name| key.required(name)?.number(-1e6, 1e6);
        let quaternion = DQuat::from_xyzw(part("x")?, part("y")?, part("z")?, part("w")?);
        if quaternion.length() < 1e-6 {
            return Err(key.wrong("is no turn: the quaternion's length is 0"));
        }
        return Ok(DMat3::from_quat(quaternion.normalize()));
    }
    let angle = |name| Ok::<_, crate::Error>(key.required(name)?.number(-360.0, 360.0)?.to_radians());
    Ok(pose::rotation(angle("yaw")?, angle("pitch")?, angle("roll")?))
}

/// A value of the file, and its path.
struct Key<'a> {
    name: &'a str,
    path: String,
    value: &'a Value,
}

impl<'a> Key<'a> {
    fn path_of(&self, key: &str) -> String {
        if self.path.is_empty() { key.to_owned() } else { format!("{}.{key}", self.path) }
    }

    fn wrong(&self, why: impl std::fmt::Display) -> crate::Error {
        invalid(&format!("{}: {}", self.name, self.path), why)
    }

    fn optional(&self, key: &str) -> Option<Self> {
        self.value.get(key).map(|value| Self { name: self.name, path: self.path_of(key), value })
    }

    fn required(&self, key: &str) -> Result<Self> {
        let missing = || invalid(self.name, format!("{} is missing", self.path_of(key)));
        self.optional(key).ok_or_else(missing)
    }

    /// Items of a list; none if it is absent.
    fn list(&self, key: &str) -> Result<Vec<Self>> {
        let Some(list) = self.optional(key) else { return Ok(Vec::new()) };
        let items = list.value.as_array().filter(|items| items.len() <= MOST);
        let items = items.ok_or_else(|| list.wrong(format!("is no list of at most {MOST} items")))?;
        let item = |(index, value)| Self { name: self.name, path: format!("{}[{index}]", list.path), value };
        Ok(items.iter().enumerate().map(item).collect())
    }

    fn text(&self) -> Result<String> {
        self.value.as_str().map(str::to_owned).ok_or_else(|| self.wrong("is no text"))
    }

    fn truth(&self) -> Result<bool> {
        self.value.as_bool().ok_or_else(|| self.wrong("is neither true nor false"))
    }

    fn number(&self, least: f64, greatest: f64) -> Result<f64> {
        let number = self.value.as_f64().filter(|number| (least..=greatest).contains(number));
        number.ok_or_else(|| self.wrong(format!("is no number from {least} to {greatest}")))
    }

    fn pair(&self) -> Result<[f64; 2]> {
        let part = |name| self.required(name)?.number(-1e6, 1e6);
        Ok([part("x")?, part("y")?])
    }

    fn vector(&self) -> Result<DVec3> {
        let part = |name| self.required(name)?.number(-1e6, 1e6);
        Ok(DVec3::new(part("x")?, part("y")?, part("z")?))
    }
}

mod unread;

#[cfg(test)]
mod tests;
