//! Blend weight of a pixel.

use super::ramp::{EdgeWeight, LEAST_RAMP, ramp};
use super::{GREEN, light_of};
use crate::error::Result;
use crate::geom::pose;
use crate::rig::{AngleRamp, DomeAngle, OutputKind, Rig};
use crate::warp::WarpMap;
use glam::{DMat3, DVec2, DVec3};

/// Number of pixels of each output, in each direction, at which the greatest black is sought.
const BLACK_GRID: u32 = 64;

/// Blend weights of all outputs of a rig, in f64: the reference for shaders.
///
/// They contain neither mask images, which are files, nor the black level, which is added after the
/// weight.
#[derive(Clone, Debug)]
pub struct Weights<'rig> {
    rig: &'rig Rig,
    /// Map of each output; `None` if the output needs the program's own lens (its weight is 1).
    maps: Vec<Option<WarpMap>>,
    /// Axes in which the pole is +y and the front −z → dome axes.
    pole_axes: DMat3,
    /// Viewer axes → dome axes.
    viewer_axes: DMat3,
}

impl<'rig> Weights<'rig> {
    /// Prepares the weights of `rig` for outputs of these sizes (width, height in pixels), in the
    /// rig's order. Fails with [`crate::ErrorKind::InvalidArgument`] if a size is missing or zero.
    pub fn new(rig: &'rig Rig, sizes: &[(u32, u32)]) -> Result<Self> {
        let map = |(index, output): (usize, &crate::rig::Output)| match output.kind {
            OutputKind::Perspective { frustum: None, .. } => Ok(None),
            _ => WarpMap::new(rig, index, sizes.get(index).copied().unwrap_or_default(), None).map(Some),
        };
        let maps = rig.outputs.iter().enumerate().map(map).collect::<Result<_>>()?;
        let viewer_axes = pose::rotation(rig.viewer.yaw, rig.viewer.pitch, rig.viewer.roll);
        Ok(Self { rig, maps, pole_axes: pose::rotation(0.0, -rig.dome.tilt, 0.0), viewer_axes })
    }

    /// Weight of a pixel (from the top left, centres at +½), 0…1; `None` where the output shows
    /// nothing.
    pub fn weight(&self, output: usize, pixel: DVec2) -> Option<f64> {
        let Some(map) = self.maps.get(output)? else { return Some(1.0) };
        match map.hit(pixel) {
            Some(hit) => Some(self.weight_at(output, hit) * self.calibrated(output, pixel)),
            // A window has no place on the dome. It shares with no output, and the angles are those
            // of its directions.
            None => map.direction(pixel).map(|direction| self.ramps_at(output, self.viewer_axes * direction)),
        }
    }

    /// Part of the light that a calibration file leaves a pixel of its output; 1 for all other
    /// outputs.
    pub fn calibrated(&self, output: usize, pixel: DVec2) -> f64 {
        let map = self.maps.get(output).and_then(Option::as_ref);
        match (map, self.rig.outputs.get(output)) {
            (Some(map), Some(output)) => light_of(map.intensity(pixel), &output.blend, GREEN),
            _ => 1.0,
        }
    }

    /// Weight of an output at a point of the dome (metres, dome axes) which it lights.
    ///
    /// A projector whose rig asks for blending from overlap shares the point with every other
    /// projector that lights it. Alone, it has all of the light, up to the edge of its picture.
    /// Ramps in dome angles are multiplied in.
    pub fn weight_at(&self, output: usize, point: DVec3) -> f64 {
        let Some(described) = self.rig.outputs.get(output) else { return 0.0 };
        let is_shared = described.blend.overlap && self.is_projector(output);
        self.ramps_at(output, point) * if is_shared { self.overlap_weight_at(output, point) } else { 1.0 }
    }

    /// True if an output lights the dome.
    fn is_projector(&self, output: usize) -> bool {
        self.rig.outputs[output].kind.is_projector()
    }

    /// Outputs that light the dome, with their maps.
    pub(super) fn projectors(&self) -> impl Iterator<Item = (usize, &WarpMap)> {
        let mapped = self.maps.iter().enumerate().filter_map(|(index, map)| map.as_ref().map(|map| (index, map)));
        mapped.filter(|(index, _)| self.is_projector(*index))
    }

    /// Angle of a point (any length) from the dome's pole, and around it (0 = front,
    /// right-positive); radians.
    pub(super) fn angles(&self, point: DVec3) -> [f64; 2] {
        let local = self.pole_axes.transpose() * point;
        [local.x.hypot(local.z).atan2(local.y), local.x.atan2(-local.z)]
    }

    /// Unit direction of these angles.
    #[cfg(test)]
    pub(super) fn direction(&self, polar: f64, azimuth: f64) -> DVec3 {
        self.pole_axes * DVec3::new(polar.sin() * azimuth.sin(), polar.cos(), -polar.sin() * azimuth.cos())
    }

