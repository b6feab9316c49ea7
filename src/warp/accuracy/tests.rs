//! Tests the comparison with maps of known errors, and with the f32 arithmetic of the shaders.

use super::*;
use crate::geom::lenses::equidistant;
use crate::geom::screen::{ClosedSurface, HalfSpace};
use crate::geom::{Frustum, PinholeRays, Pose, QuadraticForm, Quadric, Sphere, pose};
use crate::rig::{OutputKind, Rig};
use crate::testing::random::Random;
use crate::warp::testing::{projector, rig};
use glam::DMat3;
use std::f64::consts::{FRAC_PI_2, PI, TAU};

fn domemaster(aperture: f64) -> Rig {
    rig(FRAC_PI_2, DVec3::ZERO, &[OutputKind::Domemaster { aperture, tilt: FRAC_PI_2 }])
}

fn centre(x: u32, y: u32) -> DVec2 {
    DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5)
}

#[test]
fn the_exact_map_has_no_error_and_a_shifted_one_its_shift() {
    let exact = WarpMap::new(&domemaster(PI), 0, (300, 300), None).expect("valid");
    let same = compare(&exact, 1, |x, y| exact.direction(centre(x, y)).map(|d| d * 1e20));
    assert!(same.max < 1e-12 && same.is_sound() && same.edge < 300, "{same:?}");
    assert!((same.compared as f64 / (FRAC_PI_2 / 2.0 * 300.0 * 300.0) - 1.0).abs() < 0.01);
    // Moves by two thirds of a pixel near the centre, where the lens has the same scale both ways.
    let shifted = compare(&exact, 1, |x, y| {
        let near = centre(x, y).distance(DVec2::splat(150.0)) < 20.0;
        exact.direction(centre(x, y) + if near { DVec2::new(2.0 / 3.0, 0.0) } else { DVec2::ZERO })
    });
    assert!((shifted.max - 2.0 / 3.0).abs() < 0.01 && shifted.is_sound(), "{shifted:?}");
    assert!(shifted.rms < shifted.max && centre(shifted.worst.0, shifted.worst.1).distance(DVec2::splat(150.0)) < 20.0);
}

#[test]
fn faults_are_counted() {
    let exact = WarpMap::new(&domemaster(PI), 0, (64, 64), None).expect("valid");
    let faulty = compare(&exact, 1, |x, y| match (x, y) {
        (30, 30) => Some(DVec3::NAN),
        (31, 30) => Some(DVec3::ZERO),
        (32, 30) => None,
        (33, 30) => exact.direction(centre(x, y)).map(|d| -d),
        (0, 0) => Some(DVec3::X),
        (63, 63) => Some(DVec3::new(f64::INFINITY, 0.0, 0.0)),
        _ => exact.direction(centre(x, y)),
    });
    assert_eq!((faulty.non_finite, faulty.uncovered, faulty.ghosts), (3, 1, 2));
    assert!(!faulty.is_sound());
}

/// Each face has 5.5 columns: the middle of every eleventh column is on a border.
#[test]
fn on_the_border_of_two_faces_either_is_right() {
    let panorama = OutputKind::Panorama { panorama: crate::geom::Panorama::CubeStrip, angles: [0.0; 3] };
    let mut whole = rig(FRAC_PI_2, DVec3::ZERO, &[panorama]);
    whole.dome.coverage = TAU;
    let exact = WarpMap::new(&whole, 0, (33, 40), None).expect("valid");
    let moved = |by: f64| {
        let border = |x: u32| x % 11 == 5;
        compare(&exact, 1, |x, y| exact.direction(centre(x, y) + DVec2::X * if border(x) { by } else { 0.0 }))
    };
    let faces = 3 * 40;
    for by in [0.005, -0.005] {
        let found = moved(by);
        assert!(found.is_sound() && found.edge >= faces / 3 && found.max < 0.1, "{by}: {found:?}");
        assert_eq!(found.compared + found.edge, 33 * 40);
    }
    // A direction farther away is a fault, and so is a face that is nowhere near.
    assert!(!(moved(0.3).is_sound() && moved(0.3).max < 0.1));
    let astray = compare(&exact, 1, |x, y| exact.direction(centre(if x == 5 { 20 } else { x }, y)));
    assert!(!astray.is_sound() || astray.max > 1.0, "{astray:?}");
}

