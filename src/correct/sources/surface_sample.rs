//! Exact samples of an output, from which tables and meshes are made.

use crate::blend::Weights;
use crate::correct::passes::table::{Table, TablePixel};
use crate::error::Result;
use crate::geom::{Lens, pose};
use crate::rig::{OutputKind, Rig};
use crate::warp::WarpMap;
use crate::warp::accuracy::pixel_angle;
use glam::{DVec2, DVec3};

/// Samples of one output, traced ray by ray in f64.
pub(in crate::correct) struct SurfaceSampler<'rig> {
    map: WarpMap,
    weights: Weights<'rig>,
    index: usize,
    evenness: Option<Evenness>,
    scale: Scale,
    /// True if some output specifies how bright its black is.
    with_black: bool,
}

/// Visible point of a screen at a place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::correct) struct SurfaceSample {
    /// Vector from the viewer to the point, viewer axes. Its length suits interpolation, see
    /// [`Scale`].
    pub vector: DVec3,
    /// Weight in linear light, 0…1.
    pub weight: f64,
}

/// Length of the vectors from the viewer to the screen, which are interpolated over the output.
///
/// Only their directions matter. In the picture of a pinhole, vectors divided by their distance
/// along the lens's axis are linear for a flat screen. So interpolation is exact for a flat screen,
/// and also for any screen if the viewer is in the lens.
enum Scale {
    /// The distance to the screen.
    Length,
    /// The same, divided by the distance from `origin` along `axis`, both in dome axes.
    Depth { origin: DVec3, axis: DVec3 },
    /// For a picture without a position: unit vectors divided by their part along `axis`, viewer
    /// axes.
    Window { axis: DVec3 },
}

impl Scale {
    fn of(kind: &OutputKind) -> Self {
        let towards = |[yaw, pitch, roll]: [f64; 3]| -pose::rotation(yaw, pitch, roll).z_axis;
        match kind {
            OutputKind::Projector { position, angles, .. } => Self::Depth { origin: *position, axis: towards(*angles) },
            OutputKind::Optics { optics, .. } if optics.mirror.is_none() => match optics.lens {
                Lens::Pinhole { .. } => {
                    Self::Depth { origin: optics.pose.position, axis: -optics.pose.rotation.z_axis }
                }
                Lens::Fisheye { .. } => Self::Length,
            },
            OutputKind::Perspective { angles, .. } => Self::Window { axis: towards(*angles) },
            _ => Self::Length,
        }
    }
}

impl<'rig> SurfaceSampler<'rig> {
    /// Returns the sampler of output `index` of `rig`; the outputs have `sizes` pixels.
    ///
    /// # Errors
    /// Those of [`WarpMap::new`].
    pub fn new(rig: &'rig Rig, index: usize, sizes: &[(u32, u32)]) -> Result<Self> {
        let size = sizes.get(index).copied().unwrap_or_default();
        let evenness = match &rig.outputs[index].kind {
            OutputKind::Optics { even_light, .. } if *even_light > 0.0 => {
                Some(Evenness::of(rig, index, sizes, *even_light)?)
            }
            _ => None,
        };
        Ok(Self {
            map: WarpMap::new(rig, index, size, None)?,
            weights: Weights::new(rig, sizes)?,
            index,
            evenness,
            scale: Scale::of(&rig.outputs[index].kind),
            with_black: rig.outputs.iter().any(|output| output.blend.contrast.is_some()),
        })
    }

    /// Returns the output's size in pixels.
    pub fn size(&self) -> (u32, u32) {
        self.map.size()
    }

    /// Returns the sample at a pixel position (from the top left, centres at +½); `None` where
    /// nothing is shown.
    pub fn at(&self, pixel: DVec2) -> Option<SurfaceSample> {
        let even = self.evenness.as_ref().map_or(1.0, |evenness| evenness.weight(&self.map, pixel));
        match self.map.hit(pixel) {
            Some(hit) => Some(SurfaceSample {
                weight: even * self.weights.calibrated(self.index, pixel) * self.weight(hit),
                vector: self.vector(hit)?,
            }),
            None => {
                let direction = self.map.direction(pixel)?;
                let depth = match self.scale {
                    Scale::Window { axis } => direction.dot(axis),
                    _ => 1.0,
                };
                Some(SurfaceSample { vector: direction / depth, weight: self.weights.weight(self.index, pixel)? })
            }
        }
    }

