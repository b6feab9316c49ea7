//! The keys of a rig file: what each is called, its range and its default. Degrees become radians here.

use super::problems::Problems;
use super::reader::{Allowed, Section};
use super::{AngleRamp, Blend, Camera, Dome, DomeAngle, Output, OutputKind, Overlay, Rig, ViewMethod, Viewer, Views};
use crate::geom::Frustum;
use glam::DVec3;
use std::path::{Path, PathBuf};
use toml::de::DeTable;

/// Greatest width and height of a picture in pixels: the greatest texture of today's graphics hardware.
const LARGEST_PICTURE: u32 = 16384;
/// Greatest coordinate in a window: the X protocol's.
const LARGEST_WINDOW: u32 = 32767;
/// Widest opening of a pinhole in degrees; at 180° its picture would be infinitely large.
const WIDEST_PINHOLE: f64 = 179.0;

const YAW: Allowed = Allowed::closed(-360.0, 360.0, "an angle in degrees, to the right");
const PITCH: Allowed = Allowed::closed(-180.0, 180.0, "an angle in degrees, upwards");
const ROLL: Allowed = Allowed::closed(-360.0, 360.0, "an angle in degrees, clockwise");
const TILT: Allowed = Allowed::closed(-180.0, 180.0, "an angle in degrees, 0 = zenith up, 90 = pole straight ahead");
const OPENING: Allowed = Allowed::above(0.0, 360.0, "a whole opening angle in degrees");
const METRES: Allowed = Allowed::closed(-1e6, 1e6, "[x right, y up, z backward] in metres from the dome's centre");
const FIELD_OF_VIEW: Allowed = Allowed::closed(
    0.01,
    WIDEST_PINHOLE,
    "[horizontal, vertical] opening in degrees (a pinhole stays below 180; kind = \"domemaster\" shows more)",
);
const SIDE: Allowed = Allowed::closed(
    -WIDEST_PINHOLE / 2.0,
    WIDEST_PINHOLE / 2.0,
    "an angle in degrees from the lens axis, negative to the left and below",
);
const SHIFT: Allowed =
    Allowed::closed(-2.0, 2.0, "[right, up] as parts of the picture's width and height (0.5 = half a picture)");

/// Where the keys of one kind of output belong, for those who give them to another kind.
const KINDS_OF_KEYS: [(&str, &str); 6] = [
    ("aperture", "kind = \"domemaster\""),
    ("tilt", "kind = \"domemaster\" (and to [dome])"),
    ("position", "kind = \"projector\" (and to [viewer])"),
    ("shift", "kind = \"projector\" or \"perspective\", beside fov"),
    ("fov", "kind = \"projector\" or \"perspective\""),
    ("lens", "kind = \"perspective\""),
];

/// Reads the rig in `text`. `None` if it is no TOML at all; otherwise it is usable only if no problem was added.
pub(super) fn read(text: &str, file_name: &str, directory: &Path, problems: &mut Problems) -> Option<Rig> {
    let table = match DeTable::parse(text) {
        Ok(table) => table,
        Err(error) => {
            problems.add_at(error.span(), format!("this is not TOML: {}", error.message().replace('\n', ", ")));
            return None;
        }
    };
    let mut root = Section::new(table.get_ref(), String::new());
    let stem = Path::new(file_name).file_stem().map_or_else(|| file_name.into(), |stem| stem.to_string_lossy());
    let name = root.text("name", "the rig's name", problems).unwrap_or(&stem).to_owned();
    let passthrough = root.boolean("passthrough", false, problems);
    let dome = dome(root.section("dome", problems), problems);
    let viewer = viewer(root.section("viewer", problems), problems);
    let camera = camera(root.section("camera", problems), problems);
    let views = views(root.section("views", problems), problems);
    let overlay = overlay(root.section("overlay", problems), problems);
    let outputs = root
        .sections("output", "[[output]] with double brackets", problems)
        .into_iter()
        .enumerate()
        .filter_map(|(index, section)| output(section, index, &dome, directory, problems))
        .collect();
    root.finish(&[("outputs", "the file as [[output]], one for each output")], problems);
    Some(Rig { name, passthrough, dome, viewer, camera, views, overlay, outputs })
}

