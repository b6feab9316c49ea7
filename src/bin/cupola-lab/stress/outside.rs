//! Random projectors from inside to 20 radii, whose pictures reach beyond the outlines of screens
//! of every shape.

use super::case::{ATTEMPTS, Case, PLAIN, Place, pick, vector};
use super::screens;
use crate::meshes::Folder;
use crate::random::Random;
use glam::DVec3;

/// Greatest distance of a projector from the centre, in radii.
const FARTHEST: f64 = 20.0;

/// A random rig with one projector.
pub fn any(random: &mut Random, folder: &Folder) -> Result<Case, cupola::Error> {
    for _ in 0..ATTEMPTS {
        let text = text(random);
        if let Ok(rig) = folder.rig(&text) {
            return Ok(Case { rig, text, place: Place::Far });
        }
    }
    Ok(Case { rig: folder.rig(PLAIN)?, text: PLAIN.to_owned(), place: Place::Far })
}

/// A random rig file, which may be invalid.
fn text(random: &mut Random) -> String {
    let radius = pick(random, &[1.5, 5.0]);
    let [near, far] = [random.range(0.0, 0.6), random.range(0.6, 0.9)];
    let viewer = random.direction() * radius * pick(random, &[0.0, 0.0, near, far]);
    format!(
        "[dome]\nradius = {radius}\ntilt = {}\n{}[viewer]\nposition = {}\nyaw = {}\npitch = {}\nroll = {}\n\
         [[output]]\n{}flip = \"{}\"\n",
        random.range(-180.0, 180.0),
        screen(random, radius),
        vector(viewer),
        random.range(-180.0, 180.0),
        random.range(-90.0, 90.0),
        random.range(-180.0, 180.0),
        projector(random, radius),
        pick(random, &["none", "none", "horizontal", "vertical", "both"]),
    )
}

/// A random screen, rarely one of triangles.
fn screen(random: &mut Random, radius: f64) -> String {
    let mesh = pick(random, &["ball.obj", "boards.obj"]);
    let faces = pick(random, &["front", "both"]);
    let scale = radius * random.range(0.7, 1.6);
    match random.unit() < 0.06 {
        true => format!("[screen]\nshape = \"mesh\"\nfile = \"{mesh}\"\nscale = {scale}\nfaces = \"{faces}\"\n"),
        false => screens::screen(random, radius),
    }
}

/// A random projector. One outside looks at the screen, and past it.
fn projector(random: &mut Random, radius: f64) -> String {
    let inside = random.unit();
    let outside = FARTHEST.powf(random.unit());
    let distance = pick(random, &[inside, 0.9 + 0.4 * inside, outside, outside]);
    let direction = random.direction();
    let position = direction * radius * distance;
    // Screens reach to 1.6 radii around places up to 0.3 radii from the centre.
    let half = (1.6 / distance.max(1.6)).asin().to_degrees();
    let aim = -position + random.vector(-0.8, 0.8) * radius;
    let aim = aim.try_normalize().unwrap_or(DVec3::NEG_Z);
    let fov = (2.0 * half * random.range(0.05, 1.3)).min(150.0);
    let pinhole = if random.unit() < 0.3 {
        let side = |random: &mut Random| half.min(60.0) * random.range(0.1, 1.3);
        let [left, right, bottom, top] = [(); 4].map(|()| side(random));
        format!("angles = {{ left = -{left}, right = {right}, bottom = -{bottom}, top = {top} }}\n")
    } else {
        format!("fov = [{fov}, {}]\n", fov * random.range(0.3, 1.0))
    };
    let lens = if random.unit() < 0.5 { pinhole } else { screens::lens(random, &pinhole, direction, position, radius) };
    format!(
        "kind = \"projector\"\nposition = {}\nyaw = {}\npitch = {}\nroll = {}\n{lens}",
        vector(position),
        aim.x.atan2(-aim.z).to_degrees(),
        aim.y.clamp(-1.0, 1.0).asin().to_degrees(),
        random.range(-180.0, 180.0),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn projectors_are_inside_and_outside_of_every_screen() {
        let Ok(folder) = Folder::new() else { panic!("no folder") };
        let shapes = ["\"sphere\"", "\"ellipsoid\"", "\"cylinder\"", "\"cone\"", "\"plane\"", "\"mesh\"", "tilt"];
        let mut found = [[0; 2]; 7];
        for seed in 0..600 {
            let case = any(&mut Random::new(seed), &folder).expect("a rig");
            let shape = shapes.iter().position(|shape| case.text.contains(shape)).unwrap_or(6);
            let cupola::rig::OutputKind::Projector { position, .. } = case.rig.outputs[0].kind else { continue };
            found[shape][usize::from(position.length() > 2.0 * case.rig.dome.radius)] += 1;
        }
        assert!(found.as_flattened().iter().all(|count| *count > 0), "{found:?}");
    }
}
