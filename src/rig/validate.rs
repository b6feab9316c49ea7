//! What the values of a rig must satisfy together.

use super::problems::Problems;
use super::{Dome, Output, OutputKind, Rig};
use crate::geom::{Frustum, Lens, Optics, Pose};
use glam::{DVec2, DVec3};
use std::io::Read;
use std::path::Path;

/// Greatest number of outputs: what one machine's graphics adapters can carry, with room to spare.
const MOST_OUTPUTS: usize = 64;
/// Longest output name; it becomes part of file names.
const LONGEST_NAME: usize = 64;
/// Greatest coordinate in a window: the X protocol's.
const LARGEST_WINDOW: u32 = 32767;
/// The viewer's greatest distance from the centre over the radius: nearer to the screen its solid angle
/// as seen by the viewer has no useful resolution anywhere else.
const VIEWER_LIMIT: f64 = 0.99;
/// Greatest distance of a projector over the radius for which the correction is exact.
const PROJECTOR_LIMIT: f64 = 1e6;
/// Rays per direction that are tried for whether a projector sees the screen.
const RAYS: usize = 65;

/// Adds every problem of `rig` that is not one of a single value.
pub(super) fn check(rig: &Rig, problems: &mut Problems) {
    match (rig.passthrough, rig.outputs.len()) {
        (false, 0) => problems.add("output", "is missing; expected at least one [[output]], or passthrough = true"),
        (true, 1..) => {
            problems.add(
                "passthrough",
                "leaves the program's picture alone, so no [[output]] can be shown; leave out one of them",
            );
        }
        (false, count) if count > MOST_OUTPUTS => {
            problems.add(
                &path(MOST_OUTPUTS, ""),
                format!("is one too many; expected at most {MOST_OUTPUTS} outputs, not {count}"),
            );
        }
        _ => {}
    }
    names(&rig.outputs, problems);
    windows(&rig.outputs, problems);
    viewer(rig, problems);
    for (index, output) in rig.outputs.iter().enumerate() {
        if let OutputKind::Projector { position, angles, frustum } = output.kind {
            let pose = Pose::new(position, angles[0], angles[1], angles[2]);
            projector(index, &rig.dome, &pose, &frustum, problems);
        }
        if let OutputKind::Optics { optics, .. } = &output.kind {
            optics_problems(index, &rig.dome, optics, output.size, problems);
        }
        if let Some(why) = output.mask.as_deref().and_then(unusable_mask) {
            problems.add(&path(index, ".mask.image"), why);
        }
    }
}

/// The key path of the output `index`, then `key`.
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
        // Two names that differ in case only would be one file on some systems.
        if outputs[..index].iter().any(|other| other.name.eq_ignore_ascii_case(name)) {
            problems.add(&path, format!("{name:?} is the name of another output too; expected a name of its own"));
        }
    }
}

fn windows(outputs: &[Output], problems: &mut Problems) {
    let placed = outputs.iter().filter(|output| output.window.is_some()).count();
    for (index, output) in outputs.iter().enumerate() {
        let Some([x, y, width, height]) = output.window else {
            if placed > 0 {
                let why =
                    "is missing, but other outputs have one; expected a place for each output, or for none (a grid)";
                problems.add(&path(index, ".window"), why);
            }
            continue;
        };
        if x + width > LARGEST_WINDOW || y + height > LARGEST_WINDOW {
            let end = format!("ends at ({}, {})", x + width, y + height);
            problems.add(
                &path(index, ".window"),
                format!("{end}; expected an end within {LARGEST_WINDOW} pixels, as windows are"),
            );
        }
        let overlapping = outputs[..index].iter().find(|other| {
            other.window.is_some_and(|[x2, y2, width2, height2]| {
                x < x2 + width2 && x2 < x + width && y < y2 + height2 && y2 < y + height
            })
        });
        if let Some(other) = overlapping {
            let why = format!("overlaps the window of {:?}; expected [x, y, width, height] that do not", other.name);
            problems.add(&path(index, ".window"), why);
        }
    }
}

/// The viewer has to see the screen from inside.
fn viewer(rig: &Rig, problems: &mut Problems) {
    let on_screen = |output: &Output| !matches!(output.kind, OutputKind::Perspective { .. });
    let (distance, radius) = (rig.viewer.position.length(), rig.dome.radius);
    if rig.outputs.iter().any(on_screen) && distance > VIEWER_LIMIT * radius {
        problems.add(
            "viewer.position",
            format!(
                "is {distance} m from the dome's centre, not inside the dome of radius {radius} m; expected at most {} m",
                VIEWER_LIMIT * radius
            ),
        );
    }
}