/// Reads yaw, pitch and roll into radians.
fn angles(section: &mut Section, problems: &mut Problems) -> [f64; 3] {
    [("yaw", &YAW), ("pitch", &PITCH), ("roll", &ROLL)]
        .map(|(key, allowed)| section.number(key, allowed, 0.0, problems).to_radians())
}

fn dome(section: Option<Section>, problems: &mut Problems) -> Dome {
    let mut dome = Dome { radius: 5.0, tilt: 0.0, coverage: std::f64::consts::PI };
    let Some(mut section) = section else { return dome };
    dome.radius = section.number("radius", &Allowed::above(0.0, 1e6, "a radius in metres"), 5.0, problems);
    dome.tilt = section.number("tilt", &TILT, 0.0, problems).to_radians();
    dome.coverage = section.number("coverage", &OPENING, 180.0, problems).to_radians();
    section.finish(&[], problems);
    dome
}

fn viewer(section: Option<Section>, problems: &mut Problems) -> Viewer {
    let mut viewer = Viewer { position: DVec3::ZERO, yaw: 0.0, pitch: 0.0, roll: 0.0 };
    let Some(mut section) = section else { return viewer };
    viewer.position = section.vector("position", &METRES, problems);
    [viewer.yaw, viewer.pitch, viewer.roll] = angles(&mut section, problems);
    section.finish(&[], problems);
    viewer
}

fn camera(section: Option<Section>, problems: &mut Problems) -> Camera {
    let mut camera = Camera::default();
    let Some(mut section) = section else { return camera };
    camera.zoom = section.number("zoom", &super::camera::ZOOM, 1.0, problems);
    camera.shift = section.vector("move", &super::camera::MOVE, problems);
    [camera.yaw, camera.pitch, camera.roll] = angles(&mut section, problems);
    section.finish(&[("position", "[viewer]; the program's camera has `move`")], problems);
    camera
}

fn views(section: Option<Section>, problems: &mut Problems) -> Views {
    let mut views = Views { method: ViewMethod::Auto, quality: 1.0 };
    let Some(mut section) = section else { return views };
    let methods = [("auto", ViewMethod::Auto), ("cube", ViewMethod::Cube), ("single", ViewMethod::Single)];
    views.method = section.choice("method", &methods, problems).unwrap_or(ViewMethod::Auto);
    let allowed = Allowed::closed(0.1, 8.0, "a factor on the views' resolution");
    views.quality = section.number("quality", &allowed, 1.0, problems);
    section.finish(&[], problems);
    views
}

fn overlay(section: Option<Section>, problems: &mut Problems) -> Overlay {
    let mut overlay = Overlay { yaw: 0.0, pitch: 0.0, width: 60_f64.to_radians() };
    let Some(mut section) = section else { return overlay };
    overlay.yaw = section.number("yaw", &YAW, 0.0, problems).to_radians();
    overlay.pitch = section.number("pitch", &PITCH, 0.0, problems).to_radians();
    let allowed = Allowed::between(0.0, 180.0, "the angle in degrees that a window's width fills");
    overlay.width = section.number("width", &allowed, 60.0, problems).to_radians();
    section.finish(&[], problems);
    overlay
}

/// What `kind` says.
#[derive(Clone, Copy, PartialEq)]
enum Kind {
    Domemaster,
    Projector,
    Perspective,
}

