//! Pictures to the standard input of other programs, one for each output: films with ffmpeg, and
//! commands of the user.

use super::{Sink, file_name};
use crate::failure::Failure;
use crate::launch::clock::Rate;
use crate::pipe::{Form, Format, Receiver, TimeBase};
use cupola::ring::Picture;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

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

/// Receiver of the pictures.
pub enum Taker {
    /// ffmpeg, for a film.
    Film(Preset),
    /// A shell command, and the format of its input.
    Command(String, Format),
}

/// One receiver for each output.
pub struct Receivers {
    folder: PathBuf,
    name: Option<String>,
    taker: Taker,
    rate: Rate,
    receivers: Vec<One>,
}

struct One {
    receiver: Receiver,
    output: String,
    /// Name of a film until it is complete, and its final name.
    files: Option<(PathBuf, PathBuf)>,
}

impl Receivers {
    pub fn new(folder: &Path, name: Option<String>, taker: Taker, rate: Rate) -> Self {
        Self { folder: folder.to_owned(), name, taker, rate, receivers: Vec::new() }
    }

    fn start(&self, picture: &Picture, several: bool) -> Result<One, Failure> {
        let base = TimeBase { numerator: self.rate.seconds, denominator: self.rate.frames };
        let form = |format| Form { format, base, rate: self.rate };
        let output = file_name(&picture.name);
        match &self.taker {
            Taker::Command(command, format) => {
                let mut shell = Receiver::shell(command, self.rate, picture);
                let receiver = Receiver::start(shell.current_dir(&self.folder), form(*format), picture)?;
                Ok(One { receiver, output, files: None })
            }
            Taker::Film(preset) => {
                let stem = match &self.name {
                    Some(name) if several => format!("{name}-{output}"),
                    Some(name) => name.clone(),
                    None => output.clone(),
                };
                let extension = preset.extension();
                let part = self.folder.join(format!("{stem}.part.{extension}"));
                let file = self.folder.join(format!("{stem}.{extension}"));
                let mut encoder = encoder(*preset, self.rate, picture.size, &part);
                let receiver = Receiver::start(&mut encoder, form(Format::Raw), picture)?;
                Ok(One { receiver, output, files: Some((part, file)) })
            }
        }
    }
}

fn encoder(preset: Preset, rate: Rate, (width, height): (u32, u32), file: &Path) -> Command {
    let mut encoder = Command::new(ENCODER);
    encoder
        .args(["-hide_banner", "-loglevel", "error", "-y", "-f", "rawvideo", "-pixel_format", "rgba"])
        .args(["-video_size", &format!("{width}x{height}")])
        .args(["-framerate", &format!("{}/{}", rate.frames, rate.seconds), "-i", "-"])
        .args(TELEVISION)
        .args(preset.options())
        .args(["-map_metadata", "-1", "-fflags", "+bitexact", "-flags:v", "+bitexact"])
        .arg(std::path::absolute(file).unwrap_or_else(|_| file.to_owned()))
        .stdout(Stdio::null());
    encoder
}

/// Arguments for even sides and the colours of television, which codecs require.
pub const TELEVISION: [&str; 10] = [
    "-vf",
    "pad=ceil(iw/2)*2:ceil(ih/2)*2,scale=out_color_matrix=bt709:out_range=tv",
    "-colorspace",
    "bt709",
    "-color_primaries",
    "bt709",
    "-color_trc",
    "bt709",
    "-color_range",
    "tv",
];

impl One {
    fn add(&mut self, picture: &Picture, time: u64) -> Result<(), Failure> {
        let (old, new) = (self.receiver.size(), picture.size);
        if old != new {
            return Err(Failure::new(format!(
                "{}: the picture changed its size from {} × {} to {} × {}, which a film does not allow",
                self.output, old.0, old.1, new.0, new.1
            )));
        }
        self.receiver.add(picture, time)
    }

    fn finish(&mut self) -> Result<(), Failure> {
        self.receiver.finish()?;
        match &self.files {
            Some((part, file)) => {
                std::fs::rename(part, file).map_err(|error| Failure::new(format!("{}: {error}", part.display())))
            }
            None => Ok(()),
        }
    }
}

impl Sink for Receivers {
    fn take(&mut self, number: u64, pictures: &[Picture], _again: bool) -> Result<(), Failure> {
        if self.receivers.is_empty() {
            self.receivers =
                pictures.iter().map(|picture| self.start(picture, pictures.len() > 1)).collect::<Result<_, _>>()?;
        }
        if pictures.len() != self.receivers.len() {
            return Err(Failure::new("the number of outputs changed, which a film does not allow"));
        }
        self.receivers.iter_mut().zip(pictures).try_for_each(|(one, picture)| one.add(picture, number - 1))
    }

    fn resumed(&self) -> &'static str {
        "a film begins anew; pictures (without --film and --pipe) can be continued"
    }

    fn finish(&mut self) -> Result<String, Failure> {
        self.receivers.iter_mut().try_for_each(One::finish)?;
        let files: Vec<_> =
            self.receivers.iter().filter_map(|one| Some(one.files.as_ref()?.1.display().to_string())).collect();
        Ok(match files.is_empty() {
            true => "the command has taken all pictures".to_owned(),
            false => format!("the film is in {}", files.join(", ")),
        })
    }
}
