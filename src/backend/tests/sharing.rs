//! Overlapping projectors share the light of each point: all of it, and no more.

use super::Driver;
use super::picture::Picture;
use super::plans::*;
use crate::blend::EdgeWeight;
use crate::correct::{Mask, Plan, Source};
use crate::geom::{Frustum, Pose};
use crate::rig::{RampShape, Transfer};
use glam::DVec3;
use std::sync::LazyLock;

const SIZE: (u32, u32) = (480, 320);

/// Three projectors with different places, openings and ramps. They overlap in twos and threes.
fn projectors() -> [Projector; 3] {
    let frustum = Frustum::symmetric(60f64.to_radians(), 40f64.to_radians());
    let at = |x: f64, yaw: f64, pitch: f64, ramp| Projector {
        pose: Pose::new(DVec3::new(x, 0.1, 0.5), yaw, pitch, 0.05 * x),
        frustum: frustum.shifted(0.1 * x, 0.05),
        ramp,
    };
    [at(0.0, 0.0, 0.1, 0.3), at(0.3, 0.45, 0.15, 0.5), at(-0.2, 0.2, 0.6, 0.15)]
}

/// Returns the raw weight of each projector at a point, in f64, from the point's place in all
/// pictures.
fn raw_weights(projectors: &[Projector], point: DVec3) -> Vec<f64> {
    let smooth = |t: f64| t.clamp(0.0, 1.0).powi(2) * (3.0 - 2.0 * t.clamp(0.0, 1.0));
    let raw_weight = |projector: &Projector| {
        projector.picture(point).map_or(0.0, |(x, y)| {
            smooth((1.0 - x.abs()) / (2.0 * projector.ramp)) * smooth((1.0 - y.abs()) / (2.0 * projector.ramp))
        })
    };
    projectors.iter().map(raw_weight).collect()
}

/// Returns the blend weight of projector `index` at a point.
fn exact_weight(projectors: &[Projector], index: usize, point: DVec3) -> f64 {
    let raw_weights = raw_weights(projectors, point);
    let others: f64 = raw_weights.iter().enumerate().filter(|(i, _)| *i != index).map(|(_, e)| e).sum();
    if others > 0.0 { raw_weights[index] / (raw_weights[index] + others) } else { 1.0 }
}

fn others(projectors: &[Projector], index: usize) -> Vec<Projector> {
    projectors.iter().enumerate().filter(|(i, _)| *i != index).map(|(_, p)| *p).collect()
}

/// Sum of the raw weights below which a point counts as meagre. There borders cross, blend weights
/// jump, and f32 cannot follow them closely. Such places are very narrow.
const MEAGRE: f64 = 0.05;

pub fn weights_are_those_of_f64_and_add_up_to_1(driver: &dyn Driver) {
    let projectors = projectors();
    // Errors where raw weights are ample, and everywhere.
    let (mut worst, mut overlapped, mut meagre) = ([0.0f64; 2], 0, 0);
    for i in 0..3 {
        let plan = projector_plan(&projectors[i], &others(&projectors, i), SIZE);
        let map = driver.map(&plan, 0);
        for (at, pixel) in map.iter().enumerate() {
            let (x, y) = normalised(SIZE, at as u32 % SIZE.0, at as u32 / SIZE.0);
            let point = projectors[i].hit(x, y).expect("from inside every ray hits");
            // The other weights in f64 and this one add up to 1 as closely as this one is exact.
            let error = (f64::from(pixel.weight) - exact_weight(&projectors, i, point)).abs();
            let raw_weights = raw_weights(&projectors, point);
            let ample = raw_weights.iter().sum::<f64>() >= MEAGRE;
            worst[1] = worst[1].max(error);
            if ample {
                worst[0] = worst[0].max(error);
            }
            let overlapping = raw_weights.iter().filter(|c| **c > 0.0).count() > 1;
            overlapped += usize::from(overlapping);
            meagre += usize::from(overlapping && !ample);
        }
    }
    println!("share: error {worst:?}, {overlapped} pixels overlapped, {meagre} of them meagrely");
    assert!(worst[0] <= 6e-6 && worst[1] <= 5e-4, "{worst:?}");
    assert!(overlapped > 100_000 && meagre < overlapped / 20);
    // Negative control: another ramp.
    let mut wrong = projectors;
    wrong[0].ramp = 0.31;
    let point = projectors[0].hit(0.8, 0.1).expect("a hit");
    assert!((exact_weight(&wrong, 0, point) - exact_weight(&projectors, 0, point)).abs() > 1e-4);
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
        let raw_weights = raw_weights(&projectors, projectors[0].hit(x, y).expect("a hit"));
        let error = (sum(i) - 1.0).abs();
        worst[1] = worst[1].max(error);
        // All ramps have reached 1.
        if raw_weights.iter().all(|c| *c >= 1.0) {
            worst[0] = worst[0].max(error);
        }
    }
    println!("|sum of weights - 1|: {worst:?}");
    assert!(worst[0] <= 2.5e-7 && worst[1] <= 5e-4, "{worst:?}");
    // Negative control: two of the three do not add up to 1.
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

