//! `[dome]`, and `[screen]` if the screen is another surface.

use super::{METRES, OPENING, TILT, angles};
use crate::formats;
use crate::geom::Pose;
use crate::geom::screen::{Cone, Ellipsoid, Faces, MOST_TRIANGLES, Mesh, MeshProblem, Plane, Region, Screen, Shape};
use crate::rig::Dome;
use crate::rig::reading::allowed::Allowed;
use crate::rig::reading::problems::Problems;
use crate::rig::reading::reader::Section;
use glam::{DVec2, DVec3};
use std::path::Path;
use std::sync::Arc;

pub(super) fn dome(section: Option<Section>, problems: &mut Problems) -> Dome {
    let mut dome = Dome { radius: 5.0, tilt: 0.0, coverage: std::f64::consts::PI };
    let Some(mut section) = section else { return dome };
    dome.radius = section.number("radius", &Allowed::above(0.0, 1e6, "a radius in metres"), 5.0, problems);
    dome.tilt = section.number("tilt", &TILT, 0.0, problems).to_radians();
    dome.coverage = section.number("coverage", &OPENING, 180.0, problems).to_radians();
    section.finish(&[], problems);
    dome
}

const RADIUS: Allowed = Allowed::above(0.0, 1e6, "a radius in metres");
const RADII: Allowed = Allowed::above(0.0, 1e6, "[x right, y up, z backward], half axes in metres");
const ENDS: Allowed = Allowed::closed(0.0, 1e6, "[bottom, top], radii in metres, at most one of them 0");
const HEIGHTS: Allowed = Allowed::closed(-1e6, 1e6, "[bottom, top] along the axis, metres, the bottom first");
const SIDES: Allowed = Allowed::above(0.0, 1e6, "[width, height] in metres");
const SCALE: Allowed = Allowed::above(0.0, 1e6, "metres in a unit of the file");
const AZIMUTH: Allowed = Allowed::closed(
    -360.0,
    360.0,
    "[from, to] in degrees around the axis, 0 = front, to the right, at most a whole turn",
);

/// Values of `shape`.
#[derive(Clone, Copy)]
enum Kind {
    Sphere,
    Ellipsoid,
    Cylinder,
    Cone,
    Plane,
    Mesh,
}

/// Keys that only some shapes have, with these shapes.
const KEYS_OF_SHAPES: [(&str, &str); 9] = [
    ("radius", "shape = \"sphere\" or \"cylinder\""),
    ("radii", "shape = \"ellipsoid\" or \"cone\""),
    ("coverage", "shape = \"sphere\" or \"ellipsoid\""),
    ("heights", "shape = \"cylinder\" or \"cone\""),
    ("azimuth", "curved shapes"),
    ("size", "shape = \"plane\""),
    ("file", "shape = \"mesh\""),
    ("scale", "shape = \"mesh\""),
    ("faces", "shape = \"mesh\""),
];

/// Reads `[screen]`; `None` if it is absent or cannot be used.
pub(super) fn screen(section: Option<Section>, directory: &Path, problems: &mut Problems) -> Option<Screen> {
    let mut section = section?;
    let kinds = [
        ("sphere", Kind::Sphere),
        ("ellipsoid", Kind::Ellipsoid),
        ("cylinder", Kind::Cylinder),
        ("cone", Kind::Cone),
        ("plane", Kind::Plane),
        ("mesh", Kind::Mesh),
    ];
    if !section.has("shape") {
        let expected =
            "is missing; expected shape = \"sphere\", \"ellipsoid\", \"cylinder\", \"cone\", \"plane\" or \"mesh\"";
        problems.add(&section.path("shape"), expected);
    }
    let kind = section.choice("shape", &kinds, problems)?;
    let position = section.vector("position", &METRES, problems);
    let [yaw, pitch, roll] = angles(&mut section, problems);
    let shape = match kind {
        Kind::Sphere => {
            let radius = section.required_number("radius", &RADIUS, problems);
            Some(Shape::Ellipsoid(Ellipsoid { radii: DVec3::splat(radius), region: region(&mut section, problems) }))
        }
        Kind::Ellipsoid => {
            let radii = required::<3>(&mut section, "radii", &RADII, "radii = [5.0, 4.0, 5.0]", problems);
            let region = region(&mut section, problems);
            radii.map(|radii| Shape::Ellipsoid(Ellipsoid { radii: DVec3::from_array(radii), region }))
        }
        Kind::Cylinder => {
            let radius = section.required_number("radius", &RADIUS, problems);
            cone(&mut section, Some([radius; 2]), problems)
        }
        Kind::Cone => {
            let radii = required::<2>(&mut section, "radii", &ENDS, "radii = [5.0, 2.0]", problems);
            if radii == Some([0.0; 2]) {
                problems.add(&section.path("radii"), "are both 0; expected at least one radius that is not");
            }
            cone(&mut section, radii, problems)
        }
        Kind::Plane => {
            let size = required::<2>(&mut section, "size", &SIDES, "size = [4.0, 2.25]", problems);
            size.map(|size| Shape::Plane(Plane { size: DVec2::from_array(size) }))
        }
        Kind::Mesh => mesh(&mut section, directory, problems).map(|mesh| Shape::Mesh(Arc::new(mesh))),
    };
    section.finish(&KEYS_OF_SHAPES, problems);
    shape.map(|shape| Screen { pose: Pose::new(position, yaw, pitch, roll), shape })
}

