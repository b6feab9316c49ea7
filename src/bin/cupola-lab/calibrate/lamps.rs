//! The light of real projectors: their falloffs and responses are not those of the solver's model.

use super::world::{SIZE, World};
use crate::failure::Failure;
use crate::random::Random;
use cupola::blend::{Weights, code_of};
use cupola::calibrate::light::Found;
use cupola::calibrate::{Projector, joint};
use cupola::geom::{Optics, Screen};
use cupola::rig::{OutputKind, Response, Rig, Transfer};
use glam::{DVec2, DVec3};
use std::sync::Arc;

/// Channel of the light: green.
const CHANNEL: usize = 1;
/// Points of the screen at which evenness is measured.
const POINTS: usize = 4000;
/// Part of all places of the pictures that are darker than the light that counts as 1. Few places
/// at grazing light may be brighter by far.
const BRIGHTEST: f64 = 0.998;

/// The projectors of a rig as sources of light.
pub struct Lamps {
    projectors: Vec<(Projector, Optics, Lamp)>,
    screen: Screen,
    /// Light that counts as 1.
    unit: f64,
}

struct Lamp {
    brightness: f64,
    falloff: f64,
    gamma: f64,
    contrast: f64,
}

impl Lamps {
    /// Lamps for the projectors of a rig, each different.
    pub fn new(world: &World, random: &mut Random) -> Result<Self, Failure> {
        let mut projectors = Vec::new();
        for output in 0..world.exact.outputs.len() {
            let (projector, optics) = world.projector(output)?;
            let lamp = Lamp {
                brightness: random.range(0.7, 1.0),
                falloff: random.range(0.1, 0.5),
                gamma: random.range(1.9, 2.5),
                contrast: random.range(600.0, 2000.0),
            };
            projectors.push((projector, optics, lamp));
        }
        let mut lamps = Self { projectors, screen: world.exact.surface(), unit: 1.0 };
        let step = |index: u32, length: u32| (f64::from(index) + 0.5) / 60.0 * f64::from(length);
        let place = |index: u32| DVec2::new(step(index % 60, SIZE.0), step(index / 60, SIZE.1));
        let own = |output: usize| (0..60 * 60).map(move |index| (output, place(index)));
        let all = (0..lamps.projectors.len()).flat_map(own);
        let mut light: Vec<f64> = all.filter_map(|(output, pixel)| lamps.white(output, pixel)).collect();
        light.sort_by(f64::total_cmp);
        lamps.unit = light.get((BRIGHTEST * light.len() as f64) as usize).copied().unwrap_or(1.0);
        Ok(lamps)
    }

    /// Light of white at a pixel of an output. `None` where the pixel lights nothing.
    pub fn white(&self, output: usize, pixel: DVec2) -> Option<f64> {
        let (projector, optics, lamp) = &self.projectors[output];
        let point = |place: DVec2| {
            let (origin, direction) = projector.ray(optics, place)?;
            Some(self.screen.unbounded_hit(origin, direction)?.point)
        };
        let step = |axis: DVec2| Some(point(pixel + 0.5 * axis)? - point(pixel - 0.5 * axis)?);
        let area = step(DVec2::X)?.cross(step(DVec2::Y)?).length();
        let tangent = projector.off_axis(optics, pixel)?.tan();
        let light = lamp.brightness / (1.0 + lamp.falloff * tangent * tangent) / area / self.unit;
        light.is_finite().then_some(light)
    }

    /// Light of a value 0…1 of an output: 0 for black, 1 for white.
    pub fn response(&self, output: usize, value: f64) -> f64 {
        value.powf(self.projectors[output].2.gamma)
    }

    /// Part of the light of white that black gives.
    pub fn black(&self, output: usize) -> f64 {
        1.0 / self.projectors[output].2.contrast
    }

    /// Light at a point of the screen if `value` of an output and of a pixel is shown.
    fn at(&self, point: DVec3, value: impl Fn(usize, DVec2) -> f64) -> f64 {
        let own = |(output, (projector, optics, _)): (usize, &(Projector, Optics, Lamp))| {
            let pixel = projector.pixel(optics, point).filter(|pixel| projector.shows(*pixel))?;
            let black = self.black(output);
            Some(self.white(output, pixel)? * (black + (1.0 - black) * self.response(output, value(output, pixel))))
        };
        self.projectors.iter().enumerate().filter_map(own).sum()
    }

    /// Evenness of white without and with what was found: `rig` has the solved projectors.
    pub fn evenness(&self, rig: &Rig, found: &Found) -> Result<[Evenness; 2], Failure> {
        let sizes = vec![SIZE; rig.outputs.len()];
        let mut evened = rig.clone();
        for lit in &found.outputs {
            let response = Response::measured(&lit.response)
                .ok_or_else(|| Failure::new("a response that does not grow was found"))?;
            let channels = [(); 3].map(|()| response.clone());
            evened.outputs[lit.output].blend.transfer = Transfer::Measured(Arc::new(channels));
        }
        let measured = |rig: &Rig, dimming: &dyn Fn(usize, DVec2) -> f64| -> Result<Evenness, Failure> {
            let weights = Weights::new(rig, &sizes)?;
            let value = |output: usize, pixel: DVec2| {
                let light = weights.weight(output, pixel).unwrap_or(0.0) * dimming(output, pixel);
                code_of(light, &rig.outputs[output].blend, CHANNEL)
            };
            let mut random = Random::new(11);
            let mut light = Vec::with_capacity(POINTS);
            while light.len() < POINTS {
                let point = self.screen.hit(DVec3::ZERO, random.direction()).map(|hit| hit.point);
                let lit = point.map_or(0.0, |point| self.at(point, value));
                // Places that no projector lights do not count.
                if lit > 0.0 {
                    light.push(lit);
                }
            }
            Ok(Evenness::of(&light))
        };
        let index = |output: usize| found.outputs.iter().position(|lit| lit.output == output);
        let dimming = |output: usize, pixel| index(output).map_or(1.0, |index| found.dimming(index, pixel));
        Ok([measured(rig, &|_, _| 1.0)?, measured(&evened, &dimming)?])
    }
}

/// The rig with the projectors that were solved.
pub fn calibrated(rough: &Rig, found: &joint::Found) -> Rig {
    let mut rig = rough.clone();
    for (output, solved) in &found.outputs {
        rig.outputs[*output].kind = OutputKind::Optics { optics: Box::new(solved.optics.clone()), even_light: 0.0 };
    }
    rig
}

/// Deviations of light from its mean, as parts of it.
pub struct Evenness {
    /// Root mean square.
    pub rms: f64,
    /// Greatest.
    pub most: f64,
}

impl Evenness {
    fn of(light: &[f64]) -> Self {
        let mean = light.iter().sum::<f64>() / light.len().max(1) as f64;
        let off = || light.iter().map(|light| (light / mean - 1.0).abs());
        let square = off().map(|off| off * off).sum::<f64>() / light.len().max(1) as f64;
        Self { rms: square.sqrt(), most: off().fold(0.0, f64::max) }
    }
}
