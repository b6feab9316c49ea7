//! `cupola serve`: a page in the browser with the dome, the program's picture on it, and every key
//! of the rig.
//!
//! All of it is in this process. The program beside it has Cupola's library as usual: it follows a
//! rig file and publishes its frames in shared memory, and gets neither a thread nor a socket of
//! Cupola.
//!
//! `http`, `socket` and `osc` are three ways to the same [`control`]; `access` controls the first
//! one.

mod access;
pub mod control;
// What the fuzz target `serve` calls is not public.
#[cfg(fuzzing)]
#[path = "../../../../fuzz/targets/serve.rs"]
mod fuzzing;
mod http;
mod keys;
pub mod marks;
mod osc;
pub mod pattern;
mod picture;
mod program;
mod scene;
pub mod socket;
mod working;

use crate::failure::Failure;
use crate::launch::clock::{Rate, rate};
use crate::launch::loader::Scratch;
use access::Access;
use control::{Command, Server};
use cupola::system::process;
use http::{Answer, Request};
use program::{Launch, Program};
use scene::Overlay;
use serde_json::{Value, json};
use std::ffi::OsString;
use std::net::{IpAddr, Ipv4Addr, SocketAddr, TcpListener, UdpSocket};
use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::Arc;

/// The page, with everything that it needs in one document.
const PAGE: &str = concat!(
    "<!doctype html>\n<html lang=\"en\"><meta charset=\"utf-8\">\n",
    "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n<link rel=\"icon\" href=\"data:,\">\n<title>Cupola</title>\n<style>",
    include_str!("page/style.css"),
    "</style>\n",
    include_str!("page/body.html"),
    "<script nonce=\"cupola\">",
    include_str!("page/shaders.js"),
    include_str!("page/dome.js"),
    include_str!("page/page.js"),
    include_str!("page/keys.js"),
    include_str!("page/marks.js"),
    include_str!("page/drags.js"),
    "</script>\n</html>\n",
);
/// Default port.
const PORT: u16 = 8640;

/// Show the dome in a browser, with the picture of a running program on it, and change every key of
/// the rig while it runs.
#[derive(clap::Args)]
#[command(after_help = "\
The printed address opens the page; whoever knows it may change the rig and start and stop the programs that are
named here. The rig file is written only when you save.")]
pub struct Arguments {
    /// Rig file or name of a preset; may be given several times, the first is opened [default:
    /// fisheye]
    #[arg(long, short, value_name = "FILE|PRESET")]
    rig: Vec<String>,
    /// Set the size of the program's window in pixels
    #[arg(long, value_name = "WxH", value_parser = crate::arguments::size)]
    size: Option<(u32, u32)>,
    /// Run programs on a private X server without a screen (Xvfb)
    #[arg(long)]
    headless: bool,
    /// Another program that the page may start, as one line of words; may be given several times
    #[arg(long, value_name = "COMMAND")]
    program: Vec<String>,
    /// Let the programs' clocks go on by 1/FPS with each frame, so that their time can be held
    #[arg(long, value_name = "FPS", value_parser = rate)]
    clock: Option<Rate>,
    /// Hold the time of each program after its first frame
    #[arg(long, requires = "clock")]
    pause: bool,
    /// Do not start PROGRAM at once
    #[arg(long)]
    idle: bool,
    #[command(flatten)]
    ways: Ways,
    /// Program and its arguments
    #[arg(trailing_var_arg = true)]
    command: Vec<OsString>,
}

/// Ways to reach the server, and its file of marks.
#[derive(clap::Args)]
pub struct Ways {
    /// File of marks, as `cupola calibrate` reads it: the page adds those that are made on it
    #[arg(long, value_name = "FILE.csv")]
    marks: Option<PathBuf>,
    /// Port of the page; 0 takes any free one [default: 8640]
    #[arg(long, value_name = "PORT")]
    port: Option<u16>,
    /// Address of this machine for the page, for phones and other machines [default: this machine
    /// alone]
    #[arg(long, value_name = "ADDRESS", value_parser = listen_address)]
    listen: Option<IpAddr>,
    /// Also follow OSC messages at this UDP port
    #[arg(long, value_name = "[ADDRESS:]PORT", value_parser = osc_address)]
    osc: Option<SocketAddr>,
}

