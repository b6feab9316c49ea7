//! A closed loop: known light is photographed, found, and evened out.

use super::*;
use crate::blend::{Weights, code_of};
use crate::calibrate::CameraLens;
use crate::geom::Pose;
use crate::rig::{self, Response, Transfer};
use crate::testing::random::Random;
use std::sync::Arc;

const SIZES: [(u32, u32); 6] = [(1920, 1080); 6];
/// Light of the room, in the unit of a projector that lights 1 m² with a pixel.
const ROOM: f64 = 20.0;

/// A real projector: its falloffs and responses are not those of the model.
struct Truth {
    brightness: f64,
    falloff: f64,
    gamma: f64,
    contrast: f64,
}

impl Truth {
    fn random(random: &mut Random) -> Self {
        Self {
            brightness: random.range(0.7, 1.0),
            falloff: random.range(0.1, 0.5),
            gamma: random.range(1.9, 2.5),
            contrast: random.range(600.0, 2000.0),
        }
    }

    fn light(&self, projector: &Projector, screen: &Screen, pixel: DVec2, value: f64) -> f64 {
        let optics = projector.optics(&[]);
        let tangent = projector.off_axis(&optics, pixel).expect("a ray").tan();
        let area = area(projector, &optics, screen, pixel).expect("a place of the screen");
        let black = 1.0 / self.contrast;
        let response = black + (1.0 - black) * value.powf(self.gamma);
        self.brightness / (1.0 + self.falloff * tangent * tangent) / area * response
    }
}

struct Dome {
    rig: Rig,
    screen: Screen,
    projectors: Vec<(Projector, Truth)>,
}

impl Dome {
    fn new(random: &mut Random) -> Self {
        let rig = rig::load("planetarium-6").expect("a preset");
        let screen = rig.surface();
        let projector = |output| Projector::new(output, SIZES[0], &[], 5.0).expect("a projector");
        let projectors = rig.outputs.iter().map(|output| (projector(output), Truth::random(random))).collect();
        Self { rig, screen, projectors }
    }

    /// Light at a point of the dome, if `value` of an output and of a pixel is shown.
    fn light(&self, point: DVec3, value: impl Fn(usize, DVec2) -> f64) -> f64 {
        let own = |(index, (projector, truth)): (usize, &(Projector, Truth))| {
            let pixel = projector.pixel(&projector.optics(&[]), point).filter(|pixel| projector.shows(*pixel))?;
            Some(truth.light(projector, &self.screen, pixel, value(index, pixel)))
        };
        self.projectors.iter().enumerate().filter_map(own).sum()
    }

    fn readings(&self, camera: &Camera, noise: f64, random: &mut Random) -> Vec<Reading> {
        let mut readings = Vec::new();
        for (output, (projector, _)) in self.projectors.iter().enumerate() {
            for place in 0..40 * 24 {
                let pixel = DVec2::new(24.0 + 48.0 * f64::from(place % 40), 22.0 + 45.0 * f64::from(place / 40));
                let (origin, direction) = projector.ray(&projector.optics(&[]), pixel).expect("a ray");
                let Some(hit) = self.screen.hit(origin, direction) else { continue };
                let Some(seen) = camera.place(hit.point) else { continue };
                let gathered = 1.0 / (1.0 + 0.6 * (seen.distance(camera.center) / 1500.0).powi(2));
                let light = LEVELS.map(|level| {
                    let value = |index, _| if index == output { f64::from(level) / 255.0 } else { 0.0 };
                    let light = ROOM + self.light(hit.point, value);
                    gathered * (light * (1.0 + noise * random.gaussian().x))
                });
                readings.push(Reading { output, pixel, seen, light });
            }
        }
        readings
    }
}

