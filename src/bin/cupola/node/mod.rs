//! `cupola node`: a program on several machines, each of which shows its own outputs of a rig.
//!
//! Every machine runs the program with the virtual clock, and this command beside it. `sidecar`
//! releases the program's frames when `head` decides so, which runs beside the program of node 0.
//! With `--mirror` only node 0 runs the program, and `mirror` shows its pictures on the others.
//! Messages (`link`) and pictures travel through `mpi` or, on one machine, through `local`.

mod agreed;
mod door;
pub mod head;
pub mod input;
mod link;
mod local;
mod mirror;
#[cfg(feature = "mpi")]
mod mpi;
mod pictures;
mod sidecar;
mod sums;

use crate::failure::Failure;
use crate::launch::clock::Rate;
use crate::launch::loader::Scratch;
use crate::run::{self, Options};
use agreed::Agreed;
use cupola::nodes::Page;
use cupola::rig::{Node, Place, Rig};
use cupola::system::{self, process};
use link::{Deliver, Link};
use sidecar::Sidecar;
use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitCode};
use std::sync::Arc;
use std::time::Duration;

/// Run a program on several machines in step, each with its own outputs of the rig.
#[derive(clap::Args)]
#[command(after_help = "\
mpirun starts this command on each machine:
  mpirun --enable-recovery --hostfile machines cupola node --rig dome.toml -- program
The key `node` of an output says which machine shows it. Each machine runs the program with the virtual clock, and a
frame is shown when all have drawn it.")]
pub struct Arguments {
    #[command(flatten)]
    options: Options,
    /// Start N nodes on this machine, without MPI
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=256))]
    local: Option<u32>,
    /// Go on without nodes that do not answer after this time in milliseconds
    #[arg(long, value_name = "MS", default_value_t = 100, value_parser = clap::value_parser!(u32).range(2..=600_000))]
    time_out: u32,
    /// Show frames as soon as all nodes have drawn them, however long a second of the program takes
    #[arg(long)]
    unpaced: bool,
    /// Leave the program's clocks and random numbers alone
    #[arg(long, conflicts_with_all = ["clock", "seed", "clock_start"])]
    own_clocks: bool,
    /// Run the program on node 0 only; the other nodes show its pictures
    #[arg(long, conflicts_with_all = ["time_out", "unpaced", "own_clocks", "input"])]
    mirror: bool,
    /// Send keyboard and mouse events of a file to the programs of all nodes in the same frame: a
    /// file, a named pipe, or - for the standard input of node 0
    #[arg(long, value_name = "FILE|-")]
    input: Option<PathBuf>,
    /// Write the observations of node 0 to a JSON file
    #[arg(long, value_name = "FILE.json")]
    summary: Option<PathBuf>,
    /// Program and its arguments
    #[arg(trailing_var_arg = true, required = true)]
    program: Vec<OsString>,
}

/// Frame rate if the user requests no other.
const USUAL: Rate = Rate { frames: 60, seconds: 1 };

/// Variable with the path of the socket for a node of `--local`.
const SOCKET: &str = "CUPOLA_NODE_SOCKET";

/// Runs the subcommand. Returns the exit code of the program.
pub fn run(arguments: Arguments) -> Result<ExitCode, Failure> {
    let socket = std::env::var_os(SOCKET).map(PathBuf::from);
    match (socket, arguments.local) {
        (Some(socket), _) => {
            let text = std::env::var("CUPOLA_NODE").unwrap_or_default();
            let place = Place::parse(&text, system::host_name())
                .ok_or_else(|| Failure::usage(format!("{SOCKET} is set, but CUPOLA_NODE={text} is no node")))?;
            match arguments.mirror {
                true => mirror::show(arguments, &place, || local::connect_pictures(&place, &socket)),
                false => show(arguments, &place, |deliver| local::connect(&place, &socket, deliver)),
            }
        }
        (None, Some(count)) => {
            // Mistakes are reported once, before anything starts.
            prepared(&arguments, &Place { number: 0, count, host: system::host_name() })?;
            start_local(count)
        }
        (None, None) => by_mpi(arguments),
    }
}