/// Returns the plan of projector `index`, with `border(i)` as the border of projector i.
fn with_borders(projectors: &[Projector], index: usize, border: &dyn Fn(usize) -> EdgeWeight) -> Plan {
    let mut plan = projector_plan(&projectors[index], &others(projectors, index), SIZE);
    if let Source::Projector(source) = &mut plan.passes[0].source {
        source.edge_weight = border(index);
        let rest = (0..projectors.len()).filter(|other| *other != index);
        source.neighbours.iter_mut().zip(rest).for_each(|(neighbour, other)| neighbour.edge_weight = border(other));
    }
    plan
}

/// Returns the places of a point in the pictures that show it, from 0 to 1.
fn covering(projectors: &[Projector], point: DVec3) -> Vec<(usize, glam::DVec2)> {
    let place = |(index, projector): (usize, &Projector)| {
        let (x, y) = projector.picture(point)?;
        (x.abs() <= 1.0 && y.abs() <= 1.0).then(|| (index, glam::DVec2::new(0.5 + 0.5 * x, 0.5 + 0.5 * y)))
    };
    projectors.iter().enumerate().filter_map(place).collect()
}

pub fn shapes_and_exponents_are_those_of_f64(driver: &dyn Driver) {
    let projectors = projectors();
    for (shape, exponent) in [
        (RampShape::Cosine, 1.0),
        (RampShape::Power(1.0), 1.0),
        (RampShape::Power(2.0), 1.5),
        (RampShape::Smoothstep, 2.0),
    ] {
        let border = |index: usize| EdgeWeight { width: projectors[index].ramp, shape, exponent, black: 0.0 };
        let (mut worst, mut overlapping) = (0.0f64, 0);
        for index in 0..3 {
            let map = driver.map(&with_borders(&projectors, index, &border), 0);
            for (at, pixel) in map.iter().enumerate() {
                let (x, y) = normalised(SIZE, at as u32 % SIZE.0, at as u32 / SIZE.0);
                let point = projectors[index].hit(x, y).expect("from inside every ray hits");
                let raw_weights: Vec<(usize, f64)> = covering(&projectors, point)
                    .into_iter()
                    .map(|(k, place)| (k, border(k).raw_weight(place)))
                    .collect();
                let sum: f64 = raw_weights.iter().map(|(_, raw_weight)| raw_weight).sum();
                if raw_weights.len() > 1 && sum >= MEAGRE {
                    let own: f64 =
                        raw_weights.iter().filter(|(k, _)| *k == index).map(|(_, raw_weight)| raw_weight).sum();
                    worst = worst.max((f64::from(pixel.weight) - own / sum).abs());
                    overlapping += 1;
                }
            }
        }
        println!("{shape:?}, exponent {exponent}: {worst:.2e}");
        assert!(worst <= 2e-5 && overlapping > 50_000, "{shape:?}, exponent {exponent}: {worst:e}");
    }
}

/// Black levels of [`projectors`].
const BLACKS: [f64; 3] = [0.01, 0.02, 0.015];

/// Blend weight of a pixel, and the sum of the black levels there. `None` where borders cross.
type Share = Option<(f64, f64)>;