fn projector(index: usize, dome: &Dome, pose: &Pose, frustum: &Frustum, problems: &mut Problems) {
    let distance = pose.position.length();
    if distance > PROJECTOR_LIMIT * dome.radius {
        let limit = PROJECTOR_LIMIT * dome.radius;
        let why = format!("is {distance} m from the dome's centre; expected at most {limit} m");
        problems.add(&path(index, ".position"), why);
    } else if !sees_screen(dome, pose, frustum) {
        problems.add(
            &path(index, ""),
            "the projector sees no part of the screen; expected position (metres from the dome's centre, x right, y up, \
             z backward), yaw (to the right), pitch (up) and fov that reach the dome",
        );
    }
}

/// What is wrong with a projector with a lens or a mirror of its own.
fn optics_problems(index: usize, dome: &Dome, optics: &Optics, size: Option<(u32, u32)>, problems: &mut Problems) {
    let distance = optics.pose.position.length();
    if distance > PROJECTOR_LIMIT * dome.radius {
        let limit = PROJECTOR_LIMIT * dome.radius;
        let why = format!("is {distance} m from the dome's centre; expected at most {limit} m");
        problems.add(&path(index, ".position"), why);
        return;
    }
    if let Some(mirror) = &optics.mirror {
        if mirror.center.length() + mirror.radius >= dome.radius {
            problems.add(&path(index, ".mirror"), "reaches through the dome; expected a mirror inside of it");
            return;
        }
        if mirror.contains(optics.pose.position) {
            problems.add(&path(index, ".mirror"), "encloses the projector; expected a mirror before its lens");
            return;
        }
    }
    let aspect = size.map_or(1.0, |(width, height)| f64::from(width) / f64::from(height));
    let at = |step: usize| 2.0 * step as f64 / (RAYS - 1) as f64 - 1.0;
    let grid = || (0..RAYS * RAYS).map(|ray| DVec2::new(at(ray % RAYS), at(ray / RAYS)));
    if matches!(optics.lens, Lens::Pinhole { .. }) && grid().any(|point| optics.lens.ray(point, aspect).is_none()) {
        let why = "folds the picture over itself before its border; expected smaller coefficients, or a smaller fov";
        problems.add(&path(index, ".distortion"), why);
        return;
    }
    let lights = |point: DVec2| {
        let (origin, direction) = optics.ray(point, aspect)?;
        screen_hit(dome, origin, direction.try_normalize()?)
    };
    if !grid().any(|point| lights(point).is_some()) {
        let why = match optics.mirror {
            Some(_) => {
                "no light of the projector reaches the screen by way of the mirror; expected position, yaw and pitch that aim at it"
            }
            None => "the projector sees no part of the screen; expected position, yaw and pitch that reach the dome",
        };
        problems.add(&path(index, ""), why);
    }
}

/// Whether any of a grid of the projector's rays ends on the screen.
fn sees_screen(dome: &Dome, pose: &Pose, frustum: &Frustum) -> bool {
    let at = |low: f64, high: f64, step: usize| low + (high - low) * step as f64 / (RAYS - 1) as f64;
    (0..RAYS * RAYS).any(|ray| {
        let (column, row) = (ray % RAYS, ray / RAYS);
        let direction = DVec3::new(at(frustum.left, frustum.right, column), at(frustum.bottom, frustum.top, row), -1.0);
        screen_hit(dome, pose.position, pose.rotation * direction.normalize()).is_some()
    })
}

/// Where the ray from `origin` along the unit vector `direction` meets the dome's inner surface from
/// inside, if that is on the screen.
pub(super) fn screen_hit(dome: &Dome, origin: DVec3, direction: DVec3) -> Option<DVec3> {
    let along = origin.dot(direction);
    // |origin × direction| is the line's distance from the centre; this form stays exact for far origins.
    let discriminant = dome.radius * dome.radius - origin.cross(direction).length_squared();
    if discriminant < 0.0 {
        return None;
    }
    let distance = discriminant.sqrt() - along;
    let hit = origin + direction * distance;
    let pole = DVec3::new(0.0, dome.tilt.cos(), -dome.tilt.sin());
    // In angles and not in cosines: those of a whole sphere's cap would depend on rounding.
    let on_screen = hit.angle_between(pole) <= dome.coverage / 2.0;
    (distance > 0.0 && on_screen).then_some(hit)
}

/// Why the file cannot be a mask, if so.
fn unusable_mask(path: &Path) -> Option<String> {
    let mut signature = [0; 8];
    let read = std::fs::File::open(path).and_then(|mut file| file.read_exact(&mut signature));
    match read {
        Ok(()) if signature == *b"\x89PNG\r\n\x1a\n" => None,
        Err(error) if error.kind() != std::io::ErrorKind::UnexpectedEof => Some(format!(
            "{} cannot be read: {error}; expected a grey PNG file, relative to the rig file",
            path.display()
        )),
        _ => Some(format!("{} is no PNG file; expected a grey PNG file", path.display())),
    }
}
