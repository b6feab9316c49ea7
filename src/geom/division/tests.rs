use super::*;
use crate::geom::{Frustum, PictureLens};
use crate::testing::random::Random;
use std::f64::consts::PI;

fn fisheye(aperture: f64) -> PictureMap {
    let lens = PictureLens::Fisheye { aperture, circle: DVec2::ONE, pixels: DVec2::splat(1024.0) };
    PictureMap { viewer: DVec3::ZERO, position: DVec3::ZERO, lens }
}

fn projector() -> PictureMap {
    let lens = PictureLens::Pinhole(Frustum { left: -0.6, right: 0.7, bottom: -0.3, top: 0.5 });
    PictureMap { viewer: DVec3::new(0.1, -0.2, 0.0), position: DVec3::new(0.0, -0.3, 0.6), lens }
}

fn division(map: PictureMap, max_error: f64) -> Division {
    Division { map, pixels: DVec2::splat(1024.0), max_error, most: 1 << 20 }
}

/// Returns the place at which a rasteriser shows the point of a triangle with these weights. The w
/// of each corner is its distance.
fn drawn(map: &PictureMap, corners: [DVec3; 3], weights: Weights) -> Option<DVec2> {
    let (mut sum, mut w) = (DVec2::ZERO, 0.0);
    for (corner, weight) in corners.into_iter().zip(weights.to_array()) {
        let Place::At(at) = map.place(corner) else { return None };
        sum += at * corner.length() * weight;
        w += corner.length() * weight;
    }
    Some(sum / w)
}

fn direction(random: &mut Random) -> DVec3 {
    loop {
        let at = DVec3::new(random.range(-1.0, 1.0), random.range(-1.0, 1.0), random.range(-1.0, 1.0));
        if (1e-3..1.0).contains(&at.length_squared()) {
            return at * random.range(0.3, 3.0);
        }
    }
}

fn at(corners: [DVec3; 3], weights: Weights) -> DVec3 {
    corners[0] * weights.x + corners[1] * weights.y + corners[2] * weights.z
}

/// Returns the greatest error, in pixels, of the points of divided triangles that are in the
/// picture, and the number of parts.
fn worst(map: PictureMap, max_error: f64, seed: u64) -> (f64, usize) {
    let division = division(map, max_error);
    let mut random = Random::new(seed);
    let (mut worst, mut all, mut coarse) = (0.0f64, 0, 0);
    for _ in 0..60 {
        let corners = [direction(&mut random), direction(&mut random), direction(&mut random)];
        let mut parts = Vec::new();
        let outcome = division.triangle(corners, &mut |part| parts.push(part));
        assert_eq!(outcome.parts, parts.len());
        all += outcome.parts;
        if outcome.coarse > 0 {
            // The triangle passes so near to the viewer that no number of cuts suffices; it is only
            // counted.
            coarse += 1;
            continue;
        }
        for part in parts {
            let own = part.map(|weights| at(corners, weights));
            for _ in 0..12 {
                let (mut u, mut v) = (random.unit(), random.unit());
                if u + v > 1.0 {
                    (u, v) = (1.0 - u, 1.0 - v);
                }
                let weights = DVec3::new(u, v, 1.0 - u - v);
                let Place::At(exact) = map.place(at(own, weights)) else { continue };
                let Some(drawn) = drawn(&map, own, weights) else { continue };
                // Points outside the picture, or outside the circle of a fisheye, are not visible.
                let inside = match map.lens {
                    PictureLens::Fisheye { .. } => exact.length() < 1.0,
                    PictureLens::Pinhole(_) => exact.abs().max_element() < 1.0,
                };
                if inside {
                    worst = worst.max(((drawn - exact) * 0.5 * division.pixels).length());
                }
            }
        }
    }
    assert!(coarse < 4, "{coarse} of 60 triangles are not divided far enough");
    (worst, all)
}

#[test]
fn the_error_follows_the_bound() {
    for (name, map) in [("180°", fisheye(PI)), ("240°", fisheye(240f64.to_radians())), ("projector", projector())] {
        let mut before = 0;
        for max_error in [4.0, 1.0, 0.25] {
            let (worst, all) = worst(map, max_error, 1);
            assert!(worst <= max_error, "{name}: {worst:.3} pixels instead of {max_error}");
            assert!(worst > 0.2 * max_error, "{name}: {worst:.3} pixels: more parts than {max_error} needs");
            // A quarter of the error takes about twice as many cuts in both directions.
            assert!(before == 0 || all < 6 * before, "{name}: {all} parts after {before}");
            before = all;
        }
    }
}

