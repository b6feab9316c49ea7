//! `cupola stream`: sends an output that a program publishes, live, to the network, a camera
//! device, a file, a source of NDI or PipeWire, or any command.
//!
//! The program never waits: frames that come while the receiver is busy are lost, and counted.

mod destination;
mod outlet;
#[cfg(feature = "pipewire")]
mod pipewire;
mod report;

use crate::failure::Failure;
use crate::launch::clock::{Rate, rate};
use crate::pipe::{Form, Format, Receiver, TimeBase, Writing};
use crate::terminal;
use cupola::ring::{self, Frame, Next, Picture, Reader};
use cupola::system::process;
use destination::{Destination, Encoding};
use outlet::{Added, Outlet};
use report::Report;
use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Duration;

/// Interval at which the command checks whether there is a program, and whether to end.
const LOOK: Duration = Duration::from_millis(50);
/// Time after which a receiver that receives nothing no longer delays the end of this command.
const GRACE: Duration = Duration::from_secs(3);

/// Send an output that a program publishes, live: to the network, a camera device, a file or a
/// command.
#[derive(clap::Args)]
#[command(after_help = "\
The program is started with cupola run --publish or --domemaster N. It never waits: a receiver that is too slow loses
frames, which are counted. Destinations through ffmpeg:
  srt://HOST:PORT, rist://…, udp://…, tcp://…   MPEG transport stream
  rtmp://HOST/APP/KEY                           for a streaming server
  FOLDER/NAME.m3u8                              HLS: a web server gives it to browsers
  /dev/videoN                                   a device of v4l2loopback: a camera for other programs
  NAME.mkv, NAME.mp4, …                         a file
Without ffmpeg:
  ndi:NAME                                      a source of NDI, by NDI's library, which is installed separately
  pipewire:NAME                                 a video source of PipeWire: a camera for other programs
and - is the standard output, in the format of --format.")]
pub struct Arguments {
    /// Destination of the pictures: an address, a file, a device, a source, or - for the standard output
    #[arg(value_name = "PLACE", required_unless_present = "pipe", conflicts_with = "pipe")]
    place: Option<String>,
    /// Start this shell command, and hand the pictures to its standard input
    #[arg(long, value_name = "COMMAND")]
    pipe: Option<String>,
    /// Format of the pictures for a command and for the standard output
    #[arg(long, value_name = "nut|y4m|raw", default_value = "nut")]
    format: Format,
    /// Name of the output [default: the only one that is published]
    #[arg(long, value_name = "NAME")]
    output: Option<String>,
    /// Greatest number of frames per second
    #[arg(long, value_name = "FPS", value_parser = rate, default_value = "60")]
    fps: Rate,
    /// Encoder of ffmpeg, for example libx265, h264_nvenc or h264_vaapi
    #[arg(long, value_name = "NAME", default_value = "libx264")]
    encoder: String,
    /// Bits per second, for example 40M [default: by quality]
    #[arg(long, value_name = "BITS")]
    bitrate: Option<String>,
    /// End after N frames
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..))]
    frames: Option<u64>,
    /// Write numbers of frames, sent and lost, and times to a JSON file
    #[arg(long, value_name = "FILE.json")]
    stats: Option<PathBuf>,
    /// File of published pictures [default: /dev/shm/cupola-USER, with the number of the user]
    #[arg(long, value_name = "FILE")]
    published: Option<PathBuf>,
}

/// Runs the subcommand until the program ends.
pub fn run(arguments: &Arguments) -> Result<ExitCode, Failure> {
    let (target, outlet) = Target::of(arguments)?;
    process::note_end_signals();
    std::thread::spawn(end_in_time);
    let file = arguments.published.clone().unwrap_or_else(ring::default_path);
    let Some(reader) = wait_for(&file) else { return Ok(ExitCode::SUCCESS) };
    let mut report = Report::default();
    let sent = send(arguments, (&target, outlet), reader, &mut report);
    eprintln!("cupola: {report}");
    if let Some(file) = &arguments.stats {
        std::fs::write(file, format!("{:#}\n", report.json()))
            .map_err(|error| Failure::new(format!("{}: {error}", file.display())))?;
    }
    sent.map(|()| ExitCode::SUCCESS)
}

/// Ends this command in time, even if a receiver hangs.
fn end_in_time() {
    while !process::end_was_asked_for() {
        std::thread::sleep(LOOK);
    }
    std::thread::sleep(GRACE);
    eprintln!("cupola: the receiver takes no more pictures; ending without it");
    std::process::exit(1);
}

/// Waits for a program that publishes; `None` if this command has to end.
fn wait_for(file: &std::path::Path) -> Option<Reader> {
    let mut is_told = false;
    while !process::end_was_asked_for() {
        if let Ok(reader) = Reader::open(file) {
            return Some(reader);
        }
        if !std::mem::replace(&mut is_told, true) {
            eprintln!("cupola: waiting for a program that publishes its pictures in {}", file.display());
        }
        std::thread::sleep(LOOK);
    }
    None
}

