//! The planner against brute force: every pixel, random rigs, and the bars of the design.

use super::*;
use crate::geom::testing::Random;
use crate::rig::*;
use crate::warp::{WarpMap, exact_direction};
use glam::{DMat3, DVec2, DVec3};
use std::f64::consts::PI;

pub(crate) fn rig(outputs: Vec<Output>) -> Rig {
    Rig {
        name: "test".into(),
        passthrough: false,
        dome: Dome { radius: 5.0, tilt: 0.0, coverage: 2.0 * PI },
        viewer: Viewer { position: DVec3::ZERO, yaw: 0.0, pitch: 0.0, roll: 0.0 },
        camera: Camera { zoom: 1.0, shift: DVec3::ZERO, yaw: 0.0, pitch: 0.0, roll: 0.0 },
        views: Views { method: ViewMethod::Auto, quality: 1.0 },
        overlay: Overlay { yaw: 0.0, pitch: 0.0, width: 1.0 },
        outputs,
    }
}

pub(crate) fn output(name: &str, kind: OutputKind) -> Output {
    let blend = Blend { overlap: false, ramp: 0.2, ramps: Vec::new(), gamma: 2.2, black_level: 0.0 };
    Output { name: name.into(), kind, size: None, window: None, blend, mask: None }
}

pub(crate) fn fisheye(aperture_degrees: f64, tilt_degrees: f64) -> Output {
    output("dome", OutputKind::Domemaster { aperture: aperture_degrees.to_radians(), tilt: tilt_degrees.to_radians() })
}

pub(crate) fn lens(width_degrees: f64, height_degrees: f64) -> Frustum {
    Frustum::symmetric(width_degrees.to_radians(), height_degrees.to_radians())
}

pub(crate) fn projector(name: &str, position: DVec3, degrees: [f64; 3], frustum: Frustum) -> Output {
    output(name, OutputKind::Projector { position, angles: degrees.map(f64::to_radians), frustum })
}

pub(crate) fn request(sizes: &[(u32, u32)]) -> Request {
    Request { output_sizes: sizes.to_vec(), window: (800, 600), panel: false, primary: false, max_atlas: 16384 }
}

fn texels(plan: &ViewPlan) -> f64 {
    plan.views.iter().map(|view| f64::from(view.tile.width) * f64::from(view.tile.height)).sum()
}

/// Where a view shows a direction, in its tangents.
fn tangents(view: &View, direction: DVec3) -> Option<DVec2> {
    let local = view.rotation * direction;
    (local.z < 0.0).then(|| DVec2::new(local.x, local.y) / -local.z)
}

/// Where a view shows a direction, in texels from the tile's lower left corner.
fn texel(view: &View, direction: DVec3) -> Option<DVec2> {
    let at = tangents(view, direction)?;
    let part = DVec2::new(
        (at.x - view.frustum.left) / view.frustum.width(),
        (at.y - view.frustum.bottom) / view.frustum.height(),
    );
    Some(part * DVec2::new(f64::from(view.tile.width), f64::from(view.tile.height)))
}

/// The view that answers for a direction that `output` shows.
fn answering(plan: &ViewPlan, output: usize, direction: DVec3) -> Option<usize> {
    plan.output_views[output].iter().copied().find(|&view| {
        let view = &plan.views[view];
        tangents(view, direction).is_some_and(|at| view.owned.contains(at.x, at.y))
    })
}

