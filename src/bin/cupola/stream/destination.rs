//! Destination of live pictures, and ffmpeg's arguments for it.

use crate::failure::Failure;
use crate::launch::clock::Rate;
use crate::record::film::TELEVISION;
use std::path::Path;
use std::process::{Command, Stdio};

const ENCODER: &str = "ffmpeg";

/// Destination of live pictures.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Destination {
    /// The standard output of this command, without encoding.
    Output,
    /// An address or a file, encoded by ffmpeg.
    Encoded { muxer: Muxer, place: String },
    /// A device of v4l2loopback, through ffmpeg.
    Camera(String),
    /// A source of NDI with this name.
    Ndi(String),
    /// A video source of PipeWire with this name.
    PipeWire(String),
}

/// Container of encoded pictures.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Muxer {
    /// MPEG transport stream, for SRT and others.
    Transport,
    /// Flash video, for RTMP.
    Flash,
    /// A playlist and its parts.
    Playlist,
    /// A file, whose extension selects the container.
    File,
}

impl Destination {
    /// Reads the text of the command line.
    pub fn parse(text: &str) -> Result<Self, String> {
        let encoded = |muxer| Ok(Self::Encoded { muxer, place: text.to_owned() });
        if let Some((kind @ ("ndi" | "pipewire"), name)) =
            text.split_once(':').filter(|(_, name)| !name.starts_with("//"))
        {
            return match (kind, name) {
                (_, "") => Err(format!("expected the name of the source, for example {kind}:Dome")),
                ("ndi", _) => Ok(Self::Ndi(name.to_owned())),
                _ => Ok(Self::PipeWire(name.to_owned())),
            };
        }
        match text.split_once("://").map(|(scheme, _)| scheme) {
            _ if text == "-" => Ok(Self::Output),
            _ if text.is_empty() => Err("expected an address or a file".to_owned()),
            Some("srt" | "udp" | "tcp" | "rist") => encoded(Muxer::Transport),
            Some("rtmp" | "rtmps") => encoded(Muxer::Flash),
            Some(scheme) => Err(format!(
                "no preset for {scheme}://; there are srt, rist, udp, tcp, rtmp, ndi:NAME, pipewire:NAME, and --pipe \
                 for a command of your own"
            )),
            None if text.starts_with("/dev/video") => Ok(Self::Camera(text.to_owned())),
            None if text.ends_with(".m3u8") => encoded(Muxer::Playlist),
            None => encoded(Muxer::File),
        }
    }
}

/// Encoding of the pictures.
#[derive(Clone, Debug)]
pub struct Encoding {
    /// Name of the encoder in ffmpeg.
    pub encoder: String,
    /// Bits per second, in ffmpeg's form; `None`: by quality.
    pub bitrate: Option<String>,
    pub rate: Rate,
}

impl Encoding {
    /// Makes the command of ffmpeg for a destination that ffmpeg serves.
    pub fn command(&self, destination: &Destination) -> Result<Command, Failure> {
        let mut ffmpeg = Command::new(ENCODER);
        ffmpeg.args(["-hide_banner", "-loglevel", "error", "-y"]);
        // Otherwise ffmpeg would wait for more pictures to guess their format.
        ffmpeg.args(["-probesize", "32", "-analyzeduration", "0", "-f", "nut", "-i", "-"]);
        // Pictures keep their times.
        ffmpeg.args(["-fps_mode", "passthrough"]);
        match destination {
            Destination::Output | Destination::Ndi(_) | Destination::PipeWire(_) => {}
            Destination::Camera(device) => {
                ffmpeg.args(TELEVISION).args(["-pix_fmt", "yuv420p", "-f", "v4l2"]).arg(device);
            }
            Destination::Encoded { muxer, place } => {
                ffmpeg.args(["-enc_time_base", "1:90000"]).args(TELEVISION);
                self.encode(&mut ffmpeg, *muxer);
                self.wrap(&mut ffmpeg, *muxer, place)?;
            }
        }
        ffmpeg.stdout(Stdio::null());
        Ok(ffmpeg)
    }

