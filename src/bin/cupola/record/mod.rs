//! `cupola record`: writes all frames of a program to numbered pictures or to a film, or passes
//! them to a command.
//!
//! The program gets the virtual clock and publishes its frames; a thread of this command reads and
//! writes them, and the program waits for it.

pub mod film;
mod numbered;
mod open_exr;
mod timing;

use crate::failure::Failure;
use crate::launch::clock::{Rate, rate};
use crate::pipe;
use crate::run::{self, Options};
use crate::terminal;
use cupola::ring::{self, Format, Frame, Next, Picture, Reader};
use cupola::system::{self, process};
use indicatif::HumanBytes;
use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};
use timing::Timing;

/// Interval at which a reader checks whether the program still runs.
const LOOK: Duration = Duration::from_millis(20);

/// Interval at which the space on the disk is checked.
const ASK: Duration = Duration::from_secs(1);

/// Record each frame of a program: numbered pictures, or a film by way of ffmpeg.
#[derive(clap::Args)]
#[command(after_help = "\
The program has the virtual clock and waits for each picture to be written: a film plays at FPS, however long its
frames take. Pictures are DIR/NAME_000001.png and so on; several outputs have a folder each, DIR/OUTPUT. The same
command goes on with pictures that were interrupted; a film begins anew.")]
pub struct Arguments {
    #[command(flatten)]
    options: Options,
    /// Frames per second of the recording, for example 60, 59.94 or 60000/1001
    #[arg(long, value_name = "FPS", value_parser = rate, default_value = "60")]
    fps: Rate,
    /// Frame or time at which the recording begins, for example 301 or 5s; what comes before is drawn
    /// and not written
    #[arg(long, value_name = "FRAME|SECONDS", value_parser = moment, default_value = "1")]
    from: Moment,
    /// Last frame, or time at which the recording ends, instead of --frames
    #[arg(long, value_name = "FRAME|SECONDS", value_parser = moment, conflicts_with = "frames")]
    to: Option<Moment>,
    /// Folder of the recording; it is created if it does not exist
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// Prefix of the file names [default: the output's name]
    #[arg(long, value_name = "NAME")]
    name: Option<String>,
    /// Bits of each colour: 16 makes larger pictures, whose values are not rounded to 8 bits
    #[arg(long, value_name = "8|16", value_parser = depth, default_value = "8", conflicts_with_all = ["film", "pipe"])]
    depth: Format,
    /// Write OpenEXR pictures instead of PNG: half floats of linear light
    #[arg(long, conflicts_with_all = ["film", "pipe", "depth"])]
    exr: bool,
    /// Write a film with ffmpeg instead of pictures
    #[arg(long, value_name = "h264|h265|prores")]
    film: Option<film::Preset>,
    /// Start this shell command in the folder, and hand the pictures to its standard input
    #[arg(long, value_name = "COMMAND", conflicts_with = "film")]
    pipe: Option<String>,
    /// Format of these pictures
    #[arg(long, value_name = "nut|y4m|raw", requires = "pipe", default_value = "nut")]
    format: pipe::Format,
    /// Program and its arguments
    #[arg(trailing_var_arg = true, required = true)]
    program: Vec<OsString>,
}

/// Destination of a recording's pictures.
trait Sink: Send {
    /// Takes the pictures of frame `number`, counted from 1. `again`: they are those of the frame
    /// before.
    fn take(&mut self, number: u64, pictures: &[Picture], again: bool) -> Result<(), Failure>;
    /// Ends the recording. Returns a message for the user.
    fn finish(&mut self) -> Result<String, Failure>;
    /// What the same command does with a recording that was interrupted.
    fn resumed(&self) -> &'static str;
}

/// Moment of a recording.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Moment {
    /// Number of a frame, from 1.
    Frame(u64),
    /// Seconds from the start.
    Seconds(f64),
}

impl Moment {
    /// First frame that begins at this moment or later. Frame 1 is at 0.
    fn first(self, rate: Rate) -> u64 {
        match self {
            Self::Frame(frame) => frame,
            // A moment that was rounded to the beginning of a frame means this frame.
            Self::Seconds(seconds) => (seconds * rate.frames as f64 / rate.seconds as f64 - 1e-6).ceil() as u64 + 1,
        }
    }

    /// Last frame of a recording until this moment.
    fn last(self, rate: Rate) -> u64 {
        match self {
            Self::Frame(frame) => frame,
            Self::Seconds(_) => self.first(rate) - 1,
        }
    }
}

/// Parses a frame, such as `301`, or a time in seconds, such as `5s`.
fn moment(text: &str) -> Result<Moment, String> {
    let seconds = text.strip_suffix('s').and_then(|text| text.parse().ok());
    let seconds = seconds.filter(|seconds| (0.0..1e9).contains(seconds)).map(Moment::Seconds);
    let frame = || text.parse().ok().filter(|frame| *frame > 0).map(Moment::Frame);
    seconds
        .or_else(frame)
        .ok_or_else(|| "expected the number of a frame, from 1, or a time such as 5s or 2.5s".to_owned())
}

