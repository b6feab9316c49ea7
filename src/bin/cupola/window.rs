//! `cupola window`: an output in a window of its own, on any screen or monitor.
//!
//! It is a process of its own, which reads published frames. If its screen goes away, nothing else
//! ends.

use crate::failure::Failure;
use crate::pipe::nut;
use cupola::ring::{self, Frame, Next, Picture, Reader};
use std::fmt::Display;
use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Duration;
use x11rb::connection::{Connection, RequestConnection};
use x11rb::protocol::randr::ConnectionExt as _;
use x11rb::protocol::xproto::{
    ConnectionExt as _, CreateGCAux, CreateWindowAux, ImageFormat, ImageOrder, Screen, WindowClass,
};
use x11rb::rust_connection::RustConnection;

/// Interval at which the command checks whether there is a program.
const LOOK: Duration = Duration::from_millis(50);

/// Show an output that a program publishes in a window of its own, on another screen or monitor.
#[derive(clap::Args)]
#[command(after_help = "\
The program is started with cupola run --publish, or with a rig in which the output has shown = false. The picture is not
scaled: give the output the size of the monitor. It is shown one or two frames after the program's own window.")]
pub struct Arguments {
    /// Name of the output
    #[arg(value_name = "OUTPUT", required_unless_present = "stdin", conflicts_with = "stdin")]
    output: Option<String>,
    /// Show pictures from the standard input, as `cupola stream -` sends them
    #[arg(long, conflicts_with = "published")]
    stdin: bool,
    /// X screen, for example :0.1 [default: $DISPLAY]
    #[arg(long, value_name = "NAME")]
    display: Option<String>,
    /// Fill this monitor, for example DP-2, as xrandr lists it [default: a window as large as the
    /// picture]
    #[arg(long, value_name = "NAME", conflicts_with = "fullscreen")]
    monitor: Option<String>,
    /// Fill the screen
    #[arg(long)]
    fullscreen: bool,
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
    let screen = Output::open(arguments)?;
    let Some(output) = &arguments.output else { return show_input(&screen) };
    let mut reader = None;
    let mut is_told = arguments.quiet;
    while reader.is_none() {
        reader = Reader::open(&file).ok();
        if reader.is_none() {
            if !std::mem::replace(&mut is_told, true) {
                eprintln!("cupola: waiting for a program that publishes its pictures in {}", file.display());
            }
            std::thread::sleep(LOOK);
        }
    }
    let Some(mut reader) = reader else { return Ok(ExitCode::FAILURE) };
    let mut frame = Frame::default();
    let mut window = None;
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
        let window = match window {
            Some(window) => window,
            None => *window.insert(screen.window(picture)?),
        };
        screen.show(window, picture)?;
    }
}

/// Shows the pictures of the standard input until it ends.
fn show_input(screen: &Output) -> Result<ExitCode, Failure> {
    let mut reading = nut::Reading::new(std::io::stdin().lock());
    let (mut picture, mut window) = (Picture::default(), None);
    while reading.next(&mut picture).map_err(|error| Failure::new(format!("the standard input: {error}")))? {
        let window = match window {
            Some(window) => window,
            None => *window.insert(screen.window(&picture)?),
        };
        screen.show(window, &picture)?;
    }
    Ok(ExitCode::SUCCESS)
}

/// Screen of an output.
struct Output {
    connection: RustConnection,
    name: String,
    screen: Screen,
    /// Rectangle to fill: x, y, width and height in pixels.
    filled: Option<(i16, i16, u16, u16)>,
}

/// A window, with the objects that draw into it.
#[derive(Clone, Copy)]
struct Window {
    window: u32,
    context: u32,
    size: (u16, u16),
}

impl Output {
    fn failed(name: &str) -> impl Fn(&dyn Display) -> Failure {
        move |error| Failure::new(format!("the X screen {name}: {error}"))
    }

