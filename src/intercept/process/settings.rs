//! Settings of the injected library, from the environment.

use super::file_stamp::{FileStamp, text_sum_of};
use super::{clock, log};
use crate::error::{Error, ErrorKind};
use crate::rig::{self, Chosen, Defaults, Duplicate, Overrides, Place, Profiles, Rig};
use crate::ring;
use crate::system::{host_name, is_privileged, process, variable};
use std::path::{Path, PathBuf};
use std::sync::OnceLock;
use std::time::{Duration, Instant};

/// The settings of this process.
#[derive(Clone, Debug)]
pub struct Settings {
    /// The rig at the start (`CUPOLA_RIG`, preset or file; `fisheye` if unset). Keys of the profile
    /// and `CUPOLA_CAMERA`, `CUPOLA_VIEWER`, `CUPOLA_CONTENT`, `CUPOLA_METHOD` and
    /// `CUPOLA_DUPLICATE` are applied. [`crate::intercept::process::live::rig`] returns the current rig.
    pub rig: Rig,
    /// The rig's file as an absolute path, since programs change their folder; `None` for a preset.
    pub rig_file: Option<PathBuf>,
    /// Stamp of that file before it was read.
    pub rig_stamp: Option<FileStamp>,
    /// Checksum of its text; 0: there is no file.
    pub rig_sum: u64,
    /// `CUPOLA_CAMERA`, `CUPOLA_VIEWER`, `CUPOLA_CONTENT`, `CUPOLA_METHOD`.
    overrides: Overrides,
    /// `CUPOLA_DUPLICATE`.
    duplicate: Option<Duplicate>,
    /// The profile: `CUPOLA_PROFILE` (name, file or `none`), else the profile for the program's
    /// name or for one of its libraries.
    pub profile: Option<Chosen>,
    /// `CUPOLA_SIZE=WxH`: the program's window is given this size.
    pub window_size: Option<(u32, u32)>,
    /// `CUPOLA_FRAMES=N`: the program ends after its N-th presented frame.
    pub frames: Option<u64>,
    /// `CUPOLA_SECONDS=N`: the program ends after the first frame that is presented N seconds or
    /// more after the start.
    end: Option<Instant>,
    /// `CUPOLA_CAPTURE=FILE.png`: the last corrected frame of each output.
    pub capture: Option<PathBuf>,
    /// `CUPOLA_CAPTURE_VIEWS=DIR`: every view of the last frame.
    pub capture_views: Option<PathBuf>,
    /// `CUPOLA_INSPECT=FILE.html`: a page that describes the last frame.
    pub inspect: Option<PathBuf>,
    /// `CUPOLA_STATS=FILE.json`.
    pub stats: Option<PathBuf>,
    /// `CUPOLA_STATS_EVERY=SECONDS`: the statistics are also written while the program runs.
    pub stats_every: Option<Duration>,
    /// `CUPOLA_OFFSCREEN=1`: outputs at their own resolution, for captures only.
    pub offscreen: bool,
    /// False for `CUPOLA_OVERLAY=0`: flat drawing is left out.
    pub overlay: bool,
    /// `CUPOLA_PUBLISH=FILE` (`1`: the default file; `0`: none): finished pictures for other
    /// processes. Without the variable, pictures are published if the rig says so.
    pub publish: Option<PathBuf>,
    /// `CUPOLA_PUBLISH_WAIT=1`: the program waits for the readers, which then lose no picture.
    pub publish_waits: bool,
    /// `CUPOLA_PUBLISH_FROM=N`: the first frame is published, and those that come N nanoseconds of
    /// the program's time after it, or later.
    pub publish_from: u64,
    /// `CUPOLA_PUBLISH_DEPTH=16`: the published pictures have 16 bits for each colour.
    pub publish_deep: bool,
    /// `CUPOLA_PUBLISH_RATE=N`: at most N frames a second are published. The field holds the least
    /// time between two frames, in nanoseconds; 0: all frames are published.
    pub publish_interval: u64,
    /// `CUPOLA_DOMEMASTER=SIDE`: one more output outside of the window, to be published.
    domemaster: Option<u32>,
    /// `CUPOLA_NODE=NUMBER/COUNT`: number of this machine among several.
    place: Option<Place>,
    /// `CUPOLA_MIRRORS=1`: this machine also draws the outputs of the others.
    has_mirrors: bool,
    /// `CUPOLA_NODE_PAGE=FILE`: file through which `cupola node` lets the program continue.
    pub node_page: Option<PathBuf>,
    /// `CUPOLA_MASK`: whether the unsampled areas of views are masked out.
    pub mask: Mask,
    /// Whether draws are left out of views that cannot show them; `CUPOLA_CULL=0` switches that
    /// off.
    pub cull: bool,
    /// `CUPOLA_CULL=all`: also leaves out draws of few vertices, though that saves little (Vulkan).
    pub cull_all: bool,
}

