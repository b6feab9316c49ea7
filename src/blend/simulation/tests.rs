//! Simulations with known results.

use super::*;
use crate::blend::Weights;
use crate::blend::{decode, encode};
use crate::rig::OutputKind;
use crate::warp::testing::{output, projector, rig, two_projectors};

/// A picture from a function that gives the linear light at a pixel's centre.
fn picture(size: (u32, u32), gamma: f64, light: impl Fn(DVec2) -> [f64; 3]) -> Picture {
    let centre = |i: u32| DVec2::new(f64::from(i % size.0) + 0.5, f64::from(i / size.0) + 0.5);
    let rgb = (0..size.0 * size.1).flat_map(|i| light(centre(i)).map(|channel| encode(channel, gamma) as f32));
    Picture { width: size.0, height: size.1, rgb: rgb.collect() }
}

/// White pictures of all outputs, weighted by the reference, and optionally rounded to `levels`
/// codes.
fn white(rig: &Rig, size: (u32, u32), levels: Option<f64>) -> Vec<Picture> {
    let sizes = vec![size; rig.outputs.len()];
    let weights = Weights::new(rig, &sizes).expect("valid");
    let one = |k: usize| {
        let gamma = rig.outputs[k].blend.gamma;
        let mut picture = picture(size, gamma, |pixel| [weights.weight(k, pixel).unwrap_or(0.0); 3]);
        if let Some(levels) = levels {
            picture.rgb.iter_mut().for_each(|value| *value = ((f64::from(*value) * levels).round() / levels) as f32);
        }
        picture
    };
    (0..rig.outputs.len()).map(one).collect()
}

#[test]
fn white_is_white_wherever_there_is_light() {
    let rig = two_projectors(DVec3::new(0.3, -0.5, 0.4));
    let simulation = simulate(&rig, &white(&rig, (480, 270), None), 200).expect("valid");
    assert_eq!((simulation.rgb.len(), simulation.coverage.len()), (3 * 200 * 200, 200 * 200));
    assert!(simulation.coverage.contains(&0) && simulation.coverage.contains(&1) && simulation.coverage.contains(&2));
    let even = simulation.uniformity;
    assert!(even.covered_pixels > 10_000 && (even.mean - 1.0).abs() < 1e-3, "{even:?}");
    // The rest is due to bilinear interpolation of the ramps at 270 lines. It is greatest where two
    // borders cross: there the weights jump from one pixel to the next.
    let off = |simulation: &Simulation| {
        let light = simulation.rgb.chunks(3).map(|rgb| decode(f64::from(rgb[0]), 2.2));
        light.zip(&simulation.coverage).filter(|(light, count)| **count > 0 && (light - 1.0).abs() > 5.7e-3).count()
    };
    assert!(even.max < 0.1 && even.rms < 1e-3, "{even:?}");
    let rim = simulation.coverage.iter().filter(|&&count| count > 0).count() - even.covered_pixels as usize;
    assert!(off(&simulation) < rim + 30, "{} with {rim} at the rim", off(&simulation));
    // The same with 8-bit codes (goal G12, at white).
    let coded = simulate(&rig, &white(&rig, (480, 270), Some(255.0)), 200).expect("valid");
    assert!(coded.uniformity.rms < 2.5e-3, "{:?}", coded.uniformity);
    assert!(off(&coded) < rim + 40, "{} with {rim} at the rim", off(&coded));
}

#[test]
fn wrong_blending_is_seen() {
    let rig = two_projectors(DVec3::ZERO);
    let size = (240, 135);
    // No blending: twice the light.
    let plain: Vec<Picture> = (0..2).map(|_| picture(size, 2.2, |_| [1.0; 3])).collect();
    let even = simulate(&rig, &plain, 100).expect("valid").uniformity;
    assert!((even.max - 1.0).abs() < 1e-6 && even.mean > 1.05, "{even:?}");
    // Weights without the display's response: half the codes are 22 % of the light each.
    let mut wrong = rig.clone();
    wrong.outputs.iter_mut().for_each(|output| output.blend.gamma = 1.0);
    let even = simulate(&rig, &white(&wrong, size, None), 100).expect("valid").uniformity;
    assert!((even.max - 0.565).abs() < 0.01, "{even:?}");
}

