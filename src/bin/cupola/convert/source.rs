//! What is converted: the outputs of a rig, or what a calibration file says.

use super::Arguments;
use crate::Failure;
use crate::map::native_size;
use cupola::blend::{GREEN, Weights, code_of};
use cupola::formats::{Camera, Grid, Sample, bourke, domeprojection, easyblend, mpcdi, pfm, read_file, sgct, vwf};
use cupola::geom::pose;
use cupola::rig::{Dome, OutputKind, Rig};
use cupola::warp::WarpMap;
use glam::{DVec2, DVec3};
use std::path::Path;

/// What the values of a map are.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum Values {
    /// Positions in a domemaster of the rig's dome, 0…1 from the bottom left
    Picture,
    /// Points on the dome, metres from its centre: x right, y up, z backward
    Points,
    /// Directions from the viewer: x right, y up, z backward
    Directions,
}

impl Values {
    /// In words, for people and machines.
    pub fn words(self) -> &'static str {
        match self {
            Self::Picture => "picture",
            Self::Points => "points",
            Self::Directions => "directions",
        }
    }
}

/// What was opened.
pub enum Source {
    /// A rig, and what a domemaster of its dome shows.
    Rig(Box<(Rig, WarpMap)>),
    /// A configuration of SGCT.
    Sgct { config: sgct::Config, notes: Vec<String> },
    /// The maps of a calibration file.
    Maps { maps: Vec<Map>, notes: Vec<String> },
}

/// A map of a calibration file.
pub struct Map {
    name: String,
    size: Option<(u32, u32)>,
    grid: Grid,
    values: Values,
    alpha: Option<mpcdi::Alpha>,
    /// The camera whose picture the grid's values lie in; they become directions.
    camera: Option<Camera>,
}

/// One output that is converted.
pub struct Channel<'source> {
    /// Its name; may be empty where a file has only one.
    pub name: String,
    /// Its resolution in pixels.
    pub size: (u32, u32),
    /// What the values are.
    pub values: Values,
    /// Exponent of the display's response, which turns factors on displayed values into parts of light.
    pub gamma: f64,
    /// Light added to black, as a part of white.
    pub black_level: f64,
    /// The projector, if it is a pinhole, in dome axes.
    pub lamp: Option<Camera>,
    /// The dome, if a rig tells it.
    pub dome: Option<Dome>,
    kind: Kind<'source>,
}