    fn open(arguments: &Arguments) -> Result<Self, Failure> {
        let name = arguments.display.clone().or_else(|| std::env::var("DISPLAY").ok()).unwrap_or_default();
        let failed = Self::failed(&name);
        let (connection, number) = x11rb::connect(arguments.display.as_deref()).map_err(|error| failed(&error))?;
        let setup = connection.setup();
        let screen = setup.roots.get(number).cloned().ok_or_else(|| failed(&"there is no such screen"))?;
        let format = setup.pixmap_formats.iter().find(|format| format.depth == screen.root_depth);
        let mut visuals = screen.allowed_depths.iter().flat_map(|depth| &depth.visuals);
        let visual = visuals.find(|visual| visual.visual_id == screen.root_visual);
        let is_usual = format.is_some_and(|format| format.bits_per_pixel == 32 && format.depth == 24)
            && visual.is_some_and(|visual| (visual.red_mask, visual.blue_mask) == (0xff_0000, 0xff))
            && setup.image_byte_order == ImageOrder::LSB_FIRST;
        if !is_usual {
            return Err(failed(&"its pixels are not of 24 bits for red, green and blue"));
        }
        let mut filled = arguments.fullscreen.then_some((0, 0, screen.width_in_pixels, screen.height_in_pixels));
        if let Some(wanted) = &arguments.monitor {
            let monitors = connection.randr_get_monitors(screen.root, true).map_err(|error| failed(&error))?;
            let monitors = monitors.reply().map_err(|error| failed(&error))?.monitors;
            let mut names = Vec::new();
            for monitor in monitors {
                let name = connection.get_atom_name(monitor.name).map_err(|error| failed(&error))?;
                let name = String::from_utf8_lossy(&name.reply().map_err(|error| failed(&error))?.name).into_owned();
                if name == *wanted {
                    filled = Some((monitor.x, monitor.y, monitor.width, monitor.height));
                }
                names.push(name);
            }
            if filled.is_none() {
                return Err(Failure::usage(format!(
                    "the X screen {name} has no monitor {wanted:?}, but {}",
                    names.join(", ")
                )));
            }
        }
        drop(failed);
        Ok(Self { connection, name, screen, filled })
    }

    /// Opens the window for a picture.
    fn window(&self, picture: &Picture) -> Result<Window, Failure> {
        let failed = Self::failed(&self.name);
        let side = |side: u32| u16::try_from(side).unwrap_or(u16::MAX);
        let own = (0, 0, side(picture.size.0), side(picture.size.1));
        let (x, y, width, height) = self.filled.unwrap_or(own);
        if (width, height) != (own.2, own.3) {
            eprintln!(
                "cupola: the picture has {}x{} pixels, its place on the screen {width}x{height}: it is not scaled \
                 (size of the output in the rig)",
                own.2, own.3
            );
        }
        let open = || -> Result<Window, x11rb::errors::ReplyOrIdError> {
            let (window, context) = (self.connection.generate_id()?, self.connection.generate_id()?);
            let root = self.screen.root;
            // Window managers do not move this window.
            let looks = CreateWindowAux::new().override_redirect(1).background_pixel(self.screen.black_pixel);
            let class = WindowClass::INPUT_OUTPUT;
            self.connection.create_window(0, window, root, x, y, width, height, 0, class, 0, &looks)?;
            self.connection.create_gc(context, window, &CreateGCAux::new())?;
            self.connection.map_window(window)?.check()?;
            Ok(Window { window, context, size: (width, height) })
        };
        open().map_err(|error| failed(&error))
    }

    /// Shows a picture, and waits until the screen has it.
    fn show(&self, window: Window, picture: &Picture) -> Result<(), Failure> {
        let failed = Self::failed(&self.name);
        let (width, height) =
            (picture.size.0.min(window.size.0.into()) as u16, picture.size.1.min(window.size.1.into()));
        let row = picture.size.0 as usize * 4;
        let shown = usize::from(width) * 4;
        // A request without its pixels has less than a hundred bytes.
        let rows = (self.connection.maximum_request_bytes().saturating_sub(100) / shown.max(1)).max(1);
        let all: Vec<&[u8]> = picture.rgba.chunks_exact(row).take(height as usize).collect();
        let mut bytes = Vec::new();
        for (index, part) in all.chunks(rows).enumerate() {
            bytes.clear();
            for row in part {
                let (pixels, _) = row[..shown].as_chunks::<4>();
                bytes.extend(pixels.iter().flat_map(|[red, green, blue, _]| [*blue, *green, *red, 0]));
            }
            let (y, count) = ((index * rows) as i16, part.len() as u16);
            let Window { window, context, .. } = window;
            self.connection
                .put_image(ImageFormat::Z_PIXMAP, window, context, width, count, 0, y, 0, 24, &bytes)
                .map_err(|error| failed(&error))?;
        }
        self.wait()
    }

    /// Waits until the screen has executed all requests.
    fn wait(&self) -> Result<(), Failure> {
        let failed = Self::failed(&self.name);
        let answer = self.connection.get_input_focus().map_err(|error| failed(&error))?;
        answer.reply().map(|_| ()).map_err(|error| failed(&error))
    }
}