/// Weights of all pixels of each projector, the same for all drivers.
static WEIGHTS: LazyLock<[Vec<Share>; 3]> = LazyLock::new(|| {
    let projectors = projectors();
    [0, 1, 2].map(|index| {
        let weight = |at: u32| {
            let (x, y) = normalised(SIZE, at % SIZE.0, at / SIZE.0);
            let point = projectors[index].hit(x, y).expect("from inside every ray hits");
            let near = |edge: f64| (edge.abs() - 1.0).abs() < 1e-4;
            let beside_border = |p: &Projector| p.picture(point).is_some_and(|(x, y)| near(x) || near(y));
            if raw_weights(&projectors, point).iter().sum::<f64>() < MEAGRE || projectors.iter().any(beside_border) {
                return None;
            }
            let dark: f64 = covering(&projectors, point).iter().map(|(k, _)| BLACKS[*k]).sum();
            Some((exact_weight(&projectors, index, point), dark))
        };
        (0..SIZE.0 * SIZE.1).map(weight).collect()
    })
});

/// Black and white pictures, weighted as light, on displays whose black is grey: the sums are the
/// same wherever light falls.
pub fn blacks_are_evened_out(driver: &dyn Driver) {
    let projectors = projectors();
    let most: f64 = BLACKS.iter().sum();
    let measured = [1.9, 2.2, 2.6].map(crate::rig::Response::power);
    let powers = Transfer::Powers([1.8, 2.2, 2.6]);
    for transfer in [Transfer::Power, Transfer::Srgb, powers, Transfer::Measured(measured.into())] {
        let display = crate::rig::Blend { transfer: transfer.clone(), ..Default::default() };
        let border = |index: usize| EdgeWeight { black: BLACKS[index], ..projectors[index].border() };
        for white in [0.0, 1.0] {
            for index in 0..3 {
                let mut plan = with_borders(&projectors, index, &border);
                (plan.passes[0].lift, plan.passes[0].transfer) = (most, transfer.clone());
                let code = (255.0 * white) as u8;
                let shown = driver.show(&plan, false, &Picture::new(plan.views.atlas, |_, _| [code, code, code, 255]));
                let mut worst = 0.0f64;
                for (at, weight) in WEIGHTS[index].iter().enumerate() {
                    let Some((weight, dark)) = weight else { continue };
                    let (column, row) = (at as u32 % SIZE.0, at as u32 / SIZE.0);
                    let light = weight * ((1.0 - most) * white + most - dark);
                    let found = shown.at(column, SIZE.1 - 1 - row);
                    for (channel, found) in found[..3].iter().enumerate() {
                        let exact = 255.0 * crate::blend::code_of(light, &display, channel);
                        worst = worst.max((f64::from(*found) - exact).abs());
                    }
                }
                assert!(worst <= 0.6, "{transfer:?}, white {white}, projector {index}: {worst}");
            }
        }
    }
}

pub fn dithering_keeps_the_mean_light(driver: &dyn Driver) {
    let mut plan = projector_plan(&Projector::at(0.6), &[], (128, 128));
    plan.passes[0].mask = Some(Mask { width: 1, height: 1, weights: vec![20_000] });
    let exact = 255.0 * (20_000f64 / 65_535.0).powf(1.0 / 2.2);
    let mut found = [0.0, 1.0 / 255.0].map(|step| {
        plan.passes[0].dither = step;
        let shown = driver.show(&plan, false, &Picture::new(plan.views.atlas, |_, _| [255; 4]));
        assert!(shown.pixels.iter().all(|pixel| (f64::from(pixel[0]) - exact).abs() < 1.1));
        shown.pixels.iter().map(|pixel| f64::from(pixel[0])).sum::<f64>() / shown.pixels.len() as f64
    });
    found.iter_mut().for_each(|mean| *mean = (*mean - exact).abs());
    println!("mean code off by {:.3} without, {:.3} with", found[0], found[1]);
    // Half floats for masks in OpenGL ES cost a tenth of a code.
    assert!(found[1] < 0.12 && found[0] > 0.2, "{found:?}");
}
