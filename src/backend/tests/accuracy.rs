//! Results of the shaders, compared with f64.

use super::Driver;
use super::plans::*;
use crate::correct::Plan;
use crate::correct::shaders::map::MapPixel;
use crate::geom::Frustum;
use glam::DVec3;

#[derive(Debug)]
struct Comparison {
    /// Greatest angle between the two directions, in pixels of the output.
    worst: f64,
    /// Number of pixels where only one of both shows something.
    disagreements: usize,
    not_finite: usize,
    compared: usize,
}

/// Compares pixels with `exact`. `pixel`: returns the angle of a pixel around the exact direction.
fn compare(
    map: &[MapPixel],
    width: u32,
    step: usize,
    exact: impl Fn(u32, u32) -> Option<DVec3>,
    pixel: impl Fn(u32, u32, DVec3) -> f64,
) -> Comparison {
    let mut found = Comparison { worst: 0.0, disagreements: 0, not_finite: 0, compared: 0 };
    // These numbers are small if they are finite, so their sum detects one that is not.
    let sum = |shown: &MapPixel| {
        let ([x, y, z], [u, v]) = (shown.direction, shown.atlas);
        x + y + z + u + v
    };
    found.not_finite = map.iter().filter(|shown| shown.view.is_some() && !sum(shown).is_finite()).count();
    let width = width as usize;
    let compared = (0..map.len() / width).flat_map(|row| {
        let first = (step - 7 * row % step) % step;
        (first..width).step_by(step).map(move |column| (column, row))
    });
    for (column, row) in compared {
        let shown = &map[row * width + column];
        let (column, row) = (column as u32, row as u32);
        match (exact(column, row), shown.view) {
            (Some(direction), Some(_)) => {
                let [x, y, z] = shown.direction.map(f64::from);
                let angle = direction.cross(DVec3::new(x, y, z)).length().asin();
                let opposite = direction.dot(DVec3::new(x, y, z)) < 0.0;
                let error = if opposite { f64::INFINITY } else { angle / pixel(column, row, direction) };
                found.worst = found.worst.max(error);
                found.compared += 1;
            }
            (None, None) => {}
            _ => found.disagreements += 1,
        }
    }
    found
}

pub fn fisheye_180_at_4096(driver: &dyn Driver) {
    let size = (4096, 4096);
    let aperture = std::f64::consts::PI;
    let plan = fisheye_plan(size, aperture, DVec3::ZERO);
    let map = driver.map(&plan, 0);
    let pixel = aperture / 4096.0;
    let found = compare(&map, size.0, 3, |c, r| fisheye_direction(&plan, size, c, r), |_, _, _| pixel);
    println!("fisheye 180° at 4096²: {found:?}");
    assert!(found.worst <= 0.002 && found.not_finite == 0, "{found:?}");
    assert!(found.compared > 4_000_000);
    // Pixels whose centre lies on the rim within f32's rounding.
    assert!(found.disagreements < 8, "{found:?}");
    // Negative control: a shift by half a pixel is noticed.
    let aside = |c: u32, r: u32| fisheye_direction(&plan, (4096, 4095), c, r.min(4094));
    assert!(compare(&map, size.0, 997, aside, |_, _, _| pixel).worst > 0.2);
}

pub fn wide_fisheyes_not_square_and_off_centre(driver: &dyn Driver) {
    for (degrees, offset) in [(210.0f64, DVec3::ZERO), (240.0, DVec3::new(0.3, -0.4, 0.2)), (360.0, DVec3::ZERO)] {
        let size = (640, 512);
        let aperture = degrees.to_radians();
        let plan = fisheye_plan(size, aperture, offset);
        let map = driver.map(&plan, 0);
        // For a viewer off the centre, a pixel spans as little as 1/(1 + |offset|) of its angle.
        let pixel = aperture / 512.0 / (1.0 + offset.length());
        let found = compare(&map, size.0, 1, |c, r| fisheye_direction(&plan, size, c, r), |_, _, _| pixel);
        println!("fisheye {degrees}°: {found:?}");
        assert!(found.worst <= 0.002 && found.not_finite == 0 && found.disagreements < 4, "{degrees}°: {found:?}");
    }
}

/// Returns the exact direction of a projector's pixel, in viewer axes.
fn projector_direction(projector: &Projector, size: (u32, u32), column: u32, row: u32) -> Option<DVec3> {
    let viewer = viewer();
    let (x, y) = normalised(size, column, row);
    let hit = projector.hit(x, y)?;
    Some((viewer.rotation.transpose() * (hit - viewer.position)).normalize())
}

fn compare_projector(map: &[MapPixel], projector: &Projector, size: (u32, u32), step: usize) -> Comparison {
    let exact = |c, r| projector_direction(projector, size, c, r);
    let pixel = |c, r, a: DVec3| match (exact(c + 1, r), exact(c, r + 1)) {
        // The shorter side of the pixel.
        (Some(b), Some(d)) => a.distance(b).min(a.distance(d)),
        _ => 0.0,
    };
    compare(map, size.0, step, exact, pixel)
}