/// `CUPOLA_MASK`: masking unsampled areas costs a little time in each frame, and saves shading.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mask {
    /// `auto` (default): where the unsampled areas are large enough.
    Auto,
    /// `1`: always.
    Always,
    /// `0`: never.
    Never,
}

/// True if Cupola must not touch any call: with `CUPOLA=0`, and always in a program with more
/// rights than its user.
pub fn switched_off() -> bool {
    is_privileged() || variable("CUPOLA").is_some_and(|v| v == "0")
}

/// Returns the settings; `None` if they are wrong, which the log reports. The program is then left
/// alone.
pub fn settings() -> Option<&'static Settings> {
    static SETTINGS: OnceLock<Option<Settings>> = OnceLock::new();
    SETTINGS
        .get_or_init(|| match read() {
            Ok(settings) => Some(settings),
            Err(error) => {
                log::once(&format!("switched off: {error}"));
                None
            }
        })
        .as_ref()
}

fn read() -> crate::Result<Settings> {
    if is_privileged() {
        return Err(Error::new(ErrorKind::InvalidState, "the program has more rights than its user"));
    }
    let name = text("CUPOLA_RIG").unwrap_or_else(|| "fisheye".to_owned());
    let is_preset = rig::presets().iter().any(|preset| preset.name == name);
    let rig_file = (!is_preset).then(|| std::path::absolute(&name).ok()).flatten();
    let rig_stamp = rig_file.as_deref().and_then(FileStamp::of);
    let rig_sum = rig_file.as_deref().map_or(0, text_sum_of);
    let overrides = Overrides {
        camera: text("CUPOLA_CAMERA"),
        viewer: text("CUPOLA_VIEWER"),
        content: text("CUPOLA_CONTENT"),
        method: text("CUPOLA_METHOD"),
    };
    let duplicate = parsed("CUPOLA_DUPLICATE", "never", parse_duplicate)?;
    let domemaster = parsed("CUPOLA_DOMEMASTER", "1024", parse_side)?;
    let place = parsed("CUPOLA_NODE", "0/2", |n| Place::parse(n, host_name()))?;
    let has_mirrors = text("CUPOLA_MIRRORS").is_some_and(|v| v == "1");
    let profile = profile(text("CUPOLA_PROFILE").as_deref())?;
    let shared = (place.as_ref(), has_mirrors);
    let rig = loaded(Path::new(&name), profile.as_ref(), &overrides, (duplicate, domemaster), shared)?;
    Ok(Settings {
        publish: publish_path(&rig),
        publish_interval: parsed("CUPOLA_PUBLISH_RATE", "30", parse_interval)?.unwrap_or(0),
        publish_waits: text("CUPOLA_PUBLISH_WAIT").is_some_and(|v| v == "1"),
        publish_from: parsed("CUPOLA_PUBLISH_FROM", "1000000000", |n| n.parse().ok())?.unwrap_or(0),
        publish_deep: parsed("CUPOLA_PUBLISH_DEPTH", "16", parse_depth)?.unwrap_or(false),
        domemaster,
        place,
        has_mirrors,
        node_page: path("CUPOLA_NODE_PAGE"),
        rig,
        profile,
        rig_file,
        rig_stamp,
        rig_sum,
        overrides,
        duplicate,
        window_size: parsed("CUPOLA_SIZE", "1024x768", parse_size)?,
        frames: parsed("CUPOLA_FRAMES", "100", |n| n.parse().ok().filter(|n| *n > 0))?,
        end: parsed("CUPOLA_SECONDS", "10", parse_seconds)?,
        capture: path("CUPOLA_CAPTURE"),
        capture_views: path("CUPOLA_CAPTURE_VIEWS"),
        inspect: path("CUPOLA_INSPECT"),
        stats: path("CUPOLA_STATS"),
        stats_every: parsed("CUPOLA_STATS_EVERY", "1", parse_length)?,
        overlay: text("CUPOLA_OVERLAY").is_none_or(|v| v != "0"),
        offscreen: text("CUPOLA_OFFSCREEN").is_some_and(|v| v == "1"),
        mask: parsed("CUPOLA_MASK", "0", parse_mask)?.unwrap_or(Mask::Auto),
        cull: text("CUPOLA_CULL").is_none_or(|v| v != "0"),
        cull_all: text("CUPOLA_CULL").is_some_and(|v| v == "all"),
    })
}