/// Parses a number of bits.
fn depth(text: &str) -> Result<Format, String> {
    match text {
        "8" => Ok(Format::Rgba8),
        "16" => Ok(Format::Rgba16),
        _ => Err("expected 8 or 16".to_owned()),
    }
}

/// Runs the subcommand. Returns the exit code of the program.
pub fn run(arguments: Arguments) -> Result<ExitCode, Failure> {
    let Arguments { mut options, fps, from, to, out, name, depth, exr, film, pipe, format, program } = arguments;
    let first = from.first(fps);
    let frames = match (options.frames, to.map(|to| to.last(fps))) {
        (Some(frames), _) => frames,
        (None, Some(last)) => last
            .checked_sub(first - 1)
            .filter(|frames| *frames > 0)
            .ok_or_else(|| Failure::usage(format!("--to: frame {last} is before frame {first} of --from")))?,
        (None, None) => {
            return Err(Failure::usage(
                "the length of the recording is missing: give --frames N, for example --frames 600, or --to",
            ));
        }
    };
    options.frames = Some(first.saturating_add(frames - 1));
    options.published_from = (first > 1).then(|| Timing::new(fps).begin_of(first).saturating_sub(LEAD));
    if options.clock.clock.is_some() {
        return Err(Failure::usage("--clock: a recording has the clock of its --fps; leave this option out"));
    }
    if options.clock.pause {
        return Err(Failure::usage("--pause: a recording shows each frame once; leave this option out"));
    }
    if name.as_deref().is_some_and(|name| name.is_empty() || name != file_name(name)) {
        return Err(Failure::usage("--name: expected the beginning of a file's name, without slashes"));
    }
    std::fs::create_dir_all(&out)
        .map_err(|error| Failure::usage(format!("the folder {} cannot be created: {error}", out.display())))?;
    options.clock.clock = Some(fps);
    options.waits_for_readers = true;
    options.deep_pictures = exr || depth == Format::Rgba16;
    let ring = options.publish.take().filter(|file| !file.as_os_str().is_empty()).unwrap_or_else(own_ring);
    options.publish = Some(ring.clone());
    let taker = film.map(film::Taker::Film).or(pipe.map(|command| film::Taker::Command(command, format)));
    let sink: Box<dyn Sink> = match taker {
        None => Box::new(numbered::Folder::new(&out, name, numbered::Kind::new(depth, exr), first)),
        Some(taker) => Box::new(film::Receivers::new(&out, name, taker, fps)),
    };
    let has_ended = AtomicBool::new(false);
    std::thread::scope(|scope| {
        let timing = Timing::new(fps);
        let recorder = Recorder { ring: &ring, out: &out, first, frames, has_ended: &has_ended, sink, timing };
        let recording = scope.spawn(|| {
            let result = recorder.record();
            // Later frames of the program would be lost, or are not wanted.
            if result.as_ref().map_or(true, |(_, is_drawing)| *is_drawing) {
                process::stop_foreground();
            }
            result
        });
        let code = run::start(options, &program, None);
        has_ended.store(true, Ordering::SeqCst);
        let recorded =
            recording.join().unwrap_or_else(|_| Err(Failure::new("the recording failed by a defect of Cupola")));
        // A program that cannot be started is the reason for an empty recording.
        let code = code?;
        match recorded {
            Ok((words, _)) => {
                eprintln!("cupola: {words}");
                Ok(code)
            }
            Err(failure) => Err(failure),
        }
    })
}

/// File of this recording's frames. Files of recordings that were killed are removed.
fn own_ring() -> PathBuf {
    let usual = ring::default_path();
    let name = format!("{}-record-", usual.file_name().unwrap_or_default().to_string_lossy());
    let folder = usual.parent().unwrap_or(Path::new("/dev/shm"));
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
    let others = entries.filter(|entry| entry.file_name().to_string_lossy().starts_with(&name));
    others.for_each(|other| ring::remove_if_ended(&other.path()));
    folder.join(format!("{name}{}", std::process::id()))
}

/// Time before a part of a recording from which the program's pictures are read: its first frame
/// may still show one of them.
const LEAD: u64 = 1_000_000_000;

struct Recorder<'a> {
    ring: &'a Path,
    out: &'a Path,
    /// First frame of the recording, from 1.
    first: u64,
    frames: u64,
    has_ended: &'a AtomicBool,
    sink: Box<dyn Sink>,
    timing: Timing,
}