/// Reads numbers that must be present.
fn required<const COUNT: usize>(
    section: &mut Section,
    key: &'static str,
    allowed: &Allowed,
    example: &str,
    problems: &mut Problems,
) -> Option<[f64; COUNT]> {
    if !section.has(key) {
        problems.add(&section.path(key), format!("is missing; expected {example}, in metres"));
    }
    section.numbers(key, allowed, problems)
}

fn region(section: &mut Section, problems: &mut Problems) -> Region {
    let coverage = section.number("coverage", &OPENING, 360.0, problems).to_radians();
    Region { polar: 0.5 * coverage, azimuth: azimuth(section, problems) }
}

fn azimuth(section: &mut Section, problems: &mut Problems) -> Option<[f64; 2]> {
    let [from, to] = section.numbers("azimuth", &AZIMUTH, problems)?;
    if !(to > from && to - from <= 360.0) {
        let why = format!("[{from}, {to}] is not a range; expected [from, to] with from < to, at most 360 apart");
        problems.add(&section.path("azimuth"), why);
    }
    Some([from.to_radians(), to.to_radians()])
}

fn cone(section: &mut Section, radii: Option<[f64; 2]>, problems: &mut Problems) -> Option<Shape> {
    let heights = required::<2>(section, "heights", &HEIGHTS, "heights = [-1.0, 3.0]", problems);
    let azimuth = azimuth(section, problems);
    if let Some([bottom, top]) = heights
        && top <= bottom
    {
        problems.add(&section.path("heights"), format!("end at {top}, not above {bottom}; expected [bottom, top]"));
    }
    Some(Shape::Cone(Cone { heights: heights?, radii: radii?, azimuth }))
}

fn mesh(section: &mut Section, directory: &Path, problems: &mut Problems) -> Option<Mesh> {
    let scale = section.number("scale", &SCALE, 1.0, problems);
    let sides = [("front", Faces::Front), ("back", Faces::Back), ("both", Faces::Both)];
    let faces = section.choice_or("faces", &sides, Faces::Front, problems);
    let path = section.path("file");
    if !section.has("file") {
        problems.add(&path, "is missing; expected the name of a Wavefront OBJ file, relative to the rig file");
    }
    let file = section.text("file", "the name of a Wavefront OBJ file", problems)?;
    let file = directory.join(file);
    let read = formats::read_file(&file)
        .and_then(|bytes| formats::obj::read(&file.display().to_string(), &bytes, MOST_TRIANGLES));
    let triangles = match read {
        Ok(triangles) => triangles.into_iter().map(|corners| corners.map(|corner| corner * scale)).collect(),
        Err(error) => {
            problems.add(&path, error.to_string());
            return None;
        }
    };
    let problem = match Mesh::new(triangles, faces) {
        Ok(mesh) => return Some(mesh),
        Err(MeshProblem::NoSurface) => "has no triangle with an area; expected a model of the screen".to_owned(),
        Err(MeshProblem::Layers(layers)) => format!(
            "has too many triangles in one place: a ray through one of them has to be tested against {layers:.0}, on \
             average; expected a surface"
        ),
    };
    problems.add(&path, format!("{} {problem}", file.display()));
    None
}
