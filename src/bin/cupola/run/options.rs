//! Options of the subcommands that start a program, and the rig and profile that they name.

use super::environment::writable_file;
use crate::failure::Failure;
use crate::launch::clock;
use cupola::rig::{Chosen, Defaults, Overrides, Place, Profiles, Rig};
use cupola::ring;
use cupola::system;
use cupola::system::process;
use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::time::Duration;

/// Options of every subcommand that starts a program.
#[derive(clap::Args)]
#[group(skip)]
pub struct Options {
    /// Rig file or name of a preset [default: $CUPOLA_RIG, or fisheye]
    #[arg(long, short, value_name = "FILE|PRESET", overrides_with = "rig")]
    pub(super) rig: Option<String>,
    /// Profile of the program: its name, a file, or none [default: the one for the program's name,
    /// or for its libraries]
    #[arg(long, value_name = "NAME|FILE|none")]
    pub(super) profile: Option<String>,
    /// Set the size of the program's window in pixels
    #[arg(long, value_name = "WxH", value_parser = crate::arguments::size)]
    pub size: Option<(u32, u32)>,
    /// Run on a private X server without a screen (Xvfb)
    #[arg(long)]
    pub headless: bool,
    /// End the program after N frames, with exit code 0
    #[arg(long, value_name = "N", value_parser = frames)]
    pub frames: Option<u64>,
    /// End the program after N seconds, with exit code 0
    #[arg(long, value_name = "N", value_parser = seconds)]
    pub seconds: Option<Duration>,
    /// Write the last frame to a PNG file; with several outputs, one file FILE-NAME.png for each
    #[arg(long, value_name = "FILE.png")]
    pub capture: Option<PathBuf>,
    /// Write all views of the last frame as PNG files to a folder
    #[arg(long, value_name = "DIR")]
    pub capture_views: Option<PathBuf>,
    /// Write statistics (times, draws, views) to a JSON file
    #[arg(long, value_name = "FILE.json")]
    pub stats: Option<PathBuf>,
    /// Change the program's camera, for example zoom=4,move=0,0,-20,yaw=90,pitch=0,roll=0
    #[arg(long, value_name = "KEY=NUMBER,…", allow_hyphen_values = true)]
    pub(super) camera: Option<String>,
    /// Change the viewer's position and orientation, for example
    /// position=0,-0.5,1,yaw=90,pitch=0,roll=0
    #[arg(long, value_name = "KEY=NUMBER,…", allow_hyphen_values = true)]
    pub(super) viewer: Option<String>,
    /// The window already shows a projected picture: domemaster, equirectangular, cylindrical,
    /// cubemap or flat, for example domemaster,aperture=180
    #[arg(long, value_name = "KIND[,KEY=VALUE,…]", allow_hyphen_values = true)]
    pub content: Option<String>,
    /// Correction method of the outputs: fragment, table, mesh, cube-mesh, vertex or primitive, for
    /// example mesh,max_error=0.1
    #[arg(long, value_name = "METHOD[,KEY=NUMBER]")]
    pub(super) method: Option<String>,
    /// Use the resolution of each output for captures, independent of the window size
    #[arg(long)]
    pub(super) offscreen: bool,
    /// Publish the finished pictures of each frame to other programs, in shared memory [default
    /// file: /dev/shm/cupola-USER, with the number of the user]
    #[arg(long, value_name = "FILE", num_args = 0..=1, require_equals = true, default_missing_value = "")]
    pub publish: Option<PathBuf>,
    /// True if the program waits for the readers of its pictures, and ends with this command.
    #[arg(skip)]
    pub waits_for_readers: bool,
    /// Nanoseconds of the program's time after its first frame, before which no other frame is
    /// published.
    #[arg(skip)]
    pub published_from: Option<u64>,
    /// True if the published pictures have 16 bits for each colour.
    #[arg(skip)]
    pub deep_pictures: bool,
    /// Number of this machine among several, as `NUMBER/COUNT`, and the page through which its
    /// frames are released.
    #[arg(skip)]
    pub node: Option<(String, PathBuf)>,
    /// Number of this machine among several, as `NUMBER/COUNT`, if the others show its pictures.
    #[arg(skip)]
    pub mirrored: Option<String>,
    /// The program's standard input is empty.
    #[arg(skip)]
    pub without_input: bool,
    /// Publish a domemaster of N × N pixels that is drawn beside the window
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=16384))]
    pub(super) domemaster: Option<u32>,
    /// Leave out flat drawing, such as menus and text
    #[arg(long)]
    pub(super) no_overlay: bool,
    /// Draw everything in every view (no culling)
    #[arg(long)]
    pub(super) no_cull: bool,
    /// Also draw the parts of views that no output samples
    #[arg(long)]
    pub(super) no_mask: bool,
    /// Do not use the cache of results on disk
    #[arg(long)]
    pub(super) no_cache: bool,
    /// Draw scenes that the program renders to textures once per view [default: from the rig]
    #[arg(long, value_name = "auto|never|always|in-turn", value_parser = ["auto", "never", "always", "in-turn"])]
    pub(super) duplicate: Option<String>,
    /// Also write Cupola's messages to a file
    #[arg(long, value_name = "FILE")]
    pub(super) log: Option<PathBuf>,
    #[command(flatten)]
    pub clock: clock::Options,
}

