//! `cupola run`: starts a program with Cupola between the program and its graphics driver.

use crate::display;
use crate::failure::Failure;
use crate::launch::{Environment, apply, clock, loader};
use crate::own_windows;
use cupola::rig::{Chosen, Defaults, Overrides, Place, Profile, Profiles, Rig};
use cupola::ring;
use cupola::system;
use cupola::system::process::{self, Ended};
use std::ffi::OsString;
use std::os::unix::process::ExitStatusExt;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode, Stdio};
use std::time::{Duration, SystemTime};

/// Time in which a program may present one more frame after its limit.
const FOR_THE_LAST_FRAME: Duration = Duration::from_secs(2);

/// Time after which a frame is inspected, if the user requests no other.
const UNTIL_INSPECTED: Duration = Duration::from_secs(10);

/// Run an OpenGL or Vulkan program on a dome.
#[derive(clap::Args)]
#[command(
    after_help = "All arguments after PROGRAM are passed to the program. With CUPOLA=0 in the environment the program runs without Cupola."
)]
pub struct Arguments {
    #[command(flatten)]
    pub options: Options,
    /// Also serve a page with the dome and the keys of the rig, as `cupola serve` does
    #[arg(long, conflicts_with = "print_environment")]
    serve: bool,
    /// Print the environment as shell commands and do not start a program
    #[arg(long)]
    print_environment: bool,
    /// Program and its arguments
    #[arg(trailing_var_arg = true, required_unless_present = "print_environment")]
    program: Vec<OsString>,
}

/// Options of every subcommand that starts a program.
#[derive(clap::Args)]
#[group(skip)]
pub struct Options {
    /// Rig file or name of a preset [default: $CUPOLA_RIG, or fisheye]
    #[arg(long, short, value_name = "FILE|PRESET", overrides_with = "rig")]
    rig: Option<String>,
    /// Profile of the program: its name, a file, or none [default: the one for the program's name,
    /// or for its libraries]
    #[arg(long, value_name = "NAME|FILE|none")]
    profile: Option<String>,
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
    camera: Option<String>,
    /// Change the viewer's position and orientation, for example
    /// position=0,-0.5,1,yaw=90,pitch=0,roll=0
    #[arg(long, value_name = "KEY=NUMBER,…", allow_hyphen_values = true)]
    viewer: Option<String>,
    /// The window already shows a projected picture: domemaster, equirectangular, cylindrical,
    /// cubemap or flat, for example domemaster,aperture=180
    #[arg(long, value_name = "KIND[,KEY=VALUE,…]", allow_hyphen_values = true)]
    pub content: Option<String>,
    /// Correction method of the outputs: fragment, table, mesh, cube-mesh, vertex or primitive, for
    /// example mesh,max_error=0.1
    #[arg(long, value_name = "METHOD[,KEY=NUMBER]")]
    method: Option<String>,
    /// Use the resolution of each output for captures, independent of the window size
    #[arg(long)]
    offscreen: bool,
    /// Publish the finished pictures of each frame to other programs, in shared memory [default
    /// file: /dev/shm/cupola-USER, with the number of the user]
    #[arg(long, value_name = "FILE", num_args = 0..=1, require_equals = true, default_missing_value = "")]
    pub publish: Option<PathBuf>,
    /// True if the program waits for the readers of its pictures, and ends with this command.
    #[arg(skip)]
    pub waits_for_readers: bool,
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
    domemaster: Option<u32>,
    /// Draw everything in every view (no culling)
    #[arg(long)]
    no_cull: bool,
    /// Also draw the parts of views that no output samples
    #[arg(long)]
    no_mask: bool,
    /// Do not use the cache of results on disk
    #[arg(long)]
    no_cache: bool,
    /// Draw scenes that the program renders to textures once per view [default: from the rig]
    #[arg(long, value_name = "auto|never|always|in-turn", value_parser = ["auto", "never", "always", "in-turn"])]
    duplicate: Option<String>,
    /// Also write Cupola's messages to a file
    #[arg(long, value_name = "FILE")]
    log: Option<PathBuf>,
    #[command(flatten)]
    pub clock: clock::Options,
}

/// Requests of `cupola inspect` in addition to the options of `run`.
pub struct Inspection {
    /// Path of the page.
    pub output: PathBuf,
}

/// Runs the subcommand. Returns the exit code of the program.
pub fn run(arguments: Arguments) -> Result<ExitCode, Failure> {
    if arguments.serve {
        // Mistakes are reported before anything starts.
        let profile = arguments.options.profile(arguments.program.first())?;
        arguments.options.environment(profile.as_ref(), None)?;
        let given: Vec<OsString> = std::env::args_os().skip(2).collect();
        let options = own_options(&given, arguments.program.len());
        return crate::serve::run_with(arguments.options.rig_name(), options, &arguments.program);
    }
    run_and_inspect(arguments, None)
}