    /// Returns the vector from the viewer to a point of the screen (metres, dome axes); `None` for
    /// the viewer's own position, and behind the lens.
    pub fn vector(&self, point: DVec3) -> Option<DVec3> {
        let vector = self.map.viewer().point_to_local(point);
        let depth = match self.scale {
            Scale::Depth { origin, axis } => (point - origin).dot(axis),
            _ => 1.0,
        };
        (vector != DVec3::ZERO && depth > 0.0).then(|| vector / depth)
    }

    /// Returns the weight at a point of the screen, without factors that depend on the pixel.
    pub fn weight(&self, point: DVec3) -> f64 {
        self.weights.weight_at(self.index, point)
    }

    /// Returns the error of a vector that is shown at a pixel position, in pixels; `None` where
    /// nothing is to be shown.
    pub fn error(&self, pixel: DVec2, vector: DVec3) -> Option<f64> {
        let exact = self.map.direction(pixel)?;
        let size = pixel_angle(&self.map, pixel)?;
        Some(exact.cross(vector).length().atan2(exact.dot(vector)) / size)
    }

    /// Returns the table of all pixels.
    pub fn table(&self) -> Table {
        Table::new(self.size(), |column, row| {
            let pixel = DVec2::new(f64::from(column) + 0.5, f64::from(row) + 0.5);
            let sample = self.at(pixel)?;
            let hit = if self.with_black { self.map.hit(pixel) } else { None };
            let dark = hit.map_or(0.0, |hit| self.weights.black_at(hit));
            Some(TablePixel { direction: sample.vector, weight: sample.weight, dark })
        })
    }
}

/// Dimming that evens out the light of pixels of different size, on a screen that scatters light
/// evenly. The same light on a smaller area is brighter by the ratio of the areas, which is the
/// determinant of the map's Jacobian. It includes distance and incidence. Projectors count as
/// equally bright, so that their light is the same where they overlap.
struct Evenness {
    /// Area of the pixels that are not dimmed.
    reference: f64,
    strength: f64,
    /// Precomputed areas, for a picture with many pixels.
    areas: Option<Areas>,
}

/// Number of pixels in each direction that are examined for the reference.
const REFERENCE_GRID: u32 = 64;
/// Part of the pixels that are dimmed. The others, stretched pixels near grazing light, would
/// darken all.
const DIMMED: f64 = 0.9;

impl Evenness {
    /// Returns the dimming of output `index`. The reference is the output whose pixels are largest
    /// for their light.
    fn of(rig: &Rig, index: usize, sizes: &[(u32, u32)], strength: f64) -> Result<Self> {
        let size = sizes.get(index).copied().unwrap_or_default();
        let pixels = |(width, height): (u32, u32)| f64::from(width) * f64::from(height);
        let mut reference = 0.0f64;
        for (other, (output, &size)) in rig.outputs.iter().zip(sizes).enumerate() {
            if matches!(output.kind, OutputKind::Optics { even_light, .. } if even_light > 0.0) {
                let map = WarpMap::new(rig, other, size, None)?;
                reference = reference.max(Self::large_area(&map) * pixels(size));
            }
        }
        let many = size.0 >= 2 * AREA_CELLS && size.1 >= 2 * AREA_CELLS;
        let areas = many.then(|| WarpMap::new(rig, index, size, None).map(|map| Areas::of(&map))).transpose()?;
        Ok(Self { reference: reference / pixels(size), strength, areas })
    }

    /// Returns the area on the screen that most pixels of a map do not exceed.
    fn large_area(map: &WarpMap) -> f64 {
        let size = DVec2::new(f64::from(map.size().0), f64::from(map.size().1));
        let place = |i: u32| (f64::from(i) + 0.5) / f64::from(REFERENCE_GRID);
        let grid = (0..REFERENCE_GRID).flat_map(|y| (0..REFERENCE_GRID).map(move |x| DVec2::new(place(x), place(y))));
        let mut areas: Vec<f64> = grid.filter_map(|part| map.area(part * size)).collect();
        areas.sort_by(f64::total_cmp);
        areas.get((areas.len() as f64 * DIMMED) as usize).copied().unwrap_or_default()
    }

    /// Returns the weight of a pixel, linear light; 1 where its area is not known.
    fn weight(&self, map: &WarpMap, pixel: DVec2) -> f64 {
        let area = self.areas.as_ref().and_then(|areas| areas.at(pixel)).or_else(|| map.area(pixel));
        let ratio = area.filter(|_| self.reference > 0.0).map_or(1.0, |area| area / self.reference);
        ratio.min(1.0).powf(self.strength)
    }
}