/// Texels per pixel around a pixel: the least over all directions. Of a domemaster, per nominal pixel.
fn least_density(rig: &Rig, output: usize, size: (u32, u32), pixel: DVec2, view: &View) -> Option<f64> {
    const STEP: f64 = 1e-3;
    let at = |offset: DVec2| texel(view, exact_direction(rig, output, size, pixel + offset)?);
    let derivative = |axis: DVec2| Some((at(axis * STEP)? - at(-axis * STEP)?) / (2.0 * STEP));
    let (first, second) = if let OutputKind::Domemaster { aperture, .. } = rig.outputs[output].kind {
        let middle = 0.5 * DVec2::new(f64::from(size.0), f64::from(size.1));
        let radial = (pixel - middle).normalize_or(DVec2::X);
        let angle = (pixel - middle).length() * aperture / f64::from(size.0.min(size.1));
        // Around the axis, a pixel of the lens covers only sin(angle)/angle of a nominal one.
        (derivative(radial)?, derivative(radial.perp())? * if angle > 0.0 { angle / angle.sin() } else { 1.0 })
    } else {
        (derivative(DVec2::X)?, derivative(DVec2::Y)?)
    };
    let (a, b, c) = (first.length_squared(), first.dot(second), second.length_squared());
    Some((0.5 * (a + c) - (0.25 * (a - c) * (a - c) + b * b).sqrt()).max(0.0).sqrt())
}

/// Checks a plan against every pixel of every output; returns the number of pixels whose
/// resolution was measured, or what is wrong.
fn verify(rig: &Rig, request: &Request, plan: &ViewPlan) -> std::result::Result<usize, String> {
    let mut measured = 0;
    let mut used = vec![false; plan.views.len()];
    let scaled_down = plan.notes.iter().any(|note| note.contains("holds no more"));
    for (output, &size) in request.output_sizes.iter().enumerate() {
        let map = WarpMap::new(rig, output, size, Some(sight::UNIT_FRUSTUM)).unwrap();
        for (x, y) in (0..size.1).flat_map(|y| (0..size.0).map(move |x| (x, y))) {
            let wrong = |what: String| Err(format!("{what} at pixel {x}, {y} of output {output}, {rig:?}, {plan:?}"));
            let pixel = DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5);
            let Some(direction) = map.direction(pixel) else { continue };
            let Some(index) = answering(plan, output, direction) else { return wrong("no view".into()) };
            used[index] = true;
            let view = &plan.views[index];
            let size = DVec2::new(f64::from(view.tile.width), f64::from(view.tile.height));
            let slack = 1e-9 * size.max_element();
            let inside = |at: DVec2| at.cmpge(DVec2::splat(0.5 - slack)).all() && at.cmple(size - 0.5 + slack).all();
            if !texel(view, direction).is_some_and(inside) {
                return wrong(format!("the footprint leaves the tile of view {index}"));
            }
            if scaled_down || view.program_lens {
                continue;
            }
            if let Some(density) = least_density(rig, output, request.output_sizes[output], pixel, view) {
                measured += 1;
                if density < 0.999 * rig.views.quality {
                    return wrong(format!("{density} texels per pixel in view {index}"));
                }
            }
        }
    }
    match used.iter().position(|used| !used) {
        Some(idle) => Err(format!("nothing samples view {idle} of {rig:?}, {plan:?}")),
        None => Ok(measured),
    }
}

/// A rig of up to four outputs, with everything that the planner depends on.
fn random_rig(random: &mut Random) -> (Rig, Request) {
    let count = 1 + (random.unit() * 4.0) as usize;
    let mut rig = rig(Vec::new());
    rig.dome.radius = random.range(1.0, 20.0);
    rig.dome.tilt = random.range(0.0, PI / 2.0);
    if random.unit() < 0.6 {
        rig.dome.coverage = random.range(2.0, 5.5);
    }
    rig.viewer = Viewer {
        position: random.direction() * random.range(0.0, 0.5) * rig.dome.radius,
        yaw: random.range(-PI, PI),
        pitch: random.range(-1.0, 1.0),
        roll: random.range(-1.0, 1.0),
    };
    rig.views.quality = random.range(0.5, 2.0);
    rig.views.method = if random.unit() < 0.4 { ViewMethod::Cube } else { ViewMethod::Auto };
    let mut sizes = Vec::new();
    for index in 0..count {
        let name = format!("output-{index}");
        let frustum = lens(random.range(20.0, 80.0), random.range(15.0, 60.0))
            .shifted(random.range(-0.3, 0.3), random.range(-0.3, 0.3));
        let angles = [random.range(-PI, PI), random.range(-1.2, 1.2), random.range(-0.5, 0.5)];
        let kind = match (random.unit() * 4.0) as u32 {
            0 => OutputKind::Domemaster { aperture: random.range(1.0, 2.0 * PI), tilt: random.range(0.0, 2.0) },
            1 => OutputKind::Perspective { angles, frustum: Some(frustum) },
            _ => OutputKind::Projector {
                position: random.direction() * random.range(0.0, 0.9) * rig.dome.radius,
                angles,
                frustum,
            },
        };
        rig.outputs.push(output(&name, kind));
        sizes.push((random.range(20.0, 160.0) as u32, random.range(20.0, 120.0) as u32));
    }
    (rig, request(&sizes))
}

