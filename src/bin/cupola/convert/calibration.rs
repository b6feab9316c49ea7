//! Reading of calibration files.

use super::options::Values;
use crate::failure::Failure;
use cupola::blend::{decode, encode};
use cupola::formats::{
    Camera, Grid, Levels, Noted, Sample, bourke, domeprojection, easyblend, mpcdi, pictures::pfm, read_file, vwf,
};
use cupola::geom::{Lens, Optics, Pose};
use cupola::rig::Dome;
use glam::{DVec2, DVec3};
use std::path::Path;

/// Exponent of the display's response where the file does not contain it.
const USUAL_GAMMA: f64 = 2.2;
/// Greatest difference of black levels that counts as equal: half a step of 8 bits.
const EVEN: f32 = 0.5 / 255.0;

/// One output in a calibration file.
pub struct Map {
    /// Name; may be empty if the file has only one output.
    pub name: String,
    /// Resolution, if the file contains it.
    pub size: Option<(u32, u32)>,
    /// The map; `None` if the file describes only the projector.
    pub grid: Option<Grid>,
    /// Meaning of the values of the map.
    pub values: Values,
    /// Weights, in addition to those of the grid.
    pub alpha: Option<mpcdi::Alpha>,
    /// Light added to black, as a fraction of white.
    pub black_level: f64,
    /// Displayed values that black is raised to, if they are not the same everywhere.
    pub black: Option<Levels>,
    /// Camera of the picture in which the values of the grid lie. The values are converted to
    /// directions.
    camera: Option<Camera>,
    /// The projector, if the file describes it.
    pub lamp: Option<Optics>,
    /// The dome, if the file says it.
    pub dome: Option<Dome>,
}

impl Map {
    fn new(name: String, size: Option<(u32, u32)>, grid: Option<Grid>, values: Values) -> Self {
        let (alpha, black_level, black, camera, lamp, dome) = (None, 0.0, None, None, None, None);
        Self { name, size, grid, values, alpha, black_level, black, camera, lamp, dome }
    }

    /// Sets the displayed values of black. Values that are the same everywhere are converted to
    /// light.
    fn with_black(mut self, levels: Option<Levels>) -> Self {
        let Some(levels) = levels else { return self };
        let (low, high) = levels.range();
        if high - low <= EVEN && high < 1.0 {
            self.black_level = decode(f64::from(0.5 * (low + high)), self.gamma());
        } else {
            self.black = Some(levels);
        }
        self
    }

    /// Exponent of the display's response. Weights with the exponent 1 are fractions of light and
    /// say nothing about the display.
    pub fn gamma(&self) -> f64 {
        self.alpha.as_ref().map_or(USUAL_GAMMA, |alpha| if alpha.gamma == 1.0 { USUAL_GAMMA } else { alpha.gamma })
    }

    /// Value at a pixel of an output of `size` pixels, and the factor on the displayed value.
    pub fn sample(&self, pixel: DVec2, size: (u32, u32)) -> Option<Sample> {
        let mut sample = self.grid.as_ref()?.sample(pixel, size)?;
        if let Some(alpha) = &self.alpha {
            let weight = weight(alpha, pixel / DVec2::new(f64::from(size.0), f64::from(size.1)));
            sample.intensity *= if alpha.gamma == 1.0 { encode(weight, USUAL_GAMMA) } else { weight };
        }
        if let Some(camera) = &self.camera {
            sample.value = camera.ray(sample.value.truncate()).normalize();
        }
        Some(sample)
    }
}

/// Weight of the pixel at a position (0…1 from the top left).
fn weight(alpha: &mpcdi::Alpha, part: DVec2) -> f64 {
    let cell = |part: f64, count: u32| ((part * f64::from(count)) as usize).min(count.saturating_sub(1) as usize);
    let index = cell(part.y, alpha.size.1) * alpha.size.0 as usize + cell(part.x, alpha.size.0);
    alpha.weights.get(index).map_or(1.0, |weight| f64::from(*weight))
}

/// Reads a calibration file. Returns `None` if the extension is not that of a calibration file.
/// `values` is the meaning of the values of maps whose file does not define it.
pub fn open(name: &str, ending: &str, values: Values) -> Result<Option<Noted<Vec<Map>>>, Failure> {
    let read = || read_file(Path::new(name));
    let single = |grid: Grid, size| vec![Map::new(String::new(), size, Some(grid), values)];
    let (value, notes) = match ending {
        "data" | "map" => {
            let mesh = bourke::read(name, &read()?)?;
            (single(Grid::Mesh(mesh.value.mesh(name)?), None), mesh.notes)
        }
        "pfm" => {
            let raster = pfm::read(name, &read()?)?;
            let size = Some(raster.size());
            (single(Grid::Raster(raster), size), Vec::new())
        }
        "csv" => {
            let mesh = domeprojection::read(name, &read()?)?;
            (single(mesh.value, None), mesh.notes)
        }
        "ol" => {
            let mesh = easyblend::read(name, &read()?)?;
            let (mut maps, mut notes) = (single(mesh.value.grid, Some(mesh.value.size)), mesh.notes);
            if let Some(camera) = mesh.value.camera {
                (maps[0].values, maps[0].camera) = (Values::Directions, Some(camera));
                if camera.offset != DVec3::ZERO {
                    let offset = camera.offset;
                    notes.push(format!(
                        "{name}: the eye point is at {offset}, not at the origin; set the viewer's position to it"
                    ));
                }
            }
            (maps, notes)
        }
        "vwf" => {
            let set = vwf::read(name, &read()?)?;
            let mut notes = set.notes;
            if set.value.iter().any(|map| map.blend.is_some() || map.black.is_some() || map.white.is_some()) {
                notes.push(format!("{name}: the pictures are assumed to be for displays with gamma {USUAL_GAMMA}"));
            }
            (set.value.into_iter().map(vioso).collect(), notes)
        }
        "mpcdi" | "xml" => {
            let archive = mpcdi::read(name, &read()?)?;
            let (mpcdi::Archive { profile, regions, dome }, notes) = (archive.value, archive.notes);
            let dome = dome.map(|mpcdi::Dome { radius, tilt, coverage }| Dome { radius, tilt, coverage });
            (regions.into_iter().map(|of| Map { dome, ..region(of, profile) }).collect(), notes)
        }
        _ => return Ok(None),
    };
    Ok(Some(Noted { value, notes }))
}