/// Negative control: a triangle that is not divided has a large error.
#[test]
fn a_triangle_that_is_not_divided_is_wrong() {
    let division = Division { most: 1, ..division(fisheye(PI), 0.5) };
    let corners = [DVec3::new(-1.0, -1.0, -1.0), DVec3::new(1.0, -1.0, -1.0), DVec3::new(-1.0, 1.0, -1.0)];
    let mut parts = Vec::new();
    let outcome = division.triangle(corners, &mut |part| parts.push(part));
    assert_eq!((outcome, parts.len()), (Outcome { parts: 1, coarse: 1 }, 1));
    let middle = DVec3::new(0.5, 0.5, 0.0);
    let Place::At(exact) = division.map.place(at(corners, middle)) else { panic!("ahead") };
    let drawn = drawn(&division.map, corners, middle).expect("ahead");
    assert!((drawn - exact).length() * 512.0 > 20.0);
}

/// Two triangles with a common edge cut it at the same places, to the bit.
#[test]
fn neighbours_have_no_gap() {
    let division = division(fisheye(PI), 0.5);
    let mut random = Random::new(9);
    for _ in 0..20 {
        let [a, b, c, d] = std::array::from_fn(|_| direction(&mut random));
        let along = |corners: [DVec3; 3], zero: usize| {
            let mut places = Vec::new();
            division.triangle(corners, &mut |part| {
                places.extend(part.iter().filter(|weights| weights[zero] == 0.0).map(|w| at(corners, *w).to_array()));
            });
            places.sort_by(|a, b| a.partial_cmp(b).expect("finite"));
            places.dedup_by(|a, b| DVec3::from_array(*a).distance(DVec3::from_array(*b)) < 1e-12);
            places
        };
        let (one, other) = (along([a, b, c], 2), along([b, a, d], 2));
        // Parts far from the picture are not emitted; which ones differs between the triangles. So
        // only points in the picture are compared.
        let shown = |places: Vec<[f64; 3]>| -> Vec<DVec3> {
            let near = |at: &DVec3| matches!(division.map.place(*at), Place::At(at) if at.abs().max_element() < 1.0);
            places.into_iter().map(DVec3::from_array).filter(near).collect()
        };
        let (one, other) = (shown(one), shown(other));
        assert_eq!(one.len(), other.len());
        assert!(one.iter().zip(&other).all(|(a, b)| a.distance(*b) < 1e-12));
    }
}

#[test]
fn areas_and_orders_are_kept() {
    let division = division(fisheye(PI), 0.5);
    let corners = [DVec3::new(-1.0, -1.0, -1.0), DVec3::new(1.0, -1.0, -1.0), DVec3::new(-1.0, 1.0, -1.0)];
    let mut area = 0.0;
    division.triangle(corners, &mut |[a, b, c]| {
        let part = glam::DMat3::from_cols(a, b, c).determinant();
        assert!(part > 0.0);
        area += part;
    });
    assert!((area - 1.0).abs() < 1e-12);
}

#[test]
fn what_lies_behind_costs_nothing() {
    let division = division(fisheye(PI), 0.5);
    let behind = [DVec3::new(-0.3, -0.2, 1.0), DVec3::new(0.3, -0.2, 1.0), DVec3::new(0.0, 0.4, 1.0)];
    let outcome = division.triangle(behind, &mut |_| panic!("nothing of it is visible"));
    assert_eq!(outcome, Outcome::default());
    // A fisheye of 360° shows the antipode of its axis as a whole circle. Triangles around the
    // antipode are divided down to the ring that the map leaves out.
    let whole = Division { map: fisheye(2.0 * PI), most: 100_000, ..division };
    let mut longest = 0.0f64;
    whole.triangle(behind, &mut |part| {
        let places = part.map(|weights| whole.map.place(at(behind, weights)));
        if let [Place::At(a), Place::At(b), Place::At(c)] = places {
            longest = longest.max(a.distance(b)).max(b.distance(c)).max(c.distance(a));
        }
    });
    assert!(longest > 0.0 && longest < 0.7, "longest side of a part: {longest} of half the picture");
}

#[test]
fn lines_are_divided_likewise() {
    let division = division(fisheye(PI), 0.5);
    let ends = [DVec3::new(-3.0, 1.0, -0.2), DVec3::new(1.0, 1.0, -2.0)];
    let (mut covered, mut worst) = (0.0, 0.0f64);
    let outcome = division.line(ends, &mut |[from, to]| {
        covered += to - from;
        let own = [from, to].map(|weight| ends[0].lerp(ends[1], weight));
        for step in 1..16 {
            let part = f64::from(step) / 16.0;
            let weights = DVec3::new(1.0 - part, part, 0.0);
            let corners = [own[0], own[1], own[1]];
            let (Place::At(exact), Some(drawn)) =
                (division.map.place(at(corners, weights)), drawn(&division.map, corners, weights))
            else {
                panic!("ahead")
            };
            worst = worst.max((drawn - exact).length() * 512.0);
        }
    });
    assert!((covered - 1.0).abs() < 1e-12 && outcome.parts > 4 && outcome.coarse == 0);
    assert!(worst < 0.5, "{worst}");
    let few = Division { most: 3, ..division };
    assert_eq!(few.line(ends, &mut |_| {}), Outcome { parts: 3, coarse: 3 });
}
