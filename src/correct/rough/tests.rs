use super::plan;
use crate::blend::Weights;
use crate::correct::over;
use crate::correct::passes::output_pass::{OutputPass, Plan};
use crate::correct::plan::builder::build;
use crate::correct::rough::pieces::Opening;
use crate::correct::shaders::draws::{Rows, draws};
use crate::correct::shaders::glsl::{Language, Stage, specialise};
use crate::rig::{OutputKind, Rig};
use crate::views::Request;
use crate::warp::WarpMap;
use crate::warp::accuracy::pixel_angle;
use glam::{DVec2, DVec3};
use std::collections::HashSet;

/// Greatest error of a rough picture up to 640 pixels wide, in pixels.
const PIXELS: f64 = 0.6;
/// Greatest error of its weights, as a part of the light.
const LIGHT: f64 = 0.12;

fn request(rig: &Rig, size: (u32, u32)) -> Request {
    let output_sizes = vec![size; rig.outputs.len()];
    Request { output_sizes, window: (1280, 800), panel: false, primary: false, max_atlas: 8192 }
}

/// The rig with its first output turned to the right.
fn turned(rig: &Rig, degrees: f64) -> Rig {
    let mut rig = rig.clone();
    match &mut rig.outputs[0].kind {
        OutputKind::Projector { angles, .. } => angles[0] -= degrees.to_radians(),
        OutputKind::Optics { optics, .. } => {
            optics.pose.rotation = glam::DMat3::from_rotation_y(-degrees.to_radians()) * optics.pose.rotation;
        }
        OutputKind::Domemaster { tilt, .. } => *tilt += degrees.to_radians(),
        _ => rig.viewer.yaw += degrees.to_radians(),
    }
    rig
}

/// Direction and weight that a pass shows at a pixel position, from its triangles.
fn shown(pass: &OutputPass, pixel: DVec2) -> Option<(DVec3, f64)> {
    pass.batches.iter().find_map(|batch| {
        let facets = batch.facets.as_ref().expect("triangles");
        facets.triangles.iter().find_map(|triangle| {
            let [a, b, c] = triangle.map(|corner| facets.corners[corner as usize]);
            let whole = (b.place - a.place).perp_dot(c.place - a.place);
            let part = |p: DVec2, q: DVec2| (p - pixel).perp_dot(q - pixel) / whole;
            let parts = [part(b.place, c.place), part(c.place, a.place), part(a.place, b.place)];
            let inside = parts.iter().all(|part| *part >= -1e-9);
            let sum = |of: [f64; 3]| of.iter().zip(parts).map(|(value, part)| value * part).sum();
            inside.then(|| {
                let direction = a.direction * parts[0] + b.direction * parts[1] + c.direction * parts[2];
                (direction, sum([a.weight, b.weight, c.weight]))
            })
        })
    })
}

/// Compares a rough plan with the exact maps of a rig at pixels all over its outputs.
#[derive(Debug, Default)]
struct Compared {
    /// Pixels that an old view shows, and those of them that the rough plan leaves black.
    covered: usize,
    missing: usize,
    /// Greatest errors.
    pixels: f64,
    light: f64,
}

fn compare(rig: &Rig, size: (u32, u32), old: &Plan, rough: &Plan) -> Compared {
    let mut found = Compared::default();
    let sizes = vec![size; rig.outputs.len()];
    let weights = Weights::new(rig, &sizes).expect("weights");
    for (index, pass) in rough.passes.iter().enumerate() {
        let map = WarpMap::new(rig, index, size, None).expect("a map");
        let views = over::views_of(old, index, 0.0, u64::MAX);
        let openings: Vec<_> = views.into_iter().map(|view| Opening::of(&old.views, view)).collect();
        for (column, row) in (0..size.1).step_by(23).flat_map(|row| (0..size.0).step_by(17).map(move |x| (x, row))) {
            let pixel = DVec2::new(f64::from(column) + 0.5, f64::from(row) + 0.5);
            let Some(exact) = map.direction(pixel) else { continue };
            if !openings.iter().any(|opening| opening.shows(exact)) {
                continue;
            }
            found.covered += 1;
            let Some((direction, weight)) = shown(pass, pixel) else {
                found.missing += 1;
                continue;
            };
            let angle = exact.cross(direction).length().atan2(exact.dot(direction));
            if let Some(width) = pixel_angle(&map, pixel) {
                found.pixels = found.pixels.max(angle / width);
            }
            let expected = weights.weight(index, pixel).unwrap_or_default();
            found.light = found.light.max((weight - expected).abs());
        }
    }
    found
}

