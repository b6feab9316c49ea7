//! Curves at which the content of an output may end inside its picture.

use crate::views::sampling::output_map::{Map, OutputMap, traced_pixel};
use crate::views::sampling::projector_map::{Hit, ProjectorMap};
use crate::views::sampling::sample::{Sample, outer};
use glam::{DMat3, DVec3};

/// Function that returns the sample at a place along a line (0…1), where it is in the picture.
pub(crate) type BoundaryCurve<'a> = Box<dyn Fn(f64) -> Option<Sample> + 'a>;

/// A circle on the dome around `axis`.
#[derive(Clone, Copy, Debug)]
struct Circle {
    axis: DVec3,
    cosine: f64,
}

/// Distances from the contour of a surface, in radii, at which a ray is tried. The nearest ones may
/// miss the surface by rounding where the light comes from afar.
const INSETS: [f64; 4] = [1e-7, 1e-6, 1e-5, 1e-4];

/// Returns the sample of a surface that is seen edge-on, where no resolution is enough: its pixel
/// counts as wide as it is long.
fn edge_on(sample: Sample) -> Sample {
    let Sample { direction, spread } = sample;
    let squared = spread.x_axis.x + spread.y_axis.y + spread.z_axis.z;
    Sample { direction, spread: (DMat3::IDENTITY - outer(direction, direction)) * squared }
}

impl OutputMap {
    /// Returns the curves at which an output's content may end inside its picture: the rims of the
    /// screen, and the outline of a dome for a projector outside. Each curve returns the samples
    /// along it (0…1) that lie within the outermost pixel centres.
    pub fn boundary_curves(&self) -> Vec<BoundaryCurve<'_>> {
        match &self.map {
            Map::Projector(map) => {
                let distance = map.origin.length();
                // At the outline the dome is seen edge-on, and no resolution is enough. So the
                // circle lies just within it.
                let outline = (distance > map.radius)
                    .then(|| Circle { axis: map.origin / distance, cosine: map.radius / distance - 1e-6 });
                let cap = map.least_cosine.map(|cosine| Circle { axis: map.pole, cosine });
                let sampled =
                    |circle: Circle| -> BoundaryCurve<'_> { Box::new(move |turn| self.on_circle(map, &circle, turn)) };
                cap.into_iter().chain(outline).map(sampled).collect()
            }
            Map::Traced { map, .. } => {
                let mut curves: Vec<BoundaryCurve<'_>> = Vec::new();
                for rim in map.screen().rims().into_iter().chain(map.screen().horizon()) {
                    curves.push(Box::new(move |part| self.sample(traced_pixel(map, rim(part))?)));
                }
                for contour in map.origin().into_iter().flat_map(|from| map.screen().contours(from)) {
                    let just_within = move |part, inset| self.sample(traced_pixel(map, contour(part, inset))?);
                    curves.push(Box::new(move |part| INSETS.into_iter().find_map(|inset| just_within(part, inset))));
                }
                // Where the viewer looks along the surface, the picture folds.
                let viewer = map.viewer().position;
                let folds = if map.origin() == Some(viewer) { Vec::new() } else { map.screen().contours(viewer) };
                for fold in folds {
                    curves.push(Box::new(move |part| Some(edge_on(self.sample(traced_pixel(map, fold(part, 0.0))?)?))));
                }
                curves
            }
            _ => Vec::new(),
        }
    }

    /// Returns the sample at `turn` (0…1) around a circle, if it lies within the outermost pixel
    /// centres.
    fn on_circle(&self, map: &ProjectorMap, rim: &Circle, turn: f64) -> Option<Sample> {
        let (first, second) = rim.axis.any_orthonormal_pair();
        let (sine, cosine) = (turn * std::f64::consts::TAU).sin_cos();
        let radius = (1.0 - rim.cosine * rim.cosine).max(0.0).sqrt();
        let point = (rim.axis * rim.cosine + (first * cosine + second * sine) * radius) * map.radius;
        let picture = map.picture * (point - map.origin);
        let at = self.within_picture(picture)?;
        let hit = Hit { point, ray: map.rays * at.extend(1.0), distance: picture.z };
        // On the rim of the cap, rounding decides on which side the point lies.
        let on_screen = map.least_cosine.is_none_or(|least| point.dot(map.pole) >= (least - 1e-9) * map.radius);
        let far = hit.point.dot(hit.ray) > 0.0;
        (on_screen && far).then(|| map.sample(&hit, self.per_pixel())).flatten()
    }
}