    /// Light that remains at a point when all outputs show black, as a part of white.
    pub fn black_at(&self, point: DVec3) -> f64 {
        let covering = self.projectors().filter(|(_, map)| map.pixel(point).is_some());
        covering.map(|(index, _)| self.rig.outputs[index].blend.black()).sum()
    }

    /// Greatest light that remains anywhere on the screen when all outputs show black, as a part of
    /// white. It is sought at 64 × 64 pixels of each output, so that a smaller corner of an overlap
    /// may be missed and stay brighter by one black.
    pub fn greatest_black(&self) -> f64 {
        let part = |i: u32| (f64::from(i % BLACK_GRID) + 0.5) / f64::from(BLACK_GRID);
        let place = |i: u32| DVec2::new(part(i), part(i / BLACK_GRID));
        let blacks = self.projectors().flat_map(|(_, map)| {
            let size = DVec2::new(f64::from(map.size().0), f64::from(map.size().1));
            (0..BLACK_GRID * BLACK_GRID).filter_map(move |i| map.hit(place(i) * size))
        });
        blacks.map(|point| self.black_at(point)).fold(0.0, f64::max)
    }

    /// Overlap weight `e_k / Σ e_j` at a point.
    fn overlap_weight_at(&self, output: usize, point: DVec3) -> f64 {
        let edge = |index: usize, map: &WarpMap, pixel: DVec2| {
            let (width, height) = map.size();
            let part = pixel / DVec2::new(f64::from(width), f64::from(height));
            EdgeWeight::of(&self.rig.outputs[index].blend).raw_weight(part)
        };
        let others = self.projectors().filter(|(index, _)| *index != output);
        let covering = others.filter_map(|(index, map)| Some(edge(index, map, map.pixel(point)?)));
        let (others, count) = covering.fold((0.0, 0), |(sum, count), edge| (sum + edge, count + 1));
        if count == 0 {
            // The quotient is 0/0 in the corners of the only picture.
            return 1.0;
        }
        // The output lights the point, even if rounding puts it just outside its picture.
        let own = self.maps[output].as_ref().and_then(|map| Some(edge(output, map, map.pixel(point)?))).unwrap_or(0.0);
        let sum = others + own;
        // On the borders of all pictures the outputs have equal weights.
        if sum > 0.0 { own / sum } else { 1.0 / f64::from(count + 1) }
    }

    /// Product of an output's procedural ramps at a point of the dome (any length).
    fn ramps_at(&self, output: usize, point: DVec3) -> f64 {
        self.rig.outputs[output].blend.ramps.iter().map(|ramp| self.ramp_at(ramp, point)).product()
    }

    /// Value of a procedural ramp at a point of the dome (any length).
    fn ramp_at(&self, described: &AngleRamp, point: DVec3) -> f64 {
        let [polar, azimuth] = self.angles(point);
        let angle = match described.angle {
            DomeAngle::Polar => polar,
            DomeAngle::Azimuth => azimuth,
        };
        let width = described.full - described.zero;
        let width = if width.abs() < LEAST_RAMP { LEAST_RAMP.copysign(width) } else { width };
        ramp(described.shape, (angle - described.zero) / width)
    }
}