#[test]
fn what_is_shown_elsewhere_is_displaced_by_as_much_as_it_is() {
    // From two radii away the picture contains the whole sphere, whose silhouette crosses it.
    let mut whole =
        rig(FRAC_PI_2, DVec3::new(0.3, -0.2, 0.1), &[projector(DVec3::new(0.0, 0.0, 10.0), 0.0, 0.0, (70.0, 70.0))]);
    whole.dome.coverage = TAU;
    let exact = WarpMap::new(&whole, 0, (300, 300), None).expect("valid");
    let angle = |a: DVec2, b: DVec2| {
        let (a, b) = (exact.direction(a).expect("shown"), exact.direction(b).expect("shown"));
        a.cross(b).length().atan2(a.dot(b))
    };
    let displaced = |pixel: DVec2, by: DVec2| displacement(&exact, pixel, angle(pixel, pixel + by)).expect("shown");
    // In the middle, where pixels are square, the result is the distance of the move.
    for by in [DVec2::new(0.3, 0.4), DVec2::new(-1e-3, 0.0), DVec2::new(0.0, 1e-6)] {
        let found = displaced(DVec2::new(150.2, 149.7), by) / by.length();
        // A step along one axis counts as a diagonal one in the mean.
        assert!((found - 1.0).abs() < 0.01, "{by}: {found}");
    }
    // Moves across the silhouette obliquely to the middle, where a step along either axis leads
    // inside.
    let outward = DVec2::splat(0.5f64.sqrt());
    let at = |distance: f64| DVec2::new(150.2, 149.7) + outward * distance;
    let (mut shown, mut dark) = (0.0, 200.0);
    assert!(exact.direction(at(dark)).is_none());
    for _ in 0..60 {
        let middle = 0.5 * (shown + dark);
        if exact.direction(at(middle)).is_some() { shown = middle } else { dark = middle }
    }
    for by in [1e-2, 1e-4, 1e-6] {
        let pixel = at(shown - by);
        let near = outward * (0.9 * by);
        let (farther, nearer) = (displaced(pixel, near) / (0.9 * by), displaced(pixel, -near) / (0.9 * by));
        assert!((1.0..4.0).contains(&farther) && (0.9..2.0).contains(&nearer), "{by}: {farther} {nearer}");
        // Control: the error of the comparison is far greater there.
        let linear = angle(pixel, pixel + near) / pixel_angle(&exact, pixel).expect("shown");
        assert!(linear > 5.0 * by, "{by}: {linear}");
    }
    // An error of a hundredth of a pixel stays one, wherever it is.
    let mut random = Random::new(3);
    for _ in 0..300 {
        let pixel = DVec2::new(random.range(0.0, 300.0), random.range(0.0, 300.0));
        let (sine, cosine) = random.range(0.0, TAU).sin_cos();
        let by = DVec2::new(cosine, sine) * 0.01;
        if exact.direction(pixel).is_none() || exact.direction(pixel + by).is_none() {
            continue;
        }
        let found = displaced(pixel, by);
        assert!(found > 0.002, "{pixel} {by}: {found}");
    }
}

/// A quadratic form as a shader evaluates it: every coefficient and operation in f32.
fn evaluate_f32(form: &QuadraticForm, x: f32, y: f32) -> Option<DVec3> {
    let quadratic = |c: &[f64; 6]| {
        let [xx, yy, xy, x1, y1, one] = c.map(|c| c as f32);
        (xx * x + (xy * y + x1)) * x + ((yy * y + y1) * y + one)
    };
    let linear = |c: &[f64; 3]| {
        let [x1, y1, one] = c.map(|c| c as f32);
        x1 * x + (y1 * y + one)
    };
    let discriminant = quadratic(&form.d);
    let root = discriminant.max(0.0).sqrt();
    let component = |i: usize| f64::from(quadratic(&form.q[i]) + linear(&form.l[i]) * root);
    (discriminant >= 0.0).then(|| DVec3::new(component(0), component(1), component(2)))
}