fn output(
    mut section: Section,
    index: usize,
    dome: &Dome,
    directory: &Path,
    problems: &mut Problems,
) -> Option<Output> {
    let kinds = [("domemaster", Kind::Domemaster), ("projector", Kind::Projector), ("perspective", Kind::Perspective)];
    if !section.has("kind") {
        let path = section.path("kind");
        problems.add(&path, "is missing; expected kind = \"domemaster\", \"projector\" or \"perspective\"");
    }
    let kind = section.choice("kind", &kinds, problems)?;
    let name =
        section.text("name", "the output's name", problems).map_or(format!("output-{}", index + 1), str::to_owned);
    let sides = [(1, LARGEST_PICTURE); 2];
    let size =
        section.pixels("size", sides, "[width, height] in pixels", problems).map(|[width, height]| (width, height));
    let places = [(0, LARGEST_WINDOW), (0, LARGEST_WINDOW), (1, LARGEST_PICTURE), (1, LARGEST_PICTURE)];
    let window =
        section.pixels("window", places, "[x, y, width, height] in pixels from the window's top left", problems);
    let output_kind = match kind {
        Kind::Domemaster => Some(OutputKind::Domemaster {
            aperture: section.number("aperture", &OPENING, dome.coverage.to_degrees(), problems).to_radians(),
            tilt: section.number("tilt", &TILT, dome.tilt.to_degrees(), problems).to_radians(),
        }),
        Kind::Projector => {
            let position = section.vector("position", &METRES, problems);
            let angles = angles(&mut section, problems);
            frustum(&mut section, problems).map(|frustum| OutputKind::Projector { position, angles, frustum })
        }
        Kind::Perspective => {
            let angles = angles(&mut section, problems);
            perspective_frustum(&mut section, problems).map(|frustum| OutputKind::Perspective { angles, frustum })
        }
    };
    let blend = blend(section.section("blend", problems), kind, problems);
    let mask = mask(section.section("mask", problems), directory, problems);
    section.finish(&KINDS_OF_KEYS, problems);
    output_kind.map(|kind| Output { name, kind, size, window, blend, mask })
}

/// The opening of a perspective output; `Some(None)` = the program's own.
fn perspective_frustum(section: &mut Section, problems: &mut Problems) -> Option<Option<Frustum>> {
    if !section.has("lens") {
        return frustum(section, problems).map(Some);
    }
    section.choice("lens", &[("program", ())], problems)?;
    let own: Vec<&str> = ["fov", "angles", "shift"].into_iter().filter(|key| section.has(key)).collect();
    if own.is_empty() {
        return Some(None);
    }
    let why = format!("the program's lens has its own opening; leave out either `lens` or {}", own.join(", "));
    problems.add(&section.path("lens"), why);
    frustum(section, problems).map(Some)
}

/// The opening of a pinhole, from `fov` and `shift` or from `angles`.
fn frustum(section: &mut Section, problems: &mut Problems) -> Option<Frustum> {
    let fov = section.numbers::<2>("fov", &FIELD_OF_VIEW, problems);
    let shift = section.numbers::<2>("shift", &SHIFT, problems);
    let angles = section.section("angles", problems);
    let path = section.path("fov");
    match (section.has("fov"), angles) {
        (false, None) if section.has("angles") => None,
        (false, None) => {
            problems.add(
                &path,
                "is missing; expected fov = [horizontal, vertical] in degrees, or angles = { left, right, bottom, top }",
            );
            None
        }
        (true, Some(_)) => {
            problems.add(&section.path("angles"), "say the opening a second time, after `fov`; leave out one of them");
            None
        }
        (true, None) => {
            let ([horizontal, vertical], [right, up]) = (fov?, shift.unwrap_or([0.0; 2]));
            let half = |degrees: f64| (degrees.to_radians() / 2.0).tan();
            let (width, height) = (2.0 * half(horizontal), 2.0 * half(vertical));
            Some(Frustum {
                left: (right - 0.5) * width,
                right: (right + 0.5) * width,
                bottom: (up - 0.5) * height,
                top: (up + 0.5) * height,
            })
        }
        (false, Some(angles)) => {
            if section.has("shift") {
                problems.add(&section.path("shift"), "goes with `fov`; `angles` say the shift themselves");
            }
            sides(angles, problems)
        }
    }
}