#[test]
fn a_viewer_off_centre_sees_the_world_without_distortion() {
    // The pictures show a world in which each direction from the viewer has a colour. The
    // simulation must be an undistorted view of the same world, for all projectors and viewers.
    let world = |d: DVec3| [0.5 + 0.4 * (3.0 * d.x).sin(), 0.5 + 0.4 * (3.0 * d.y + 1.0).sin(), 0.5 - 0.4 * d.z];
    let mut rig = two_projectors(DVec3::new(1.0, -1.0, 1.5));
    rig.viewer.yaw = 0.2;
    rig.outputs.push(output("third", projector(DVec3::new(0.0, 1.0, 2.0), 3.0, -20.0, (60.0, 40.0))));
    let fisheye = OutputKind::Domemaster { aperture: PI, tilt: 1.2 };
    let alone = Rig { outputs: vec![output("fisheye", fisheye)], ..rig.clone() };
    for (rig, size) in [(rig, (640, 360)), (alone, (640, 640))] {
        let sizes = vec![size; rig.outputs.len()];
        let weights = Weights::new(&rig, &sizes).expect("valid");
        let pictures: Vec<Picture> = (0..rig.outputs.len())
            .map(|k| {
                let map = WarpMap::new(&rig, k, size, None).expect("valid");
                picture(size, 2.2, |pixel| {
                    let weight = weights.weight(k, pixel).unwrap_or(0.0);
                    world(map.direction(pixel).unwrap_or(DVec3::Z)).map(|channel| weight * channel)
                })
            })
            .collect();
        let simulation = simulate(&rig, &pictures, 150).expect("valid");
        let lens = Fisheye { aperture: PI };
        let (mut worst, mut wrong, mut compared) = (0.0f64, 0.0f64, 0);
        let at = |x: i32, y: i32| (usize::try_from(y * 150 + x)).expect("inside");
        for y in 4..146 {
            for x in 4..146 {
                // Only well inside the lit area.
                let lit = |dx: i32, dy: i32| simulation.coverage[at(x + dx, y + dy)] > 0;
                if !(-4..=4).all(|i| lit(i, -4) && lit(i, 4) && lit(-4, i) && lit(4, i)) {
                    continue;
                }
                let (u, v) = ((f64::from(x) + 0.5) / 75.0 - 1.0, 1.0 - (f64::from(y) + 0.5) / 75.0);
                let Some(direction) = lens.direction(u, v) else { continue };
                compared += 1;
                for channel in 0..3 {
                    let light = decode(f64::from(simulation.rgb[3 * at(x, y) + channel]), 2.2);
                    worst = worst.max((light - world(direction)[channel]).abs());
                    wrong =
                        wrong.max((light - world(DVec3::new(-direction.x, direction.y, direction.z))[channel]).abs());
                }
            }
        }
        assert!(compared > 3_000 && worst < 5e-3, "{compared} {worst}");
        assert!(wrong > 0.3, "a mirrored world is not taken for the same");
    }
}

#[test]
fn pictures_must_fit() {
    let fisheye = OutputKind::Domemaster { aperture: PI, tilt: 0.0 };
    let rig = rig(0.0, DVec3::ZERO, &[fisheye]);
    assert!(simulate(&rig, &[], 10).is_err());
    let short = Picture { width: 2, height: 2, rgb: vec![0.0; 11] };
    assert!(simulate(&rig, &[short], 10).is_err());
    let empty = Picture { width: 0, height: 2, rgb: Vec::new() };
    assert!(simulate(&rig, &[empty], 10).is_err());
    let black = Picture { width: 2, height: 2, rgb: vec![0.0; 12] };
    let simulation = simulate(&rig, &[black], 0).expect("an empty picture is a picture");
    assert!(simulation.rgb.is_empty() && simulation.uniformity == Uniformity::default());
}

