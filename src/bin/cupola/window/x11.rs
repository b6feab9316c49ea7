//! Windows on any X screen or monitor: the X server shows the pictures, or, with a swap interval or a
//! swap group, an OpenGL driver does.

use super::presenter::{Filled, Heard, report_size};
use crate::failure::Failure;
use cupola::backend::gl::driver::glx;
use cupola::rig::WindowSwaps;
use std::cell::Cell;
use std::fmt::Display;
use std::time::{Duration, Instant};
use x11rb::connection::{Connection, RequestConnection};
use x11rb::protocol::Event;
use x11rb::protocol::randr::ConnectionExt as _;
use x11rb::protocol::xproto::{
    ChangeWindowAttributesAux, ConnectionExt as _, CreateGCAux, CreateWindowAux, EventMask, ImageFormat, ImageOrder,
    InputFocus, Rectangle, Screen, WindowClass,
};
use x11rb::rust_connection::RustConnection;

/// A window on an X screen, which opens with the first picture and closes with this value.
pub struct Presenter {
    connection: RustConnection,
    /// Name of the screen, for messages.
    name: String,
    screen: Screen,
    /// Rectangle to fill: x and y, and width and height in pixels; `None` = the size of the
    /// picture.
    filled: ((i16, i16), Option<(u16, u16)>),
    swaps: WindowSwaps,
    window: Option<Window>,
    /// Monitor that the window fills, and the time at which its place was last asked for.
    monitor: Option<(String, Cell<Instant>)>,
}

/// Interval at which the place of a monitor is asked for.
const LOOK: Duration = Duration::from_secs(1);

/// A window, with the object that draws into it.
struct Window {
    window: u32,
    context: u32,
    size: (u16, u16),
    /// The driver that shows the pictures; `None`: the X server does.
    driver: Option<glx::window::Window>,
}

fn failed(name: &str) -> impl Fn(&dyn Display) -> Failure {
    move |error| Failure::new(format!("the X screen {name}: {error}"))
}

impl Presenter {
    /// Connects to a screen, for example `:0.1`; `None` = `$DISPLAY`. With `swaps` an OpenGL driver
    /// shows the pictures, without them the X server.
    ///
    /// # Errors
    /// The screen or the monitor does not exist, or its pixels do not have 8 bits for each of red,
    /// green and blue.
    pub fn open(display: Option<&str>, filled: &Filled, swaps: WindowSwaps) -> Result<Self, Failure> {
        let name = display.map(str::to_owned).or_else(|| std::env::var("DISPLAY").ok()).unwrap_or_default();
        let failed = failed(&name);
        let (connection, number) = x11rb::connect(display).map_err(|error| failed(&error))?;
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
        let on_monitor = match filled {
            Filled::Monitor(name) => Some((name.clone(), Cell::new(Instant::now()))),
            _ => None,
        };
        let filled = match filled {
            Filled::Picture { x, y } => ((*x, *y), None),
            Filled::Screen => ((0, 0), Some((screen.width_in_pixels, screen.height_in_pixels))),
            Filled::Monitor(wanted) => {
                let (x, y, width, height) = monitor(&connection, &name, screen.root, wanted)?;
                ((x, y), Some((width, height)))
            }
        };
        drop(failed);
        Ok(Self { connection, name, screen, filled, swaps, window: None, monitor: on_monitor })
    }