    fn encode(&self, ffmpeg: &mut Command, muxer: Muxer) {
        ffmpeg.args(["-c:v", &self.encoder, "-pix_fmt", "yuv420p"]);
        let is_software = matches!(&*self.encoder, "libx264" | "libx265");
        if is_software {
            ffmpeg.args(["-preset", "veryfast"]);
            if muxer != Muxer::File {
                ffmpeg.args(["-tune", "zerolatency"]);
            }
        }
        match &self.bitrate {
            Some(bits) => drop(ffmpeg.args(["-b:v", bits, "-maxrate", bits, "-bufsize", bits])),
            None if is_software => drop(ffmpeg.args(["-crf", "20"])),
            None => {}
        }
        if muxer != Muxer::File {
            // A receiver that joins later waits for a key frame: there is one each second.
            let second = (self.rate.frames / self.rate.seconds.max(1)).max(1);
            ffmpeg.args(["-bf", "0", "-g", &second.to_string()]);
        }
    }

    fn wrap(&self, ffmpeg: &mut Command, muxer: Muxer, place: &str) -> Result<(), Failure> {
        match muxer {
            Muxer::Transport => {
                ffmpeg.args(["-flush_packets", "1", "-muxdelay", "0", "-muxpreload", "0", "-f", "mpegts", place]);
            }
            Muxer::Flash => {
                ffmpeg.args(["-flvflags", "no_duration_filesize", "-f", "flv", place]);
            }
            Muxer::Playlist | Muxer::File => {
                let path = std::path::absolute(place)
                    .map_err(|error| Failure::usage(format!("the file {place} cannot be written: {error}")))?;
                folder(&path)?;
                if muxer == Muxer::Playlist {
                    ffmpeg.args(["-f", "hls", "-hls_time", "1", "-hls_list_size", "6"]);
                    ffmpeg.args(["-hls_flags", "delete_segments+independent_segments"]);
                }
                ffmpeg.arg(path);
            }
        }
        Ok(())
    }
}

/// Fails if there is no folder for a file.
fn folder(path: &Path) -> Result<(), Failure> {
    match path.parent().is_some_and(Path::is_dir) {
        true => Ok(()),
        false => Err(Failure::usage(format!("{}: the folder of this file does not exist", path.display()))),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_place_says_how_pictures_are_sent() {
        let muxer = |text: &str| match Destination::parse(text) {
            Ok(Destination::Encoded { muxer, .. }) => Some(muxer),
            _ => None,
        };
        assert_eq!(muxer("srt://dome:9000?mode=caller"), Some(Muxer::Transport));
        assert_eq!(muxer("rtmp://dome/live/key"), Some(Muxer::Flash));
        assert_eq!(muxer("web/live.m3u8"), Some(Muxer::Playlist));
        assert_eq!(muxer("show.mkv"), Some(Muxer::File));
        assert_eq!(Destination::parse("-"), Ok(Destination::Output));
        assert_eq!(Destination::parse("/dev/video10"), Ok(Destination::Camera("/dev/video10".to_owned())));
        assert_eq!(Destination::parse("ndi:Dome: left"), Ok(Destination::Ndi("Dome: left".to_owned())));
        assert_eq!(Destination::parse("pipewire:Dome"), Ok(Destination::PipeWire("Dome".to_owned())));
        assert!(Destination::parse("pipewire:").is_err_and(|words| words.contains("pipewire:Dome")));
        assert!(Destination::parse("ndi:").is_err_and(|words| words.contains("name of the source")));
        assert!(Destination::parse("ndi://Dome").is_err_and(|words| words.contains("ndi:NAME")));
        assert!(Destination::parse("gopher://dome").is_err_and(|words| words.contains("no preset for gopher")));
    }
}