#[cfg(feature = "mpi")]
fn by_mpi(arguments: Arguments) -> Result<ExitCode, Failure> {
    if !mpi::is_there() {
        return Err(Failure::usage(format!("{NOT_STARTED}mpirun -np 4 cupola node …, or give --local N")));
    }
    let job = mpi::Job::join()?;
    let place = job.place.clone();
    match arguments.mirror {
        true => mirror::show(arguments, &place, || Ok(job.connect_pictures())),
        false => show(arguments, &place, |deliver| Ok(job.connect(deliver))),
    }
}

#[cfg(not(feature = "mpi"))]
fn by_mpi(_arguments: Arguments) -> Result<ExitCode, Failure> {
    Err(Failure::usage(format!(
        "{NOT_STARTED}--local N. Nodes on several machines need a cupola that was built with MPI: cargo build \
         --release --features mpi"
    )))
}

/// Beginning of messages to a user who has started a single node.
const NOT_STARTED: &str = "this command is one of several nodes; start all of them by ";

/// Prepares the rig of each known machine. Returns that of this machine, or an error.
fn prepared(arguments: &Arguments, place: &Place) -> Result<(Rig, Option<(u32, u32)>), Failure> {
    if arguments.options.clock.starts_now() && !arguments.mirror {
        return Err(Failure::usage(
            "--clock-start now differs from node to node; give a date, for example 2030-12-24T18:00:00",
        ));
    }
    if arguments.options.clock.pause && !arguments.mirror {
        return Err(Failure::usage("--pause: the time of several machines cannot be held; leave this option out"));
    }
    if let Some(source) = arguments.input.as_deref().filter(|source| place.number == 0 && !input::is_standard(source)) {
        std::fs::metadata(source).map_err(|error| Failure::usage(format!("--input {}: {error}", source.display())))?;
    }
    let rig = arguments.options.rig()?;
    if arguments.mirror && place.number == 0 {
        rig.clone().with_mirrors(place)?;
    }
    let hosts = rig.outputs.iter().filter_map(|output| match &output.node {
        Some(Node::Host(host)) => Some(host.clone()),
        _ => None,
    });
    let named = hosts.map(|host| Place { host, number: u32::MAX, ..*place });
    let numbered = (0..place.count).map(|number| Place { number, ..place.clone() });
    let mut size = None;
    for other in numbered.chain(named) {
        let extent = rig.clone().on_node(&other)?.extent();
        size = size
            .max(extent.zip(size).map(|((w, h), (x, y)): ((u32, u32), (u32, u32))| (w.max(x), h.max(y))).or(extent));
    }
    Ok((rig.on_node(place)?, size))
}

