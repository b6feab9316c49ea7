//! Numbered pictures in the form that makers of dome films exchange: `Name_000001.png`.

use super::{Sink, file_name, open_exr};
use crate::failure::Failure;
use cupola::ring::{Format, Picture};
use image::codecs::png::{CompressionType, FilterType, PngEncoder};
use image::{ExtendedColorType, ImageEncoder};
use std::path::{Path, PathBuf};

/// Kind of the files.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// PNG, 8 bits for each colour.
    Png,
    /// PNG, 16 bits for each colour.
    DeepPng,
    /// OpenEXR.
    Exr,
}

impl Kind {
    pub fn new(depth: Format, exr: bool) -> Self {
        match depth {
            _ if exr => Self::Exr,
            Format::Rgba8 => Self::Png,
            Format::Rgba16 => Self::DeepPng,
        }
    }

    fn extension(self) -> &'static str {
        if self == Self::Exr { "exr" } else { "png" }
    }

    /// Encodes a picture as a file.
    fn file(self, picture: &Picture) -> Result<Vec<u8>, String> {
        match (self, picture.format) {
            (Self::Exr, Format::Rgba16) => open_exr::file(picture).map_err(|error| error.to_string()),
            (Self::Png | Self::DeepPng, format) if (format == Format::Rgba16) == (self == Self::DeepPng) => {
                png(picture).map_err(|error| error.to_string())
            }
            (_, format) => Err(format!(
                "the program publishes pictures of {} bits for each colour; leave --depth and --exr out",
                format.pixel_bytes() * 2
            )),
        }
    }
}

/// A folder of pictures, with a folder for each output if there are several.
pub struct Folder {
    path: PathBuf,
    name: Option<String>,
    kind: Kind,
    /// Number of the first frame in the names of its files.
    first: u64,
    /// First frame of which a picture was missing at the start; 0 before the first frame.
    first_missing: u64,
    written: u64,
}

impl Folder {
    pub fn new(path: &Path, name: Option<String>, kind: Kind, first: u64) -> Self {
        Self { path: path.to_owned(), name, kind, first, first_missing: 0, written: 0 }
    }

    /// File of a picture of frame `number`, counted from 1.
    fn file(&self, number: u64, picture: &Picture, several: bool) -> PathBuf {
        let number = self.first - 1 + number;
        let output = file_name(&picture.name);
        let folder = if several { self.path.join(&output) } else { self.path.clone() };
        folder.join(format!("{}_{number:06}.{}", self.name.as_ref().unwrap_or(&output), self.kind.extension()))
    }

    /// Finds the pictures that an earlier run has written.
    fn begin(&mut self, pictures: &[Picture]) -> Result<(), Failure> {
        let several = pictures.len() > 1;
        for picture in pictures {
            let file = self.file(1, picture, several);
            let folder = file.parent().unwrap_or(&self.path);
            std::fs::create_dir_all(folder).map_err(|error| failed(folder, &error))?;
        }
        let is_there = |number: &u64| pictures.iter().all(|picture| self.file(*number, picture, several).exists());
        let there = (1..).take_while(is_there).count() as u64;
        self.first_missing = there + 1;
        if there > 0 {
            eprintln!(
                "cupola: {there} frames are there already; the recording goes on with frame {}",
                self.first + there
            );
        }
        Ok(())
    }
}

impl Sink for Folder {
    fn take(&mut self, number: u64, pictures: &[Picture], again: bool) -> Result<(), Failure> {
        if self.first_missing == 0 {
            self.begin(pictures)?;
        }
        let is_there = number < self.first_missing;
        // Two frames show whether the pictures belong to another recording.
        let is_compared = is_there && (number == 1 || number + 1 == self.first_missing);
        if is_there && !is_compared {
            return Ok(());
        }
        for picture in pictures {
            let file = self.file(number, picture, pictures.len() > 1);
            if again && !is_compared {
                let before = self.file(number - 1, picture, pictures.len() > 1);
                let bytes = std::fs::read(&before).map_err(|error| failed(&before, &error))?;
                write_whole(&file, &bytes).map_err(|error| failed(&file, &error))?;
                continue;
            }
            let bytes = self.kind.file(picture);
            let bytes = bytes.map_err(|error| Failure::new(format!("{}: {error}", file.display())))?;
            if is_compared {
                let before = std::fs::read(&file).map_err(|error| failed(&file, &error))?;
                if before != bytes {
                    return Err(Failure::new(format!(
                        "{} is there already and shows another picture: the folder has another recording, or the program \
                         does not draw the same again; choose an empty folder for --out",
                        file.display()
                    )));
                }
            } else {
                write_whole(&file, &bytes).map_err(|error| failed(&file, &error))?;
            }
        }
        self.written += u64::from(!is_compared);
        Ok(())
    }

    fn resumed(&self) -> &'static str {
        "the same command goes on with this recording"
    }

    fn finish(&mut self) -> Result<String, Failure> {
        Ok(format!("{} frames were written to {}", self.written, self.path.display()))
    }
}

/// Writes a file that gets its name only when it is complete.
fn write_whole(file: &Path, bytes: &[u8]) -> std::io::Result<()> {
    let mut part = file.as_os_str().to_owned();
    part.push(".part");
    let part = PathBuf::from(part);
    // A name that is a link, or a part of an earlier run, is removed instead of written through.
    let _ = std::fs::remove_file(&part);
    let written = std::fs::write(&part, bytes).and_then(|()| std::fs::rename(&part, file));
    written.inspect_err(|_| drop(std::fs::remove_file(&part)))
}

fn failed(path: &Path, error: &std::io::Error) -> Failure {
    let more = match error.kind() {
        std::io::ErrorKind::StorageFull | std::io::ErrorKind::QuotaExceeded => {
            "; all files that have their name are whole, and the same command goes on when there is space"
        }
        _ => "",
    };
    Failure::new(format!("{}: {error}{more}", path.display()))
}

/// Encodes a picture as an RGB PNG file. Equal pixels give equal bytes.
fn png(picture: &Picture) -> image::ImageResult<Vec<u8>> {
    // Without alpha: three of four numbers.
    let bytes = picture.format.pixel_bytes();
    let rgb: Vec<u8> = picture.rgba.chunks_exact(bytes).flat_map(|pixel| &pixel[..bytes / 4 * 3]).copied().collect();
    let color = if picture.format == Format::Rgba16 { ExtendedColorType::Rgb16 } else { ExtendedColorType::Rgb8 };
    let mut bytes = Vec::new();
    PngEncoder::new_with_quality(&mut bytes, CompressionType::Fast, FilterType::Adaptive).write_image(
        &rgb,
        picture.size.0,
        picture.size.1,
        color,
    )?;
    Ok(bytes)
}
