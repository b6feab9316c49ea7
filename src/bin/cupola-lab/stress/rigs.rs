//! Random and adversarial rigs. They are generated as text, so that a rig that fails can be saved
//! to a file.

use super::case::{ATTEMPTS, Case, PLAIN, Place, pick, vector};
use super::screens;
use crate::random::Random;
use std::path::Path;

/// A random rig with one output.
pub fn any(random: &mut Random) -> Result<Case, cupola::Error> {
    for _ in 0..ATTEMPTS {
        let (text, place) = match random.unit() {
            kind if kind < 0.35 => domemaster(random),
            kind if kind < 0.85 => projector(random),
            _ => perspective(random),
        };
        if let Ok(rig) = cupola::rig::parse(&text, "stress.toml", Path::new("")) {
            return Ok(Case { rig, text, place });
        }
    }
    let rig = cupola::rig::parse(PLAIN, "stress.toml", Path::new(""))?;
    Ok(Case { rig, text: PLAIN.to_owned(), place: Place::Inside })
}

/// A random rig with 2…12 overlapping projectors on a dome or on a screen of another shape.
pub fn overlapping(random: &mut Random) -> Result<Case, cupola::Error> {
    for _ in 0..ATTEMPTS {
        let count = 2 + (random.unit() * 11.0) as usize;
        let (mut text, radius) = dome(random, 0.6);
        if random.unit() < 0.4 {
            text += &screens::screen(random, radius);
        }
        let fov = random.range(30.0, 80.0);
        for index in 0..count {
            let position = random.direction() * radius * random.range(0.0, 0.9);
            let yaw = 360.0 * index as f64 / count as f64 - 180.0 + random.range(-20.0, 20.0);
            text += &format!(
                "[[output]]\nkind = \"projector\"\nposition = {}\nyaw = {yaw}\npitch = {}\nroll = {}\nfov = [{fov}, {}]\n{}",
                vector(position),
                random.range(0.0, 60.0),
                random.range(-30.0, 30.0),
                fov * 0.6,
                blend(random),
            );
        }
        if let Ok(rig) = cupola::rig::parse(&text, "stress.toml", Path::new("")) {
            return Ok(Case { rig, text, place: Place::Inside });
        }
    }
    any(random)
}

/// A random `blend` of a projector.
fn blend(random: &mut Random) -> String {
    let power = format!("\"power\", power = {}", random.range(0.5, 4.0));
    let shape = pick(random, &["\"smoothstep\"", "\"cosine\"", &power]).to_owned();
    let exponent = random.range(1.0, 2.0);
    let contrast = format!(", contrast = {}", 10f64.powf(random.range(2.0, 6.0)));
    let zero = random.range(60.0, 150.0);
    let ramps = format!(
        ", ramps = [{{ angle = \"polar\", zero = {zero}, full = {} }}, {{ angle = \"azimuth\", zero = {}, full = {} }}]",
        zero - random.range(0.5, 30.0),
        random.range(-180.0, -100.0),
        random.range(-90.0, 0.0),
    );
    format!(
        "blend = {{ ramp = {}, shape = {shape}, exponent = {}, gamma = {}{}{} }}\n",
        random.range(0.02, 0.5),
        pick(random, &[1.0, 1.0, exponent]),
        random.range(1.0, 2.6),
        pick(random, &["", "", &contrast]),
        pick(random, &["", "", &ramps]),
    )
}

/// A random `[dome]`, mostly of 5 m, and a `[viewer]` at most `farthest` radii from the centre.
/// Returns the radius too.
fn dome(random: &mut Random, farthest: f64) -> (String, f64) {
    let radius = if random.unit() < 0.7 { 5.0 } else { 10f64.powf(random.range(-4.0, 6.0)) };
    let coverage = pick(random, &[180.0, 180.0, 360.0, 0.0]);
    let coverage = if coverage == 0.0 { random.range(100.0, 360.0) } else { coverage };
    let aside = random.unit() * farthest;
    let viewer = random.direction() * radius * pick(random, &[0.0, aside]);
    let text = format!(
        "[dome]\nradius = {radius}\ntilt = {}\ncoverage = {coverage}\n\
         [viewer]\nposition = {}\nyaw = {}\npitch = {}\nroll = {}\n",
        random.range(-90.0, 90.0),
        vector(viewer),
        random.range(-180.0, 180.0),
        random.range(-90.0, 90.0),
        random.range(-180.0, 180.0),
    );
    (text, radius)
}