/// Runs the program of this node.
fn show(
    arguments: Arguments,
    place: &Place,
    connect: impl FnOnce(Arc<Deliver>) -> Result<Box<dyn Link>, Failure>,
) -> Result<ExitCode, Failure> {
    let (rig, size) = prepared(&arguments, place)?;
    let Arguments { mut options, time_out, unpaced, own_clocks, input, summary, program, .. } = arguments;
    sidecar::announce(place, &rig);
    let rate = *options.clock.clock.get_or_insert(USUAL);
    if own_clocks {
        options.clock.clock = None;
    }
    if options.headless {
        // Programs draw differently in windows of different sizes.
        options.size = options.size.or(size);
    }
    options.stats = options.stats.map(|file| of_node(&file, place));
    options.capture_views = options.capture_views.map(|folder| folder.join(format!("node-{}", place.number)));
    if let Some(folder) = &options.capture_views {
        std::fs::create_dir_all(folder)
            .map_err(|error| Failure::usage(format!("{} cannot be created: {error}", folder.display())))?;
    }
    let length = length_of(rate);
    let limit = Duration::from_millis(time_out.into());
    let path = page_path();
    options.node = Some((format!("{}/{}", place.number, place.count), path.clone()));
    let paced = (!unpaced && !own_clocks).then_some(length);
    // The standard input of node 0 is for the programs of all nodes.
    options.without_input = input.as_deref().is_some_and(input::is_standard);
    let source = input.as_deref().filter(|_| place.number == 0).map(input::open).transpose()?;
    let sidecar = Sidecar::start(place, &path, limit, length, paced, connect)?;
    let own = Agreed::of_options(&options);
    let settings = sidecar.agree(own)?;
    if let Some(words) = settings.differences(&own) {
        sidecar::say(&format!("node {} takes the settings of node 0: {words}", place.number));
    }
    settings.apply(&mut options);
    sidecar.set_length(options.clock.clock.map_or(length, length_of));
    if input.is_some() {
        sidecar.take_input(source);
    }
    let code = run::start(options, &program, None);
    let ended = code.as_ref().is_ok_and(|code| *code == ExitCode::SUCCESS);
    sidecar.finish(ended, summary.as_deref());
    code
}

/// Length of a frame.
fn length_of(rate: Rate) -> Duration {
    Duration::from_secs_f64(rate.seconds as f64 / rate.frames as f64)
}

/// Path of this node's page. Pages of commands that were killed are removed.
fn page_path() -> PathBuf {
    let usual = cupola::ring::default_path();
    let name = format!("{}-node-", usual.file_name().unwrap_or_default().to_string_lossy());
    let folder = usual.parent().unwrap_or(Path::new("/dev/shm"));
    for entry in std::fs::read_dir(folder).into_iter().flatten().flatten() {
        let is_page = entry.file_name().to_string_lossy().starts_with(&name);
        if is_page && Page::open(&entry.path()).is_ok_and(|page| !page.has_command()) {
            // Another node may have removed it meanwhile.
            let _ = std::fs::remove_file(entry.path());
        }
    }
    folder.join(format!("{name}{}", std::process::id()))
}

/// Path of a file of this node, beside those of the others.
fn of_node(file: &Path, place: &Place) -> PathBuf {
    let part = |part: Option<&std::ffi::OsStr>| part.unwrap_or_default().to_string_lossy().into_owned();
    let (stem, extension) = (part(file.file_stem()), part(file.extension()));
    file.with_file_name(format!("{stem}-node-{}.{extension}", place.number))
}

/// Starts the nodes of `--local`, and waits for them.
fn start_local(count: u32) -> Result<ExitCode, Failure> {
    let failed = |error: std::io::Error| Failure::new(format!("the nodes cannot be started: {error}"));
    let scratch = Scratch::new()?;
    let socket = scratch.path().join("head");
    let program = std::env::current_exe().map_err(failed)?;
    process::note_end_signals();
    let mut nodes: Vec<Child> = Vec::new();
    for number in 0..count {
        let mut command = Command::new(&program);
        command.args(std::env::args_os().skip(1));
        command.env("CUPOLA_NODE", format!("{number}/{count}")).env(SOCKET, &socket);
        nodes.push(command.spawn().map_err(failed)?);
    }
    let mut worst = 0;
    let mut is_told = false;
    while !nodes.is_empty() {
        if process::end_was_asked_for() && !std::mem::replace(&mut is_told, true) {
            // The processes may have ended meanwhile.
            nodes.iter().for_each(|node| drop(process::terminate(node)));
        }
        nodes.retain_mut(|node| match node.try_wait() {
            Ok(None) => true,
            Ok(Some(status)) => {
                worst = worst.max(status.code().unwrap_or(1));
                false
            }
            Err(_) => false,
        });
        std::thread::sleep(Duration::from_millis(20));
    }
    Ok(ExitCode::from(u8::try_from(worst).unwrap_or(1)))
}
