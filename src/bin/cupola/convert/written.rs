//! Written files, and the pixels of one output.

use super::options::Values;
use super::source::Channel;
use crate::failure::Failure;
use crate::terminal;
use cupola::formats::Raster;
use cupola::warp::MapError;
use glam::DVec2;
use serde_json::json;
use std::io::Write;
use std::path::{Path, PathBuf};

/// A file that was written.
pub struct Written {
    /// Path of the file.
    pub path: PathBuf,
    /// Number of outputs in it.
    pub outputs: usize,
    /// Meaning of the values of a map.
    pub values: Option<Values>,
    /// Error of interpolation against the exact map, where there is one.
    pub error: Option<MapError>,
}

impl Written {
    /// A map of one output.
    pub fn map(path: PathBuf, values: Values) -> Self {
        Self { path, outputs: 1, values: Some(values), error: None }
    }

    /// A rig.
    pub fn rig(path: PathBuf, outputs: usize) -> Self {
        Self { path, outputs, values: None, error: None }
    }

    /// Description as JSON.
    pub fn json(&self) -> serde_json::Value {
        let error = self.error.map(
            |error| json!({ "max": error.max, "rms": error.rms, "uncovered": error.uncovered, "ghosts": error.ghosts }),
        );
        json!({
            "path": self.path.display().to_string(),
            "outputs": self.outputs,
            "values": self.values.map(Values::words),
            "error_pixels": error,
        })
    }

    /// Description as text.
    pub fn words(&self) -> String {
        let error = self.error.map_or(String::new(), |error| {
            format!(
                "; greatest error between the nodes {:.4} pixels (root mean square {:.4}), {} pixels missing",
                error.max, error.rms, error.uncovered
            )
        });
        let values = self.values.map_or(String::new(), |values| format!(", values: {}", values.words()));
        format!("{}: outputs: {}{values}{error}", self.path.display(), self.outputs)
    }
}

/// The path for one output: `dome-left.ENDING` for `dome.data`. Only harmless characters of names
/// from files are used.
pub fn file_beside(path: &Path, index: usize, name: &str, ending: &str) -> PathBuf {
    let harmless: String = name.chars().filter(|c| c.is_ascii_alphanumeric() || "-_".contains(*c)).take(64).collect();
    let name = if harmless.is_empty() { format!("{}", index + 1) } else { harmless };
    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    path.with_file_name(format!("{stem}-{name}.{ending}"))
}

/// Writes a file.
pub fn save(path: &Path, bytes: &[u8]) -> Result<(), Failure> {
    cupola::system::create(path)
        .and_then(|mut file| file.write_all(bytes))
        .map_err(|error| Failure::new(format!("{} cannot be written: {error}", path.display())))
}

/// Value of every pixel, and its weight on the displayed value (0 if nothing is shown). Computed on
/// all processors.
pub fn raster(channel: &Channel) -> Result<(Raster, Vec<f32>), Failure> {
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
