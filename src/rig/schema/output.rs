//! `[[output]]`: the keys of every output, and those of each kind.

use super::{METRES, TILT, angles, blend, calibration, lens, method};
use crate::geom::lenses::panorama::{Panorama, Span};
use crate::geom::{Lens, Optics, PixelRect, Pose, Sphere};
use crate::rig::reading::allowed::Allowed;
use crate::rig::reading::problems::Problems;
use crate::rig::reading::reader::Section;
use crate::rig::{Dome, Flip, Output, OutputKind, OwnWindow};
use glam::DVec3;
use std::path::Path;

/// Greatest width and height of a picture in pixels: the greatest texture of today's graphics
/// hardware.
const LARGEST_PICTURE: u32 = 16384;
/// Greatest coordinate in a window, from the X protocol.
const LARGEST_WINDOW: u32 = 32767;

/// Kind of output to which each key belongs, for users who give a key to another kind.
const KINDS_OF_KEYS: [(&str, &str); 21] = [
    ("file", "kind = \"mesh\""),
    ("values", "kind = \"mesh\""),
    ("picture", "kind = \"mesh\""),
    ("aperture", "kind = \"domemaster\""),
    ("projection", "kind = \"domemaster\", or to the table `fisheye` of a projector"),
    ("coefficients", "kind = \"domemaster\", or to the table `fisheye` of a projector"),
    ("measured", "kind = \"domemaster\", or to the table `fisheye` of a projector"),
    ("width", "kind = \"equirectangular\" or \"cylindrical\""),
    ("latitudes", "kind = \"equirectangular\" or \"cylindrical\""),
    ("keystone", "kind = \"projector\""),
    ("tilt", "kind = \"domemaster\" (and to [dome])"),
    ("position", "kind = \"projector\" (and to [viewer])"),
    ("shift", "kind = \"projector\" or \"perspective\", beside fov"),
    ("fisheye", "kind = \"projector\""),
    ("distortion", "kind = \"projector\""),
    ("mirror", "kind = \"projector\""),
    ("even_light", "kind = \"projector\""),
    ("fov", "kind = \"projector\" or \"perspective\""),
    ("lens", "kind = \"perspective\""),
    ("max_error", "method = \"table\", \"mesh\" or \"primitive\""),
    ("density", "method = \"cube-mesh\""),
];

/// Values of the key `kind`.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum Kind {
    Domemaster,
    Projector,
    Perspective,
    Equirectangular,
    Cylindrical,
    Cubemap,
    Mesh,
}

const KINDS: [(&str, Kind); 7] = [
    ("domemaster", Kind::Domemaster),
    ("projector", Kind::Projector),
    ("perspective", Kind::Perspective),
    ("equirectangular", Kind::Equirectangular),
    ("cylindrical", Kind::Cylindrical),
    ("cubemap", Kind::Cubemap),
    ("mesh", Kind::Mesh),
];

const WIDTH: Allowed = Allowed::closed(0.1, 360.0, "the angle from side to side in degrees");
const EYE: Allowed = Allowed::closed(-1.0, 1.0, "metres to the right of the viewer's position");

pub(super) fn output(
    mut section: Section,
    index: usize,
    dome: &Dome,
    directory: &Path,
    problems: &mut Problems,
) -> Option<Output> {
    let kind = kind(&mut section, problems)?;
    let given = section.text("name", "the output's name", problems);
    let name = given.map_or(format!("output-{}", index + 1), str::to_owned);
    problems.name_output(index, &name);
    let sides = [(1, LARGEST_PICTURE); 2];
    let size =
        section.pixels("size", sides, "[width, height] in pixels", problems).map(|[width, height]| (width, height));
    let places = [(0, LARGEST_WINDOW), (0, LARGEST_WINDOW), (1, LARGEST_PICTURE), (1, LARGEST_PICTURE)];
    let window =
        section.pixels("window", places, "[x, y, width, height] in pixels from the window's top left", problems);
    let window = window.map(|[x, y, width, height]| PixelRect { x, y, width, height });
    let eye = section.number("eye", &EYE, 0.0, problems);
    let method = method::method(&mut section, problems);
    let own_window = own_window(&mut section, problems);
    let shown = shown(&mut section, own_window.is_none(), size, window, problems);
    let node = section.node("node", problems);
    let publish = section.boolean("publish", !shown, problems);
    let output_kind = geometry(&mut section, kind, dome, directory, problems);
    let flip = section.choice_or("flip", &Flip::WORDS, Flip::default(), problems);
    let blend = blend::blend(section.section("blend", problems), kind, directory, problems);
    let mask = blend::mask(section.section("mask", problems), directory, problems);
    let black = blend::black(section.section("black", problems), size, &blend, directory, problems);
    section.finish(&KINDS_OF_KEYS, problems);
    output_kind.map(|kind| Output {
        name,
        kind,
        method,
        size,
        window,
        blend,
        mask,
        black,
        eye,
        flip,
        publish,
        shown,
        own_window,
        node,
        here: true,
    })
}

/// Reads the key `kind`.
fn kind(section: &mut Section, problems: &mut Problems) -> Option<Kind> {
    if !section.has("kind") {
        let path = section.path("kind");
        let words = KINDS.map(|(word, _)| format!("\"{word}\"")).join(", ");
        problems.add(&path, format!("is missing; expected one of kind = {words}"));
    }
    section.choice("kind", &KINDS, problems)
}

