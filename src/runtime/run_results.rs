//! Captures and statistics of a run.

use crate::cache::Counts;
use crate::error::{Error, ErrorKind, Result};
use crate::runtime::frame_times::{FrameTimes, Milliseconds};
use crate::system::create;
use serde::Serialize;
use std::collections::BTreeMap;
use std::io::{Cursor, Write};
use std::path::{Path, PathBuf};

/// A picture read back from the driver: 8 bits per channel, rows from the bottom.
pub struct Picture {
    /// Name of the output or view.
    pub name: String,
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// RGBA, row by row from the bottom.
    pub rgba: Vec<u8>,
}

/// Numbers that `--stats` writes.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Statistics {
    /// Number of presented frames.
    pub frames: u64,
    /// Number of these that were not corrected, because the window was not mapped (X11).
    pub hidden_frames: u64,
    /// Name of the rig.
    pub rig: String,
    /// OpenGL version and driver of the program's context.
    pub driver: String,
    /// Views, in order.
    pub views: Vec<ViewStatistics>,
    /// Faces of the cube that no output samples.
    pub skipped_views: Vec<String>,
    /// Number of draws of the program to its window.
    pub draws_seen: u64,
    /// Number of flat draws that went to the panel.
    pub panel_draws: u64,
    /// Number of draws that went to the primary view.
    pub primary_draws: u64,
    /// Number of draws to the program's own framebuffers that were issued once per view.
    pub duplicated_draws: u64,
    /// Number of times that a draw, recorded for each view and the panel, was left out of one of
    /// them because its vertices turned out to be out of sight there, or because only other machines
    /// show that view (Vulkan).
    pub draws_out_of_sight: u64,
    /// Number of draws of the scene whose vertices had known bounds.
    pub bounded_draws: u64,
    /// Number of these draws that are partly in the primary view, counted until it is known whether
    /// the program itself leaves out draws beside its picture.
    pub draws_at_border: u64,
    /// Number of these draws, counted until then, that are wholly beside the primary view or behind
    /// the eye.
    pub draws_beside: u64,
    /// Number of ranges of buffers that were read back for the bounds, each once until its buffer
    /// changes.
    pub ranges_read: u64,
    /// Number of times that the unsampled areas of the views were closed for drawing.
    pub closings: u64,
    /// Number of the program's framebuffers, drawn to until the end, that are drawn once per view.
    pub duplicated_framebuffers: u64,
    /// Number of its other framebuffers, by the obstacle.
    pub single_framebuffers: BTreeMap<String, u64>,
    /// Number of draws by the way in which their projection was found.
    pub projection_found: BTreeMap<String, u64>,
    /// Lenses of the program with which the views of the last frames were drawn: left, right, lower
    /// and upper edge of the program's picture, as tangents of the angles from straight ahead.
    pub lenses: Vec<[f64; 4]>,
    /// Name of the profile that was used; empty if there was none.
    pub profile: String,
    /// Number of pixels of all outputs.
    pub output_pixels: u64,
    /// Number of pixels that the correction computes in a frame, including batches that are left
    /// out. The others are known to be black: outside of a circle or of the dome, masked, not lit.
    pub corrected_pixels: u64,
    /// Number of batches of the correction that were not drawn, because their views were cleared
    /// views.
    pub batches_left_out: u64,
    /// Number of lines and triangles, or parts of them, that the method `primitive` did not divide
    /// far enough, in all frames and outputs. Absent if the driver cannot count them.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub coarse_primitives: Option<u64>,
    /// Number of pipelines that the method `primitive` does not divide, by reason. Their draws are
    /// drawn as with `vertex` (Vulkan).
    pub undivided_pipelines: BTreeMap<String, u64>,
    /// Number of pictures of outputs of which only the part that was drawn to was corrected, and
    /// the rest cleared.
    pub outputs_narrowed: u64,
    /// Number of shader programs that were linked: the correction's, and the program's with
    /// Cupola's epilogue.
    pub shaders_linked: u64,
    /// Use of the result cache: found, not found, written.
    pub cache: Counts,
    /// Number of OpenGL errors of Cupola's own calls; must be 0.
    pub own_errors: u64,
    /// Times of the window's frames.
    pub milliseconds: FrameMilliseconds,
    /// Frames that were published for other processes; absent if none were.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub published: Option<Published>,
    /// Notes of the planner, and reasons why the program is shown flat.
    pub notes: Vec<String>,
}

/// Published frames in [`Statistics`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Published {
    /// Number of published frames.
    pub frames: u64,
    /// Number of living readers.
    pub readers: usize,
    /// Number of frames that readers lost, added up over the readers.
    pub lost: u64,
    /// Number of frames that were not published because the graphics driver had not yet finished
    /// earlier ones.
    pub left_out: u64,
}

/// Times of frames in [`Statistics`]; times that were not measured are absent.
#[derive(Clone, Copy, Debug, Default, Serialize)]
pub struct FrameMilliseconds {
    /// Time from one frame to the next.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub frame: Option<Milliseconds>,
    /// Processor time of the presenting thread, program and driver included.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub processor: Option<Milliseconds>,
    /// Processor time in which that thread records the correction.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub processor_correction: Option<Milliseconds>,
    /// Time of the device from the first draw of a frame to the correction: the program's drawing
    /// in all views (OpenGL).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub device_drawing: Option<Milliseconds>,
    /// Time of the device for the correction.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub device_correction: Option<Milliseconds>,
}