    /// Opens the window for pictures of a size.
    fn open_window(&self, (width, height): (u32, u32)) -> Result<Window, Failure> {
        let side = |side: u32| u16::try_from(side).unwrap_or(u16::MAX);
        let picture = (side(width), side(height));
        let ((x, y), filled) = self.filled;
        let (width, height) = filled.unwrap_or(picture);
        report_size((picture.0.into(), picture.1.into()), (width.into(), height.into()));
        let (connection, root) = (&self.connection, self.screen.root);
        let open = || -> Result<Window, x11rb::errors::ReplyOrIdError> {
            let (window, context) = (connection.generate_id()?, connection.generate_id()?);
            // Window managers do not move this window.
            let looks = CreateWindowAux::new().override_redirect(1).background_pixel(self.screen.black_pixel);
            let looks = looks.cursor(no_cursor(connection, root)?);
            let class = WindowClass::INPUT_OUTPUT;
            connection.create_window(0, window, root, x, y, width, height, 0, class, 0, &looks)?;
            connection.create_gc(context, window, &CreateGCAux::new())?;
            connection.map_window(window)?.check()?;
            Ok(Window { window, context, size: (width, height), driver: None })
        };
        let made = open().map_err(|error| failed(&self.name)(&error))?;
        let wants = self.swaps != WindowSwaps::default();
        Ok(Window { driver: wants.then(|| self.driver(&made)).flatten(), ..made })
    }

    /// Returns a driver with the swap interval and the swap group. Messages say what it refuses.
    fn driver(&self, made: &Window) -> Option<glx::window::Window> {
        let size = (made.size.0.into(), made.size.1.into());
        let driver = glx::window::Window::new(Some(&self.name), made.window, self.screen.root_visual, size);
        let driver = match driver {
            Ok(driver) => driver,
            Err(error) => {
                let why = error.message;
                eprintln!("cupola: the X server shows the pictures, without swap interval and swap group: {why}");
                return None;
            }
        };
        if self.swaps.interval.is_some_and(|interval| !driver.set_interval(interval)) {
            eprintln!("cupola: the driver has no swap interval");
        }
        if let Some(group) = self.swaps.group {
            if !driver.join_group(group) {
                eprintln!(
                    "cupola: the driver does not let the window join swap group {group}, so displays are not locked \
                     together; `cupola doctor` says whether it has swap groups"
                );
            } else if let Some(barrier) = self.swaps.barrier
                && !driver.bind_barrier(group, barrier)
            {
                eprintln!("cupola: the driver does not bind swap group {group} to barrier {barrier}");
            }
        }
        Some(driver)
    }

    /// Shows a picture as [`presenter::Presenter::show`](super::presenter::Presenter::show) does.
    ///
    /// # Errors
    /// The X server is gone, or refuses the window.
    pub fn show(&mut self, size: (u32, u32), rgba: &[u8]) -> Result<(), Failure> {
        if self.window.is_none() {
            self.window = Some(self.open_window(size)?);
        }
        let Some(Window { window, context, size: (across, down), driver }) = &mut self.window else { return Ok(()) };
        if let Some(driver) = driver {
            driver.show(size, rgba)?;
            return self.look_for_monitor();
        }
        let (window, context, across, down) = (*window, *context, *across, *down);
        let failed = failed(&self.name);
        let (width, height) = (size.0.min(across.into()) as u16, size.1.min(down.into()) as u16);
        let row = size.0 as usize * 4;
        let shown = usize::from(width) * 4;
        // A request without its pixels has less than a hundred bytes.
        let rows = (self.connection.maximum_request_bytes().saturating_sub(100) / shown.max(1)).max(1);
        let all: Vec<&[u8]> = rgba.chunks_exact(row.max(1)).take(height as usize).collect();
        let mut bytes = Vec::new();
        for (index, part) in all.chunks(rows).enumerate() {
            bytes.clear();
            for row in part {
                let (pixels, _) = row[..shown].as_chunks::<4>();
                bytes.extend(pixels.iter().flat_map(|[red, green, blue, _]| [*blue, *green, *red, 0]));
            }
            let (y, count) = ((index * rows) as i16, part.len() as u16);
            self.connection
                .put_image(ImageFormat::Z_PIXMAP, window, context, width, count, 0, y, 0, 24, &bytes)
                .map_err(|error| failed(&error))?;
        }
        self.wait()
    }