/// Options of `run --serve` before the program that a run without the page has too.
fn own_options(given: &[OsString], program: usize) -> Vec<OsString> {
    let before = &given[..given.len().saturating_sub(program)];
    before.iter().filter(|argument| *argument != "--serve" && *argument != "--").cloned().collect()
}

/// Runs the subcommand, with a page about the last frame if one is requested. Returns the exit code
/// of the program.
pub fn run_and_inspect(mut arguments: Arguments, inspection: Option<Inspection>) -> Result<ExitCode, Failure> {
    if inspection.is_some() && arguments.options.frames.is_none() {
        arguments.options.seconds = arguments.options.seconds.or(Some(UNTIL_INSPECTED));
    }
    if arguments.print_environment {
        let profile = arguments.options.profile(arguments.program.first())?;
        let mut environment = arguments.options.environment(profile.as_ref(), inspection.as_ref())?;
        environment.extend(loader::Loader::persistent()?.environment(&Vec::new())?);
        print_environment(&environment, profile.as_ref());
        return Ok(ExitCode::SUCCESS);
    }
    start(arguments.options, &arguments.program, inspection)
}

/// Exit code for a program that has ended, as in a shell.
fn exit_code(ended: &Ended) -> i32 {
    match ended {
        Ended::Stopped => 0,
        Ended::ByItself(status) => status.code().or_else(|| status.signal().map(|signal| 128 + signal)).unwrap_or(1),
    }
}

/// Command that starts `program` with these options, without its environment.
fn command(program: &OsString, given: &[OsString], options: &Options, switched_off: bool) -> Command {
    let mut command = Command::new(program);
    command.args(given);
    if options.clock.clock.is_some() && !switched_off {
        process::with_fixed_addresses(&mut command);
    }
    if options.waits_for_readers {
        process::end_with_parent(&mut command);
    }
    if options.without_input {
        command.stdin(Stdio::null());
    }
    if options.node.is_some() {
        process::without_broken_pipes(&mut command);
    }
    command
}

/// Starts a program. Returns its exit code.
pub fn start(mut options: Options, program: &[OsString], inspection: Option<Inspection>) -> Result<ExitCode, Failure> {
    let switched_off = std::env::var_os("CUPOLA").is_some_and(|value| value == "0");
    let (program, given) = program.split_first().ok_or_else(|| Failure::usage("no program was given"))?;
    let profile = options.profile(Some(program))?;
    let rig = options.rig_with(profile.as_ref())?;
    if options.headless && options.size.is_none() && !options.offscreen {
        // Without a screen no window manager enlarges the window for the outputs.
        options.size = rig.extent();
    }
    let mut environment = options.environment(profile.as_ref(), inspection.as_ref())?;
    let scratch = loader::Scratch::new()?;
    let size = options.size.unwrap_or((1920, 1200));
    let server = options.headless.then(|| display::Server::start(size, scratch.path())).transpose()?;
    let display = server.as_ref().map_or_else(Vec::new, display::Server::environment);
    if switched_off {
        environment.clear();
    } else {
        environment.extend(loader::Loader::temporary(scratch.path())?.environment(&display)?);
    }
    environment.extend(display.clone());

    let mut command = command(program, given, &options, switched_off);
    if let Some(chosen) = profile.filter(|_| !switched_off) {
        eprintln!("cupola: {}", chosen.description());
        command.envs(variables(&chosen));
    }
    apply(&mut command, &environment);
    let expected = Expected::new(&options, inspection.as_ref());
    let published = environment.iter().find(|(name, _)| *name == "CUPOLA_PUBLISH").and_then(|(_, file)| file.clone());
    if let Some(file) = published.as_deref().map(Path::new).filter(|_| !options.waits_for_readers) {
        eprintln!("cupola: finished pictures are published in {}", file.display());
    }
    let windows = match published.as_deref().filter(|_| !options.waits_for_readers && !switched_off) {
        Some(file) => own_windows::Windows::open(&options.on_this_node(rig)?, Path::new(file), &display),
        None => own_windows::Windows::default(),
    };
    // The library ends the program in a frame; only a program that draws none has to be stopped.
    let limit = options.seconds.map(|seconds| seconds + FOR_THE_LAST_FRAME);
    let ended = process::run_in_foreground(&mut command, limit).map_err(|error| cannot_start(program, &error))?;
    windows.close();
    if let Some(file) = &published {
        // A program that was killed leaves the file behind.
        ring::remove_if_ended(Path::new(file));
    }
    let code = exit_code(&ended);
    if code == 0 && !switched_off {
        expected.check(&options)?;
    }
    if let Some(Inspection { output }) = inspection.filter(|page| expected.missing().all(|file| file != page.output)) {
        eprintln!("cupola: the page is in {}", output.display());
    }
    Ok(ExitCode::from(u8::try_from(code).unwrap_or(1)))
}

