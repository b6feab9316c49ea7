//! Points where blend weights must jump: the edges of two pictures cross, and no third picture
//! lights the point.
//!
//! Next to such a point, one side belongs to the first projector alone, the other side to the
//! second alone. Between them the weights pass from 0 to 1 within an angle that shrinks to nothing.
//! No ramp can prevent that; another picture can.

use super::{EdgeWeight, Weights};
use crate::error::Result;
use crate::rig::Rig;
use crate::warp::WarpMap;
use glam::{DVec2, DVec3};

/// A point where blend weights jump.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Crossing {
    /// The two outputs.
    pub outputs: [usize; 2],
    /// The point, dome axes.
    pub point: DVec3,
    /// Angle from the dome's pole, radians.
    pub polar: f64,
    /// Angle around the pole, 0 = front, right-positive, radians.
    pub azimuth: f64,
}

/// Number of steps along each side of a picture.
const STEPS: u32 = 256;
/// Number of halvings of a step: the result is far below a pixel.
const HALVINGS: u32 = 30;
/// Least raw weight of a third projector that makes the weights continuous.
const ENOUGH: f64 = 0.01;

/// Points of the screen where the blend weights of overlapping outputs jump, for outputs of these
/// sizes (pixels).
///
/// Two borders that cross within less than a step of each other (1/256 of a side) may be missed.
///
/// # Errors
/// Errors of [`Weights::new`].
pub fn crossings(rig: &Rig, sizes: &[(u32, u32)]) -> Result<Vec<Crossing>> {
    let weights = Weights::new(rig, sizes)?;
    let sharing: Vec<(usize, &WarpMap)> =
        weights.projectors().filter(|(index, _)| rig.outputs[*index].blend.overlap).collect();
    let mut found = Vec::new();
    for (place, &(first, map)) in sharing.iter().enumerate() {
        for &(second, other) in &sharing[place + 1..] {
            for point in crossings_of(map, other) {
                let beneath = sharing.iter().filter(|(third, _)| ![first, second].contains(third));
                let raw_weight =
                    beneath.map(|(third, map)| raw_weight(&EdgeWeight::of(&rig.outputs[*third].blend), map, point));
                if raw_weight.sum::<f64>() < ENOUGH {
                    let [polar, azimuth] = weights.angles(point);
                    found.push(Crossing { outputs: [first, second], point, polar, azimuth });
                }
            }
        }
    }
    Ok(found)
}

/// Returns the raw weight of a projector at a point.
fn raw_weight(edge_weight: &EdgeWeight, map: &WarpMap, point: DVec3) -> f64 {
    let size = DVec2::new(f64::from(map.size().0), f64::from(map.size().1));
    map.pixel(point).map_or(0.0, |pixel| edge_weight.raw_weight(pixel / size))
}

/// Returns the points at which the border of one picture on the screen enters or leaves another
/// picture. Edges of the screen do not count.
fn crossings_of(map: &WarpMap, other: &WarpMap) -> Vec<DVec3> {
    let size = DVec2::new(f64::from(map.size().0), f64::from(map.size().1));
    let corners = [DVec2::ZERO, DVec2::X, DVec2::ONE, DVec2::Y];
    let mut found = Vec::new();
    for (index, start) in corners.into_iter().enumerate() {
        let end = corners[(index + 1) % 4];
        let at = |t: f64| map.hit(start.lerp(end, t) * size);
        let inside = |t: f64| at(t).map(|point| other.pixel(point).is_some());
        for step in 0..STEPS {
            let [mut low, mut high] = [step, step + 1].map(|step| f64::from(step) / f64::from(STEPS));
            let (Some(before), Some(after)) = (inside(low), inside(high)) else { continue };
            if before == after {
                continue;
            }
            for _ in 0..HALVINGS {
                let middle = 0.5 * (low + high);
                if inside(middle) == Some(before) { low = middle } else { high = middle }
            }
            found.extend(at(low));
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::warp::testing::{projector, rig};
    use std::f64::consts::FRAC_PI_2;

    #[test]
    fn two_borders_cross_twice_and_a_third_picture_mends_one() {
        // Side by side from the centre, one 10° higher.
        let pair = [projector(DVec3::ZERO, 0.0, 0.0, (60.0, 40.0)), projector(DVec3::ZERO, 40.0, 10.0, (60.0, 40.0))];
        let two = rig(FRAC_PI_2, DVec3::ZERO, &pair);
        let found = crossings(&two, &[(960, 600); 2]).expect("valid");
        assert_eq!(found.len(), 2, "{found:?}");
        assert!(found.iter().all(|crossing| crossing.outputs == [0, 1]));
        // Close to the crossing, the weights do jump.
        let weights = Weights::new(&two, &[(960, 600); 2]).expect("valid");
        for crossing in &found {
            let direction = weights.direction(crossing.polar, crossing.azimuth);
            let (across, up) =
                (direction.any_orthonormal_vector(), direction.cross(direction.any_orthonormal_vector()));
            let around = (0..64).map(|i| {
                let (sine, cosine) = (f64::from(i) * std::f64::consts::TAU / 64.0).sin_cos();
                (direction + (across * cosine + up * sine) * 1e-5) * two.dome.radius
            });
            let lit = around.filter(|point| weights.projectors().all(|(_, map)| map.pixel(*point).is_some()));
            let is_shared: Vec<f64> = lit.map(|point| weights.weight_at(0, point)).collect();
            let (least, most) = is_shared.iter().fold((1.0f64, 0.0f64), |(l, m), s| (l.min(*s), m.max(*s)));
            assert!(least < 0.2 && most > 0.8, "{crossing:?}: {least} to {most}");
        }
        let upper =
            found.iter().map(|crossing| weights.direction(crossing.polar, crossing.azimuth).y).fold(-1.0, f64::max);
        let third = projector(DVec3::ZERO, 15.0, 25.0, (60.0, 40.0));
        let three = rig(FRAC_PI_2, DVec3::ZERO, &[pair[0].clone(), pair[1].clone(), third]);
        let mended = crossings(&three, &[(960, 600); 3]).expect("valid");
        let old = mended.iter().filter(|crossing| crossing.outputs == [0, 1]).count();
        assert_eq!(old, 1, "the crossing at a height of {upper} has a picture beneath: {mended:?}");
    }
}
