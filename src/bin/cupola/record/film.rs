//! Films: raw pictures to the standard input of ffmpeg, one process for each output.

use super::{Sink, file_name};
use crate::failure::Failure;
use crate::launch::clock::Rate;
use cupola::ring::Picture;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};

const ENCODER: &str = "ffmpeg";

/// Codec, quality and container of a film.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum Preset {
    /// For players: H.264, 8 bit, 4:2:0.
    H264,
    /// H.265, for larger pictures than H.264 permits.
    H265,
    /// For cutting: ProRes 422 HQ, 10 bit.
    Prores,
}

impl Preset {
    fn options(self) -> &'static [&'static str] {
        match self {
            Self::H264 => &["-c:v", "libx264", "-preset", "medium", "-crf", "16", "-pix_fmt", "yuv420p"],
            Self::H265 => &["-c:v", "libx265", "-crf", "18", "-pix_fmt", "yuv420p", "-tag:v", "hvc1"],
            Self::Prores => &["-c:v", "prores_ks", "-profile:v", "3", "-pix_fmt", "yuv422p10le"],
        }
    }

    fn extension(self) -> &'static str {
        match self {
            Self::H264 | Self::H265 => "mp4",
            Self::Prores => "mov",
        }
    }
}

/// One film for each output.
pub struct Films {
    folder: PathBuf,
    name: Option<String>,
    preset: Preset,
    rate: Rate,
    films: Vec<Film>,
}

struct Film {
    encoder: Child,
    size: (u32, u32),
    part: PathBuf,
    file: PathBuf,
}

impl Films {
    pub fn new(folder: &Path, name: Option<String>, preset: Preset, rate: Rate) -> Self {
        Self { folder: folder.to_owned(), name, preset, rate, films: Vec::new() }
    }

    fn start(&self, picture: &Picture, several: bool) -> Result<Film, Failure> {
        let output = file_name(&picture.name);
        let stem = match &self.name {
            Some(name) if several => format!("{name}-{output}"),
            Some(name) => name.clone(),
            None => output,
        };
        let extension = self.preset.extension();
        let file = self.folder.join(format!("{stem}.{extension}"));
        let part = self.folder.join(format!("{stem}.part.{extension}"));
        let (width, height) = picture.size;
        let encoder = Command::new(ENCODER)
            .args(["-hide_banner", "-loglevel", "error", "-y", "-f", "rawvideo", "-pixel_format", "rgba"])
            .args(["-video_size", &format!("{width}x{height}")])
            .args(["-framerate", &format!("{}/{}", self.rate.frames, self.rate.seconds), "-i", "-"])
            // These codecs want even sides and pictures in the colours of television.
            .args(["-vf", "pad=ceil(iw/2)*2:ceil(ih/2)*2,scale=out_color_matrix=bt709:out_range=tv"])
            .args(["-colorspace", "bt709", "-color_primaries", "bt709", "-color_trc", "bt709", "-color_range", "tv"])
            .args(self.preset.options())
            .args(["-map_metadata", "-1", "-fflags", "+bitexact", "-flags:v", "+bitexact"])
            .arg(std::path::absolute(&part).unwrap_or_else(|_| part.clone()))
            .stdin(Stdio::piped())
            .stdout(Stdio::null())
            .spawn()
            .map_err(|error| {
                Failure::new(format!("{ENCODER}, which writes films, cannot be started: {error}; install it"))
            })?;
        Ok(Film { encoder, size: picture.size, part, file })
    }
}

impl Film {
    fn add(&mut self, picture: &Picture) -> Result<(), Failure> {
        if picture.size != self.size {
            return Err(Failure::new(format!(
                "{}: the picture changed its size from {} × {} to {} × {}, which a film cannot",
                self.file.display(),
                self.size.0,
                self.size.1,
                picture.size.0,
                picture.size.1
            )));
        }
        let written = self.encoder.stdin.as_mut().map_or(Ok(()), |input| input.write_all(&picture.rgba));
        written.map_err(|error| {
            Failure::new(format!("{}: {ENCODER} takes no more pictures: {error}", self.part.display()))
        })
    }

    fn finish(&mut self) -> Result<(), Failure> {
        drop(self.encoder.stdin.take());
        let failed = |error: std::io::Error| Failure::new(format!("{}: {error}", self.part.display()));
        let status = self.encoder.wait().map_err(failed)?;
        if !status.success() {
            return Err(Failure::new(format!("{}: {ENCODER} failed with {status}", self.part.display())));
        }
        std::fs::rename(&self.part, &self.file).map_err(failed)
    }
}

impl Drop for Film {
    fn drop(&mut self) {
        // The part of a film that was not finished stays: ffmpeg closes it when its input ends.
        drop(self.encoder.stdin.take());
        let _ = self.encoder.wait();
    }
}

impl Sink for Films {
    fn take(&mut self, _number: u64, pictures: &[Picture]) -> Result<(), Failure> {
        if self.films.is_empty() {
            self.films =
                pictures.iter().map(|picture| self.start(picture, pictures.len() > 1)).collect::<Result<_, _>>()?;
        }
        if pictures.len() != self.films.len() {
            return Err(Failure::new("the number of outputs changed, which a film cannot"));
        }
        self.films.iter_mut().zip(pictures).try_for_each(|(film, picture)| film.add(picture))
    }

    fn finish(&mut self) -> Result<String, Failure> {
        self.films.iter_mut().try_for_each(Film::finish)?;
        let files: Vec<_> = self.films.iter().map(|film| film.file.display().to_string()).collect();
        Ok(format!("the film is in {}", files.join(", ")))
    }
}
