//! What is written.

use super::Arguments;
use super::source::{Channel, Values, ending};
use crate::{Failure, terminal};
use cupola::formats::{Grid, Raster, bourke, mpcdi, pfm, vwf};
use cupola::warp::{MapError, compare};
use glam::DVec2;
use serde_json::json;
use std::path::{Path, PathBuf};

/// The formats that can be written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    Bourke,
    Pfm,
    Vwf,
    Mpcdi,
}

impl Format {
    /// The format of a file by its name's ending.
    pub fn of(path: &Path) -> Result<Self, Failure> {
        match ending(path).as_str() {
            "data" | "map" => Ok(Self::Bourke),
            "pfm" => Ok(Self::Pfm),
            "vwf" => Ok(Self::Vwf),
            "mpcdi" => Ok(Self::Mpcdi),
            other => Err(Failure::usage(format!(
                "{}: nothing is known to write as {other:?}; expected a name that ends in .data, .map, .pfm, .vwf or .mpcdi",
                path.display()
            ))),
        }
    }
}

/// A file that was written.
pub struct Written {
    path: PathBuf,
    outputs: usize,
    values: Values,
    /// The error of interpolation against the exact map, where there is one.
    error: Option<MapError>,
}

impl Written {
    /// For machines.
    pub fn json(&self) -> serde_json::Value {
        let error = self.error.map(
            |error| json!({ "max": error.max, "rms": error.rms, "uncovered": error.uncovered, "ghosts": error.ghosts }),
        );
        json!({
            "path": self.path.display().to_string(),
            "outputs": self.outputs,
            "values": self.values.words(),
            "error_pixels": error,
        })
    }

    /// For people.
    pub fn words(&self) -> String {
        let error = self.error.map_or(String::new(), |error| {
            format!(
                "; between its nodes it is at most {:.4} pixels off the exact map (root mean square {:.4}), and leaves out {} pixels",
                error.max, error.rms, error.uncovered
            )
        });
        format!("{}: outputs: {}, values: {}{error}", self.path.display(), self.outputs, self.values.words())
    }
}

/// Writes the channels as `format`.
pub fn write(arguments: &Arguments, format: Format, channels: &[Channel]) -> Result<Vec<Written>, Failure> {
    let path = &arguments.to;
    let Some(values) = channels.first().map(|channel| channel.values) else { return Ok(Vec::new()) };
    let together = |bytes: Vec<u8>| {
        save(path, &bytes)?;
        Ok(vec![Written { path: path.clone(), outputs: channels.len(), values, error: None }])
    };
    match format {
        Format::Bourke if values == Values::Points => {
            Err(Failure::usage("a warp mesh has positions in a picture; use --values picture"))
        }
        Format::Bourke => each(path, channels, |channel| mesh(channel, arguments.nodes)),
        Format::Pfm => {
            each(path, channels, |channel| Ok((pfm::write(channel.size.0, raster(channel)?.0.values()), None)))
        }
        Format::Vwf => {
            let map = |channel: &Channel| {
                let raster = raster(channel)?.0;
                Ok(vwf::VwfMap { name: channel.name.clone(), points: values == Values::Points, raster })
            };
            let maps: Vec<_> = channels.iter().map(map).collect::<Result<_, Failure>>()?;
            together(vwf::write(&maps)?)
        }
        Format::Mpcdi => {
            let profile = if values == Values::Points { mpcdi::Profile::Screen } else { mpcdi::Profile::Flat };
            let region = |channel: &Channel| {
                let (warp, weights) = raster(channel)?;
                let alpha = Some(mpcdi::Alpha { size: channel.size, weights, gamma: channel.gamma });
                Ok(mpcdi::Region { id: channel.name.clone(), size: channel.size, warp, alpha })
            };
            let regions = channels.iter().map(region).collect::<Result<_, Failure>>()?;
            together(mpcdi::write(&mpcdi::Archive { profile, regions })?)
        }
    }
}

/// Writes a file for each channel: the path itself for the only one, else PATH-NAME.
fn each(
    path: &Path,
    channels: &[Channel],
    write: impl Fn(&Channel) -> Result<(Vec<u8>, Option<MapError>), Failure>,
) -> Result<Vec<Written>, Failure> {
    let mut written = Vec::new();
    for (index, channel) in channels.iter().enumerate() {
        let path = if channels.len() == 1 { path.to_owned() } else { named(path, index, &channel.name) };
        let (bytes, error) = write(channel)?;
        save(&path, &bytes)?;
        written.push(Written { path, outputs: 1, values: channel.values, error });
    }
    Ok(written)
}

/// `dome.data` → `dome-left.data`. Names out of files become part of a path: only harmless characters stay.
fn named(path: &Path, index: usize, name: &str) -> PathBuf {
    let harmless: String = name.chars().filter(|c| c.is_ascii_alphanumeric() || "-_".contains(*c)).take(64).collect();
    let name = if harmless.is_empty() { format!("{}", index + 1) } else { harmless };
    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    path.with_file_name(format!("{stem}-{name}.{}", path.extension().unwrap_or_default().to_string_lossy()))
}

fn save(path: &Path, bytes: &[u8]) -> Result<(), Failure> {
    std::fs::write(path, bytes).map_err(|error| Failure::new(format!("{} cannot be written: {error}", path.display())))
}

/// What every pixel shows, and its weight on the displayed value (0 where nothing is shown), on all processors.
fn raster(channel: &Channel) -> Result<(Raster, Vec<f32>), Failure> {
    let (width, height) = (channel.size.0 as usize, channel.size.1 as usize);
    let mut pixels = vec![([f32::NAN; 3], 0.0); width * height];
    let bar = terminal::progress(height as u64, "rows");
    let workers = std::thread::available_parallelism().map_or(1, usize::from);
    let rows = height.div_ceil(workers);
    std::thread::scope(|scope| {
        for (part, band) in pixels.chunks_mut(rows * width).enumerate() {
            let bar = &bar;
            scope.spawn(move || {
                for (row, line) in band.chunks_mut(width).enumerate() {
                    let y = (part * rows + row) as f64 + 0.5;
                    for (column, pixel) in line.iter_mut().enumerate() {
                        if let Some(sample) = channel.sample(DVec2::new(column as f64 + 0.5, y)) {
                            *pixel = (sample.value.as_vec3().to_array(), sample.intensity as f32);
                        }
                    }
                    bar.inc(1);
                }
            });
        }
    });
    bar.finish_and_clear();
    let (values, weights) = pixels.into_iter().unzip();
    let raster = Raster::new(channel.size, values).ok_or_else(|| Failure::new("an output has no pixels"))?;
    Ok((raster, weights))
}

/// A warp mesh of `nodes` columns and rows, and its error between them.
fn mesh(channel: &Channel, (columns, rows): (u32, u32)) -> Result<(Vec<u8>, Option<MapError>), Failure> {
    if columns < 2 || rows < 2 {
        return Err(Failure::usage("a warp mesh has at least 2x2 nodes"));
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
    // What was rounded in the text counts too.
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
