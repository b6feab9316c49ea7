//! Conditions that several values of a rig must satisfy together.

use super::reading::problems::Problems;
use super::{Method, Output, OutputKind, Rig, mask};
use crate::geom::screen::{Faces, Screen, Shape};
use crate::geom::{Lens, Optics, Pose};
use glam::DVec2;

/// Longest output name; it becomes part of file names.
const LONGEST_NAME: usize = 64;
/// Greatest coordinate in a window, from the X protocol.
const LARGEST_WINDOW: u32 = 32767;
/// Greatest distance of the viewer from the centre divided by the radius. Nearer to the screen, the
/// screen's solid angle for the viewer leaves no useful resolution anywhere else.
const VIEWER_LIMIT: f64 = 0.99;
/// Greatest distance of a projector divided by the radius for which the correction is exact.
const PROJECTOR_LIMIT: f64 = 1e6;
/// Number of rays in each direction that test whether a projector sees the screen.
const RAYS: usize = 65;

/// Adds every problem of `rig` that concerns several values.
pub(super) fn check(rig: &Rig, problems: &mut Problems) {
    let shown = rig.outputs.iter().filter(|output| output.shown).count();
    match (rig.passthrough, rig.outputs.len()) {
        (false, 1..) if shown == 0 => problems.add(
            "output",
            "none of them has a place in the program's window; expected one without display, monitor, fullscreen and \
             shown = false",
        ),
        (false, _) if shown == 0 => {
            problems.add("output", "is missing; expected at least one [[output]], or passthrough = true")
        }
        (true, 1..) => {
            problems.add(
                "passthrough",
                "leaves the program's picture alone, so no [[output]] can be shown; leave out one of them",
            );
        }
        _ => {}
    }
    if rig.passthrough && rig.content.is_some() {
        problems.add("content", "is shown by outputs, and passthrough = true has none; leave out one of them");
    }
    names(&rig.outputs, problems);
    windows(&rig.outputs, problems);
    viewer(rig, problems);
    for (index, output) in rig.outputs.iter().enumerate() {
        match &output.kind {
            OutputKind::Projector { position, angles: [yaw, pitch, roll], frustum } => {
                let pose = Pose::new(*position, *yaw, *pitch, *roll);
                let optics = Optics { pose, lens: Lens::pinhole(*frustum), mirror: None };
                projector(index, rig, &optics, problems);
            }
            OutputKind::Optics { optics, .. } => projector(index, rig, optics, problems),
            _ => {}
        }
        if let Some(why) = rig.content.as_ref().and_then(|_| Rig::refuses_content(&output.kind)) {
            problems.add(&path(index, ".lens"), why);
        }
        if let Some(why) = impossible_method(rig, output) {
            problems.add(&path(index, ".method"), why);
        }
        if let Some(why) = output.mask.as_deref().and_then(mask::unusable) {
            problems.add(&path(index, ".mask.image"), why);
        }
    }
}

/// Path of a key of the output `index`.
fn path(index: usize, key: &str) -> String {
    format!("output[{index}]{key}")
}

fn names(outputs: &[Output], problems: &mut Problems) {
    for (index, output) in outputs.iter().enumerate() {
        let name = output.name.as_str();
        let legal = |c: char| c.is_ascii_alphanumeric() || "-_.".contains(c);
        let path = path(index, ".name");
        if name.is_empty() || name.len() > LONGEST_NAME || name.starts_with(['.', '-']) || !name.chars().all(legal) {
            problems.add(
                &path,
                format!(
                    "{name:?} cannot be used; expected 1 to {LONGEST_NAME} of the letters a–z and A–Z, digits, `-`, `_` and `.`, \
                     beginning with a letter, a digit or `_`"
                ),
            );
        }
        // Two names that differ only in case would be one file on some systems.
        if outputs[..index].iter().any(|other| other.name.eq_ignore_ascii_case(name)) {
            problems.add(&path, format!("{name:?} is the name of another output too; expected a name of its own"));
        }
    }
}

