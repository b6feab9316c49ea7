//! Random lenses and pictures of directions on random screens, as rig files.

use super::case::{ATTEMPTS, Case, PLAIN, Place, pick, vector};
use super::maps;
use crate::random::Random;
use cupola::rig::Rig;
use glam::DVec3;
use std::path::Path;

/// A random rig with one output on a screen of any shape. Some outputs have a formula, others need
/// a table.
pub fn any(random: &mut Random) -> Result<Case, cupola::Error> {
    for _ in 0..ATTEMPTS {
        let (text, place) = text(random);
        if let Ok(rig) = parse(&text) {
            return Ok(Case { rig, text, place });
        }
    }
    Ok(Case { rig: parse(PLAIN)?, text: PLAIN.to_owned(), place: Place::Inside })
}

fn parse(text: &str) -> cupola::Result<Rig> {
    cupola::rig::parse(text, "stress.toml", Path::new(""))
}

/// A random rig file, which may be invalid, and the place of viewer and projector.
fn text(random: &mut Random) -> (String, Place) {
    let radius = if random.unit() < 0.7 { 5.0 } else { 10f64.powf(random.range(-2.0, 4.0)) };
    let aside = random.unit() * pick(random, &[0.5, 0.9]);
    let viewer = pick(random, &[0.0, aside]);
    let head = format!(
        "[dome]\nradius = {radius}\ntilt = {}\n{}[viewer]\nposition = {}\nyaw = {}\npitch = {}\nroll = {}\n[[output]]\n",
        random.range(-90.0, 90.0),
        screen(random, radius),
        vector(random.direction() * radius * viewer),
        random.range(-180.0, 180.0),
        random.range(-90.0, 90.0),
        random.range(-180.0, 180.0),
    );
    let (output, distance) = if random.unit() < 0.4 { (picture(random), 0.0) } else { projector(random, radius) };
    // Screens reach from 0.7 to 1.6 radii, so a place beyond 0.6 radii may be near the screen.
    let place = if viewer.max(distance) <= 0.6 { Place::Inside } else { Place::Far };
    (head + &output, place)
}

/// A random size as in [`maps::size`], or, rarely, a strip of up to 16384 pixels.
pub fn size(random: &mut Random) -> (u32, u32) {
    let (long, short) = (16384.0 * random.range(0.1, 1.0), random.range(16.0, 48.0));
    let cubemap_faces = [(long as u32, short as u32), (short as u32, long as u32)];
    let strip = pick(random, &cubemap_faces);
    let usual = maps::size(random);
    pick(random, &[usual, usual, usual, usual, usual, usual, usual, strip])
}

/// A random `[screen]` around the centre of the dome and about as large as its radius; or none.
pub fn screen(random: &mut Random, radius: f64) -> String {
    let aside = vector(random.direction() * radius * random.range(0.0, 0.3));
    let [a, b, c] = [(); 3].map(|()| radius * random.range(0.7, 1.6));
    let (bottom, top) = (-radius * random.range(0.3, 1.5), radius * random.range(0.3, 1.5));
    let coverage = format!("coverage = {}\n", random.range(120.0, 360.0));
    let part = format!("azimuth = [{}, {}]\n", random.range(-180.0, -30.0), random.range(30.0, 180.0));
    let (coverage, part) = (pick(random, &["", &coverage]).to_owned(), pick(random, &["", &part]).to_owned());
    let pose = format!(
        "yaw = {}\npitch = {}\nroll = {}\nposition = {}\n",
        random.range(-180.0, 180.0),
        random.range(-90.0, 90.0),
        random.range(-180.0, 180.0),
        pick(random, &["[0, 0, 0]", &aside]),
    );
    let shape = match random.unit() {
        kind if kind < 0.2 => return coverage,
        kind if kind < 0.35 => format!("shape = \"sphere\"\nradius = {a}\n{coverage}{part}"),
        kind if kind < 0.5 => format!("shape = \"ellipsoid\"\nradii = [{a}, {b}, {c}]\n{coverage}{part}"),
        kind if kind < 0.6 => format!("shape = \"ellipsoid\"\nradii = [{a}, {b}, {a}]\n{coverage}{part}"),
        kind if kind < 0.75 => format!("shape = \"cylinder\"\nradius = {a}\nheights = [{bottom}, {top}]\n{part}"),
        kind if kind < 0.9 => format!("shape = \"cone\"\nradii = [{a}, {b}]\nheights = [{bottom}, {top}]\n{part}"),
        _ => {
            let turned = format!("yaw = {}\npitch = {}\n", random.range(-30.0, 30.0), random.range(-30.0, 30.0));
            let plane = format!("shape = \"plane\"\nsize = [{}, {}]\n", 2.0 * a, b);
            return format!("[screen]\n{plane}{turned}position = [0, 0, {}]\n", -c);
        }
    };
    format!("[screen]\n{shape}{pose}")
}