impl Ways {
    /// Options that take the next argument as their value.
    pub const OPTIONS: [&str; 4] = ["--marks", "--port", "--listen", "--osc"];

    /// True if no option is given.
    pub fn is_default(&self) -> bool {
        let Self { marks, port, listen, osc } = self;
        marks.is_none() && port.is_none() && listen.is_none() && osc.is_none()
    }
}

fn listen_address(text: &str) -> Result<IpAddr, String> {
    text.parse().map_err(|_| {
        "expected an address of this machine in numbers, for example 192.168.1.20, or 0.0.0.0 for all of them"
            .to_owned()
    })
}

fn osc_address(text: &str) -> Result<SocketAddr, String> {
    let port = |text: &str| text.parse().ok().map(|port| SocketAddr::from((Ipv4Addr::LOCALHOST, port)));
    text.parse()
        .ok()
        .or_else(|| port(text))
        .ok_or_else(|| "expected a port, for example 9000, or ADDRESS:PORT".to_owned())
}

/// Runs the subcommand.
pub fn run(arguments: Arguments) -> Result<ExitCode, Failure> {
    let mut options: Vec<OsString> = Vec::new();
    if let Some((width, height)) = arguments.size {
        options.extend(["--size".into(), format!("{width}x{height}").into()]);
    }
    options.extend(arguments.headless.then(|| "--headless".into()));
    if let Some(Rate { frames, seconds }) = arguments.clock {
        options.extend(["--clock".into(), format!("{frames}/{seconds}").into()]);
    }
    options.extend(arguments.pause.then(|| "--pause".into()));
    let mut programs = Vec::new();
    if let Some(name) = arguments.command.first() {
        programs.push((name.to_string_lossy().into_owned(), arguments.command.clone()));
    }
    for line in &arguments.program {
        programs.push((line.clone(), line.split_whitespace().map(OsString::from).collect()));
    }
    let rigs = if arguments.rig.is_empty() { vec!["fisheye".to_owned()] } else { arguments.rig };
    let starts = !arguments.idle && !arguments.command.is_empty();
    serve(rigs, programs, options, starts, &arguments.ways, false)
}

/// Serves the page for one program with these options of `run`, until it ends:
/// `cupola run --serve`.
pub fn run_with(rig: String, options: Vec<OsString>, program: &[OsString], ways: &Ways) -> Result<ExitCode, Failure> {
    let name = program.first().map_or_else(String::new, |name| name.to_string_lossy().into_owned());
    serve(vec![rig], vec![(name, program.to_owned())], options, true, ways, true)
}

fn serve(
    rigs: Vec<String>,
    programs: Vec<(String, Vec<OsString>)>,
    options: Vec<OsString>,
    starts: bool,
    ways: &Ways,
    is_once: bool,
) -> Result<ExitCode, Failure> {
    let scratch = Scratch::new()?;
    let launch = Launch {
        options,
        working_file: scratch.path().join("rig.toml"),
        ring: ring_file(),
        statistics: scratch.path().join("statistics.json"),
        clock: scratch.path().join("clock"),
    };
    let (program, supervised) = Program::new();
    let marks = ways.marks.clone();
    let server = Server::new(rigs, programs, launch.clone(), program, marks, scratch.path()).map_err(Failure::usage)?;
    let server = Arc::new(server);
    process::note_end_signals();
    announce(&server, ways)?;
    let socket =
        socket::serve(server.clone()).map_err(|error| Failure::new(format!("the socket of cupola ctl: {error}")))?;
    eprintln!("cupola: cupola ctl --socket {}", socket.path().display());
    if starts {
        server.run(Command::Start { program: None, command: None }, true).map_err(Failure::usage)?;
    }
    program::supervise(&supervised, &launch, is_once);
    // The program has removed it already, unless it was killed.
    let _ = std::fs::remove_file(&launch.ring);
    Ok(ExitCode::SUCCESS)
}