fn windows(outputs: &[Output], problems: &mut Problems) {
    let placed = outputs.iter().filter(|output| output.window.is_some()).count();
    for (index, output) in outputs.iter().enumerate() {
        let Some(place) = output.window else {
            if placed > 0 && output.shown {
                let why =
                    "is missing, but other outputs have one; expected a place for each output, or for none (a grid)";
                problems.add(&path(index, ".window"), why);
            }
            continue;
        };
        let (right, bottom) = (place.x.saturating_add(place.width), place.y.saturating_add(place.height));
        if right > LARGEST_WINDOW || bottom > LARGEST_WINDOW {
            let end = format!("ends at ({right}, {bottom})");
            problems.add(
                &path(index, ".window"),
                format!("{end}; expected an end within {LARGEST_WINDOW} pixels, as windows are"),
            );
        }
        // Each machine has a window of its own.
        let overlaps =
            |other: &&Output| other.node == output.node && other.window.is_some_and(|window| window.meets(place));
        if let Some(other) = outputs[..index].iter().find(overlaps) {
            let why = format!("overlaps the window of {:?}; expected [x, y, width, height] that do not", other.name);
            problems.add(&path(index, ".window"), why);
        }
    }
}

/// Checks that the viewer sees the screen from inside.
fn viewer(rig: &Rig, problems: &mut Problems) {
    let on_screen = |output: &&Output| !matches!(output.kind, OutputKind::Perspective { .. });
    let farthest = |farthest: f64, output: &Output| rig.eye(output).position.length().max(farthest);
    let (distance, radius) = (rig.outputs.iter().filter(on_screen).fold(0.0, farthest), rig.dome.radius);
    if rig.screen.is_none() && distance > VIEWER_LIMIT * radius {
        problems.add(
            "viewer.position",
            format!(
                "is {distance} m from the dome's centre, not inside the dome of radius {radius} m; expected at most {} m",
                VIEWER_LIMIT * radius
            ),
        );
    }
}

/// Checks that a projector reaches the screen, with a lens that has one ray for each pixel.
fn projector(index: usize, rig: &Rig, optics: &Optics, problems: &mut Problems) {
    let screen = rig.surface();
    let distance = optics.pose.position.length();
    if distance > PROJECTOR_LIMIT * screen.size() {
        let limit = PROJECTOR_LIMIT * screen.size();
        let why = format!("is {distance} m from the dome's centre; expected at most {limit} m");
        problems.add(&path(index, ".position"), why);
        return;
    }
    if let Some(mirror) = &optics.mirror {
        if rig.screen.is_none() && mirror.center.length() + mirror.radius >= rig.dome.radius {
            problems.add(&path(index, ".mirror"), "reaches through the dome; expected a mirror inside of it");
            return;
        }
        if mirror.contains(optics.pose.position) {
            problems.add(&path(index, ".mirror"), "encloses the projector; expected a mirror before its lens");
            return;
        }
    }
    let output = &rig.outputs[index];
    let aspect = output.size.map_or(1.0, |(width, height)| f64::from(width) / f64::from(height));
    let at = |step: usize| 2.0 * step as f64 / (RAYS - 1) as f64 - 1.0;
    let grid = || (0..RAYS * RAYS).map(|ray| DVec2::new(at(ray % RAYS), at(ray / RAYS)));
    if matches!(optics.lens, Lens::Pinhole { .. }) && grid().any(|point| optics.lens.ray(point, aspect).is_none()) {
        let why = "folds the picture over itself before its border; expected smaller coefficients, or a smaller fov";
        problems.add(&path(index, ".distortion"), why);
        return;
    }
    let lit = |point: DVec2| {
        let (origin, direction) = optics.ray(point, aspect)?;
        Some(screen.hit(origin, direction)?.point)
    };
    let eye = rig.eye(output).position;
    let nearest = grid().filter_map(lit).map(|point| point.distance(eye)).reduce(f64::min);
    match nearest {
        None => problems.add(&path(index, ""), unlit(optics, &screen)),
        Some(nearest) if rig.screen.is_some() && nearest < (1.0 - VIEWER_LIMIT) * screen.size() => problems.add(
            "viewer.position",
            format!("is {nearest} m from the screen; expected at least {} m", (1.0 - VIEWER_LIMIT) * screen.size()),
        ),
        Some(_) => {}
    }
}

