//! Writing of outputs in the formats of other programs.

use super::options::{ArchiveProfile, ArchiveVersion, Arguments, Format, Values, ending};
use super::source::Channel;
use super::written::{Written, file_beside, raster, save};
use super::{refuse_to_replace_any, rig};
use crate::failure::Failure;
use cupola::formats::{Camera, Grid, Raster, bourke, mpcdi, pictures::pfm, vwf};
use cupola::geom::{Frustum, Lens, Optics, Projection, pose};
use cupola::rig::Dome;
use cupola::warp::{MapError, compare};
use glam::{DMat3, DVec2, DVec3};
use std::path::Path;

/// Greatest angle between a side of a camera's picture and its axis, degrees.
const WIDEST_CAMERA: f64 = 85.0;

/// Writes the channels as `format`.
pub fn write(arguments: &Arguments, format: Format, channels: &[Channel]) -> Result<Vec<Written>, Failure> {
    let path = &arguments.to;
    let Some(values) = channels.first().map(|channel| channel.values) else { return Ok(Vec::new()) };
    let together = |bytes: Vec<u8>| {
        save(path, &bytes)?;
        Ok(vec![Written { path: path.clone(), outputs: channels.len(), values: Some(values), error: None }])
    };
    if let Some(channel) = channels.iter().find(|channel| format != Format::Rig && !channel.has_map()) {
        return Err(Failure::usage(format!(
            "the file describes only the projector of {:?} and contains no map; write a rig (.toml), add its screen, and convert that rig",
            channel.name
        )));
    }
    match format {
        Format::Rig => {
            rig::refuse_to_replace_parts(path, channels, arguments.force)?;
            rig::from_channels(path, &arguments.from, channels, arguments.projectors)
        }
        Format::Bourke if values != Values::Picture => Err(Failure::usage(format!(
            "a warp mesh contains positions in a picture, not {}; use --values picture",
            values.words()
        ))),
        Format::Vwf if values == Values::Directions => Err(Failure::usage(
            "this format contains positions in a picture or points, not directions; write a .pfm or .mpcdi file",
        )),
        Format::Bourke => each(path, channels, arguments.force, |channel| mesh(channel, arguments.nodes)),
        Format::Pfm => each(path, channels, arguments.force, |channel| {
            Ok((pfm::write(channel.size.0, raster(channel)?.0.values()), None))
        }),
        Format::Vwf => {
            let maps: Vec<_> =
                channels.iter().map(|channel| vwf_map(channel, values)).collect::<Result<_, Failure>>()?;
            together(vwf::write(&maps)?)
        }
        Format::Mpcdi => {
            let version = match arguments.archive_version {
                ArchiveVersion::One => mpcdi::Version::One,
                ArchiveVersion::Two => mpcdi::Version::Two,
            };
            let profile = match (values, arguments.profile) {
                (Values::Picture, _) => mpcdi::Profile::Flat,
                (Values::Directions, _) => mpcdi::Profile::Perspective,
                (Values::Points, Some(ArchiveProfile::ShaderLamps)) => mpcdi::Profile::ShaderLamps,
                (Values::Points, _) => mpcdi::Profile::Screen,
            };
            let regions = channels.iter().map(|channel| region(channel, profile)).collect::<Result<_, Failure>>()?;
            let dome = channels.iter().find_map(|channel| channel.dome);
            let dome = dome.map(|Dome { radius, tilt, coverage }| mpcdi::Dome { radius, tilt, coverage });
            together(mpcdi::write(&mpcdi::Archive { profile, regions, dome }, version)?)
        }
    }
}

/// A channel as a map of a VWF file.
fn vwf_map(channel: &Channel, values: Values) -> Result<vwf::VwfMap, Failure> {
    let (raster, weights) = raster(channel)?;
    let size = raster.size();
    // Pixels that show nothing have no weight.
    let weighed = raster.values().iter().zip(&weights).any(|(value, weight)| !value[0].is_nan() && *weight < 1.0);
    Ok(vwf::VwfMap {
        name: channel.name.clone(),
        points: values == Values::Points,
        black: channel.levels().map(|levels| levels.resized(size)),
        blend: weighed.then_some(vwf::Picture { size, values: weights }),
        white: None,
        raster,
    })
}

/// A channel as a region of an MPCDI archive.
fn region(channel: &Channel, profile: mpcdi::Profile) -> Result<mpcdi::Region, Failure> {
    let (mut warp, weights) = raster(channel)?;
    let (camera, fisheye) = match profile {
        mpcdi::Profile::Perspective => (Some(looking_at(&channel.name, &warp)?), None),
        mpcdi::Profile::ShaderLamps => projector(channel)?,
        mpcdi::Profile::Flat | mpcdi::Profile::Screen => (None, None),
    };
    if let (mpcdi::Profile::Perspective, Some(camera)) = (profile, &camera) {
        let place = |value: &[f32; 3]| match camera.place(DVec3::from_array(value.map(f64::from))) {
            Some(place) => [place.x as f32, place.y as f32, 0.0],
            None => [f32::NAN; 3],
        };
        let values = warp.values().iter().map(place).collect();
        warp = Raster::new(channel.size, values).ok_or_else(|| Failure::new("an output has no pixels"))?;
    }
    Ok(mpcdi::Region {
        id: channel.name.clone(),
        size: channel.size,
        warp: Some(warp),
        alpha: Some(mpcdi::Alpha { size: channel.size, weights, gamma: channel.gamma }),
        beta: channel.levels(),
        camera,
        fisheye,
    })
}

