//! Picture that an audience sees when all outputs light the dome.

use super::{code_of, light_of};
use crate::error::{Error, ErrorKind, Result};
use crate::geom::{Fisheye, pose};
use crate::rig::{Blend, Rig};
use crate::warp::WarpMap;
use glam::{DVec2, DVec3};
use std::f64::consts::{FRAC_PI_2, PI};

/// A picture that an output shows.
#[derive(Clone, Debug, PartialEq)]
pub struct Picture {
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// Red, green and blue of each pixel, row by row from the top, as sent to the display: encoded,
    /// 0…1.
    pub rgb: Vec<f32>,
}

/// Picture that the audience sees.
#[derive(Clone, Debug, PartialEq)]
pub struct Simulation {
    /// Width and height in pixels.
    pub size: u32,
    /// Red, green and blue of each pixel, row by row from the top, encoded for the first output's
    /// display. Not limited to 1: light adds up.
    pub rgb: Vec<f32>,
    /// Number of outputs that light each pixel.
    pub coverage: Vec<u8>,
    /// Evenness of the light.
    pub uniformity: Uniformity,
}

/// Evenness of the summed light, relative to full white. It has a meaning for white pictures, where
/// the summed linear light is the sum of the weights and should be 1.
///
/// Pixels count if at least one output lights them, except where a bilinear sample would mix in a
/// pixel that is rightly black because it lies outside the circle of its output or off the screen.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Uniformity {
    /// Greatest deviation of the light (mean of the three primaries) from 1.
    pub max: f64,
    /// Root mean square deviation from 1.
    pub rms: f64,
    /// Mean light.
    pub mean: f64,
    /// Number of pixels counted.
    pub covered_pixels: u64,
}

/// Light at one point.
struct Light {
    /// Summed linear light.
    rgb: [f64; 3],
    /// Number of outputs that contribute.
    coverage: u8,
    /// True if no sample touches a pixel that shows nothing.
    whole: bool,
}

/// Picture of one output, and its map.
struct Source<'a> {
    map: WarpMap,
    picture: &'a Picture,
    blend: &'a Blend,
}

/// Simulates the dome. The result is an equidistant picture, `size` pixels wide and high, of the
/// viewer's sight when each output of `rig` shows its picture (in the rig's order).
///
/// The picture's centre points to the dome's pole, in the viewer's frame, turned as a domemaster of
/// that tilt is; its aperture is the dome's coverage, at least 180°. For each pixel the viewer's
/// ray is followed to the dome, and the linear light of all outputs at that point is summed (each
/// sampled bilinearly, its display's response undone, the light of its black added). Perspective
/// outputs are not on the dome; they appear as windows in front of the viewer.
///
/// Fails with [`ErrorKind::InvalidArgument`] if the pictures do not fit the rig, or an output needs
/// the program's lens.
pub fn simulate(rig: &Rig, pictures: &[Picture], size: u32) -> Result<Simulation> {
    let sources = sources(rig, pictures)?;
    let lens = Fisheye { aperture: rig.dome.coverage.max(PI) };
    let lens_axes = pose::rotation(0.0, FRAC_PI_2 - rig.dome.tilt, 0.0);
    let viewer = rig.viewer_pose();
    let screen = rig.surface();
    let shown = rig.outputs.first().map(|output| output.blend.clone()).unwrap_or_default();
    let count = size as usize * size as usize;
    let mut simulation = Simulation {
        size,
        rgb: Vec::with_capacity(3 * count),
        coverage: Vec::with_capacity(count),
        uniformity: Uniformity::default(),
    };
    let mut evenness = Evenness::default();
    for index in 0..count {
        let position = |i: usize| (i as f64 + 0.5) / f64::from(size) * 2.0 - 1.0;
        let direction = lens.direction(position(index % size as usize), -position(index / size as usize));
        let point = direction.and_then(|lens_direction| {
            Some(screen.unbounded_hit(viewer.position, viewer.direction_to_parent(lens_axes * lens_direction))?.point)
        });
        let light = point.map_or(Light { rgb: [0.0; 3], coverage: 0, whole: false }, |point| light_at(&sources, point));
        if light.coverage > 0 && light.whole {
            evenness.add(light.rgb.iter().sum::<f64>() / 3.0);
        }
        simulation.rgb.extend([0, 1, 2].map(|channel| code_of(light.rgb[channel], &shown, channel) as f32));
        simulation.coverage.push(light.coverage);
    }
    simulation.uniformity = evenness.result();
    Ok(simulation)
}