pub fn projectors_from_near_the_centre_to_near_the_screen(driver: &dyn Driver) {
    for (size, bound) in [((1920, 1080), 0.001), ((3840, 2160), 0.002)] {
        for distance in [0.3, 0.6, 0.9] {
            let projector = Projector::at(distance);
            let plan = projector_plan(&projector, &[], size);
            let map = driver.map(&plan, 0);
            let found = compare_projector(&map, &projector, size, 3);
            println!("projector at {distance} R, {size:?}: {found:?}");
            assert!(found.worst <= bound && found.not_finite == 0 && found.disagreements == 0, "{distance}: {found:?}");
            // Negative control: a projector that is moved by a ten-thousandth of the radius.
            let mut moved = projector;
            moved.pose.position.x += 1e-4;
            assert!(compare_projector(&map, &moved, size, 997).worst > 2.0 * bound);
        }
    }
}

pub fn projectors_outside_however_far(driver: &dyn Driver) {
    let size = (1920, 1080);
    for distance in [0.97, 2.0, 10.0, 1e3, 1e6] {
        let half = 0.5 / f64::max(distance, 1.0);
        let projector = Projector {
            pose: crate::geom::Pose::new(DVec3::new(0.0, 0.0, distance), 0.0, 0.0, 0.1),
            frustum: Frustum { left: -half, right: half, bottom: -half, top: 0.8 * half },
            ramp: 0.2,
        };
        let plan = projector_plan(&projector, &[], size);
        let map = driver.map(&plan, 0);
        let found = compare_projector(&map, &projector, size, 7);
        println!("projector at {distance} R: {found:?}");
        assert!(found.worst <= 0.004 && found.not_finite == 0 && found.disagreements == 0, "{distance}: {found:?}");
    }
}

pub fn several_views_and_one_agree(driver: &dyn Driver) {
    let size = (640, 480);
    let projector = Projector::at(0.6);
    let mut plan = projector_plan(&projector, &[], size);
    plan.views = cube_views(700, viewer().rotation);
    plan.passes[0].batches[0].views = (0..6).collect();
    for edge in [false, true] {
        plan.passes[0].batches[0].edge = edge;
        let map = driver.map(&plan, 0);
        let found = compare_projector(&map, &projector, size, 1);
        assert!(found.worst <= 0.001 && found.not_finite == 0 && found.disagreements == 0, "{found:?}");
        let used: std::collections::BTreeSet<_> = map.iter().map(|p| p.view).collect();
        assert!(used.len() >= 2, "only {used:?}");
    }
}

pub fn a_projector_outside_misses_around_the_sphere(driver: &dyn Driver) {
    let size = (640, 480);
    let mut projector = Projector::at(3.0);
    projector.pose = crate::geom::Pose::new(DVec3::new(0.0, 0.0, 3.0), 0.0, 0.0, 0.0);
    projector.frustum = Frustum { left: -0.5, right: 0.5, bottom: -0.4, top: 0.4 };
    let mut plan = projector_plan(&projector, &[], size);
    plan.views = cube_views(700, viewer().rotation);
    plan.passes[0].batches[0].views = (0..6).collect();
    plan.passes[0].batches[0].edge = true;
    let map = driver.map(&plan, 0);
    let found = compare(&map, size.0, 1, |c, r| projector_direction(&projector, size, c, r), |_, _, _| 1e-3);
    assert!(map[0].view.is_none() && map[size.0 as usize * 240 + 320].view.is_some());
    // Within f32's rounding of the silhouette.
    assert!(found.disagreements < 4 && found.not_finite == 0, "{found:?}");
    assert!(map.iter().all(|p| p.view.is_none() == p.direction[0].is_nan()));
}

pub fn a_perspective_picture(driver: &dyn Driver) {
    let size = (300, 200);
    let frustum = Frustum { left: -0.7, right: 1.1, bottom: -0.6, top: 0.3 };
    let turn = crate::geom::Pose::new(DVec3::ZERO, 0.4, 0.2, 0.1).rotation;
    let source = crate::correct::Source::Perspective { matrix: turn * frustum.rays() };
    let plan = Plan { views: cube_views(400, turn), passes: vec![pass(size, source, (0..6).collect(), false)] };
    let exact = |c, r| {
        let (x, y) = normalised(size, c, r);
        Some((turn * frustum.rays() * DVec3::new(x, y, 1.0)).normalize())
    };
    let map = driver.map(&plan, 0);
    let found = compare(&map, size.0, 1, exact, |_, _, _| 1.8 / 300.0);
    assert!(found.worst < 0.001 && found.disagreements == 0, "{found:?}");
}