/// Sends frames until the program ends, or up to the requested number. `outlet`: if it is open.
fn send(
    arguments: &Arguments,
    (target, mut outlet): (&Target, Option<Outlet>),
    mut reader: Reader,
    report: &mut Report,
) -> Result<(), Failure> {
    let mut frame = Frame::default();
    let mut pace = Pace::new(arguments.fps);
    // Time of the outlet's first frame.
    let mut begin = None;
    let bar = terminal::spinner("no frame yet");
    while !process::end_was_asked_for() && arguments.frames.is_none_or(|frames| report.sent < frames) {
        match reader.next(LOOK, &mut frame)? {
            Next::Ended => break,
            Next::Nothing => {
                outlet.as_ref().map_or(Ok(()), Outlet::handle_events)?;
                continue;
            }
            Next::Frame => {}
        }
        report.read(&frame, reader.lost());
        if !pace.takes(frame.time) {
            continue;
        }
        let picture = chosen(&frame, arguments.output.as_deref())?;
        if outlet.as_ref().is_some_and(|outlet| !outlet.takes(picture.size)) {
            eprintln!("cupola: the picture has another size now: the receiver is started again");
            (outlet, begin) = (None, None);
        }
        if outlet.is_none() {
            outlet = Some(target.open(arguments, picture)?);
        }
        let Some(outlet) = &mut outlet else { break };
        match outlet.add(picture, frame.time.saturating_sub(*begin.get_or_insert(frame.time)))? {
            Added::Sent => report.sent(frame.time),
            Added::Lost => report.lost_here(),
            Added::Unseen => report.unseen(),
            Added::Gone => break,
        }
        bar.set_message(format!("{report}"));
    }
    bar.finish_and_clear();
    report.lost_before(reader.lost());
    outlet.as_mut().map_or(Ok(()), Outlet::finish)
}

/// Picture of the requested output.
fn chosen<'a>(frame: &'a Frame, output: Option<&str>) -> Result<&'a Picture, Failure> {
    let names = || frame.pictures.iter().map(|picture| &*picture.name).collect::<Vec<_>>().join(", ");
    match (output, &frame.pictures[..]) {
        (None, [only]) => Ok(only),
        (None, _) => Err(Failure::usage(format!(
            "several outputs are published: choose one by --output NAME ({}), or publish one domemaster with cupola run \
             --domemaster N",
            names()
        ))),
        (Some(output), all) => all
            .iter()
            .find(|picture| picture.name == output)
            .ok_or_else(|| Failure::usage(format!("no output {output:?} is published, but {}", names()))),
    }
}

/// Receiver of the pictures, from the command line.
enum Target {
    Shell(String),
    Place(Destination),
}

impl Target {
    /// The receiver, and its outlet if that does not depend on the pictures. A wrong destination is
    /// reported before the command waits for a program.
    fn of(arguments: &Arguments) -> Result<(Self, Option<Outlet>), Failure> {
        let Some(place) = &arguments.place else {
            return Ok((Self::Shell(arguments.pipe.clone().unwrap_or_default()), None));
        };
        let destination = Destination::parse(place).map_err(Failure::usage)?;
        let outlet = match &destination {
            Destination::Ndi(name) => Some(Outlet::ndi(name, arguments.fps)?),
            Destination::PipeWire(name) => Some(Outlet::pipewire(name, arguments.fps)?),
            _ => arguments.encoding().command(&destination).map(|_| None)?,
        };
        Ok((Self::Place(destination), outlet))
    }

    fn open(&self, arguments: &Arguments, picture: &Picture) -> Result<Outlet, Failure> {
        let rate = arguments.fps;
        let form = |format| Form { format, base: TimeBase::LIVE, rate };
        let receiver = |mut command, format| Receiver::start(&mut command, form(format), picture);
        Ok(match self {
            Self::Place(Destination::Output) => {
                Outlet::Output(Writing::new(form(arguments.format), picture.size), picture.size)
            }
            Self::Place(Destination::Ndi(name)) => Outlet::ndi(name, rate)?,
            Self::Place(Destination::PipeWire(name)) => Outlet::pipewire(name, rate)?,
            Self::Place(destination) => {
                Outlet::Receiver(receiver(arguments.encoding().command(destination)?, Format::Nut)?)
            }
            Self::Shell(command) => {
                Outlet::Receiver(receiver(Receiver::shell(command, rate, picture), arguments.format)?)
            }
        })
    }
}

impl Arguments {
    fn encoding(&self) -> Encoding {
        Encoding { encoder: self.encoder.clone(), bitrate: self.bitrate.clone(), rate: self.fps }
    }
}

/// Skips frames of a program that draws faster than they are sent.
struct Pace {
    length: u64,
    /// Time at which the next frame is due, nanoseconds.
    due: u64,
}

impl Pace {
    fn new(rate: Rate) -> Self {
        Self { length: 1_000_000_000 * rate.seconds / rate.frames.max(1), due: 0 }
    }

    fn takes(&mut self, time: u64) -> bool {
        // Frames of the same rate come a little early and late.
        if time + 2 * self.length < self.due {
            return false;
        }
        self.due = if time > self.due + self.length { time } else { self.due } + self.length;
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_program_of_the_same_rate_loses_nothing_and_a_faster_one_keeps_the_rate() {
        let taken = |length: u64| {
            let mut pace = Pace::new(Rate { frames: 60, seconds: 1 });
            let jitter = |frame: u64| if frame.is_multiple_of(3) { 24_000_000 } else { 0 };
            (1..=600).filter(|frame| pace.takes(1_000_000_000 + frame * length + jitter(*frame))).count()
        };
        assert_eq!(taken(16_666_667), 600);
        assert_eq!(taken(33_333_333), 600);
        assert!((299..=304).contains(&taken(8_333_333)), "{}", taken(8_333_333));
        assert!((479..=484).contains(&taken(13_333_333)), "{}", taken(13_333_333));
    }
}