/// A random domemaster, from 0.001° to the whole sphere.
fn domemaster(random: &mut Random) -> (String, Place) {
    let farthest = pick(random, &[0.9, 0.9, 0.989]);
    let text = dome(random, farthest).0;
    let (wide, keyhole) = (random.range(1.0, 360.0), 10f64.powf(random.range(-3.0, 0.0)));
    let aperture = pick(random, &[180.0, 360.0, 359.999, wide, keyhole]);
    let text = text
        + &format!(
            "[[output]]\nkind = \"domemaster\"\naperture = {aperture}\ntilt = {}\n",
            random.range(-180.0, 180.0)
        );
    (text, if farthest <= 0.9 { Place::Inside } else { Place::Far })
}

/// A random projector inside, at the surface, or far outside, with any lens shift.
fn projector(random: &mut Random) -> (String, Place) {
    let (text, radius) = dome(random, 0.9);
    let inside = random.unit() * 0.9;
    let distance = pick(random, &[0.0, 0.3, 0.6, 0.9, inside, 0.97, 0.999_999, 1.000_001, 1.1, 2.0, 10.0, 1e3, 1e6]);
    let direction = random.direction();
    let position = direction * radius * distance;
    // Aimed near the centre; from outside, within the disc of the sphere.
    let half = if distance > 1.0 { (1.0 / distance).min(1.0).asin() } else { 0.9 };
    let fov = 2.0 * half.to_degrees() * random.range(0.05, 0.9);
    let aim = -direction;
    let spread = if distance > 1.0 { 0.3 * half.to_degrees() } else { 60.0 };
    let yaw = aim.x.atan2(-aim.z).to_degrees() + random.range(-spread, spread);
    let pitch = aim.y.clamp(-1.0, 1.0).asin().to_degrees() + random.range(-spread, spread);
    let (small, large) = (random.range(-0.5, 0.5), random.range(-2.0, 2.0));
    let shift = pick(random, &[0.0, 0.0, small, large]);
    let text = text
        + &format!(
            "[[output]]\nkind = \"projector\"\nposition = {}\nyaw = {yaw}\npitch = {}\nroll = {}\nfov = [{fov}, {}]\nshift = [{shift}, {}]\n",
            vector(position),
            pitch.clamp(-180.0, 180.0),
            random.range(-180.0, 180.0),
            fov * random.range(0.3, 1.0),
            shift * random.range(-1.0, 1.0),
        );
    let place = match distance {
        0.0..=0.9 => Place::Inside,
        _ => Place::Far,
    };
    (text, place)
}

/// A random flat picture, from 0.01° to 178°.
fn perspective(random: &mut Random) -> (String, Place) {
    let (usual, wide) = (random.range(1.0, 120.0), random.range(120.0, 178.0));
    let fov = pick(random, &[usual, wide, 0.01]);
    let text = format!(
        "[[output]]\nkind = \"perspective\"\nyaw = {}\npitch = {}\nroll = {}\nfov = [{fov}, {}]\nshift = [{}, 0.0]\n",
        random.range(-180.0, 180.0),
        random.range(-90.0, 90.0),
        random.range(-180.0, 180.0),
        fov * random.range(0.3, 1.0),
        random.range(-0.5, 0.5),
    );
    (text, Place::Inside)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_plain_rig_is_valid_and_most_random_ones_are() {
        assert!(cupola::rig::parse(PLAIN, "stress.toml", Path::new("")).is_ok());
        let mut kinds = std::collections::BTreeSet::new();
        for seed in 0..200 {
            let case = any(&mut Random::new(seed)).expect("a rig");
            kinds.insert(case.text.contains("projector") as u8 + 2 * case.text.contains("perspective") as u8);
            assert!(overlapping(&mut Random::new(seed)).expect("a rig").rig.outputs.len() > 1, "{seed}");
        }
        assert_eq!(kinds.len(), 3);
    }
}