/// Returns a variable of the environment; `None` if it is unset, empty or not Unicode.
fn text(name: &str) -> Option<String> {
    variable(name)?.into_string().ok().filter(|value| !value.is_empty())
}

/// Returns a variable that names a file or folder; `None` if it is unset or empty.
fn path(name: &str) -> Option<PathBuf> {
    variable(name).filter(|value| !value.is_empty()).map(PathBuf::from)
}

/// Returns a variable as `parse` reads it. If `parse` refuses the value, the error gives `example`.
fn parsed<T>(name: &str, example: &str, parse: impl FnOnce(&str) -> Option<T>) -> crate::Result<Option<T>> {
    let Some(value) = text(name) else { return Ok(None) };
    parse(&value).map(Some).ok_or_else(|| wrong(name, &value, example))
}

/// Parses a number of bits. Returns whether it is 16.
fn parse_depth(text: &str) -> Option<bool> {
    match text {
        "8" => Some(false),
        "16" => Some(true),
        _ => None,
    }
}

/// Returns the file of the published frames; `None` if none are published.
fn publish_path(rig: &Rig) -> Option<PathBuf> {
    match path("CUPOLA_PUBLISH") {
        Some(path) if path == Path::new("0") => None,
        Some(path) if path != Path::new("1") => Some(std::path::absolute(&path).unwrap_or(path)),
        None if !rig.publishes() => None,
        _ => Some(ring::default_path()),
    }
}

impl Settings {
    /// True if somebody looks at the pictures of this process as they come, for example on the page
    /// of `cupola serve`. With a virtual clock they are recorded, and have to be exact.
    pub fn is_watched(&self) -> bool {
        self.publish.is_some() && self.publish_interval > 0 && !self.publish_waits && clock::time().is_none()
    }

    /// True if the program has run for the requested time.
    pub fn is_time_over(&self) -> bool {
        self.end.is_some_and(|end| Instant::now() >= end)
    }

    /// Returns the number of this machine among several; 0 for a single machine.
    pub fn node(&self) -> u32 {
        self.place.as_ref().map_or(0, |place| place.number)
    }

    /// True if something is written when the program ends.
    pub fn has_report(&self) -> bool {
        self.needs_statistics() || self.capture.is_some() || self.capture_views.is_some()
    }

    /// True if statistics are needed: for `--stats` or for `cupola inspect`.
    pub fn needs_statistics(&self) -> bool {
        self.stats.is_some() || self.inspect.is_some()
    }

    /// Reads the rig's file again and applies the environment variables of the start.
    pub fn load(&self) -> crate::Result<Rig> {
        match &self.rig_file {
            Some(file) => {
                let replaced = (self.duplicate, self.domemaster);
                let shared = (self.place.as_ref(), self.has_mirrors);
                loaded(file, self.profile.as_ref(), &self.overrides, replaced, shared)
            }
            None => Ok(self.rig.clone()),
        }
    }
}

/// Returns the profile of this process. `run` has chosen one by the name of the program that it
/// starts. The libraries of a program are known only here, so a profile chosen by a library is
/// reported here.
fn profile(given: Option<&str>) -> crate::Result<Option<Chosen>> {
    let profiles = Profiles::read(process::profile_folder().as_deref());
    let chosen = match given {
        Some("none") => return Ok(None),
        Some(name) => return profiles.load(name).map(Some),
        None => profiles.choose(&process::program_name(), &process::loaded_libraries()),
    };
    if let Some(chosen) = &chosen {
        log::once(&chosen.description());
    }
    Ok(chosen)
}