#[test]
fn a_rough_picture_is_within_its_bound_where_the_old_views_show_it() {
    for (name, size) in [("planetarium-6", (480, 270)), ("planetarium-2", (640, 400)), ("fisheye", (512, 512))] {
        let rig = crate::rig::load(name).expect("a preset");
        let request = request(&rig, size);
        let old = build(&rig, &request).expect("a plan");
        for degrees in [0.0, 3.0, -10.0] {
            let new = turned(&rig, degrees);
            let rough = plan(&new, &request, &old, u64::MAX).expect("it serves");
            let found = compare(&new, size, &old, &rough);
            println!("{name} {degrees}°: {found:?}");
            assert!(found.pixels < PIXELS && found.light < LIGHT, "{name} {degrees}: {found:?}");
            // Cells at the rim and at the border of what is shown are left out.
            assert!(found.covered > 400 && found.missing * 40 < found.covered, "{name} {degrees}: {found:?}");
            // Negative control: the rough picture of a rig that is turned a little further.
            let other = plan(&turned(&rig, degrees + 0.5), &request, &old, u64::MAX).expect("it serves");
            assert!(compare(&new, size, &old, &other).pixels > PIXELS, "{name} {degrees}");
        }
    }
}

/// So its shaders need not be compiled for each change.
#[test]
fn the_shaders_of_rough_pictures_have_no_numbers_of_the_rig() {
    let rig = crate::rig::load("planetarium-6").expect("a preset");
    let request = request(&rig, (480, 270));
    let old = build(&rig, &request).expect("a plan");
    let texts = |plan: &Plan| -> HashSet<String> {
        let list = draws(plan, &plan.passes, false, Rows::FromBottom).expect("draws");
        let draws = list.outputs.iter().flatten();
        draws.map(|draw| specialise(&draw.constants, Language::Glsl330, Stage::Present).fragment).collect()
    };
    let rough = |degrees| texts(&plan(&turned(&rig, degrees), &request, &old, u64::MAX).expect("it serves"));
    // One for the pictures, one for black.
    assert_eq!((rough(1.0).len(), rough(1.0)), (2, rough(2.0)));
    // Negative control: those of exact pictures have.
    let exact = |degrees| texts(&build(&turned(&rig, degrees), &request).expect("a plan"));
    assert_ne!(exact(1.0), exact(2.0));
}

#[test]
fn views_that_cannot_serve_are_refused() {
    let rig = crate::rig::load("planetarium-2").expect("a preset");
    let request = request(&rig, (640, 400));
    let old = build(&rig, &request).expect("a plan");
    assert!(plan(&rig, &request, &old, u64::MAX).is_some());
    let mut fewer = rig.clone();
    fewer.outputs.pop();
    assert!(plan(&fewer, &request, &old, u64::MAX).is_none(), "another number of outputs");
    let mut own = old.clone();
    own.views.views[0].program_lens = true;
    assert!(plan(&rig, &request, &own, u64::MAX).is_none(), "a view with the program's own lens");
    // Views that are not drawn are not shown.
    let none = plan(&rig, &request, &old, 0).expect("it serves");
    assert!(none.passes.iter().all(|pass| pass.batches.is_empty()));
}