enum Kind<'source> {
    Output { index: usize, map: Box<WarpMap>, rig: &'source Rig, content: &'source WarpMap, weights: Weights<'source> },
    Map(&'source Map),
}

/// Opens what is to be converted; a calibration file is known by how it begins or by its name's ending.
pub fn open(arguments: &Arguments) -> Result<Source, Failure> {
    let ending = ending(Path::new(&arguments.from));
    let name = arguments.from.as_str();
    let single = |grid: Grid, size| {
        vec![Map { name: String::new(), size, grid, values: arguments.values(), alpha: None, camera: None }]
    };
    let read = || read_file(Path::new(name));
    Ok(match ending.as_str() {
        "data" | "map" => {
            let mesh = bourke::read(name, &read()?)?;
            Source::Maps { maps: single(Grid::Mesh(mesh.value.mesh(name)?), None), notes: mesh.notes }
        }
        "pfm" => {
            let raster = pfm::read(name, &read()?)?;
            Source::Maps { maps: single(Grid::Raster(raster.clone()), Some(raster.size())), notes: Vec::new() }
        }
        "csv" => {
            let mesh = domeprojection::read(name, &read()?)?;
            Source::Maps { maps: single(mesh.value, None), notes: mesh.notes }
        }
        "json" => {
            let read = sgct::read(name, &read()?)?;
            Source::Sgct { config: read.value, notes: read.notes }
        }
        "ol" => {
            let mesh = easyblend::read(name, &read()?)?;
            let mut maps = single(mesh.value.grid, Some(mesh.value.size));
            let mut notes = mesh.notes;
            if let Some(camera) = mesh.value.camera {
                (maps[0].values, maps[0].camera) = (Values::Directions, Some(camera));
                if camera.offset != DVec3::ZERO {
                    notes.push(format!(
                        "{name}: the eye point is off the origin by {}; put the viewer there",
                        camera.offset
                    ));
                }
            }
            Source::Maps { maps, notes }
        }
        "vwf" => {
            let set = vwf::read(name, &read()?)?;
            let map = |map: vwf::VwfMap| Map {
                name: map.name,
                size: Some(map.raster.size()),
                grid: Grid::Raster(map.raster),
                values: if map.points { Values::Points } else { Values::Picture },
                alpha: None,
                camera: None,
            };
            Source::Maps { maps: set.value.into_iter().map(map).collect(), notes: set.notes }
        }
        "mpcdi" => {
            let archive = mpcdi::read(name, &read()?)?;
            let profile = archive.value.profile;
            let values = match profile {
                mpcdi::Profile::Flat => Values::Picture,
                mpcdi::Profile::Perspective => Values::Directions,
                mpcdi::Profile::Screen | mpcdi::Profile::ShaderLamps => Values::Points,
            };
            let mut notes = archive.notes;
            if archive.value.regions.iter().any(|region| region.beta.is_some()) {
                notes.push(format!("{name}: black levels (betaMap) are not taken over; say them in the rig"));
            }
            let map = |region: mpcdi::Region| Map {
                name: region.id,
                size: Some(region.size),
                grid: Grid::Raster(region.warp),
                values,
                alpha: region.alpha,
                camera: region.camera.filter(|_| profile == mpcdi::Profile::Perspective),
            };
            Source::Maps { maps: archive.value.regions.into_iter().map(map).collect(), notes }
        }
        _ => {
            let rig = cupola::rig::load(name)?;
            if rig.outputs.is_empty() {
                return Err(Failure::usage(format!("the rig {} has no outputs", rig.name)));
            }
            let content = domemaster(&rig)?;
            Source::Rig(Box::new((rig, content)))
        }
    })
}

/// The ending of a file's name, in lower case.
pub fn ending(path: &Path) -> String {
    path.extension().unwrap_or_default().to_string_lossy().to_lowercase()
}

/// A domemaster of the rig's dome, 1 × 1 so that its pixel positions are parts of the picture.
fn domemaster(rig: &Rig) -> Result<WarpMap, Failure> {
    let mut rig = rig.clone();
    rig.outputs.truncate(1);
    rig.outputs[0].kind = OutputKind::Domemaster { aperture: rig.dome.coverage, tilt: rig.dome.tilt };
    Ok(WarpMap::new(&rig, 0, (1, 1), None)?)
}

impl Arguments {
    /// What the values of maps are to be: the profile of an archive decides it too.
    fn values(&self) -> Values {
        self.profile.map_or(self.values, super::target::ArchiveProfile::values)
    }
}

impl Source {
    /// What was assumed about the file.
    pub fn notes(&self) -> &[String] {
        match self {
            Self::Rig(_) => &[],
            Self::Sgct { notes, .. } | Self::Maps { notes, .. } => notes,
        }
    }

    /// The outputs that are converted, of the wanted sizes.
    pub fn channels(&self, arguments: &Arguments) -> Result<Vec<Channel<'_>>, Failure> {
        let wanted = |name: &str| arguments.output.as_deref().is_none_or(|wanted| wanted == name);
        let mut channels = Vec::new();
        match self {
            Self::Rig(opened) => {
                let (rig, content) = &**opened;
                for index in (0..rig.outputs.len()).filter(|index| wanted(&rig.outputs[*index].name)) {
                    let size = arguments.size.unwrap_or_else(|| native_size(rig, index));
                    let map = Box::new(WarpMap::new(rig, index, size, None)?);
                    let sizes: Vec<_> = (0..rig.outputs.len()).map(|output| native_size(rig, output)).collect();
                    let weights = Weights::new(rig, &with(sizes, index, size))?;
                    let kind = Kind::Output { index, map, rig, content, weights };
                    let output = &rig.outputs[index];
                    channels.push(Channel {
                        name: output.name.clone(),
                        size,
                        values: arguments.values(),
                        gamma: output.blend.gamma,
                        black_level: output.blend.black_level,
                        lamp: lamp(&output.kind),
                        dome: Some(rig.dome),
                        kind,
                    });
                }
            }
            Self::Sgct { .. } => {}
            Self::Maps { maps, .. } => {
                for map in maps.iter().filter(|map| wanted(&map.name)) {
                    let size = arguments.size.or(map.size).ok_or_else(|| {
                        Failure::usage("the file does not say the output's size in pixels; give it with --size WxH")
                    })?;
                    let kind = Kind::Map(map);
                    let gamma = map.alpha.as_ref().map_or(1.0, |alpha| alpha.gamma);
                    let (name, values) = (map.name.clone(), map.values);
                    channels.push(Channel {
                        name,
                        size,
                        values,
                        gamma,
                        black_level: 0.0,
                        lamp: None,
                        dome: None,
                        kind,
                    });
                }
            }
        }
        match (channels.is_empty(), &arguments.output) {
            (true, Some(name)) => Err(Failure::usage(format!("{} has no output {name:?}", arguments.from))),
            _ => Ok(channels),
        }
    }
}