/// A channel of a VIOSO file.
fn vioso(map: vwf::VwfMap) -> Map {
    let values = if map.points { Values::Points } else { Values::Picture };
    let size = Some(map.raster.size());
    let mut opened = Map::new(map.name, size, Some(Grid::Raster(map.raster)), values);
    let alpha =
        |picture: vwf::Picture| mpcdi::Alpha { size: picture.size, weights: picture.values, gamma: USUAL_GAMMA };
    opened.alpha = match (map.blend.map(alpha), map.white.map(alpha)) {
        (Some(blend), Some(white)) => Some(product(blend, &white)),
        (blend, white) => blend.or(white),
    };
    opened.with_black(map.black)
}

/// Product of two weights, at the pixels of the first.
fn product(mut first: mpcdi::Alpha, second: &mpcdi::Alpha) -> mpcdi::Alpha {
    let (width, height) = first.size;
    for (index, value) in (0..width * height).zip(&mut first.weights) {
        let pixel = DVec2::new(f64::from(index % width) + 0.5, f64::from(index / width) + 0.5);
        *value *= weight(second, pixel / DVec2::new(f64::from(width), f64::from(height))) as f32;
    }
    first
}

/// A region of an MPCDI archive.
fn region(region: mpcdi::Region, profile: mpcdi::Profile) -> Map {
    let values = match profile {
        mpcdi::Profile::Flat => Values::Picture,
        mpcdi::Profile::Perspective => Values::Directions,
        mpcdi::Profile::Screen | mpcdi::Profile::ShaderLamps => Values::Points,
    };
    let mut opened = Map::new(region.id, Some(region.size), region.warp.map(Grid::Raster), values);
    opened.alpha = region.alpha;
    match profile {
        mpcdi::Profile::Perspective => opened.camera = region.camera,
        mpcdi::Profile::ShaderLamps => {
            let pinhole = |camera: Camera| {
                let pose = Pose { position: camera.offset, rotation: camera.rotation };
                Optics { pose, lens: Lens::pinhole(camera.frustum), mirror: None }
            };
            opened.lamp = region.fisheye.or(region.camera.map(pinhole));
        }
        mpcdi::Profile::Flat | mpcdi::Profile::Screen => {}
    }
    opened.with_black(region.beta)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn even_black_levels_are_light_and_others_a_picture() {
        let of = |values: &[[f32; 3]]| {
            let levels = Levels { size: (values.len() as u32, 1), values: values.to_vec() };
            Map::new("a".to_owned(), None, None, Values::Picture).with_black(Some(levels))
        };
        let even = of(&[[0.1; 3], [0.1005; 3], [0.101; 3]]);
        assert!((even.black_level - 0.1005f64.powf(2.2)).abs() < 1e-6 && even.black.is_none());
        for uneven in [&[[0.0; 3], [0.1; 3]][..], &[[0.1, 0.1, 0.2]], &[[1.0; 3]]] {
            let found = of(uneven);
            assert_eq!((found.black_level, found.black.expect("a picture").values), (0.0, uneven.to_vec()));
        }
    }

    #[test]
    fn weights_that_are_light_become_factors_on_displayed_values() {
        let raster = cupola::formats::Raster::new((1, 1), vec![[0.5; 3]]);
        let mut map = Map::new("a".to_owned(), None, raster.map(Grid::Raster), Values::Picture);
        let factor = |map: &Map| map.sample(DVec2::splat(0.5), (1, 1)).map(|sample| sample.intensity);
        for (gamma, expected) in [(1.0, 0.25f64.powf(1.0 / 2.2)), (2.4, 0.25)] {
            map.alpha = Some(mpcdi::Alpha { size: (1, 1), weights: vec![0.25], gamma });
            assert!(factor(&map).is_some_and(|found| (found - expected).abs() < 1e-12), "{gamma}");
        }
        let half = mpcdi::Alpha { size: (2, 1), weights: vec![0.5, 0.25], gamma: 2.2 };
        assert_eq!(product(half.clone(), &half).weights, [0.25, 0.0625]);
    }
}