/// Returns the reason why a projector lights nothing.
fn unlit(optics: &Optics, screen: &Screen) -> &'static str {
    match (&optics.mirror, &screen.shape) {
        (Some(_), _) => {
            "no light of the projector reaches the screen by way of the mirror; expected position, yaw and pitch that aim at it"
        }
        (None, Shape::Mesh(mesh)) if mesh.faces() != Faces::Both => {
            "the projector lights no face of the screen on the side that is screen; expected position, yaw and pitch that \
             reach it, or the other side in [screen] faces"
        }
        (None, _) => {
            "the projector sees no part of the screen; expected position (metres from the dome's centre, x right, y up, \
             z backward), yaw (to the right), pitch (up) and fov that reach the screen"
        }
    }
}

/// Widest domemaster to which a mesh of the dome is flattened, radians: beyond it, triangles get
/// too near to the point behind.
const WIDEST_FLATTENED: f64 = 1.5 * std::f64::consts::PI;

/// Returns the reason why the method of an output cannot make its picture; `None` if it can.
fn impossible_method(rig: &Rig, output: &Output) -> Option<&'static str> {
    match (output.method, &output.kind) {
        (Method::Fragment, _) => None,
        (_, OutputKind::Perspective { frustum: None, .. }) => {
            Some("needs a map that is known before the program draws; expected \"fragment\" with the program's own lens")
        }
        (Method::CubeMesh { .. }, _) if rig.screen.is_some() => {
            Some("\"cube-mesh\" is a mesh of the dome, but there is a [screen]; expected \"fragment\", \"table\" or \"mesh\"")
        }
        (Method::CubeMesh { .. }, OutputKind::Domemaster { aperture, .. }) if *aperture > WIDEST_FLATTENED => {
            Some("\"cube-mesh\" flattens at most 270°; expected a smaller aperture, or \"fragment\", \"table\" or \"mesh\"")
        }
        (Method::CubeMesh { .. }, OutputKind::Projector { .. } | OutputKind::Domemaster { .. }) => None,
        (Method::CubeMesh { .. }, _) => Some(
            "\"cube-mesh\" is for plain projectors and equidistant domemasters; expected \"fragment\", \"table\" or \"mesh\"",
        ),
        (Method::Vertex | Method::Primitive { .. }, _) => unprojectable(rig, output),
        (Method::Table { .. } | Method::Mesh { .. }, _) => None,
    }
    .or_else(|| {
        let evened = rig.outputs.iter().any(|output| output.blend.contrast.is_some());
        let why = "cannot even out blacks, which blend.contrast asks for; expected \"fragment\" for all outputs";
        (output.method != Method::Fragment && !output.method.projects_vertices() && evened).then_some(why)
    })
}

/// Returns the reason why vertices cannot be projected straight to an output; `None` if they can.
/// Such a projection needs a closed form from direction to pixel.
fn unprojectable(rig: &Rig, output: &Output) -> Option<&'static str> {
    match &output.kind {
        OutputKind::Domemaster { .. } | OutputKind::Projector { .. } if rig.screen.is_some() => Some(
            "projects vertices by way of the dome, but there is a [screen]; expected \"fragment\", \"table\" or \"mesh\"",
        ),
        OutputKind::Projector { position, .. } if position.length() >= VIEWER_LIMIT * rig.dome.radius => {
            Some("projects vertices for projectors inside the dome only; expected a position inside, or \"fragment\"")
        }
        OutputKind::Domemaster { .. } | OutputKind::Projector { .. } => None,
        _ => Some("projects vertices for plain projectors and equidistant domemasters only; expected \"fragment\""),
    }
}