/// A random opening from a millionth of a degree to `widest` degrees.
fn opening(random: &mut Random, widest: f64) -> f64 {
    let (wide, keyhole) = (random.range(1.0, widest), 10f64.powf(random.range(-6.0, 0.0)));
    pick(random, &[widest, wide, wide, wide, keyhole])
}

/// A random projection and aperture of a fisheye.
fn curve(random: &mut Random, separator: &str) -> String {
    let [f3, f5] = [random.range(-0.08, 0.05), random.range(-0.005, 0.005)];
    let (curve, widest) = match random.unit() {
        kind if kind < 0.2 => ("projection = \"equidistant\"".to_owned(), 360.0),
        kind if kind < 0.4 => ("projection = \"equisolid\"".to_owned(), 360.0),
        kind if kind < 0.6 => ("projection = \"stereographic\"".to_owned(), 350.0),
        kind if kind < 0.75 => ("projection = \"orthographic\"".to_owned(), 180.0),
        kind if kind < 0.9 => {
            (format!("projection = \"polynomial\"{separator}coefficients = [1, {f3}, {f5}, 0]"), 200.0)
        }
        _ => {
            let nodes = format!("[[20, {}], [40, 0.49], [60, {}], [85, 1]]", 0.25 + f5, 0.72 + 0.3 * f3);
            (format!("projection = \"measured\"{separator}measured = {nodes}"), 170.0)
        }
    };
    format!("{curve}{separator}aperture = {}", opening(random, widest))
}

/// A random picture of directions around the centre of the dome.
fn picture(random: &mut Random) -> String {
    let turned = format!(
        "yaw = {}\npitch = {}\nroll = {}\n",
        random.range(-180.0, 180.0),
        random.range(-90.0, 90.0),
        random.range(-180.0, 180.0)
    );
    let width = opening(random, 360.0).max(0.1);
    let low = random.range(-89.0, 80.0);
    let high = low + (89.0 - low) * opening(random, 100.0) / 100.0;
    match random.unit() {
        kind if kind < 0.5 => {
            format!("kind = \"domemaster\"\n{}\ntilt = {}\n", curve(random, "\n"), random.range(-180.0, 180.0))
        }
        kind if kind < 0.7 => {
            format!("kind = \"equirectangular\"\nwidth = {width}\nlatitudes = [{low}, {high}]\n{turned}")
        }
        kind if kind < 0.9 => format!("kind = \"cylindrical\"\nwidth = {width}\nlatitudes = [{low}, {high}]\n{turned}"),
        _ => format!("kind = \"cubemap\"\n{turned}"),
    }
}