/// Reads the keys that only outputs of this `kind` have.
fn geometry(
    section: &mut Section,
    kind: Kind,
    dome: &Dome,
    directory: &Path,
    problems: &mut Problems,
) -> Option<OutputKind> {
    match kind {
        Kind::Domemaster => domemaster(section, dome, problems),
        Kind::Projector => {
            let position = section.vector("position", &METRES, problems);
            let angles = angles(section, problems);
            projector(section, position, angles, problems)
        }
        Kind::Perspective => {
            let angles = angles(section, problems);
            lens::perspective_frustum(section, problems).map(|frustum| OutputKind::Perspective { angles, frustum })
        }
        Kind::Mesh => calibration::mesh(section, dome, directory, problems),
        Kind::Equirectangular | Kind::Cylindrical | Kind::Cubemap => {
            let angles = angles(section, problems);
            let panorama = match kind {
                Kind::Equirectangular => span(section, 90.0, problems).map(Panorama::Equirectangular),
                Kind::Cylindrical => span(section, 45.0, problems).map(Panorama::Cylindrical),
                _ => Some(Panorama::CubeStrip),
            };
            panorama.map(|panorama| OutputKind::Panorama { panorama, angles })
        }
    }
}

/// Expected text of the key `display`.
const DISPLAY: &str = "an X screen or a Wayland compositor, for example \":0.1\" or \"wayland-0\"";

/// Reads the window of its own that an output requests.
fn own_window(section: &mut Section, problems: &mut Problems) -> Option<OwnWindow> {
    let display = section.text("display", DISPLAY, problems).map(str::to_owned);
    let monitor =
        section.text("monitor", "a monitor as xrandr or the compositor lists it, for example \"DP-2\"", problems);
    let monitor = monitor.map(str::to_owned);
    let fullscreen = section.boolean("fullscreen", false, problems);
    if fullscreen && monitor.is_some() {
        let path = section.path("fullscreen");
        problems.add(&path, "is the whole screen, `monitor` a part of it; leave out one of them");
    }
    (display.is_some() || monitor.is_some() || fullscreen).then_some(OwnWindow { display, monitor, fullscreen })
}

/// True if the output has a place in the program's window. `usually`: it has no window of its own.
fn shown(
    section: &mut Section,
    usually: bool,
    size: Option<(u32, u32)>,
    window: Option<PixelRect>,
    problems: &mut Problems,
) -> bool {
    let shown = section.boolean("shown", usually, problems);
    let path = section.path("shown");
    if shown && !usually {
        problems.add(
            &path,
            "means a place in the program's window, but `display`, `monitor` and `fullscreen` a window of its own",
        );
    }
    if !shown && size.is_none() {
        let why = if usually { "shown = false" } else { "display, monitor or fullscreen" };
        problems.add(&path, format!("needs a size; expected size = [width, height] in pixels beside {why}"));
    }
    if !shown && window.is_some() {
        problems.add(&path, "means that the output has no place in the window; leave out `window`");
    }
    shown
}

/// Reads a domemaster; without another projection in the file it is the plain one.
fn domemaster(section: &mut Section, dome: &Dome, problems: &mut Problems) -> Option<OutputKind> {
    let tilt = section.number("tilt", &TILT, dome.tilt.to_degrees(), problems).to_radians();
    let special = section.has("projection");
    let lens = lens::fisheye(section, dome.coverage.to_degrees(), problems)?;
    Some(match special {
        false => OutputKind::Domemaster { aperture: lens.aperture, tilt },
        true => {
            let angles = [0.0, std::f64::consts::FRAC_PI_2 - tilt, 0.0];
            OutputKind::Panorama { panorama: Panorama::Fisheye(lens), angles }
        }
    })
}

/// Returns the range of directions that an unrolled picture shows. Its latitudes end at most
/// `limit` degrees up and down.
pub(super) fn span(section: &mut Section, limit: f64, problems: &mut Problems) -> Option<Span> {
    let width = section.number("width", &WIDTH, 360.0, problems).to_radians();
    let allowed = match limit {
        90.0 => Allowed::closed(-90.0, 90.0, "[bottom, top] latitudes in degrees"),
        _ => Allowed::closed(-89.0, 89.0, "[bottom, top] latitudes in degrees, on a cylinder's wall"),
    };
    let [bottom, top] = section.numbers_or("latitudes", &allowed, [-limit, limit], problems);
    if top - bottom < 0.01 {
        problems.add(&section.path("latitudes"), format!("end at {top}, not above {bottom}; expected [bottom, top]"));
        return None;
    }
    Some(Span { width, bottom: bottom.to_radians(), top: top.to_radians() })
}

/// Reads a projector; if the file gives only its opening, it is a plain pinhole.
fn projector(section: &mut Section, position: DVec3, angles: [f64; 3], problems: &mut Problems) -> Option<OutputKind> {
    let special = ["fisheye", "distortion", "keystone", "mirror", "even_light"].iter().any(|key| section.has(key));
    let lens = lens::projector_lens(section, problems);
    let mirror = section.section("mirror", problems).map(|section| mirror(section, problems));
    let allowed = Allowed::closed(0.0, 1.0, "how far the light is evened out");
    let even_light = section.number("even_light", &allowed, 0.0, problems);
    let plain = match lens? {
        Lens::Pinhole { frustum, .. } if !special => return Some(OutputKind::Projector { position, angles, frustum }),
        lens => lens,
    };
    let [yaw, pitch, roll] = angles;
    let optics = Optics { pose: Pose::new(position, yaw, pitch, roll), lens: plain, mirror };
    Some(OutputKind::Optics { optics: Box::new(optics), even_light })
}

/// Reads a convex spherical mirror.
fn mirror(mut section: Section, problems: &mut Problems) -> Sphere {
    let center = section.vector("center", &METRES, problems);
    let radius = section.required_number("radius", &Allowed::above(0.0, 1e6, "a radius in metres"), problems);
    section.finish(&[], problems);
    Sphere { center, radius }
}