/// [`Weights::weight`] of a single pixel; `None` also where [`Weights::new`] fails.
pub fn weight(rig: &Rig, output: usize, sizes: &[(u32, u32)], pixel: DVec2) -> Option<f64> {
    Weights::new(rig, sizes).ok()?.weight(output, pixel)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::blend::smoothstep;
    use crate::geom::{QuadraticForm, Sphere};
    use crate::testing::random::Random;
    use crate::warp::testing::{output, projector, rig, two_projectors};
    use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI};

    #[test]
    fn weights_add_up_to_one_wherever_there_is_light() {
        let mut random = Random::new(30);
        let mut rig = two_projectors(DVec3::ZERO);
        rig.outputs.push(output("third", projector(DVec3::new(0.0, 1.0, 2.0), 3.0, -20.0, (60.0, 40.0))));
        rig.outputs[2].blend.ramp = 0.4;
        let weights = Weights::new(&rig, &[(1920, 1080); 3]).expect("valid");
        let mut depths = [0; 4];
        for _ in 0..50_000 {
            let point = random.direction() * rig.dome.radius;
            let lit = |k: &usize| weights.maps[*k].as_ref().is_some_and(|map| map.pixel(point).is_some());
            let covering: Vec<usize> = (0..3).filter(lit).collect();
            depths[covering.len()] += 1;
            let sum: f64 = covering.iter().map(|&k| weights.weight_at(k, point)).sum();
            assert!(covering.is_empty() || (sum - 1.0).abs() < 1e-14, "{point}: {sum}");
            if let [single] = covering[..] {
                assert_eq!(weights.weight_at(single, point), 1.0);
            }
        }
        assert!(depths.iter().all(|&depth| depth > 300), "all depths of overlap occur: {depths:?}");
        // Negative control: without one of them, the others do not add up to 1.
        let first = (0..50_000)
            .map(|_| random.direction() * 5.0)
            .find(|p| (0..2).all(|k| weights.maps[k].as_ref().is_some_and(|map| map.pixel(*p).is_some())));
        assert!(first.is_some_and(|p| weights.weight_at(0, p) < 1.0));
    }

    #[test]
    fn a_known_overlap_has_known_weights() {
        // Two pictures of 90°, side by side from the centre, the right one turned by 45°: they
        // overlap from 0° to 45°. The ramps are as wide as half the picture.
        let mut rig = rig(
            FRAC_PI_2,
            DVec3::ZERO,
            &[projector(DVec3::ZERO, 0.0, 0.0, (90.0, 60.0)), projector(DVec3::ZERO, 45.0, 0.0, (90.0, 60.0))],
        );
        for output in &mut rig.outputs {
            output.blend.ramp = 0.5;
        }
        let weights = Weights::new(&rig, &[(1000, 600); 2]).expect("valid");
        // Half-way, both have the same weight.
        let middle = DVec3::new((PI / 8.0).sin(), 0.0, -(PI / 8.0).cos()) * 5.0;
        assert!((weights.weight_at(0, middle) - 0.5).abs() < 1e-14);
        // Straight ahead the right picture begins at its edge.
        let x = 500.0 + 500.0 * 0.1;
        let t = (1.0 - 0.55) / 0.5;
        let own = smoothstep(t);
        let angle = 0.1f64.atan() - FRAC_PI_4;
        let other = smoothstep((0.5 + 0.5 * angle.tan()) / 0.5);
        let found = weights.weight(0, DVec2::new(x, 300.0)).expect("shown");
        assert!((found - own / (own + other)).abs() < 1e-13, "{found}");
        // Left of straight ahead, only the left picture lights the point.
        assert_eq!(weights.weight(0, DVec2::new(1e-3, 1e-3)), Some(1.0));
    }

    #[test]
    fn the_corner_of_the_only_picture_is_lit() {
        let rig = rig(FRAC_PI_2, DVec3::ZERO, &[projector(DVec3::ZERO, 0.0, 0.0, (60.0, 40.0))]);
        assert_eq!(weight(&rig, 0, &[(100, 100)], DVec2::ZERO), Some(1.0));
        assert_eq!(weight(&rig, 0, &[(100, 100)], DVec2::new(-1.0, 5.0)), None);
        assert_eq!(weight(&rig, 0, &[], DVec2::ZERO), None);
        assert_eq!(weight(&rig, 1, &[(100, 100)], DVec2::ZERO), None);
    }

    #[test]
    fn an_output_without_overlap_keeps_its_light() {
        let mut rig = two_projectors(DVec3::ZERO);
        let point = DVec3::new(0.0, 0.3, -1.0).normalize() * 5.0;
        let share = Weights::new(&rig, &[(100, 60); 2]).expect("valid").weight_at(0, point);
        assert!(share > 0.0 && share < 1.0, "{share}");
        rig.outputs[1].blend.overlap = false;
        let weights = Weights::new(&rig, &[(100, 60); 2]).expect("valid");
        assert_eq!((weights.weight_at(0, point), weights.weight_at(1, point)), (share, 1.0));
    }

    /// A quadratic form as a shader evaluates it.
    fn evaluate_f32(form: &QuadraticForm, x: f32, y: f32) -> glam::Vec3 {
        let quadratic = |c: &[f64; 6]| {
            let [xx, yy, xy, x1, y1, one] = c.map(|c| c as f32);
            (xx * x + (xy * y + x1)) * x + ((yy * y + y1) * y + one)
        };
        let root = quadratic(&form.d).max(0.0).sqrt();
        let linear = |c: &[f64; 3]| c[0] as f32 * x + (c[1] as f32 * y + c[2] as f32);
        glam::Vec3::from_array(std::array::from_fn(|i| quadratic(&form.q[i]) + linear(&form.l[i]) * root))
    }

    #[test]
    fn weights_in_f32_add_up_too() {
        // As in goal G12, but each projector finds its own weight of a point from its own rounded
        // pixel position (1/16,000 of a pixel), not all of them at the same one.
        let rig = crate::rig::load("planetarium-6").expect("an embedded preset");
        let sphere = Sphere { center: DVec3::ZERO, radius: rig.dome.radius };
        let pinhole = |k: usize| match rig.outputs[k].kind {
            OutputKind::Projector { position, angles: [yaw, pitch, roll], frustum } => {
                (position, pose::rotation(yaw, pitch, roll), frustum)
            }
            _ => panic!("all are projectors"),
        };
        let count = rig.outputs.len();
        // Picture of j along the rays of k.
        let forms: Vec<Vec<QuadraticForm>> = (0..count)
            .map(|k| {
                let (origin, rotation, frustum) = pinhole(k);
                let seen = |j: usize| {
                    let (eye, axes, lens) = pinhole(j);
                    QuadraticForm::new(
                        origin,
                        rotation * frustum.rays(),
                        &sphere,
                        eye,
                        lens.picture() * axes.transpose(),
                    )
                };
                (0..count).map(seen).collect()
            })
            .collect();
        let smooth = |t: f32| t.clamp(0.0, 1.0) * t.clamp(0.0, 1.0) * (3.0 - 2.0 * t.clamp(0.0, 1.0));
        let edge = |x: f32, y: f32, ramp: f64| {
            let steepness = (0.5 / ramp) as f32;
            smooth((1.0 - x.abs()) * steepness) * smooth((1.0 - y.abs()) * steepness)
        };
        let sizes = vec![(1920, 1080); count];
        let weights = Weights::new(&rig, &sizes).expect("valid");
        let mut random = Random::new(31);
        let (mut worst_sum, mut worst, mut shared) = (0.0f64, 0.0f64, 0);
        for _ in 0..30_000 {
            let point = random.direction() * rig.dome.radius;
            let (mut sum, mut lit) = (0.0, 0);
            for (k, seen) in forms.iter().enumerate() {
                let Some(pixel) = weights.maps[k].as_ref().and_then(|map| map.pixel(point)) else { continue };
                let (x, y) = ((pixel.x / 960.0 - 1.0) as f32, (1.0 - pixel.y / 540.0) as f32);
                let other = |j: usize| {
                    let s = evaluate_f32(&seen[j], x, y);
                    if s.z > 0.0 { edge(s.x / s.z, s.y / s.z, rig.outputs[j].blend.ramp) } else { 0.0 }
                };
                let others: f32 = (0..count).filter(|j| *j != k).map(other).sum();
                let own = edge(x, y, rig.outputs[k].blend.ramp);
                let found = f64::from(if others > 0.0 { own / (own + others).max(1e-37) } else { 1.0 });
                worst = worst.max((found - weights.weight_at(k, point)).abs());
                (sum, lit) = (sum + found, lit + 1);
            }
            if lit > 1 {
                worst_sum = worst_sum.max((sum - 1.0f64).abs());
                shared += 1;
            }
        }
        assert!(shared > 5_000 && worst_sum < 4e-6 && worst < 4e-6, "{worst_sum:e} {worst:e} {shared}");
    }

    #[test]
    fn ramps_follow_dome_angles() {
        let fisheye = OutputKind::Domemaster { aperture: PI, tilt: 0.0 };
        let mut rig = rig(0.0, DVec3::ZERO, &[fisheye]);
        let ramp = |angle, zero: f64, full: f64| AngleRamp {
            angle,
            zero: zero.to_radians(),
            full: full.to_radians(),
            shape: crate::rig::RampShape::Smoothstep,
        };
        rig.outputs[0].blend.ramps = vec![ramp(DomeAngle::Polar, 80.0, 60.0), ramp(DomeAngle::Azimuth, -10.0, 30.0)];
        let at = |rig: &Rig, polar: f64, azimuth: f64| {
            let tilt = rig.dome.tilt;
            let (polar, azimuth) = (polar.to_radians(), azimuth.to_radians());
            let local = DVec3::new(polar.sin() * azimuth.sin(), polar.cos(), -polar.sin() * azimuth.cos());
            // The pole leans forward by the tilt.
            let (sine, cosine) = tilt.sin_cos();
            let leaned = DVec3::new(local.x, cosine * local.y + sine * local.z, cosine * local.z - sine * local.y);
            Weights::new(rig, &[(100, 100)]).expect("valid").weight_at(0, leaned * 5.0)
        };
        for tilt in [0.0, 0.5, FRAC_PI_2] {
            rig.dome.tilt = tilt;
            assert!((at(&rig, 50.0, 40.0) - 1.0).abs() < 1e-12);
            assert!((at(&rig, 70.0, 40.0) - 0.5).abs() < 1e-12 && at(&rig, 81.0, 40.0) == 0.0);
            assert!((at(&rig, 50.0, 10.0) - 0.5).abs() < 1e-12 && at(&rig, 50.0, -11.0) == 0.0);
        }
        rig.outputs[0].blend.ramps = vec![ramp(DomeAngle::Polar, 45.0, 45.0)];
        assert_eq!((at(&rig, 44.0, 0.0), at(&rig, 46.0, 0.0)), (0.0, 1.0), "a ramp without width is a step");
    }
}