impl Recorder<'_> {
    fn open(&self) -> Result<Reader, Failure> {
        loop {
            let ended = self.has_ended.load(Ordering::SeqCst);
            match Reader::open(self.ring) {
                Ok(reader) => return Ok(reader.taking_deep()),
                Err(_) if !ended => std::thread::sleep(LOOK),
                Err(_) => {
                    return Err(Failure::new(
                        "the program ended and has published no frame: it drew nothing with OpenGL or Vulkan, or Cupola \
                         left it alone (see the messages above, and cupola doctor)",
                    ));
                }
            }
        }
    }

    /// Reads and writes all frames. Returns a message for the user, and whether the program goes on
    /// drawing.
    fn record(mut self) -> Result<(String, bool), Failure> {
        let mut reader = self.open()?;
        let (mut frame, mut before) = (Frame::default(), Frame::default());
        let mut progress = Progress::new(self.frames, self.out);
        let (mut read, mut taken) = (0, 0);
        // Number of frames for which the picture before was shown.
        let mut held = 1;
        while taken < self.frames {
            match reader.next(LOOK, &mut frame)? {
                Next::Nothing if self.has_ended.load(Ordering::SeqCst) => break,
                Next::Nothing => continue,
                Next::Ended => break,
                Next::Frame => {}
            }
            if reader.lost() > 0 || frame.number != read {
                return Err(Failure::new(format!("picture {} could not be read, and is missing", read + 1)));
            }
            read += 1;
            let last = self.timing.last();
            let found = self.timing.frame(frame.time);
            held = if last > 0 { found - last } else { held };
            // Counted from the first frame of the recording; 0 and below: before it.
            let number = i128::from(found) - i128::from(self.first) + 1;
            if self.first > 1 && read == 2 && number > 1 && frame.index > before.index + 1 {
                return Err(Failure::new(format!(
                    "frame {} shows a picture that the program drew more than a second before it; begin with an \
                     earlier frame (--from)",
                    self.first
                )));
            }
            // The picture before is shown until this one comes.
            while i128::from(taken) + 1 < number && taken < self.frames {
                taken += 1;
                self.sink.take(taken, &before.pictures, taken > 1)?;
                progress.show(taken);
            }
            if number > 0 && taken < self.frames {
                taken += 1;
                self.sink.take(taken, &frame.pictures, false)?;
                progress.show(taken);
            }
            std::mem::swap(&mut frame, &mut before);
        }
        // The last picture of a program that ends is shown as long as the one before, if this completes
        // the recording. Otherwise the program has failed, and would show another one.
        if taken > 0 && taken + held > self.frames {
            for number in taken + 1..=self.frames {
                self.sink.take(number, &before.pictures, true)?;
                taken = number;
            }
        }
        progress.bar.finish_and_clear();
        if taken < self.frames {
            let reached = format!("the program ended after {taken} of {} frames", self.frames);
            return Err(Failure::new(format!("{reached}; {}", self.sink.resumed())));
        }
        let words = self.sink.finish()?;
        Ok((
            format!("{words}, {:.1} frames in a second", progress.rate(taken)),
            before.index < self.first - 1 + self.frames,
        ))
    }
}

/// Bar that shows how far a recording is.
struct Progress<'a> {
    bar: indicatif::ProgressBar,
    begin: Instant,
    /// Time at which the free space was last asked for.
    asked: Option<Instant>,
    out: &'a Path,
}

impl<'a> Progress<'a> {
    fn new(frames: u64, out: &'a Path) -> Self {
        Self { bar: terminal::progress(frames, "frames"), begin: Instant::now(), asked: None, out }
    }

    /// Frames in a second.
    fn rate(&self, taken: u64) -> f64 {
        taken as f64 / self.begin.elapsed().as_secs_f64().max(1e-6)
    }

    fn show(&mut self, taken: u64) {
        self.bar.set_position(taken);
        if self.asked.is_none_or(|asked| asked.elapsed() > ASK) {
            self.asked = Some(Instant::now());
            let free = system::free_bytes(self.out).map_or_else(|_| "?".into(), |free| HumanBytes(free).to_string());
            self.bar.set_message(format!("frames, {:.1} in a second, {free} free, to go:", self.rate(taken)));
        }
    }
}

/// Converts a name to a part of a file name.
fn file_name(name: &str) -> String {
    let safe: String = name.chars().map(|c| if c == '/' || c.is_control() { '_' } else { c }).collect();
    safe.strip_prefix('.').map_or_else(|| safe.clone(), |rest| format!("_{rest}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn moments_are_frames_or_times() {
        let rate = Rate { frames: 60, seconds: 1 };
        let of = |text: &str| moment(text).map(|moment| (moment.first(rate), moment.last(rate)));
        assert_eq!(of("301"), Ok((301, 301)));
        assert_eq!(of("5s"), Ok((301, 300)));
        assert_eq!(of("0s"), Ok((1, 0)));
        assert_eq!(of("0.05s"), Ok((4, 3)));
        assert_eq!(of("0.051s"), Ok((5, 4)));
        let television = Rate { frames: 60_000, seconds: 1001 };
        assert_eq!(moment("1.001s").map(|moment| moment.first(television)), Ok(61));
        for wrong in ["", "0", "-1", "s", "-1s", "infs", "5m", "1.5"] {
            assert!(moment(wrong).is_err(), "{wrong}");
        }
    }
}