/// A random projector with any lens, and its distance from the centre in radii.
fn projector(random: &mut Random, radius: f64) -> (String, f64) {
    let inside = random.unit() * 0.9;
    let distance = pick(random, &[0.0, 0.3, 0.6, inside, inside, 0.95, 2.0, 1e3]);
    let direction = random.direction();
    let half = if distance > 1.0 { (1.0 / distance).min(1.0).asin().to_degrees() } else { 50.0 };
    let spread = if distance > 1.0 { 0.3 * half } else { 60.0 };
    let head = format!(
        "kind = \"projector\"\nposition = {}\nyaw = {}\npitch = {}\nroll = {}\n",
        vector(direction * radius * distance),
        (-direction.x).atan2(direction.z).to_degrees() + random.range(-spread, spread),
        -direction.y.clamp(-1.0, 1.0).asin().to_degrees() + random.range(-spread, spread),
        random.range(-180.0, 180.0),
    );
    let fov = 2.0 * half * random.range(0.05, 0.9);
    let pinhole = format!("fov = [{fov}, {}]\n", fov * random.range(0.3, 1.0));
    let lens = lens(random, &pinhole, direction, direction * radius * distance, radius);
    (head + &lens, distance)
}

/// A random lens of a projector at `position`, in this direction from the centre, as keys of its
/// output; `pinhole` opens those without a formula of their own.
pub fn lens(random: &mut Random, pinhole: &str, direction: DVec3, position: DVec3, radius: f64) -> String {
    let corner = |random: &mut Random, x: f64, y: f64| {
        format!("[{}, {}]", x * random.range(0.6, 1.0), y * random.range(0.6, 1.0))
    };
    match random.unit() {
        kind if kind < 0.2 => format!("{pinhole}shift = [{}, {}]\n", random.range(-0.6, 0.6), random.range(-0.6, 0.6)),
        kind if kind < 0.35 => {
            let corners = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)].map(|(x, y)| corner(random, x, y));
            format!("{pinhole}keystone = [{}]\n", corners.join(", "))
        }
        kind if kind < 0.5 => {
            let [k1, k2, p1, p2] = [0.15, 0.03, 0.004, 0.004].map(|most| random.range(-most, most));
            format!("{pinhole}distortion = {{ radial = [{k1}, {k2}, 0], tangential = [{p1}, {p2}] }}\n")
        }
        kind if kind < 0.85 => {
            let size = format!(", size = [{}, {}]", random.range(0.5, 1.5), random.range(0.5, 2.0));
            format!("fisheye = {{ {}{} }}\n", curve(random, ", "), pick(random, &["", &size]))
        }
        _ => {
            // The mirror is ahead of the lens, at a distance of 1.5 to 4 of its radii.
            let mirror = random.range(0.05, 0.25) * radius;
            let away = mirror * random.range(1.5, 4.0);
            let ahead = -direction * away + random.direction() * 0.3 * mirror;
            format!("{pinhole}mirror = {{ center = {}, radius = {mirror} }}\n", vector(position + ahead))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeMap;

    #[test]
    fn every_screen_meets_every_kind_of_output() {
        let mut pairs = BTreeMap::new();
        let word = |text: &str, words: &[&'static str]| {
            words.iter().copied().find(|word| text.contains(word)).unwrap_or("plain")
        };
        for seed in 0..3_000 {
            let text = any(&mut Random::new(seed)).expect("a rig").text;
            let screen = word(&text, &["\"sphere\"", "\"ellipsoid\"", "\"cylinder\"", "\"cone\"", "\"plane\""]);
            let lenses = [
                "domemaster",
                "equirect",
                "cylindrical",
                "cubemap",
                "keystone",
                "distortion",
                "fisheye",
                "mirror",
                "shift",
            ];
            *pairs.entry((screen, word(&text, &lenses))).or_insert(0) += 1;
        }
        // Pictures of all directions are not possible on a plane.
        assert!(pairs.len() >= 6 * 9 - 4, "{pairs:?}");
        let plain: u32 = pairs.iter().filter(|((_, lens), _)| *lens == "plain").map(|(_, count)| count).sum();
        assert_eq!(plain, 0, "{pairs:?}");
    }
}