impl Options {
    /// Name or path of the rig.
    pub(super) fn rig_name(&self) -> String {
        self.rig.clone().or_else(|| std::env::var("CUPOLA_RIG").ok()).unwrap_or_else(|| "fisheye".into())
    }

    /// Name or path of the requested profile, or `none`.
    pub(super) fn profile_name(&self) -> Option<String> {
        self.profile.clone().or_else(|| std::env::var("CUPOLA_PROFILE").ok())
    }

    /// The requested profile, or the one for the program of this name.
    pub(super) fn profile(&self, program: Option<&OsString>) -> Result<Option<Chosen>, Failure> {
        let profiles = Profiles::read(process::profile_folder().as_deref());
        match (self.profile_name().as_deref(), program) {
            (Some("none"), _) => Ok(None),
            (Some(name), _) => Ok(Some(profiles.load(name)?)),
            (None, None) => Ok(None),
            (None, Some(program)) => {
                for error in profiles.errors() {
                    eprintln!("cupola: a profile is left out: {error}");
                }
                let name = Path::new(program).file_name().unwrap_or_default();
                Ok(profiles.choose(&name.to_string_lossy(), &[]))
            }
        }
    }

    /// The rig with the replacements of the options.
    pub fn rig(&self) -> Result<Rig, Failure> {
        self.rig_with(self.profile(None)?.as_ref())
    }

    /// The rig with the additions of a profile and the replacements of the options.
    pub(super) fn rig_with(&self, profile: Option<&Chosen>) -> Result<Rig, Failure> {
        let overrides = Overrides {
            camera: self.camera.clone(),
            viewer: self.viewer.clone(),
            content: self.content.clone(),
            method: self.method.clone(),
        };
        let defaults = profile.map_or_else(Defaults::default, |chosen| chosen.profile.defaults);
        Ok(overrides.apply(cupola::rig::load_with(&self.rig_name(), &defaults)?)?)
    }

    /// The rig with the outputs of this machine, if there are several machines.
    pub(super) fn on_this_node(&self, rig: Rig) -> Result<Rig, Failure> {
        let place = self.node.as_ref().map(|(place, _)| place).or(self.mirrored.as_ref());
        let place = place.and_then(|place| Place::parse(place, system::host_name()));
        Ok(place.map_or(Ok(rig.clone()), |place| rig.on_node(&place))?)
    }

    /// File of published pictures, if there are any to publish.
    pub fn published(&self, rig: &Rig) -> Result<Option<OsString>, Failure> {
        let environment = || std::env::var_os("CUPOLA_PUBLISH").filter(|file| !file.is_empty() && file != "1");
        let file = match &self.publish {
            Some(file) if !file.as_os_str().is_empty() => Some(writable_file(file)?),
            Some(_) => Some(ring::default_path().into()),
            None if self.domemaster.is_some() || self.mirrored.is_some() || rig.publishes() => {
                Some(environment().unwrap_or_else(|| ring::default_path().into()))
            }
            None => None,
        };
        Ok(file.filter(|file| file != "0"))
    }
}

/// Parses a number of seconds above 0, such as `2.5`.
fn seconds(text: &str) -> Result<Duration, String> {
    let parsed = text.parse().ok().and_then(|seconds| Duration::try_from_secs_f64(seconds).ok());
    parsed
        .filter(|seconds| !seconds.is_zero() && seconds.as_secs() < 100_000_000)
        .ok_or_else(|| "expected a number of seconds above 0, for example 2.5".to_owned())
}

/// Parses a number of frames.
fn frames(text: &str) -> Result<u64, String> {
    text.parse()
        .ok()
        .filter(|count| *count > 0)
        .ok_or_else(|| "expected a whole number above 0, for example 60".to_owned())
}