/// The opening of a pinhole from the angles of its four sides.
fn sides(mut section: Section, problems: &mut Problems) -> Option<Frustum> {
    let [left, right, bottom, top] =
        ["left", "right", "bottom", "top"].map(|key| section.required_number(key, &SIDE, problems));
    let complete = ["left", "right", "bottom", "top"].iter().all(|key| section.has(key));
    let mut ordered = true;
    for (low, high, low_key, high_key) in [(left, right, "left", "right"), (bottom, top, "bottom", "top")] {
        if complete && high - low < 0.01 {
            problems.add(
                &section.path(high_key),
                format!("{high} is not above {low_key} = {low}; {low_key} is negative where it lies on its own side of the lens axis"),
            );
            ordered = false;
        }
    }
    section.finish(&[], problems);
    let tangent = |degrees: f64| degrees.to_radians().tan();
    let frustum = Frustum { left: tangent(left), right: tangent(right), bottom: tangent(bottom), top: tangent(top) };
    (complete && ordered).then_some(frustum)
}

fn blend(section: Option<Section>, kind: Kind, problems: &mut Problems) -> Blend {
    let overlap = kind == Kind::Projector;
    let mut blend = Blend { overlap, ramp: 0.25, ramps: Vec::new(), gamma: 2.2, black_level: 0.0 };
    let Some(mut section) = section else { return blend };
    blend.overlap = section.boolean("overlap", overlap, problems);
    if blend.overlap && kind != Kind::Projector {
        let path = section.path("overlap");
        problems.add(&path, "only projectors overlap on the screen; leave it out here, or use `ramps`");
    }
    let ramp = Allowed::above(0.0, 0.5, "a part of the picture's width and height");
    blend.ramp = section.number("ramp", &ramp, 0.25, problems);
    blend.gamma =
        section.number("gamma", &Allowed::closed(1.0, 4.0, "the exponent of the display's response"), 2.2, problems);
    let black = Allowed::below(0.0, 1.0, "light added to black, as a part of white");
    blend.black_level = section.number("black_level", &black, 0.0, problems);
    let example = "ramps = [{ angle = \"polar\", zero = 90, full = 80 }]";
    blend.ramps = section
        .sections("ramps", example, problems)
        .into_iter()
        .filter_map(|ramp| angle_ramp(ramp, problems))
        .collect();
    section.finish(&[("image", "[output.mask]")], problems);
    blend
}

fn angle_ramp(mut section: Section, problems: &mut Problems) -> Option<AngleRamp> {
    if !section.has("angle") {
        problems.add(&section.path("angle"), "is missing; expected angle = \"polar\" or \"azimuth\"");
    }
    let angle = section.choice("angle", &[("polar", DomeAngle::Polar), ("azimuth", DomeAngle::Azimuth)], problems)?;
    let allowed = match angle {
        DomeAngle::Polar => Allowed::closed(0.0, 180.0, "an angle in degrees from the dome's pole"),
        DomeAngle::Azimuth => {
            Allowed::closed(-180.0, 180.0, "an angle in degrees around the pole, 0 = front, to the right")
        }
    };
    let zero = section.required_number("zero", &allowed, problems);
    let full = section.required_number("full", &allowed, problems);
    if section.has("zero") && zero == full {
        problems.add(&section.path("full"), format!("{full} is also `zero`; the ramp needs a width"));
    }
    section.finish(&[], problems);
    Some(AngleRamp { angle, zero: zero.to_radians(), full: full.to_radians() })
}

fn mask(section: Option<Section>, directory: &Path, problems: &mut Problems) -> Option<PathBuf> {
    let mut section = section?;
    if !section.has("image") {
        problems
            .add(&section.path("image"), "is missing; expected the name of a grey PNG file, relative to the rig file");
    }
    let image = section.text("image", "the name of a grey PNG file", problems);
    let path = image.and_then(|image| match std::path::absolute(directory.join(image)) {
        Ok(path) if !image.is_empty() => Some(path),
        _ => {
            problems.add(&section.path("image"), "the name is empty; expected that of a grey PNG file");
            None
        }
    });
    section.finish(&[], problems);
    path
}