/// Greatest and root mean square deviation from 1 of the light at random points of the screen, when
/// all outputs of `rig` show white in codes of `levels` steps, and the output `moved` shows it one
/// pixel to the right. Points nearer to the top or the bottom of a picture than the part `left_out`
/// of its height do not count.
fn evenness_of_codes(rig: &Rig, size: (u32, u32), levels: f64, moved: Option<usize>, left_out: f64) -> [f64; 2] {
    let sizes = vec![size; rig.outputs.len()];
    let weights = Weights::new(rig, &sizes).expect("valid");
    let mut random = crate::testing::random::Random::new(17);
    let (mut worst, mut squares, mut count) = (0.0f64, 0.0, 0);
    while count < 40_000 {
        let point = random.direction() * rig.dome.radius;
        let height = f64::from(size.1);
        let outside = |pixel: DVec2| pixel.y < left_out * height || pixel.y > (1.0 - left_out) * height;
        if weights.projectors().any(|(_, map)| map.pixel(point).is_some_and(outside)) {
            continue;
        }
        let lights = weights.projectors().filter_map(|(k, map)| {
            let pixel = map.pixel(point)?;
            let shown = if moved == Some(k) { pixel + DVec2::X } else { pixel };
            let code = (encode(weights.weight(k, shown)?, 2.2) * levels).round() / levels;
            Some(decode(code, 2.2))
        });
        let lights: Vec<f64> = lights.collect();
        if lights.is_empty() {
            continue;
        }
        let deviation = lights.iter().sum::<f64>() - 1.0;
        (worst, squares, count) = (worst.max(deviation.abs()), squares + deviation * deviation, count + 1);
    }
    [worst, (squares / f64::from(count)).sqrt()]
}

#[test]
fn codes_of_8_and_10_bits_keep_the_light_even() {
    let rig = crate::rig::load("planetarium-2").expect("a preset");
    let [eight, ten] = [255.0, 1023.0].map(|levels| evenness_of_codes(&rig, (2560, 1600), levels, None, 0.0));
    println!("8 bits {eight:.5?}, 10 bits {ten:.5?}");
    assert!(eight[0] <= 0.006 && eight[1] <= 0.0025 && ten[0] <= 0.0015, "{eight:?} {ten:?}");
    // Negative control: six bits are too few.
    assert!(evenness_of_codes(&rig, (2560, 1600), 63.0, None, 0.0)[0] > 0.006);
}

#[test]
fn a_pixel_of_misalignment_is_hardly_seen_over_a_wide_ramp() {
    // Two pictures of 1000 pixels from the centre that overlap by 200 of them. Above and below,
    // where their borders cross, blend weights jump, and a pixel matters more.
    let (half, ramp) = (15f64.to_radians().tan(), 0.2);
    let turn = 15.0 + (half * (1.0 - 2.0 * ramp)).atan().to_degrees();
    let lens = (30.0, 20.0);
    let mut pair =
        rig(FRAC_PI_2, DVec3::ZERO, &[projector(DVec3::ZERO, 0.0, 0.0, lens), projector(DVec3::ZERO, turn, 0.0, lens)]);
    pair.outputs.iter_mut().for_each(|output| output.blend.ramp = ramp);
    let fine = 1e9;
    let [aligned, moved] = [None, Some(1)].map(|moved| evenness_of_codes(&pair, (1000, 640), fine, moved, 0.25)[0]);
    println!("aligned {aligned:.2e}, a pixel aside {moved:.5}");
    assert!(aligned < 1e-8 && moved <= 0.008 && moved > 0.004, "{aligned} {moved}");
}