/// A pinhole projector as a camera.
fn lamp(kind: &OutputKind) -> Option<Camera> {
    let OutputKind::Projector { position, angles: [yaw, pitch, roll], frustum } = kind else { return None };
    Some(Camera { offset: *position, rotation: pose::rotation(*yaw, *pitch, *roll), frustum: *frustum })
}

/// `sizes` with the one of `index` replaced.
fn with(mut sizes: Vec<(u32, u32)>, index: usize, size: (u32, u32)) -> Vec<(u32, u32)> {
    sizes[index] = size;
    sizes
}

impl Channel<'_> {
    /// What is shown at a pixel (from the top left, centres at +½): the value, and the factor on the displayed value.
    pub fn sample(&self, pixel: DVec2) -> Option<Sample> {
        match &self.kind {
            Kind::Map(map) => {
                let mut sample = map.grid.sample(pixel, self.size)?;
                if let Some(alpha) = &map.alpha {
                    sample.intensity *=
                        weight(alpha, pixel / DVec2::new(f64::from(self.size.0), f64::from(self.size.1)));
                }
                if let Some(camera) = &map.camera {
                    sample.value = camera.ray(sample.value.truncate()).normalize();
                }
                Some(sample)
            }
            Kind::Output { index, map, rig, content, weights } => {
                let value = value(rig, content, map, self.values, pixel)?;
                let intensity = code_of(weights.weight(*index, pixel)?, &rig.outputs[*index].blend, GREEN);
                Some(Sample { value, intensity })
            }
        }
    }

    /// The exact map, and the direction that the viewer sees at a value, where a rig tells them.
    pub fn exact(&self) -> Option<(&WarpMap, impl Fn(DVec3) -> Option<DVec3>)> {
        let Kind::Output { map, rig, content, .. } = &self.kind else { return None };
        let values = self.values;
        let direction = move |value: DVec3| match values {
            Values::Picture => content.direction(DVec2::new(value.x, 1.0 - value.y)),
            Values::Points => rig.viewer_pose().point_to_local(value).try_normalize(),
            Values::Directions => value.try_normalize(),
        };
        Some((map, direction))
    }
}

/// The value of a pixel. A picture that has no place on the dome is put where the viewer sees it there.
fn value(rig: &Rig, content: &WarpMap, map: &WarpMap, values: Values, pixel: DVec2) -> Option<DVec3> {
    if values == Values::Directions {
        return map.direction(pixel);
    }
    let point = match map.hit(pixel) {
        Some(point) => point,
        None => {
            let viewer = rig.viewer_pose();
            map.screen().unbounded_hit(viewer.position, viewer.direction_to_parent(map.direction(pixel)?))?.point
        }
    };
    match values {
        Values::Points | Values::Directions => Some(point),
        Values::Picture => content.pixel(point).map(|part| DVec3::new(part.x, 1.0 - part.y, 0.0)),
    }
}

/// The weight of the pixel that holds a place (0…1 from the top left).
fn weight(alpha: &mpcdi::Alpha, part: DVec2) -> f64 {
    let cell = |part: f64, count: u32| ((part * f64::from(count)) as usize).min(count.saturating_sub(1) as usize);
    let index = cell(part.y, alpha.size.1) * alpha.size.0 as usize + cell(part.x, alpha.size.0);
    alpha.weights.get(index).map_or(1.0, |weight| f64::from(*weight))
}
