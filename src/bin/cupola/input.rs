//! `cupola input`: keyboard and mouse events in a window, as lines for `cupola node --input`.

use crate::failure::Failure;
use crate::node::input::{Event, screen};
use std::io::Write;
use std::process::ExitCode;
use x11rb::connection::Connection;
use x11rb::errors::{ConnectionError, ReplyError};
use x11rb::protocol::Event as XEvent;
use x11rb::protocol::xproto::{AtomEnum, ConnectionExt as _, CreateWindowAux, EventMask, PropMode, WindowClass};
use x11rb::rust_connection::RustConnection;
use x11rb::wrapper::ConnectionExt as _;

/// Print keyboard and mouse events of a window, for `cupola node --input`.
#[derive(clap::Args)]
#[command(after_help = "\
  cupola input | mpirun --hostfile machines cupola node --input - --rig dome.toml -- program
The window has to be on another X server than the programs. Its whole area stands for the whole window of each program.")]
pub struct Arguments {
    /// X screen, for example :1 [default: $DISPLAY]
    #[arg(long, value_name = "NAME")]
    display: Option<String>,
    /// Width and height of the window in pixels
    #[arg(long, value_name = "WxH", default_value = "640x360", value_parser = crate::arguments::size)]
    size: (u32, u32),
}

/// Runs the subcommand until the window is closed.
pub fn run(arguments: &Arguments) -> Result<ExitCode, Failure> {
    let name = arguments.display.clone().or_else(|| std::env::var("DISPLAY").ok()).unwrap_or_default();
    let failed = |error: &dyn std::fmt::Display| Failure::new(format!("the X screen {name}: {error}"));
    let (connection, number) = x11rb::connect(arguments.display.as_deref()).map_err(|error| failed(&error))?;
    let desk = Desk::open(connection, number, arguments.size).map_err(|error| failed(&error))?;
    let Some(mut desk) = desk else {
        return Err(Failure::usage(format!(
            "the X screen {name} is already used by programs of cupola node, or by another window of cupola input, and \
             this window would receive their events: open it on another X server (--display)"
        )));
    };
    desk.serve().map_err(|error| failed(&error))?;
    Ok(ExitCode::SUCCESS)
}

/// The window, and the keys and buttons that are held down in it.
struct Desk {
    connection: RustConnection,
    /// Symbols of the keys by their code.
    symbols: Vec<u32>,
    /// Message that closes the window.
    close: u32,
    size: (u16, u16),
    held: Vec<Event>,
}

impl Desk {
    /// Opens the window; `None` if the X server already sends events to programs.
    fn open(connection: RustConnection, number: usize, size: (u32, u32)) -> Result<Option<Self>, ReplyError> {
        let setup = connection.setup();
        let screen = setup.roots.get(number).ok_or(ConnectionError::UnknownError)?;
        let window = connection.generate_id().map_err(|_| ConnectionError::UnknownError)?;
        let side = |side: u32| u16::try_from(side).unwrap_or(u16::MAX);
        let size = (side(size.0), side(size.1));
        let mask = EventMask::KEY_PRESS
            | EventMask::KEY_RELEASE
            | EventMask::BUTTON_PRESS
            | EventMask::BUTTON_RELEASE
            | EventMask::POINTER_MOTION
            | EventMask::FOCUS_CHANGE
            | EventMask::STRUCTURE_NOTIFY;
        let looks = CreateWindowAux::new().background_pixel(screen.black_pixel).event_mask(mask);
        let class = WindowClass::INPUT_OUTPUT;
        connection.create_window(0, window, screen.root, 0, 0, size.0, size.1, 0, class, 0, &looks)?.check()?;
        if !screen::own(&connection, window)? {
            return Ok(None);
        }
        let title = b"Keyboard and mouse of cupola node";
        connection.change_property8(PropMode::REPLACE, window, AtomEnum::WM_NAME, AtomEnum::STRING, title)?;
        let atom = |name: &[u8]| Ok::<_, ReplyError>(connection.intern_atom(false, name)?.reply()?.atom);
        let (protocols, close) = (atom(b"WM_PROTOCOLS")?, atom(b"WM_DELETE_WINDOW")?);
        connection.change_property32(PropMode::REPLACE, window, protocols, AtomEnum::ATOM, &[close])?;
        let (least, most) = (setup.min_keycode, setup.max_keycode);
        let map = connection.get_keyboard_mapping(least, most - least + 1)?.reply()?;
        let of_keys = map.keysyms.chunks(map.keysyms_per_keycode.max(1).into()).map(|symbols| symbols[0]);
        let symbols = std::iter::repeat_n(0, least.into()).chain(of_keys).collect();
        connection.map_window(window)?.check()?;
        Ok(Some(Self { connection, symbols, close, size, held: Vec::new() }))
    }

    /// Prints lines until the window is closed, or nobody reads them.
    fn serve(&mut self) -> Result<(), ConnectionError> {
        loop {
            let lines = match self.connection.wait_for_event()? {
                XEvent::KeyPress(event) => self.held_or_not(self.key(event.detail), true),
                XEvent::KeyRelease(event) => self.held_or_not(self.key(event.detail), false),
                XEvent::ButtonPress(event) => self.button(event.detail, true),
                XEvent::ButtonRelease(event) => self.button(event.detail, false),
                XEvent::MotionNotify(event) => vec![self.place(event.event_x, event.event_y)],
                XEvent::ConfigureNotify(event) => {
                    self.size = (event.width, event.height);
                    continue;
                }
                // The release of held keys goes to another window.
                XEvent::FocusOut(_) => self.released(),
                XEvent::ClientMessage(event) if event.data.as_data32()[0] == self.close => {
                    // Nobody may read any more.
                    let _ = print(&self.released());
                    return Ok(());
                }
                _ => continue,
            };
            if print(&lines).is_err() {
                return Ok(());
            }
        }
    }

    fn key(&self, code: u8) -> Event {
        Event::Key { symbol: self.symbols.get(usize::from(code)).copied().unwrap_or(0), is_down: true }
    }

    fn button(&mut self, number: u8, is_down: bool) -> Vec<Event> {
        self.held_or_not(Event::Button { number, is_down: true }, is_down)
    }

    /// Records a pressed or released key or button, and returns its event; `held` is its press.
    fn held_or_not(&mut self, held: Event, is_down: bool) -> Vec<Event> {
        if matches!(held, Event::Key { symbol: 0, .. }) {
            // A key without a symbol has no name.
            return Vec::new();
        }
        self.held.retain(|known| *known != held);
        if is_down {
            self.held.push(held);
        }
        vec![if is_down { held } else { held.released() }]
    }

    fn released(&mut self) -> Vec<Event> {
        self.held.drain(..).map(|held| held.released()).collect()
    }

    fn place(&self, x: i16, y: i16) -> Event {
        let part = |at: i16, size: u16| ((f64::from(at) + 0.5) / f64::from(size.max(1))).clamp(0.0, 1.0);
        Event::Place { x: part(x, self.size.0), y: part(y, self.size.1) }
    }
}

fn print(lines: &[Event]) -> std::io::Result<()> {
    let mut output = std::io::stdout().lock();
    lines.iter().try_for_each(|line| writeln!(output, "{line}"))?;
    output.flush()
}