impl From<&FrameTimes> for FrameMilliseconds {
    fn from(times: &FrameTimes) -> Self {
        Self {
            frame: times.frame.summary(),
            processor: times.processor.summary(),
            processor_correction: times.correction.summary(),
            device_drawing: times.device_drawing.summary(),
            device_correction: times.device_correction.summary(),
        }
    }
}

/// A view's part of [`Statistics`].
#[derive(Clone, Debug, Default, Serialize)]
pub struct ViewStatistics {
    /// Name.
    pub name: String,
    /// Width in texels.
    pub width: u32,
    /// Height in texels.
    pub height: u32,
    /// Number of texels that are closed for drawing, because no output samples them.
    pub closed_texels: u64,
    /// Number of draws issued to it since the views were planned.
    pub draws_issued: u64,
    /// Number of draws that were left out because they do not reach it.
    pub draws_culled: u64,
    /// Number of draws issued to the program's own framebuffers that are drawn once per view
    /// (OpenGL).
    pub duplicated_draws_issued: u64,
    /// Number of these draws that were left out.
    pub duplicated_draws_culled: u64,
}

/// Writes text to a file.
///
/// # Errors
/// The file cannot be written.
pub fn write_text(path: &Path, text: &str) -> Result<()> {
    write(path, text.as_bytes())
}

/// Writes `statistics` as JSON.
///
/// # Errors
/// The file cannot be written.
pub fn write_statistics(path: &Path, statistics: &Statistics) -> Result<()> {
    let text = serde_json::to_string_pretty(statistics)
        .map_err(|error| Error::new(ErrorKind::Internal, format!("statistics: {error}")))?;
    write(path, (text + "\n").as_bytes())
}

/// Writes `statistics` as JSON in place of the file: readers see the old or the new content.
///
/// # Errors
/// The file cannot be written.
pub fn replace_statistics(path: &Path, statistics: &Statistics) -> Result<()> {
    let next = path.with_extension(format!("{}.next", std::process::id()));
    write_statistics(&next, statistics)?;
    std::fs::rename(&next, path).map_err(|error| Error::new(ErrorKind::Io, format!("{}: {error}", path.display())))
}

fn write(path: &Path, bytes: &[u8]) -> Result<()> {
    let written = create(path).and_then(|mut file| file.write_all(bytes));
    written.map_err(|error| Error::new(ErrorKind::Io, format!("{}: {error}", path.display())))
}

/// Path of a capture: `FILE.png` for a single picture, `FILE-NAME.png` for one of several.
pub fn capture_path(path: &Path, name: &str, several: bool) -> PathBuf {
    if !several {
        return path.to_owned();
    }
    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    let extension = path.extension().map_or("png".into(), |e| e.to_string_lossy());
    path.with_file_name(format!("{stem}-{name}.{extension}"))
}

/// Writes a picture as an RGB PNG, turned so that its first row is the top one.
///
/// # Errors
/// The file cannot be written.
pub fn write_picture(path: &Path, picture: &Picture) -> Result<()> {
    let failed = |error| Error::new(ErrorKind::Internal, format!("{}: {error}", path.display()));
    write(path, &png(picture.width, picture.height, &upright_rgb(picture)).map_err(failed)?)
}

/// Encodes a picture as a PNG file, reduced to at most `width` pixels across.
///
/// # Errors
/// The picture cannot be encoded.
pub fn reduced_png(picture: &Picture, width: u32) -> Result<Vec<u8>> {
    let failed = |error: String| Error::new(ErrorKind::Internal, format!("{}: {error}", picture.name));
    let rgb = image::RgbImage::from_raw(picture.width, picture.height, upright_rgb(picture))
        .ok_or_else(|| failed("its pixels are missing".to_owned()))?;
    let width = width.min(picture.width);
    let height = (u64::from(picture.height) * u64::from(width) / u64::from(picture.width.max(1))).max(1) as u32;
    let rgb = if width < picture.width { image::imageops::thumbnail(&rgb, width, height) } else { rgb };
    png(rgb.width(), rgb.height(), &rgb).map_err(|error| failed(error.to_string()))
}

/// Pixels as RGB, the first row at the top.
fn upright_rgb(picture: &Picture) -> Vec<u8> {
    let row = picture.width as usize * 4;
    picture
        .rgba
        .chunks_exact(row.max(1))
        .rev()
        .flat_map(|line| line.chunks_exact(4).flat_map(|pixel| [pixel[0], pixel[1], pixel[2]]))
        .collect()
}

fn png(width: u32, height: u32, rgb: &[u8]) -> image::ImageResult<Vec<u8>> {
    let mut bytes = Cursor::new(Vec::new());
    let format = image::ImageFormat::Png;
    image::write_buffer_with_format(&mut bytes, rgb, width, height, image::ExtendedColorType::Rgb8, format)?;
    Ok(bytes.into_inner())
}

#[cfg(test)]
mod tests {
    use super::capture_path;
    use std::path::Path;

    #[test]
    fn several_outputs_get_several_files() {
        let path = Path::new("out/dome.png");
        assert_eq!(capture_path(path, "left", false), path);
        assert_eq!(capture_path(path, "left", true), Path::new("out/dome-left.png"));
    }
}