    /// Lets the open window have the keyboard and the mouse's buttons.
    ///
    /// # Errors
    /// The X server is gone.
    pub fn take_keyboard(&self) -> Result<(), Failure> {
        let Some(Window { window, .. }) = self.window else { return Ok(()) };
        let take = || -> Result<(), x11rb::errors::ReplyError> {
            let heard = ChangeWindowAttributesAux::new()
                .event_mask(EventMask::KEY_PRESS | EventMask::BUTTON_PRESS | EventMask::EXPOSURE);
            self.connection.change_window_attributes(window, &heard)?.check()?;
            self.connection.set_input_focus(InputFocus::POINTER_ROOT, window, x11rb::CURRENT_TIME)?.check()
        };
        take().map_err(|error| failed(&self.name)(&error))
    }

    /// What happened to the window since the last call.
    ///
    /// # Errors
    /// The X server is gone.
    pub fn heard(&self) -> Result<Heard, Failure> {
        let mut heard = Heard::default();
        while let Some(event) = self.connection.poll_for_event().map_err(|error| failed(&self.name)(&error))? {
            heard.is_pressed |= matches!(event, Event::KeyPress(_) | Event::ButtonPress(_));
            heard.is_uncovered |= matches!(event, Event::Expose(_));
        }
        Ok(heard)
    }

    /// Waits until the screen has executed all requests.
    ///
    /// # Errors
    /// The X server is gone, or the monitor is, or it has another place.
    pub fn wait(&self) -> Result<(), Failure> {
        let failed = failed(&self.name);
        let answer = self.connection.get_input_focus().map_err(|error| failed(&error))?;
        answer.reply().map(|_| ()).map_err(|error| failed(&error))?;
        self.look_for_monitor()
    }

    /// Fails if the monitor is gone or has another place; asks once a second.
    fn look_for_monitor(&self) -> Result<(), Failure> {
        let Some((wanted, asked)) = self.monitor.as_ref().filter(|(_, asked)| asked.get().elapsed() > LOOK) else {
            return Ok(());
        };
        asked.set(Instant::now());
        let (x, y, width, height) = monitor(&self.connection, &self.name, self.screen.root, wanted)?;
        match self.filled == ((x, y), Some((width, height))) {
            true => Ok(()),
            false => Err(Failure::new(format!("the X screen {}: monitor {wanted} has another place", self.name))),
        }
    }
}

/// Creates a cursor without any pixel: the pointer would be a part of the picture.
fn no_cursor(connection: &RustConnection, root: u32) -> Result<u32, x11rb::errors::ReplyOrIdError> {
    let (pixmap, cursor) = (connection.generate_id()?, connection.generate_id()?);
    connection.create_pixmap(1, pixmap, root, 1, 1)?;
    let context = connection.generate_id()?;
    connection.create_gc(context, pixmap, &CreateGCAux::new().foreground(0))?;
    let point = Rectangle { x: 0, y: 0, width: 1, height: 1 };
    connection.poly_fill_rectangle(pixmap, context, &[point])?;
    connection.create_cursor(cursor, pixmap, pixmap, 0, 0, 0, 0, 0, 0, 0, 0)?;
    connection.free_gc(context)?;
    connection.free_pixmap(pixmap)?;
    Ok(cursor)
}

/// Rectangle of a monitor.
fn monitor(connection: &RustConnection, name: &str, root: u32, wanted: &str) -> Result<(i16, i16, u16, u16), Failure> {
    let failed = failed(name);
    let monitors = connection.randr_get_monitors(root, true).map_err(|error| failed(&error))?;
    let monitors = monitors.reply().map_err(|error| failed(&error))?.monitors;
    let mut names = Vec::new();
    for monitor in monitors {
        let own = connection.get_atom_name(monitor.name).map_err(|error| failed(&error))?;
        let own = String::from_utf8_lossy(&own.reply().map_err(|error| failed(&error))?.name).into_owned();
        if own == wanted {
            return Ok((monitor.x, monitor.y, monitor.width, monitor.height));
        }
        names.push(own);
    }
    Err(Failure::usage(format!("the X screen {name} has no monitor {wanted:?}, but {}", names.join(", "))))
}