/// Number of cells in each direction in which areas are interpolated, where they vary smoothly: in
/// the preset `idome` that saves four fifths of all rays.
const AREA_CELLS: u32 = 256;
/// Greatest error of an interpolated area, as a part of it. Half of it is the error of a weight.
const AREA_ERROR: f64 = 1e-3;

/// The areas that pixels light, at the corners of cells.
struct Areas {
    /// Distance between corners, pixels.
    step: DVec2,
    /// Areas, row by row; NaN where a pixel has none, and where they change too fast to be
    /// interpolated, as where light grazes the screen.
    corners: Vec<f64>,
}

impl Areas {
    fn of(map: &WarpMap) -> Self {
        let size = DVec2::new(f64::from(map.size().0), f64::from(map.size().1));
        // Pixels in the first and last row and column have differences to both sides, too.
        let step = (size - 1.0) / f64::from(AREA_CELLS);
        let places = (0..=AREA_CELLS).flat_map(|y| (0..=AREA_CELLS).map(move |x| (f64::from(x), f64::from(y))));
        let area = |(x, y)| map.area(DVec2::new(x, y) * step + 0.5).unwrap_or(f64::NAN);
        let areas: Vec<f64> = places.map(area).collect();
        let corners =
            (0..areas.len()).map(|index| if Self::is_smooth(&areas, index) { areas[index] } else { f64::NAN });
        Self { step, corners: corners.collect() }
    }

    /// True if the areas around a corner are nearly linear: the error of linear interpolation is an
    /// eighth of the second difference.
    fn is_smooth(areas: &[f64], corner: usize) -> bool {
        let width = AREA_CELLS as usize + 1;
        let (x, y) = (corner % width, corner / width);
        let inner = |at: usize| at.clamp(1, width - 2);
        let second = |at: usize, step: usize| areas[at - step] - 2.0 * areas[at] + areas[at + step];
        let (across, down) = (second(y * width + inner(x), 1), second(inner(y) * width + x, width));
        across.abs() + down.abs() <= 8.0 * AREA_ERROR * areas[corner]
    }

    /// Returns the area at a pixel position; `None` where it has to be found without interpolation:
    /// at an edge of the shown part.
    fn at(&self, pixel: DVec2) -> Option<f64> {
        let last = f64::from(AREA_CELLS - 1);
        let place = (pixel - 0.5) / self.step;
        let cell = place.floor().clamp(DVec2::ZERO, DVec2::splat(last));
        let part = place - cell;
        let corner =
            |x: usize, y: usize| self.corners[(cell.y as usize + y) * (AREA_CELLS as usize + 1) + cell.x as usize + x];
        let row = |y: usize| corner(0, y) * (1.0 - part.x) + corner(1, y) * part.x;
        let area = row(0) * (1.0 - part.y) + row(1) * part.y;
        area.is_finite().then_some(area)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn areas_between_cells_corners_are_those_of_pixels() {
        let text = include_str!("../../../examples/rigs/mirror-planetarium.toml");
        let grazing = crate::rig::parse(text, "mirror-planetarium.toml", std::path::Path::new("")).expect("a rig");
        for rig in [crate::rig::load("idome").expect("a preset"), grazing] {
            let size = (640, 640);
            let map = WarpMap::new(&rig, 0, size, None).expect("a map");
            let areas = Areas::of(&map);
            let (mut all, mut compared, mut worst) = (0, 0, 0.0f64);
            for (x, y) in (0..size.1).flat_map(|y| (0..size.0).map(move |x| (x, y))).step_by(7) {
                let pixel = DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5);
                let Some(exact) = map.area(pixel) else { continue };
                all += 1;
                if let Some(between) = areas.at(pixel) {
                    compared += 1;
                    worst = worst.max((between / exact - 1.0).abs());
                }
            }
            println!("{}: {compared} of {all} areas are interpolated, off by {worst:.2e}", rig.name);
            // Rounding of the second differences, which are those of the corners only.
            assert!(compared * 2 > all && worst < 1.5 * AREA_ERROR, "{}: {compared} of {all}, {worst}", rig.name);
            // Negative control: the area of another cell is noticed.
            let aside = DVec2::new(320.5, 200.5);
            let (there, here) = (areas.at(aside + areas.step), map.area(aside));
            assert!((there.expect("shown") / here.expect("shown") - 1.0).abs() > 1e-3);
        }
    }
}