#[test]
fn the_closed_form_in_f32_meets_the_goal() {
    // Goal G1: 0.001 px at 1080p.
    let size = (1920u32, 1080u32);
    let positions = [DVec3::ZERO, DVec3::new(0.0, 0.0, 3.0), DVec3::new(0.0, 0.0, 10.0), DVec3::new(0.0, 0.0, 5e4)];
    for position in positions {
        let fov = if position.z > 5.0 { 2.0 * (4.0 / position.z).atan().to_degrees() } else { 60.0 };
        let mut rig = rig(FRAC_PI_2, DVec3::new(0.5, -1.0, 2.0), &[projector(position, 0.0, 0.0, (fov, 0.6 * fov))]);
        rig.dome.coverage = TAU;
        let exact = WarpMap::new(&rig, 0, size, None).expect("valid");
        let OutputKind::Projector { frustum, .. } = rig.outputs[0].kind else { panic!("a projector") };
        let sphere = Sphere { center: DVec3::ZERO, radius: rig.dome.radius };
        let form = QuadraticForm::new(position, frustum.rays(), &sphere, rig.viewer.position, DMat3::IDENTITY);
        let error = compare(&exact, 7, |x, y| {
            let (x, y) = ((x as f32 + 0.5) / 960.0 - 1.0, 1.0 - (y as f32 + 0.5) / 540.0);
            evaluate_f32(&form, x, y)
        });
        assert!(error.is_sound() && error.max <= 1e-3 && error.rms < 3e-4, "{position}: {error:?}");
        // Negative control: the comparison notices the near hit and a wrong viewer.
        let wrong =
            QuadraticForm::new(position, frustum.rays(), &sphere, DVec3::new(0.5, -1.0, 2.001), DMat3::IDENTITY);
        assert!(compare(&exact, 31, |x, y| wrong.evaluate(x as f64 / 960.0 - 1.0, 1.0 - y as f64 / 540.0)).max > 0.1);
    }
}

#[test]
fn the_fisheye_polynomials_in_f32_meet_the_goal() {
    for aperture in [PI, 210f64.to_radians(), 240f64.to_radians(), TAU] {
        let mut rig = domemaster(aperture);
        rig.viewer.position = DVec3::new(0.5, 0.5, 1.0);
        rig.viewer.yaw = 0.5;
        rig.outputs[0].kind = OutputKind::Domemaster { aperture, tilt: 0.3 };
        let exact = WarpMap::new(&rig, 0, (4096, 4096), None).expect("valid");
        let fitted = equidistant::sine_cosine_polynomials(aperture);
        let horner = |c: &[f64], s: f32| c.iter().rev().fold(0.0f32, |sum, c| sum * s + *c as f32);
        let viewer = Pose::new(rig.viewer.position, 0.5, 0.0, 0.0);
        let rotation = pose::rotation(0.0, FRAC_PI_2 - 0.3, 0.0).as_mat3();
        let offset = (viewer.direction_to_local(viewer.position) / -rig.dome.radius).as_vec3();
        let error = compare(&exact, 29, |x, y| {
            let (x, y) = ((x as f32 + 0.5) / 2048.0 - 1.0, 1.0 - (y as f32 + 0.5) / 2048.0);
            let (qx, qy) = (x * (0.5 * aperture) as f32, y * (0.5 * aperture) as f32);
            let s = qx * qx + qy * qy;
            let sine = horner(&fitted.sine, s);
            let lens = glam::Vec3::new(qx * sine, qy * sine, -horner(&fitted.cosine, s));
            (x * x + y * y <= 1.0).then(|| (rotation * lens + offset).as_dvec3())
        });
        assert!(error.is_sound() && error.max <= 2e-3, "{aperture}: {error:?}");
    }
}

#[test]
fn the_recipe_with_two_arccosines_is_found_out() {
    // Computes θ = acos(z), φ = acos(x/sin θ), and the direction from both: NaN near the axis and
    // the meridian y = 0.
    let exact = WarpMap::new(&domemaster(PI), 0, (4095, 4095), None).expect("valid");
    // 23 divides 2047: the middle row and column are among the samples.
    let error = compare(&exact, 23, |x, y| {
        let d = exact.direction(centre(x, y))?.as_vec3();
        let theta = (-d.z).acos();
        let phi = (d.x / theta.sin()).acos() * d.y.signum();
        Some(glam::Vec3::new(theta.sin() * phi.cos(), theta.sin() * phi.sin(), -theta.cos()).as_dvec3())
    });
    assert!(error.non_finite > 0 && error.max > 0.1, "{error:?}");
}