#[test]
fn random_rigs_are_shown_completely_sharply_and_without_idle_views() {
    let mut random = Random::new(11);
    let mut measured = 0;
    let rounds = std::env::var("ROUNDS").ok().and_then(|r| r.parse().ok()).unwrap_or(40);
    for round in 0..rounds {
        let (rig, request) = random_rig(&mut random);
        let plan = plan(&rig, &request).unwrap_or_else(|error| panic!("{round}: {error}"));
        measured += verify(&rig, &request, &plan).unwrap_or_else(|error| panic!("{round}: {error}"));
    }
    assert!(measured > 100_000, "only {measured} pixels were measured");
}

#[test]
fn the_check_of_plans_notices_what_is_wrong() {
    let rig = rig(vec![fisheye(180.0, 90.0)]);
    let request = request(&[(100, 100)]);
    let good = plan(&rig, &request).unwrap();
    let fails = |change: &dyn Fn(&mut ViewPlan)| {
        let mut bad = good.clone();
        change(&mut bad);
        verify(&rig, &request, &bad).is_err()
    };
    assert!(!fails(&|_| {}));
    assert!(fails(&|plan| plan.views[0].owned.left = 0.5 * plan.views[0].owned.right), "a part is missing");
    assert!(fails(&|plan| plan.views[1].frustum = plan.views[1].owned), "no guard, so the footprint leaves the tile");
    assert!(fails(&|plan| plan.views[0].tile.width -= 3), "a coarser view");
    assert!(
        fails(&|plan| {
            let mut idle = plan.views[0].clone();
            idle.rotation = DMat3::from_rotation_y(PI);
            plan.views.push(idle);
        }),
        "a view that nothing samples"
    );
}

#[test]
fn the_fisheye_preset_needs_four_views_and_little_more_than_its_disc() {
    for size in [512, 1024, 2048, 4096] {
        let start = std::time::Instant::now();
        let plan = plan(&rig(vec![fisheye(180.0, 90.0)]), &request(&[(size, size)])).unwrap();
        println!("planned in {:?}", start.elapsed());
        let ratio = texels(&plan) / (0.25 * PI * f64::from(size) * f64::from(size));
        println!("{size}: {} views, {ratio:.4} of the disc, atlas {:?}", plan.views.len(), plan.atlas);
        for view in &plan.views {
            println!("   {} {:?} {:?}", view.name, view.tile, view.frustum);
        }
        assert!(plan.views.len() <= 5);
        assert!(ratio <= 2.15, "{ratio}");
    }
}

#[test]
fn a_projector_off_the_centre_needs_one_tight_view() {
    for (position, degrees) in [
        (DVec3::new(0.0, 0.0, 3.0), [0.0; 3]),
        (DVec3::new(0.0, 0.0, -3.0), [0.0; 3]),
        (DVec3::new(3.0, 0.0, 0.0), [0.0; 3]),
    ] {
        let rig = rig(vec![projector("p", position, degrees, lens(60.0, 40.0))]);
        let plan = plan(&rig, &request(&[(1920, 1080)])).unwrap();
        let ratio = texels(&plan) / (1920.0 * 1080.0);
        println!("{position}: {ratio:.4} {:?}", plan.views);
        assert_eq!(plan.views.len(), 1);
        assert!(ratio <= 1.7, "{ratio}");
    }
}
