//! Overlapping projectors share the light of each point: all of it, and no more.

use super::Driver;
use super::picture::Picture;
use super::plans::*;
use crate::geom::{Frustum, Pose};
use glam::DVec3;

const SIZE: (u32, u32) = (480, 320);

/// Three projectors with different places, openings and ramps, which overlap by twos and threes.
fn projectors() -> [Projector; 3] {
    let frustum = Frustum::symmetric(60f64.to_radians(), 40f64.to_radians());
    let at = |x: f64, yaw: f64, pitch: f64, ramp| Projector {
        pose: Pose::new(DVec3::new(x, 0.1, 0.5), yaw, pitch, 0.05 * x),
        frustum: frustum.shifted(0.1 * x, 0.05),
        ramp,
    };
    [at(0.0, 0.0, 0.1, 0.3), at(0.3, 0.45, 0.15, 0.5), at(-0.2, 0.2, 0.6, 0.15)]
}

/// What each projector gives to a point before it is shared out, in f64, from the point's place in all pictures.
fn claims(projectors: &[Projector], point: DVec3) -> Vec<f64> {
    let smooth = |t: f64| t.clamp(0.0, 1.0).powi(2) * (3.0 - 2.0 * t.clamp(0.0, 1.0));
    let claim = |projector: &Projector| {
        projector.picture(point).map_or(0.0, |(x, y)| {
            smooth((1.0 - x.abs()) / (2.0 * projector.ramp)) * smooth((1.0 - y.abs()) / (2.0 * projector.ramp))
        })
    };
    projectors.iter().map(claim).collect()
}

/// The share of projector `index` of a point.
fn exact_share(projectors: &[Projector], index: usize, point: DVec3) -> f64 {
    let claims = claims(projectors, point);
    let others: f64 = claims.iter().enumerate().filter(|(i, _)| *i != index).map(|(_, e)| e).sum();
    if others > 0.0 { claims[index] / (claims[index] + others) } else { 1.0 }
}

fn others(projectors: &[Projector], index: usize) -> Vec<Projector> {
    projectors.iter().enumerate().filter(|(i, _)| *i != index).map(|(_, p)| *p).collect()
}

/// Where the claims on a point add up to less than this, borders cross with nothing beneath: shares jump
/// there, and f32 cannot follow them closely. It is a hair's breadth.
const MEAGRE: f64 = 0.05;

pub fn shares_are_those_of_f64_and_add_up_to_1(driver: &dyn Driver) {
    let projectors = projectors();
    // Where claims are ample, and everywhere.
    let (mut worst, mut overlapped, mut meagre) = ([0.0f64; 2], 0, 0);
    for i in 0..3 {
        let plan = projector_plan(&projectors[i], &others(&projectors, i), SIZE);
        let map = driver.map(&plan, 0);
        for (at, pixel) in map.iter().enumerate() {
            let (x, y) = normalised(SIZE, at as u32 % SIZE.0, at as u32 / SIZE.0);
            let point = projectors[i].hit(x, y).expect("from inside every ray hits");
            // The other shares in f64 and this one add up to 1 as closely as this one is exact.
            let error = (f64::from(pixel.weight) - exact_share(&projectors, i, point)).abs();
            let claims = claims(&projectors, point);
            let ample = claims.iter().sum::<f64>() >= MEAGRE;
            worst[1] = worst[1].max(error);
            if ample {
                worst[0] = worst[0].max(error);
            }
            let shared = claims.iter().filter(|c| **c > 0.0).count() > 1;
            overlapped += usize::from(shared);
            meagre += usize::from(shared && !ample);
        }
    }
    println!("share: error {worst:?}, {overlapped} pixels overlapped, {meagre} of them meagrely");
    assert!(worst[0] <= 6e-6 && worst[1] <= 5e-4, "{worst:?}");
    assert!(overlapped > 100_000 && meagre < overlapped / 20);
    // Negative control: another ramp.
    let mut wrong = projectors;
    wrong[0].ramp = 0.31;
    let point = projectors[0].hit(0.8, 0.1).expect("a hit");
    assert!((exact_share(&wrong, 0, point) - exact_share(&projectors, 0, point)).abs() > 1e-4);
}

/// Three projectors at one place with one opening: their pixels coincide, so that what the shaders
/// compute can be added as light adds.
pub fn what_the_shaders_compute_for_one_point_adds_up_to_1(driver: &dyn Driver) {
    let frustum = Frustum::symmetric(60f64.to_radians(), 40f64.to_radians());
    let base = Projector { pose: Pose::new(DVec3::new(0.1, 0.2, 0.6), 0.2, 0.1, 0.0), frustum, ramp: 0.3 };
    let projectors = [base, Projector { ramp: 0.17, ..base }, Projector { ramp: 0.5, ..base }];
    let maps: Vec<_> = (0..3)
        .map(|i| {
            let plan = projector_plan(&projectors[i], &others(&projectors, i), SIZE);
            driver.map(&plan, 0)
        })
        .collect();
    let sum = |i: usize| maps.iter().map(|map| f64::from(map[i].weight)).sum::<f64>();
    let mut worst = [0.0f64; 2];
    for i in 0..maps[0].len() {
        let (x, y) = normalised(SIZE, i as u32 % SIZE.0, i as u32 / SIZE.0);
        let claims = claims(&projectors, projectors[0].hit(x, y).expect("a hit"));
        let error = (sum(i) - 1.0).abs();
        worst[1] = worst[1].max(error);
        // All ramps have reached 1.
        if claims.iter().all(|c| *c >= 1.0) {
            worst[0] = worst[0].max(error);
        }
    }
    println!("|sum of weights - 1|: {worst:?}");
    assert!(worst[0] <= 2.5e-7 && worst[1] <= 5e-4, "{worst:?}");
    // Negative control: two of the three are not all.
    assert!((0..maps[0].len()).any(|i| sum(i) - f64::from(maps[2][i].weight) < 0.9));
}

pub fn in_8_bits_the_sum_of_two_stays_within_the_quantisation(driver: &dyn Driver) {
    let frustum = Frustum::symmetric(60f64.to_radians(), 40f64.to_radians());
    let base = Projector { pose: Pose::new(DVec3::new(0.1, 0.2, 0.6), 0.2, 0.1, 0.0), frustum, ramp: 0.3 };
    let projectors = [base, Projector { ramp: 0.5, ..base }];
    let pictures: Vec<Picture> = (0..2)
        .map(|i| {
            let plan = projector_plan(&projectors[i], &others(&projectors, i), SIZE);
            driver.show(&plan, false, &Picture::new(plan.views.atlas, |_, _| [255; 4]))
        })
        .collect();
    let light = |i: usize| pictures.iter().map(|p| (f64::from(p.pixels[i][0]) / 255.0).powf(2.2)).sum::<f64>();
    let errors: Vec<f64> = (0..pictures[0].pixels.len()).map(|i| (light(i) - 1.0).abs()).collect();
    let worst = errors.iter().copied().fold(0.0, f64::max);
    let rms = (errors.iter().map(|e| e * e).sum::<f64>() / errors.len() as f64).sqrt();
    println!("8 bits: max {worst:.5}, rms {rms:.5}");
    assert!(worst <= 0.006 && rms <= 0.0025, "{worst} {rms}");
}
