//! `cupola window`: an output in a window of its own, on any screen or monitor.
//!
//! It is a process of its own, which reads published frames. If its screen goes away, nothing else
//! ends.
//!
//! [`presenter`] shows pictures on a screen of an X server ([`x11`]) or a Wayland compositor
//! ([`wayland`]). [`opening`] starts such processes for the outputs of a
//! rig. [`screens`] opens the windows of all outputs, for test pictures.

pub mod opening;
pub mod presenter;
pub mod screens;
pub mod wayland;
mod x11;

use crate::failure::Failure;
use crate::pipe::nut;
use crate::window::presenter::{Filled, Presenter};
use cupola::rig::WindowSwaps;
use cupola::ring::{self, Frame, Next, Picture, Reader};
use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Duration;

/// Interval at which the command checks whether there is a program.
const LOOK: Duration = Duration::from_millis(50);

/// Show an output that a program publishes in a window of its own, on another screen or monitor.
#[derive(clap::Args)]
#[command(after_help = "\
The program is started with cupola run --publish, or with a rig in which the output has shown = false. The picture is
not scaled: give the output the size of the monitor. It is shown one or two frames after the program's own window.")]
pub struct Arguments {
    /// Name of the output
    #[arg(value_name = "OUTPUT", required_unless_present = "stdin", conflicts_with = "stdin")]
    output: Option<String>,
    /// Show pictures from the standard input, as `cupola stream -` sends them
    #[arg(long, conflicts_with = "published")]
    stdin: bool,
    /// X screen, for example :0.1, or Wayland compositor, for example wayland-0 [default:
    /// $WAYLAND_DISPLAY for a monitor, else $DISPLAY]
    #[arg(long, value_name = "NAME")]
    display: Option<String>,
    /// Fill this monitor, for example DP-2, as xrandr or the Wayland compositor lists it [default: a
    /// window as large as the picture]
    #[arg(long, value_name = "NAME", conflicts_with = "fullscreen")]
    monitor: Option<String>,
    /// Fill the screen
    #[arg(long)]
    fullscreen: bool,
    /// Refreshes of the display that each picture waits for at least (0 to 16); 0 may show parts of
    /// two pictures at once [default: the X server shows pictures when they come]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(0..=16))]
    swap_interval: Option<u32>,
    /// Join this swap group of the driver (GLX_NV_swap_group), so that windows of several screens
    /// change at one time
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1024))]
    swap_group: Option<u32>,
    /// Bind the swap group to this barrier, so that windows of several machines change at one time
    #[arg(long, value_name = "N", requires = "swap_group", value_parser = clap::value_parser!(u32).range(1..=1024))]
    swap_barrier: Option<u32>,
    /// Place of the window's upper left corner on the screen
    #[arg(long, value_name = "X,Y", value_parser = place, hide = true)]
    at: Option<(i16, i16)>,
    /// File of published pictures [default: /dev/shm/cupola-USER, with the number of the user]
    #[arg(long, value_name = "FILE")]
    published: Option<PathBuf>,
    /// Do not report the wait for a program
    #[arg(long, hide = true)]
    quiet: bool,
}

/// Runs the subcommand until the program ends.
pub fn run(arguments: &Arguments) -> Result<ExitCode, Failure> {
    let file = arguments.published.clone().unwrap_or_else(ring::default_path);
    let mut screen = arguments.screen()?;
    let Some(output) = &arguments.output else { return show_input(screen) };
    let mut reader = None;
    let mut is_told = arguments.quiet;
    while reader.is_none() {
        reader = Reader::open_at_newest(&file).ok();
        if reader.is_none() {
            if !std::mem::replace(&mut is_told, true) {
                eprintln!("cupola: waiting for a program that publishes its pictures in {}", file.display());
            }
            std::thread::sleep(LOOK);
        }
    }
    let Some(mut reader) = reader else { return Ok(ExitCode::FAILURE) };
    let mut frame = Frame::default();
    loop {
        reader.skip_to_newest();
        match reader.next(LOOK, &mut frame)? {
            Next::Ended => return Ok(ExitCode::SUCCESS),
            Next::Nothing => {
                screen.wait()?;
                continue;
            }
            Next::Frame => {}
        }
        let Some(picture) = frame.pictures.iter().find(|picture| picture.name == *output) else {
            let names: Vec<&str> = frame.pictures.iter().map(|picture| &*picture.name).collect();
            let published = names.join(", ");
            return Err(Failure::usage(format!("no output {output:?} is published, but {published}")));
        };
        screen.show(picture.size, &picture.rgba)?;
    }
}

/// Shows the pictures of the standard input until it ends.
fn show_input(mut screen: Presenter) -> Result<ExitCode, Failure> {
    let mut reading = nut::Reading::new(std::io::stdin().lock());
    let mut picture = Picture::default();
    while reading.next(&mut picture).map_err(|error| Failure::new(format!("the standard input: {error}")))? {
        screen.show(picture.size, &picture.rgba)?;
    }
    Ok(ExitCode::SUCCESS)
}

/// Parses `X,Y`.
fn place(text: &str) -> Result<(i16, i16), String> {
    let number = |text: &str| text.parse().ok();
    let place = text.split_once(',').and_then(|(x, y)| number(x).zip(number(y)));
    place.ok_or_else(|| "expected X,Y, two whole numbers".to_owned())
}

impl Arguments {
    fn screen(&self) -> Result<Presenter, Failure> {
        let filled = Filled::of(self.monitor.as_deref(), self.fullscreen, self.at.unwrap_or_default());
        let swaps = WindowSwaps { interval: self.swap_interval, group: self.swap_group, barrier: self.swap_barrier };
        Presenter::open(self.display.as_deref(), &filled, swaps)
    }
}