/// The projector of a channel for profile sl: a pinhole, or a fisheye with a polynomial.
fn projector(channel: &Channel) -> Result<(Option<Camera>, Option<Optics>), Failure> {
    match &channel.lamp {
        Some(Optics { pose, lens: Lens::Pinhole { frustum, distortion, keystone }, .. })
            if distortion.is_none() && *keystone == DMat3::IDENTITY =>
        {
            let camera = Camera { offset: pose.position, rotation: pose.rotation, frustum: *frustum };
            Ok((Some(camera), None))
        }
        Some(optics @ Optics { lens: Lens::Fisheye { lens, .. }, .. })
            if matches!(lens.projection, Projection::Equidistant | Projection::Polynomial(_)) =>
        {
            Ok((None, Some(optics.clone())))
        }
        _ => Err(Failure::usage(format!(
            "profile sl needs a pinhole projector or one with an equidistant or polynomial fisheye; output {:?} is not, or it is mirrored",
            channel.name
        ))),
    }
}

/// A camera whose picture contains all directions, upright and centred on their mean.
fn looking_at(name: &str, directions: &Raster) -> Result<Camera, Failure> {
    let shown =
        || directions.values().iter().map(|value| DVec3::from_array(value.map(f64::from))).filter(|v| v.is_finite());
    let mean: DVec3 = shown().sum();
    let rotation = pose::rotation(mean.x.atan2(-mean.z), mean.y.atan2(mean.x.hypot(mean.z)), 0.0);
    let plain = Frustum { left: 0.0, right: 1.0, bottom: 0.0, top: 1.0 };
    let camera = Camera { offset: DVec3::ZERO, rotation, frustum: plain };
    let (mut low, mut high) = (DVec2::INFINITY, DVec2::NEG_INFINITY);
    for direction in shown() {
        // Directions behind the camera are infinitely far out and refused below.
        let place = camera.place(direction).unwrap_or(DVec2::INFINITY);
        (low, high) = (low.min(place), high.max(place));
    }
    let widest = WIDEST_CAMERA.to_radians().tan();
    if !(low.cmpge(DVec2::splat(-widest)).all() && high.cmple(DVec2::splat(widest)).all() && low.cmplt(high).all()) {
        return Err(Failure::usage(format!(
            "output {name:?} shows nothing or too wide an angle for one perspective picture; write profile 2d or a3"
        )));
    }
    let frustum = Frustum { left: low.x, right: high.x, bottom: low.y, top: high.y };
    Ok(Camera { frustum, ..camera })
}

/// Writes a file for each channel: to `path` if there is one channel, otherwise to PATH-NAME.
fn each(
    path: &Path,
    channels: &[Channel],
    force: bool,
    write: impl Fn(&Channel) -> Result<(Vec<u8>, Option<MapError>), Failure>,
) -> Result<Vec<Written>, Failure> {
    let file = |index: usize| match channels {
        [_] => path.to_owned(),
        _ => file_beside(path, index, &channels[index].name, &ending(path)),
    };
    refuse_to_replace_any((0..channels.len()).map(file), force)?;
    let mut written = Vec::new();
    for (index, channel) in channels.iter().enumerate() {
        let path = file(index);
        let (bytes, error) = write(channel)?;
        save(&path, &bytes)?;
        written.push(Written { path, outputs: 1, values: Some(channel.values), error });
    }
    Ok(written)
}

/// A warp mesh with this number of columns and rows, and its error between the nodes.
fn mesh(channel: &Channel, (columns, rows): (u32, u32)) -> Result<(Vec<u8>, Option<MapError>), Failure> {
    if columns < 2 || rows < 2 {
        return Err(Failure::usage("a warp mesh needs at least 2x2 nodes"));
    }
    let (width, height) = (f64::from(channel.size.0), f64::from(channel.size.1));
    let mut nodes = Vec::new();
    for row in 0..rows {
        for column in 0..columns {
            let part = DVec2::new(f64::from(column) / f64::from(columns - 1), f64::from(row) / f64::from(rows - 1));
            let (x, y) = ((2.0 * part.x - 1.0) * width / height, 2.0 * part.y - 1.0);
            nodes.push(match channel.sample(DVec2::new(part.x * width, (1.0 - part.y) * height)) {
                Some(sample) => [x, y, sample.value.x, sample.value.y, sample.intensity],
                None => [x, y, 0.0, 0.0, -1.0],
            });
        }
    }
    let arrangement = bourke::Arrangement::Rectangular;
    let (columns, rows) = (columns as usize, rows as usize);
    let text = bourke::write(&bourke::WarpMesh { arrangement, columns, rows, nodes });
    // The error includes the rounding of numbers in the text.
    let grid = Grid::Mesh(bourke::read("the mesh", text.as_bytes())?.value.mesh("the mesh")?);
    let error = channel.exact().map(|(exact, direction)| {
        let seen = |x: u32, y: u32| {
            let pixel = DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5);
            grid.sample(pixel, channel.size).and_then(|sample| direction(sample.value))
        };
        compare(exact, 1 + channel.size.0 / 1024, seen)
    });
    Ok((text.into_bytes(), error))
}