#[test]
fn a_pixel_has_the_size_that_the_lens_gives_it() {
    let exact = WarpMap::new(&domemaster(PI), 0, (1000, 1000), None).expect("valid");
    let at_centre = pixel_angle(&exact, DVec2::splat(500.0)).expect("shown");
    assert!((at_centre / (PI / 1000.0) - 1.0).abs() < 1e-5);
    let narrow = rig(
        FRAC_PI_2,
        DVec3::ZERO,
        &[OutputKind::Perspective { angles: [0.0; 3], frustum: Some(Frustum::symmetric(0.02, 0.02)) }],
    );
    let window = WarpMap::new(&narrow, 0, (100, 100), None).expect("valid");
    assert!((pixel_angle(&window, DVec2::splat(50.0)).expect("shown") / 2e-4 - 1.0).abs() < 1e-3);
}

#[test]
fn projectors_anywhere_are_sound_in_f32() {
    // Goals G1 and G2 at 2160p, over random rigs: projector and viewer anywhere, a cap of any size.
    let mut random = Random::new(40);
    let size = (3840u32, 2160u32);
    let (mut compared, mut dark) = (0, 0);
    for round in 0..120 {
        let outside = round % 3 == 2;
        let distance = 5.0 * if outside { 10f64.powf(random.range(0.3, 6.0)) } else { random.range(0.0, 0.95) };
        let position = random.direction() * distance;
        // Aims at a point in the dome, however far away it is.
        let forward = (random.direction() * random.range(0.0, 2.0) - position).normalize();
        let angles = [forward.x.atan2(-forward.z), forward.y.asin(), random.range(-PI, PI)];
        let half = if outside { random.range(0.3, 1.1) * 5.0 / distance } else { random.range(0.1, 1.5) };
        let shift = (random.range(-0.3, 0.3), random.range(-0.3, 0.3));
        let frustum =
            Frustum { left: -half, right: half, bottom: -0.6 * half, top: 0.6 * half }.shifted(shift.0, shift.1);
        let viewer = random.direction() * random.range(0.0, 4.5);
        let mut rig = rig(random.range(0.0, PI), viewer, &[OutputKind::Projector { position, angles, frustum }]);
        rig.dome.coverage = random.range(1.0, TAU + 1.0).min(TAU);
        (rig.viewer.yaw, rig.viewer.roll) = (random.range(-PI, PI), random.range(-PI, PI));
        let exact = WarpMap::new(&rig, 0, size, None).expect("valid");
        let sphere = Sphere { center: DVec3::ZERO, radius: rig.dome.radius };
        let rays = pose::rotation(angles[0], angles[1], angles[2]) * frustum.rays();
        let to_viewer = pose::rotation(rig.viewer.yaw, 0.0, rig.viewer.roll).transpose();
        let form = QuadraticForm::new(position, rays, &sphere, viewer, to_viewer);
        let pole = DVec3::new(0.0, rig.dome.tilt.cos(), -rig.dome.tilt.sin());
        let limit = HalfSpace { normal: pole, distance: rig.dome.radius * (0.5 * rig.dome.coverage).cos() };
        let surface = ClosedSurface::Quadric(Quadric::from(&sphere));
        let cap = PinholeRays { origin: position, rays, surface }.within([Some(limit), None, None]);
        let error = compare(&exact, 47, |x, y| {
            let (x, y) = ((x as f32 + 0.5) / 1920.0 - 1.0, 1.0 - (y as f32 + 0.5) / 1080.0);
            let on_screen = rig.dome.coverage >= TAU || evaluate_f32(&cap, x, y)?.x >= 0.0;
            if on_screen { evaluate_f32(&form, x, y) } else { None }
        });
        assert!(error.is_sound() && error.max <= 2e-3 && error.rms <= 8e-4, "{round}: {distance} m, {error:?}");
        compared += error.compared;
        dark += 82 * 46 - error.compared;
    }
    assert!(compared > 200_000 && dark > 100_000, "both lit and dark pixels occur: {compared}, {dark}");
}
