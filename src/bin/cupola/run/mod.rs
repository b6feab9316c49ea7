//! `cupola run`: starts a program with Cupola between the program and its graphics driver.

mod environment;
mod expected_files;
mod options;

use crate::display;
use crate::failure::Failure;
use crate::launch::{apply, loader};
use crate::serve::Ways;
use crate::window::opening;
use cupola::ring;
use cupola::system::process::{self, Ended};
use environment::{print_environment, variables};
use expected_files::Expected;
use std::ffi::OsString;
use std::os::unix::process::ExitStatusExt;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode, Stdio};
use std::time::Duration;

pub use options::Options;

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
    started: Started,
    /// Also serve a page with the dome and the keys of the rig, as `cupola serve` does
    #[arg(long, conflicts_with = "print_environment")]
    serve: bool,
    #[command(flatten)]
    ways: Ways,
}

/// What is started, also by `cupola inspect`.
#[derive(clap::Args)]
#[group(skip)]
pub struct Started {
    #[command(flatten)]
    options: Options,
    /// Print the environment as shell commands and do not start a program
    #[arg(long, conflicts_with = "pause")]
    print_environment: bool,
    /// Program and its arguments
    #[arg(trailing_var_arg = true, required_unless_present = "print_environment")]
    program: Vec<OsString>,
}

/// Requests of `cupola inspect` in addition to the options of `run`.
pub struct Inspection {
    /// Path of the page.
    pub output: PathBuf,
}

/// Runs the subcommand. Returns the exit code of the program.
pub fn run(arguments: Arguments) -> Result<ExitCode, Failure> {
    let Arguments { started, serve, ways } = arguments;
    if serve {
        let Started { options, program, .. } = started;
        // Mistakes are reported before anything starts.
        let profile = options.profile(program.first())?;
        options.environment(profile.as_ref(), None)?;
        let given: Vec<OsString> = std::env::args_os().skip(2).collect();
        let own = own_options(&given, program.len());
        return crate::serve::run_with(options.rig_name(), own, &program, &ways);
    }
    if !ways.is_default() {
        return Err(Failure::usage(format!("{} are options of the page; add --serve", Ways::OPTIONS.join(", "))));
    }
    run_and_inspect(started, None)
}

/// Options of `run --serve` before the program that a run without the page has too.
fn own_options(given: &[OsString], program: usize) -> Vec<OsString> {
    let mut before = given[..given.len().saturating_sub(program)].iter();
    let mut options = Vec::new();
    while let Some(argument) = before.next() {
        let text = argument.to_string_lossy();
        let of_the_page = Ways::OPTIONS.iter().find_map(|option| text.strip_prefix(option));
        match of_the_page {
            // The value is the next argument.
            Some("") => drop(before.next()),
            Some(rest) if rest.starts_with('=') => {}
            _ if text == "--serve" || text == "--" => {}
            _ => options.push(argument.clone()),
        }
    }
    options
}

/// Runs the subcommand, with a page about the last frame if one is requested. Returns the exit code
/// of the program.
pub fn run_and_inspect(mut arguments: Started, inspection: Option<Inspection>) -> Result<ExitCode, Failure> {
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
    let held = if switched_off || options.node.is_some() || options.waits_for_readers {
        None
    } else {
        options.clock.held()?
    };
    environment.extend(held.as_ref().map(|held| ("CUPOLA_CLOCK_PAGE", Some(held.path().into()))));

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
        Some(file) => opening::Windows::open(&options.on_this_node(rig)?, Path::new(file), &display),
        None => opening::Windows::default(),
    };
    // The library ends the program in a frame; only a program that draws none has to be stopped.
    let limit = options.seconds.map(|seconds| seconds + FOR_THE_LAST_FRAME);
    let ended = process::run_in_foreground(&mut command, limit).map_err(|error| cannot_start(program, &error))?;
    windows.close();
    drop(held);
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

/// Failure for a program that cannot be started, with the exit code of a shell.
fn cannot_start(program: &OsString, error: &std::io::Error) -> Failure {
    let name = program.to_string_lossy();
    match error.kind() {
        std::io::ErrorKind::NotFound => Failure { message: format!("{name}: command not found"), code: 127 },
        _ => Failure { message: format!("{name}: cannot be started: {error}"), code: 126 },
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_options_of_the_page_are_not_those_of_the_run() {
        let given = |line: &str| line.split(' ').map(OsString::from).collect::<Vec<_>>();
        let line = "--serve --size 640x400 --port 0 --osc=9000 --marks m.csv --headless -- app --port 3";
        assert_eq!(own_options(&given(line), 3), given("--size 640x400 --headless"));
    }
}