/// Returns the rig of a preset or a file, with the keys that the profile adds and those that the
/// environment replaces.
fn loaded(
    name_or_path: &Path,
    profile: Option<&Chosen>,
    overrides: &Overrides,
    (duplicate, domemaster): (Option<Duplicate>, Option<u32>),
    (place, has_mirrors): (Option<&Place>, bool),
) -> crate::Result<Rig> {
    let defaults = profile.map_or_else(Defaults::default, |chosen| chosen.profile.defaults);
    let mut rig = overrides.apply(rig::load_with(&name_or_path.to_string_lossy(), &defaults)?)?;
    if let Some(duplicate) = duplicate {
        rig.views.duplicate = duplicate;
    }
    if let Some(side) = domemaster {
        rig = rig.with_domemaster(side);
    }
    if variable("CUPOLA_PUBLISH").is_some_and(|value| value == "0") {
        rig.beside.clear();
    }
    match place {
        Some(place) if has_mirrors => rig.with_mirrors(place),
        Some(place) => rig.on_node(place),
        None => Ok(rig),
    }
}

fn wrong(name: &str, value: &str, example: &str) -> crate::Error {
    crate::Error::new(
        crate::ErrorKind::InvalidArgument,
        format!("{name}={value}: not understood; expected, for example, {name}={example}"),
    )
}

/// Reads a number of seconds above 0. Returns the time at which they are over.
fn parse_seconds(text: &str) -> Option<Instant> {
    Instant::now().checked_add(parse_length(text)?)
}

/// Reads a number of seconds above 0.
fn parse_length(text: &str) -> Option<Duration> {
    Duration::try_from_secs_f64(text.parse().ok()?).ok().filter(|seconds| !seconds.is_zero())
}

/// Reads a size: `1024x768` → (1024, 768); each number is 1…16384.
fn parse_size(text: &str) -> Option<(u32, u32)> {
    let (width, height) = text.split_once('x')?;
    let (width, height) = (width.parse().ok()?, height.parse().ok()?);
    let fits = |n: u32| (1..=16384).contains(&n);
    (fits(width) && fits(height)).then_some((width, height))
}

/// Reads the side of a picture in pixels, 1…16384.
fn parse_side(text: &str) -> Option<u32> {
    text.parse().ok().filter(|side| (1..=16384).contains(side))
}

fn parse_mask(text: &str) -> Option<Mask> {
    match text {
        "auto" => Some(Mask::Auto),
        "0" => Some(Mask::Never),
        "1" => Some(Mask::Always),
        _ => None,
    }
}

fn parse_duplicate(text: &str) -> Option<Duplicate> {
    match text {
        "auto" => Some(Duplicate::Auto),
        "never" => Some(Duplicate::Never),
        "always" => Some(Duplicate::Always),
        "in-turn" => Some(Duplicate::InTurn),
        _ => None,
    }
}

/// Returns the nanoseconds between frames at a rate per second, which is above 0 and at most 1000.
fn parse_interval(rate: &str) -> Option<u64> {
    let rate: f64 = rate.parse().ok().filter(|rate| *rate > 0.0 && *rate <= 1000.0)?;
    Some((1e9 / rate) as u64)
}

#[cfg(test)]
mod tests {
    use super::{parse_seconds, parse_size};
    use std::time::{Duration, Instant};

    #[test]
    fn sizes() {
        assert_eq!(parse_size("1024x768"), Some((1024, 768)));
        for wrong in ["", "1024", "0x5", "5x-1", "axb", "99999x1"] {
            assert_eq!(parse_size(wrong), None, "{wrong}");
        }
    }

    #[test]
    fn seconds() {
        let before = Instant::now();
        let end = parse_seconds("2.5").expect("a number");
        assert!(end >= before + Duration::from_millis(2500) && end <= Instant::now() + Duration::from_millis(2500));
        for wrong in ["", "0", "-1", "nan", "inf", "1e300", "2s"] {
            assert_eq!(parse_seconds(wrong), None, "{wrong}");
        }
    }
}