/// Root mean square and greatest deviation from the mean, as parts of it.
fn unevenness(light: &[f64]) -> (f64, f64) {
    let mean = light.iter().sum::<f64>() / light.len() as f64;
    let off = || light.iter().map(|light| light / mean - 1.0);
    (crate::calibrate::marks::rms(off()), off().fold(0.0, |most: f64, off| most.max(off.abs())))
}

#[test]
fn light_becomes_even() {
    let mut random = Random::new(121);
    let dome = Dome::new(&mut random);
    let pose = Pose::new(DVec3::new(0.3, -0.4, 0.2), 0.4, 1.2, 0.3);
    let camera = Camera::new(pose, CameraLens::Fisheye, 905.0, (4000, 3000));
    let readings = dome.readings(&camera, 0.003, &mut random);
    let found = solve(&dome.rig, &SIZES, &camera, &readings).expect("bright enough");
    let mut evened = dome.rig.clone();
    for (lit, (_, truth)) in found.outputs.iter().zip(&dome.projectors) {
        let contrast = lit.contrast.expect("black is seen");
        assert!((contrast / truth.contrast - 1.0).abs() < 0.15, "{contrast}, right is {}", truth.contrast);
        for [value, light] in &lit.response {
            assert!((light - value.powf(truth.gamma)).abs() < 1e-3, "{value} {light} {}", truth.gamma);
        }
        let response = Response::measured(&lit.response).expect("it grows");
        let blend = &mut evened.outputs[lit.output].blend;
        blend.transfer = Transfer::Measured(Arc::new([(); 3].map(|()| response.clone())));
    }
    let weights = Weights::new(&evened, &SIZES).expect("sizes");
    let shown = |dims: &dyn Fn(usize, DVec2) -> f64, rig: &Rig| -> Vec<f64> {
        let mut random = Random::new(122);
        let mut light = Vec::new();
        while light.len() < 2000 {
            let point = 5.0 * random.direction();
            let value = |index: usize, pixel: DVec2| {
                let part = weights.weight_at(index, point) * dims(index, pixel);
                // Displays have 8 bits, and the values are dithered.
                code_of(part, &rig.outputs[index].blend, 1)
            };
            let lit = dome.light(point, value);
            // Only points of the screen count that some projector lights.
            if lit > 0.0 && dome.screen.hit(DVec3::ZERO, point).is_some() {
                light.push(lit);
            }
        }
        light
    };
    let before = unevenness(&shown(&|_, _| 1.0, &dome.rig));
    let after = unevenness(&shown(&|index, pixel| found.dimming(index, pixel), &evened));
    assert!(before.0 > 0.1, "it was uneven: {before:?}");
    assert!(after.0 < 0.01 && after.1 < 0.02, "{after:?}");
    // If the camera had another falloff, its readings would not show the real light.
    let mut blind = readings;
    blind.iter_mut().for_each(|reading| reading.seen.x = camera.center.x);
    let found = solve(&dome.rig, &SIZES, &camera, &blind).expect("bright enough");
    let wrong = unevenness(&shown(&|index, pixel| found.dimming(index, pixel), &evened));
    assert!(wrong.0 > 0.02, "{wrong:?}");
}

#[test]
fn photographs_that_tell_nothing_are_refused() {
    let mut random = Random::new(123);
    let dome = Dome::new(&mut random);
    let camera = Camera::new(Pose::new(DVec3::ZERO, 0.0, 1.5, 0.0), CameraLens::Fisheye, 905.0, (4000, 3000));
    let mut readings = dome.readings(&camera, 0.0, &mut random);
    let refused = solve(&dome.rig, &SIZES, &camera, &readings[..5]).expect_err("too few");
    assert!(refused.message.contains("\"front\" was seen in 5 places"), "{refused}");
    readings.iter_mut().for_each(|reading| reading.light = [1.0; LEVELS.len()]);
    let refused = solve(&dome.rig, &SIZES, &camera, &readings).expect_err("all alike");
    assert!(refused.message.contains("do not tell"), "{refused}");
}
