//! Sources of a conversion: the outputs of a rig or of a calibration file.

use super::calibration::{self, Map};
use super::options::{Arguments, Values, ending};
use crate::failure::Failure;
use crate::map::native_size;
use cupola::blend::{GREEN, Weights, code_of, encode};
use cupola::formats::{Levels, Noted, Sample, mpcdi, read_file, sgct};
use cupola::geom::{Lens, Optics, Pose};
use cupola::rig::{BlackValues, Dome, Flip, Output, OutputKind, Rig};
use cupola::warp::WarpMap;
use glam::{DVec2, DVec3};
use std::path::Path;

/// An opened source.
pub enum Source {
    /// A rig, and the map of a domemaster of its dome.
    Rig(Box<(Rig, WarpMap)>),
    /// An SGCT configuration.
    Sgct { config: sgct::Config, notes: Vec<String> },
    /// The maps of a calibration file.
    Maps { maps: Vec<Map>, notes: Vec<String> },
}

/// One output that is converted.
pub struct Channel<'source> {
    /// Name; may be empty if the file has only one output.
    pub name: String,
    /// Resolution in pixels.
    pub size: (u32, u32),
    /// Meaning of the values.
    pub values: Values,
    /// Exponent of the display's response, which converts factors on displayed values to fractions
    /// of light.
    pub gamma: f64,
    /// Light added to black, as a fraction of white.
    pub black_level: f64,
    /// Displayed values that black is raised to, one for each pixel of the output, if they are not
    /// the same everywhere.
    pub black: Option<Levels>,
    /// The projector in dome axes, if there is one without a mirror.
    pub lamp: Option<Optics>,
    /// The dome, if the source says it: a rig, or an archive that Cupola wrote.
    pub dome: Option<Dome>,
    kind: Kind<'source>,
}

enum Kind<'source> {
    Output { index: usize, map: Box<WarpMap>, rig: &'source Rig, content: &'source WarpMap, weights: Weights<'source> },
    Map(&'source Map),
}

/// Opens the source of a conversion. Calibration files are recognised by their extension.
pub fn open(arguments: &Arguments) -> Result<Source, Failure> {
    let name = arguments.from.as_str();
    let ending = ending(Path::new(name));
    if ending == "json" {
        let read = sgct::read(name, &read_file(Path::new(name))?)?;
        return Ok(Source::Sgct { config: read.value, notes: read.notes });
    }
    if let Some(Noted { value: maps, notes }) = calibration::open(name, &ending, arguments.values())? {
        return Ok(Source::Maps { maps, notes });
    }
    let rig = cupola::rig::load(name)?.with_all_outputs().into_owned();
    if rig.outputs.is_empty() {
        return Err(Failure::usage(format!("the rig {} has no outputs", rig.name)));
    }
    let content = domemaster(&rig)?;
    Ok(Source::Rig(Box::new((rig, content))))
}

/// The map of a domemaster of the rig's dome. Its size is 1 × 1, so that pixel positions are
/// fractions of the picture.
fn domemaster(rig: &Rig) -> Result<WarpMap, Failure> {
    let mut rig = rig.clone();
    rig.outputs.truncate(1);
    rig.outputs[0].kind = OutputKind::Domemaster { aperture: rig.dome.coverage, tilt: rig.dome.tilt };
    rig.outputs[0].flip = Flip::default();
    Ok(WarpMap::new(&rig, 0, (1, 1), None)?)
}

impl Source {
    /// Assumptions about the file, for the user.
    pub fn notes(&self) -> &[String] {
        match self {
            Self::Rig(_) => &[],
            Self::Sgct { notes, .. } | Self::Maps { notes, .. } => notes,
        }
    }

    /// The outputs to convert.
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
                        black: black(output, size),
                        lamp: lamp(output),
                        dome: Some(rig.dome),
                        kind,
                    });
                }
            }
            Self::Sgct { .. } => {}
            Self::Maps { maps, .. } => {
                for map in maps.iter().filter(|map| wanted(&map.name)) {
                    let size = arguments.size.or(map.size).ok_or_else(|| {
                        Failure::usage("the file does not contain the size of the output; give it with --size WxH")
                    })?;
                    let kind = Kind::Map(map);
                    channels.push(Channel {
                        name: map.name.clone(),
                        size,
                        values: map.values,
                        gamma: map.gamma(),
                        black_level: map.black_level,
                        black: map.black.as_ref().map(|black| black.resized(size)),
                        lamp: map.lamp.clone(),
                        dome: map.dome,
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

/// Displayed values that the black of an output is raised to, mirrored like the output.
fn black(output: &Output, size: (u32, u32)) -> Option<Levels> {
    let black = output.black.as_deref()?;
    let mut levels = black.levels.resized(size);
    if black.values == BlackValues::Light {
        for value in &mut levels.values {
            *value = [0, 1, 2].map(|channel| code_of(f64::from(value[channel]), &output.blend, channel) as f32);
        }
    }
    levels.values = output.flip.items(&levels.values, size.0 as usize);
    Some(levels)
}

/// The projector of an output; `None` if it has a mirror or a mirrored picture, or if there is
/// none.
fn lamp(output: &Output) -> Option<Optics> {
    match &output.kind {
        _ if !output.flip.is_none() => None,
        OutputKind::Projector { position, angles: [yaw, pitch, roll], frustum } => {
            let pose = Pose::new(*position, *yaw, *pitch, *roll);
            Some(Optics { pose, lens: Lens::pinhole(*frustum), mirror: None })
        }
        OutputKind::Optics { optics, .. } if optics.mirror.is_none() => Some((**optics).clone()),
        _ => None,
    }
}

/// `sizes` with the size at `index` replaced.
fn with(mut sizes: Vec<(u32, u32)>, index: usize, size: (u32, u32)) -> Vec<(u32, u32)> {
    sizes[index] = size;
    sizes
}

impl Channel<'_> {
    /// Value at a pixel (from the top left, centres at +½), and the factor on the displayed value.
    pub fn sample(&self, pixel: DVec2) -> Option<Sample> {
        match &self.kind {
            Kind::Map(map) => map.sample(pixel, self.size),
            Kind::Output { index, map, rig, content, weights } => {
                let value = value(rig, content, map, self.values, pixel)?;
                let intensity = code_of(weights.weight(*index, pixel)?, &rig.outputs[*index].blend, GREEN);
                Some(Sample { value, intensity })
            }
        }
    }

    /// Displayed values that black is raised to: a picture, or 1 × 1 for a single level; `None` if
    /// black is not raised.
    pub fn levels(&self) -> Option<Levels> {
        let level = encode(self.black_level, self.gamma) as f32;
        self.black.clone().or_else(|| (level > 0.0).then(|| Levels::even((1, 1), level)))
    }

    /// True if there is a map, not only a projector.
    pub fn has_map(&self) -> bool {
        !matches!(&self.kind, Kind::Map(map) if map.grid.is_none())
    }

    /// The projector that a calibration file describes, and its weights.
    pub fn described_projector(&self) -> Option<(&Optics, Option<&mpcdi::Alpha>)> {
        let Kind::Map(map) = &self.kind else { return None };
        Some((map.lamp.as_ref()?, map.alpha.as_ref()))
    }

    /// The exact map, and the function from a value to the direction that the viewer sees; `None`
    /// without a rig.
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

/// The value of a pixel. If the pixel has no point on the dome, the point is where the viewer's ray
/// meets the screen.
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
