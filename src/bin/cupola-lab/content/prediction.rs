//! Pictures that outputs and an audience should see of a content picture, pixel by pixel in f64.

use crate::failure::Failure;
use cupola::blend::{Picture, Weights, code_of, light_of};
use cupola::geom::ContentMap;
use cupola::rig::{Filter, OutputKind, Rig};
use cupola::warp::WarpMap;
use glam::{DVec2, DVec3};
use std::path::Path;

/// Encoded red, green and blue, 0…1.
pub type Color = [f64; 3];

/// Content picture on a rig: nothing here uses the shaders or what is computed for them.
pub struct Prediction<'a> {
    /// The rig around the content, whose viewer is in the dome's centre.
    rig: &'a Rig,
    plain: &'a Picture,
    weights: Weights<'a>,
    evenness: Vec<Option<Evenness>>,
    /// Map of each output.
    pub maps: Vec<WarpMap>,
    /// Map from directions to the content picture, for each output.
    content: Vec<ContentMap>,
}

/// Dimming of a projector with `even_light`.
struct Evenness {
    strength: f64,
    /// Area of a pixel that is not dimmed, square metres.
    full: f64,
}

/// Number of pixels in each direction at which the areas of pixels are compared.
const AREA_GRID: u32 = 64;
/// Part of the pixels that are dimmed: the largest tenth is not.
const DIMMED: f64 = 0.9;
/// Step, in pixels, within which rounding may decide whether a pixel shows something.
const RIM: f64 = 0.02;

impl<'a> Prediction<'a> {
    /// Prepares the prediction for the rig of `Rig::around_content`, the program's picture and the
    /// sizes of the outputs.
    pub fn new(rig: &'a Rig, plain: &'a Picture, sizes: &[(u32, u32)]) -> Result<Self, Failure> {
        if rig.views.filter != Filter::Bilinear {
            return Err(Failure::usage("the prediction is bilinear; expected views.filter = \"bilinear\""));
        }
        if let Some(output) = rig.outputs.iter().find(|output| output.mask.is_some() || output.blend.black() > 0.0) {
            return Err(Failure::usage(format!(
                "output {} has a mask or a black level, which are not predicted",
                output.name
            )));
        }
        let count = 0..rig.outputs.len();
        let maps = count.clone().map(|index| WarpMap::new(rig, index, sizes[index], None));
        let maps = maps.collect::<cupola::error::Result<Vec<_>>>()?;
        let content = count.clone().filter_map(|index| rig.content_map(index, (plain.width, plain.height)));
        let strength = |index: usize| match rig.outputs[index].kind {
            OutputKind::Optics { even_light, .. } if even_light > 0.0 => Some(even_light),
            _ => None,
        };
        let pixels = |index: usize| f64::from(sizes[index].0) * f64::from(sizes[index].1);
        let evened = count.clone().filter(|index| strength(*index).is_some());
        let light = evened.map(|index| large_area(&maps[index]) * pixels(index)).fold(0.0, f64::max);
        let even = |index| strength(index).map(|strength| Evenness { strength, full: light / pixels(index) });
        Ok(Self {
            weights: Weights::new(rig, sizes)?,
            evenness: count.map(even).collect(),
            content: content.collect(),
            rig,
            plain,
            maps,
        })
    }

    /// Colour of the content picture at a point of the screen (metres, dome axes): the weighted
    /// mean of the four nearest pixels. `None` where the picture shows nothing.
    pub fn color(&self, output: usize, point: DVec3) -> Option<Color> {
        let place = self.content[output].place(self.rig.viewer_pose().point_to_local(point))?;
        let size = DVec2::new(f64::from(self.plain.width), f64::from(self.plain.height));
        let corner = DVec2::new(place.x, 1.0 - place.y) * size - 0.5;
        let (base, part) = (corner.floor(), corner - corner.floor());
        let mut color = [0.0; 3];
        for (x, y) in [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (1.0, 1.0)] {
            let pixel = (base + DVec2::new(x, y)).clamp(DVec2::ZERO, size - 1.0);
            let weights = DVec2::ONE - (DVec2::new(x, y) - part).abs();
            let index = 3 * (pixel.y as usize * self.plain.width as usize + pixel.x as usize);
            for (sum, value) in color.iter_mut().zip(&self.plain.rgb[index..index + 3]) {
                *sum += weights.x * weights.y * f64::from(*value);
            }
        }
        Some(color)
    }

    /// Colour of an output's pixel; `None` where it shows nothing.
    pub fn pixel(&self, output: usize, pixel: DVec2) -> Option<Color> {
        let map = &self.maps[output];
        let color = self.color(output, map.hit(pixel)?)?;
        let even = self.evenness[output].as_ref().map_or(1.0, |evenness| evenness.weight(map, pixel));
        let weight = even * self.weights.weight(output, pixel)?;
        let blend = &self.rig.outputs[output].blend;
        let dimmed = |channel: usize| code_of(weight * light_of(color[channel], blend, channel), blend, channel);
        Some(if weight == 1.0 { color } else { [0, 1, 2].map(dimmed) })
    }

    /// True if rounding decides whether a pixel shows something.
    pub fn is_rim(&self, output: usize, pixel: DVec2) -> bool {
        let shows = |x: f64, y: f64| {
            let hit = self.maps[output].hit(pixel + RIM * DVec2::new(x, y));
            hit.is_some_and(|point| self.color(output, point).is_some())
        };
        let found = [shows(1.0, 0.0), shows(-1.0, 0.0), shows(0.0, 1.0), shows(0.0, -1.0)];
        found.contains(&true) && found.contains(&false)
    }
}

impl Evenness {
    /// Weight of a pixel, linear light; 1 where its area is not known.
    fn weight(&self, map: &WarpMap, pixel: DVec2) -> f64 {
        map.area(pixel).map_or(1.0, |area| (area / self.full).min(1.0).powf(self.strength))
    }
}

/// Area that nine tenths of a map's pixels do not exceed.
fn large_area(map: &WarpMap) -> f64 {
    let size = DVec2::new(f64::from(map.size().0), f64::from(map.size().1));
    let part = |index: u32| (f64::from(index) + 0.5) / f64::from(AREA_GRID);
    let places = (0..AREA_GRID * AREA_GRID).map(|i| DVec2::new(part(i % AREA_GRID), part(i / AREA_GRID)) * size);
    let mut areas: Vec<f64> = places.filter_map(|place| map.area(place)).collect();
    areas.sort_by(f64::total_cmp);
    areas.get((areas.len() as f64 * DIMMED) as usize).copied().unwrap_or_default()
}

/// Reads a picture.
pub fn read(file: &Path) -> Result<Picture, Failure> {
    let unreadable = |error: String| Failure::usage(format!("{} cannot be read: {error}", file.display()));
    let reader = image::ImageReader::open(file).map_err(|error| unreadable(error.to_string()))?;
    let image = reader.decode().map_err(|error| unreadable(error.to_string()))?.into_rgb32f();
    Ok(Picture { width: image.width(), height: image.height(), rgb: image.into_raw() })
}