/// Pairs outputs with their pictures.
fn sources<'a>(rig: &'a Rig, pictures: &'a [Picture]) -> Result<Vec<Source<'a>>> {
    let invalid = |message: String| Error::new(ErrorKind::InvalidArgument, message);
    if pictures.len() != rig.outputs.len() {
        let (given, needed) = (pictures.len(), rig.outputs.len());
        return Err(invalid(format!("{given} pictures given, rig \"{}\" has {needed} outputs", rig.name)));
    }
    let source = |(index, picture): (usize, &'a Picture)| {
        let output = &rig.outputs[index];
        let expected = 3 * picture.width as usize * picture.height as usize;
        if picture.rgb.len() != expected {
            let found = picture.rgb.len();
            return Err(invalid(format!("the picture of \"{}\" has {found} values, not {expected}", output.name)));
        }
        let map = WarpMap::new(rig, index, (picture.width, picture.height), None)?;
        Ok(Source { map, picture, blend: &output.blend })
    };
    pictures.iter().enumerate().map(source).collect()
}

/// Light of all outputs at a point of the dome.
fn light_at(sources: &[Source<'_>], point: DVec3) -> Light {
    let mut light = Light { rgb: [0.0; 3], coverage: 0, whole: true };
    for source in sources {
        let Some(pixel) = source.map.pixel(point) else { continue };
        let (rgb, whole) = source.sample(pixel);
        for (sum, channel) in light.rgb.iter_mut().zip(rgb) {
            *sum += channel + source.blend.black();
        }
        light.coverage = light.coverage.saturating_add(1);
        light.whole &= whole;
    }
    light
}

impl Source<'_> {
    /// Linear light at a position by bilinear interpolation, clamped at the border, and whether all
    /// four pixels show something.
    fn sample(&self, pixel: DVec2) -> ([f64; 3], bool) {
        let corner = pixel - 0.5;
        let base = corner.floor();
        let part = corner - base;
        let mut rgb = [0.0; 3];
        let mut whole = true;
        for (dx, dy) in [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (1.0, 1.0)] {
            let last = DVec2::new(f64::from(self.picture.width - 1), f64::from(self.picture.height - 1));
            let tap = (base + DVec2::new(dx, dy)).clamp(DVec2::ZERO, last);
            let weight =
                (if dx > 0.0 { part.x } else { 1.0 - part.x }) * (if dy > 0.0 { part.y } else { 1.0 - part.y });
            let index = 3 * (tap.y as usize * self.picture.width as usize + tap.x as usize);
            for (channel, (sum, encoded)) in rgb.iter_mut().zip(&self.picture.rgb[index..index + 3]).enumerate() {
                *sum += weight * light_of(f64::from(*encoded), self.blend, channel);
            }
            whole = whole && self.map.direction(tap + 0.5).is_some();
        }
        (rgb, whole)
    }
}

/// Sums for [`Uniformity`].
#[derive(Default)]
struct Evenness {
    count: u64,
    sum: f64,
    squares: f64,
    max: f64,
}

impl Evenness {
    /// Counts a pixel.
    fn add(&mut self, light: f64) {
        let deviation = light - 1.0;
        self.count += 1;
        self.sum += light;
        self.squares += deviation * deviation;
        self.max = self.max.max(deviation.abs());
    }

    /// Statistics; all zero if nothing was counted.
    fn result(&self) -> Uniformity {
        let count = self.count.max(1) as f64;
        Uniformity {
            max: self.max,
            rms: (self.squares / count).sqrt(),
            mean: self.sum / count,
            covered_pixels: self.count,
        }
    }
}

#[cfg(test)]
mod tests;