impl Options {
    /// Name or path of the rig.
    fn rig_name(&self) -> String {
        self.rig.clone().or_else(|| std::env::var("CUPOLA_RIG").ok()).unwrap_or_else(|| "fisheye".into())
    }

    /// Name or path of the requested profile, or `none`.
    fn profile_name(&self) -> Option<String> {
        self.profile.clone().or_else(|| std::env::var("CUPOLA_PROFILE").ok())
    }

    /// The requested profile, or the one for the program of this name.
    fn profile(&self, program: Option<&OsString>) -> Result<Option<Chosen>, Failure> {
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
    fn rig_with(&self, profile: Option<&Chosen>) -> Result<Rig, Failure> {
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
    fn on_this_node(&self, rig: Rig) -> Result<Rig, Failure> {
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

    /// Environment variables that configure the library.
    fn environment(&self, profile: Option<&Chosen>, inspection: Option<&Inspection>) -> Result<Environment, Failure> {
        // Wrong options are reported before anything starts.
        let rig = self.rig_with(profile)?;
        let mut environment = settings(self, &self.rig_name())?;
        let name = profile_variable(self.profile_name(), profile);
        environment.extend(name.map(|name| ("CUPOLA_PROFILE", Some(name))));
        environment.extend(self.published(&rig)?.map(|file| ("CUPOLA_PUBLISH", Some(file))));
        environment.extend(self.waits_for_readers.then(|| ("CUPOLA_PUBLISH_WAIT", Some("1".into()))));
        environment.extend(self.clock.environment()?);
        if let Some((place, page)) = &self.node {
            environment.push(("CUPOLA_NODE", Some(place.into())));
            environment.push(("CUPOLA_NODE_PAGE", Some(page.into())));
        }
        if let Some(place) = &self.mirrored {
            environment.push(("CUPOLA_NODE", Some(place.into())));
            environment.push(("CUPOLA_MIRRORS", Some("1".into())));
        }
        if let Some(Inspection { output }) = inspection {
            environment.push(("CUPOLA_INSPECT", Some(writable_file(output)?)));
        }
        Ok(environment)
    }
}

/// Value of the variable that names the profile to the library: `none`, a name or a path; not set
/// if the library has to choose.
fn profile_variable(given: Option<String>, profile: Option<&Chosen>) -> Option<OsString> {
    match profile.map(|chosen| &chosen.profile) {
        Some(Profile { file: Some(file), .. }) => Some(file.into()),
        Some(profile) => Some((&profile.name).into()),
        None => given.map(Into::into),
    }
}

/// Environment variables of a profile. Those that the user has set stay.
fn variables(chosen: &Chosen) -> impl Iterator<Item = (&str, &str)> {
    let variables = chosen.profile.environment.iter().map(|(name, value)| (name.as_str(), value.as_str()));
    variables.filter(|(name, _)| std::env::var_os(name).is_none())
}

/// A file, with its time and length, which show whether it was written again.
type Stamp = (PathBuf, SystemTime, u64);

/// Files that exist for `file` now; for a capture of several outputs all that have its name.
fn stamps(file: &Path, several: bool) -> Vec<Stamp> {
    let stem = format!("{}-", file.file_stem().unwrap_or_default().to_string_lossy());
    let folder = file.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten().filter(|_| several);
    let others = entries.filter(|entry| entry.file_name().to_string_lossy().starts_with(&stem));
    let files = std::iter::once(file.to_owned()).chain(others.map(|entry| entry.path()));
    let stamp = |path: PathBuf| {
        let data = std::fs::metadata(&path).ok()?;
        Some((path, data.modified().ok()?, data.len()))
    };
    files.filter_map(stamp).collect()
}

/// Requested files, with the state before the program started.
struct Expected(Vec<(PathBuf, bool, Vec<Stamp>)>);

impl Expected {
    fn new(arguments: &Options, inspection: Option<&Inspection>) -> Self {
        let page = inspection.map(|inspection| (&inspection.output, false));
        let capture = arguments.capture.as_ref().map(|file| (file, true));
        let statistics = arguments.stats.as_ref().map(|file| (file, false));
        let files = [capture, statistics, page].into_iter().flatten();
        Self(files.map(|(file, several)| (file.clone(), several, stamps(file, several))).collect())
    }

    /// Files that were not written. One picture is enough for several outputs.
    fn missing(&self) -> impl Iterator<Item = &Path> {
        let is_written = |file: &Path, several: bool, before: &[Stamp]| {
            stamps(file, several).iter().any(|stamp| !before.contains(stamp))
        };
        self.0.iter().filter(move |(file, several, before)| !is_written(file, *several, before)).map(|file| &*file.0)
    }

    /// Fails if one of the files was not written.
    fn check(&self, arguments: &Options) -> Result<(), Failure> {
        let Some(file) = self.missing().next() else { return Ok(()) };
        let frames = arguments.frames.map_or_else(|| "no frame".to_owned(), |n| format!("fewer than {n} frames"));
        Err(Failure::new(format!(
            "{} was not written: the program presented {frames} with OpenGL or Vulkan in time, or Cupola left it alone \
             (see the messages above, and cupola doctor)",
            file.display()
        )))
    }
}

/// Environment variables that configure the library.
fn settings(arguments: &Options, rig: &str) -> Result<Environment, Failure> {
    let is_preset = cupola::rig::presets().iter().any(|preset| preset.name == rig);
    let rig = if is_preset { rig.into() } else { absolute(Path::new(rig))? };
    let mut environment: Environment = vec![("CUPOLA_RIG", Some(rig))];
    let mut set = |name, value: Option<OsString>| environment.extend(value.map(|value| (name, Some(value))));
    set("CUPOLA_CAMERA", arguments.camera.as_ref().map(Into::into));
    set("CUPOLA_VIEWER", arguments.viewer.as_ref().map(Into::into));
    set("CUPOLA_CONTENT", arguments.content.as_ref().map(Into::into));
    set("CUPOLA_METHOD", arguments.method.as_ref().map(Into::into));
    set("CUPOLA_SIZE", arguments.size.map(|(width, height)| format!("{width}x{height}").into()));
    set("CUPOLA_FRAMES", arguments.frames.map(|frames| frames.to_string().into()));
    set("CUPOLA_SECONDS", arguments.seconds.map(|seconds| seconds.as_secs_f64().to_string().into()));
    set("CUPOLA_OFFSCREEN", arguments.offscreen.then(|| "1".into()));
    set("CUPOLA_DOMEMASTER", arguments.domemaster.map(|side| side.to_string().into()));
    set("CUPOLA_DUPLICATE", arguments.duplicate.as_ref().map(Into::into));
    set("CUPOLA_CULL", arguments.no_cull.then(|| "0".into()));
    set("CUPOLA_MASK", arguments.no_mask.then(|| "0".into()));
    set("CUPOLA_CACHE", arguments.no_cache.then(|| "0".into()));
    let files =
        [("CUPOLA_CAPTURE", &arguments.capture), ("CUPOLA_STATS", &arguments.stats), ("CUPOLA_LOG", &arguments.log)];
    let ending = arguments.capture.as_deref().and_then(Path::extension);
    if ending.is_some_and(|ending| !ending.eq_ignore_ascii_case("png")) {
        return Err(Failure::usage("--capture: captures are PNG pictures; expected a name that ends in .png"));
    }
    for (name, file) in files {
        set(name, file.as_deref().map(writable_file).transpose()?);
    }
    if let Some(folder) = &arguments.capture_views {
        std::fs::create_dir_all(folder)
            .map_err(|error| Failure::usage(format!("the folder {} cannot be created: {error}", folder.display())))?;
        set("CUPOLA_CAPTURE_VIEWS", Some(absolute(folder)?));
    }
    Ok(environment)
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

/// Absolute path of a file to be written. Fails if its folder does not exist, or if it is a folder.
fn writable_file(file: &Path) -> Result<OsString, Failure> {
    let path = PathBuf::from(absolute(file)?);
    match path.parent().filter(|folder| folder.is_dir()) {
        Some(_) if path.is_dir() => {
            Err(Failure::usage(format!("{} is a folder; expected the name of a file", file.display())))
        }
        Some(_) => Ok(path.into()),
        None => Err(Failure::usage(format!("{}: the folder of this file does not exist", file.display()))),
    }
}

fn absolute(path: &Path) -> Result<OsString, Failure> {
    let absolute = std::path::absolute(path).map_err(|error| Failure::usage(format!("{}: {error}", path.display())))?;
    Ok(absolute.into())
}

/// Failure for a program that cannot be started, with the exit code of a shell.
fn cannot_start(program: &OsString, error: &std::io::Error) -> Failure {
    let name = program.to_string_lossy();
    match error.kind() {
        std::io::ErrorKind::NotFound => Failure { message: format!("{name}: command not found"), code: 127 },
        _ => Failure { message: format!("{name}: cannot be started: {error}"), code: 126 },
    }
}

/// Prints commands for a POSIX shell.
fn print_environment(environment: &Environment, profile: Option<&Chosen>) {
    let export = |name: &str, value: &str| println!("export {name}='{}'", value.replace('\'', r"'\''"));
    for (name, value) in environment {
        match value {
            Some(value) => export(name, &value.to_string_lossy()),
            None => println!("unset {name}"),
        }
    }
    for (name, value) in profile.into_iter().flat_map(variables) {
        export(name, value);
    }
}