/// Path of a file in memory, named after this process.
fn ring_file() -> std::path::PathBuf {
    let memory = std::path::Path::new("/dev/shm");
    let folder = if memory.is_dir() { memory.to_owned() } else { std::env::temp_dir() };
    folder.join(format!("cupola-serve-{}", std::process::id()))
}

/// Opens the ways to the server, and prints the address.
fn announce(server: &Arc<Server>, ways: &Ways) -> Result<(), Failure> {
    let address = SocketAddr::from((ways.listen.unwrap_or(IpAddr::V4(Ipv4Addr::LOCALHOST)), ways.port.unwrap_or(PORT)));
    let busy =
        |what: &str, error: std::io::Error| Failure::new(format!("{what}: {error}; --port 0 takes any free port"));
    let listener = TcpListener::bind(address).map_err(|error| busy(&address.to_string(), error))?;
    let address = listener.local_addr().map_err(|error| busy(&address.to_string(), error))?;
    let access = Access::new(address).map_err(|error| Failure::new(format!("random numbers: {error}")))?;
    let host = match address.ip() {
        ip if ip.is_unspecified() => "ADDRESS-OF-THIS-MACHINE".to_owned(),
        IpAddr::V6(ip) => format!("[{ip}]"),
        ip => ip.to_string(),
    };
    eprintln!("cupola: open {}", access.url(&host));
    if !address.ip().is_loopback() {
        eprintln!(
            "cupola: whoever can read this network can read the address, too; use a network of your own, or ssh -L"
        );
    }
    let answered = server.clone();
    http::serve(listener, Arc::new(access), move |request| answer(&answered, request));
    if let Some(address) = ways.osc {
        let socket = UdpSocket::bind(address).map_err(|error| Failure::new(format!("OSC at {address}: {error}")))?;
        if let Ok(address) = socket.local_addr() {
            eprintln!("cupola: OSC at {address}");
        }
        osc::serve(socket, server.clone());
    }
    Ok(())
}

/// Answers a request. Without the secret word only the page is available, which shows nothing by
/// itself.
fn answer(server: &Server, request: &Request) -> Answer {
    match (request.is_post, request.path.as_str()) {
        (false, "/") => return Answer::new(200, "text/html; charset=utf-8", PAGE),
        _ if !request.has_token => {
            return Answer::words(403, "Open the complete address that cupola printed.");
        }
        _ => {}
    }
    let number = |name: &str| request.value(name).and_then(|value| value.parse::<u64>().ok());
    match (request.is_post, request.path.as_str()) {
        (false, "/frame") => {
            let side = number("side").unwrap_or(512).min(4096) as u32;
            match picture::wait(&server.pictures, &server.program, number("after").unwrap_or(0), side) {
                None => Answer::words(204, ""),
                Some(small) => Answer::new(200, "image/jpeg", small.jpeg.clone())
                    .with("X-Cupola-Frame", small.number.to_string())
                    .with("X-Cupola-Index", small.index.to_string())
                    .with("X-Cupola-Version", small.version.map_or(String::new(), |version| version.to_string()))
                    .with("X-Cupola-Places", small.layout()),
            }
        }
        (false, "/scene") => {
            let (version, scene) = server.scene();
            let known = request.value("have").unwrap_or_default().split(',').filter_map(|id| id.parse().ok());
            Answer::new(200, "application/octet-stream", scene.bytes(version, &known.collect::<Vec<u64>>()))
        }
        (false, "/overlay") => {
            let Some(overlay) = request.value("kind").and_then(Overlay::named) else {
                return Answer::words(400, "There is no such overlay.");
            };
            let (version, scene) = server.scene();
            answered(scene.overlay(overlay).map(|values| json!({ "version": version, "values": values })))
        }
        (true, "/do") => {
            let command =
                serde_json::from_slice::<Command>(&request.body).map_err(|error| format!("not a request: {error}"));
            answered(command.and_then(|command| server.run(command, false)))
        }
        _ => Answer::words(404, "There is nothing here."),
    }
}

fn answered(result: Result<Value, String>) -> Answer {
    match result {
        Ok(value) => Answer::json(200, &value),
        Err(message) => Answer::words(400, &message),
    }
}
