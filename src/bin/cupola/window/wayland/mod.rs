//! Windows on a Wayland compositor. It shows whole pictures only, without tearing.

mod events;

use self::events::{Events, Output};
use super::presenter::{Filled, Heard, report_size};
use crate::failure::Failure;
use cupola::system::anonymous_file;
use std::fmt::Display;
use std::fs::File;
use std::os::fd::AsFd;
use std::os::unix::fs::FileExt;
use std::os::unix::net::UnixStream;
use std::path::PathBuf;
use std::time::{Duration, Instant};
use wayland_client::globals::{BindError, GlobalList, registry_queue_init};
use wayland_client::protocol::{wl_buffer, wl_compositor, wl_output, wl_seat, wl_shm, wl_surface};
use wayland_client::{Connection, EventQueue, Proxy};
use wayland_protocols::wp::viewporter::client::wp_viewporter;
use wayland_protocols::xdg::shell::client::xdg_wm_base;
use wayland_protocols::xdg::xdg_output::zv1::client::zxdg_output_manager_v1::ZxdgOutputManagerV1;

/// Number of pictures in memory: the compositor shows one, and may hold another one.
pub const BUFFERS: usize = 3;
/// Longest time that a picture waits for the display, since hidden windows are not shown.
const HIDDEN: Duration = Duration::from_millis(100);
/// Interval at which answers of the compositor are waited for.
const GLANCE: Duration = Duration::from_millis(1);

/// A window of a Wayland compositor, which opens with the first picture and closes with this value.
pub struct Presenter {
    queue: EventQueue<Events>,
    events: Events,
    globals: GlobalList,
    /// Name of the compositor's socket, for messages.
    name: String,
    filled: Filled,
    window: Option<Window>,
}

/// The window, its memory, and the monitor that it fills.
struct Window {
    surface: wl_surface::WlSurface,
    buffers: Vec<wl_buffer::WlBuffer>,
    memory: File,
    size: (u32, u32),
    monitor: Option<FilledMonitor>,
}

/// The monitor that a window fills.
struct FilledMonitor {
    number: u32,
    size: (u32, u32),
    /// Size that the compositor gave the window there, in its own units.
    given: (i32, i32),
}

fn failed(name: &str) -> impl Fn(&dyn Display) -> Failure + use<> {
    let name = name.to_owned();
    move |error| Failure::new(format!("the Wayland compositor {name}: {error}"))
}

/// Returns the monitors of a compositor, each with its name and size.
///
/// # Errors
/// As for [`Presenter::open`].
pub fn monitors(socket: &str) -> Result<Vec<String>, Failure> {
    let presenter = Presenter::open(socket, &Filled::Picture { x: 0, y: 0 })?;
    let describe = |output: &Output| format!("{} {}x{}", output.name, output.seen().0, output.seen().1);
    Ok(presenter.events.outputs.iter().map(describe).collect())
}

impl Presenter {
    /// Connects to the compositor with this socket, for example `wayland-0`.
    ///
    /// # Errors
    /// There is no such compositor, it lacks a necessary interface, or it has no such monitor.
    pub fn open(socket: &str, filled: &Filled) -> Result<Self, Failure> {
        let failed = failed(socket);
        let folder = std::env::var_os("XDG_RUNTIME_DIR").map(PathBuf::from).unwrap_or_default();
        let path = folder.join(socket);
        if !path.is_absolute() {
            return Err(failed(&"XDG_RUNTIME_DIR, the folder of its socket, is not set"));
        }
        let stream = UnixStream::connect(path).map_err(|error| failed(&error))?;
        let connection = Connection::from_socket(stream).map_err(|error| failed(&error))?;
        let (globals, mut queue) = registry_queue_init::<Events>(&connection).map_err(|error| failed(&error))?;
        let (handle, mut events) = (queue.handle(), Events { is_shown: true, ..Events::default() });
        for global in globals.contents().clone_list() {
            if global.interface == wl_output::WlOutput::interface().name {
                events.bind_output(globals.registry(), global.name, global.version, &handle);
            }
        }
        // Older compositors give names to monitors only by this interface.
        if let Ok(manager) = globals.bind::<ZxdgOutputManagerV1, _, _>(&handle, 2..=3, ()) {
            for output in &events.outputs {
                manager.get_xdg_output(&output.output, &handle, output.number);
            }
        }
        // Without a seat there is no keyboard.
        let _ = globals.bind::<wl_seat::WlSeat, _, _>(&handle, 1..=5, ());
        // The second answer has the names and modes of the monitors.
        queue.roundtrip(&mut events).map_err(|error| failed(&error))?;
        let presenter = Self { queue, events, globals, name: socket.to_owned(), filled: filled.clone(), window: None };
        presenter.monitor()?;
        Ok(presenter)
    }

    /// The monitor that the window fills; `None` if it is as large as the picture.
    fn monitor(&self) -> Result<Option<&Output>, Failure> {
        let outputs = &self.events.outputs;
        match &self.filled {
            Filled::Picture { .. } => Ok(None),
            Filled::Screen => match outputs.first() {
                Some(output) => Ok(Some(output)),
                None => Err(failed(&self.name)(&"it has no monitor")),
            },
            Filled::Monitor(wanted) => {
                let found = outputs.iter().find(|output| output.name == *wanted);
                let names = || outputs.iter().map(|output| &*output.name).collect::<Vec<_>>().join(", ");
                let missing = || {
                    let name = &self.name;
                    Failure::usage(format!("the Wayland compositor {name} has no monitor {wanted:?}, but {}", names()))
                };
                found.map(Some).ok_or_else(missing)
            }
        }
    }

    /// Opens the window for pictures of a size.
    fn open_window(&mut self, picture: (u32, u32)) -> Result<Window, Failure> {
        let failed = failed(&self.name);
        let monitor = self.monitor()?.map(|output| (output.output.clone(), output.number, output.seen()));
        let size = monitor.as_ref().map_or(picture, |(_, _, size)| *size);
        // A monitor without a mode.
        if size.0 == 0 || size.1 == 0 {
            return Err(failed(&"the monitor is switched off"));
        }
        report_size(picture, size);
        let handle = self.queue.handle();
        let lacks = |name: &'static str| {
            let failed = &failed;
            move |error: BindError| failed(&format!("{name}: {error}"))
        };
        let compositor: wl_compositor::WlCompositor =
            self.globals.bind(&handle, 4..=4, ()).map_err(lacks("wl_compositor 4"))?;
        let shell: xdg_wm_base::XdgWmBase = self.globals.bind(&handle, 1..=1, ()).map_err(lacks("xdg_wm_base"))?;
        let memory: wl_shm::WlShm = self.globals.bind(&handle, 1..=1, ()).map_err(lacks("wl_shm"))?;
        let viewporter: Option<wp_viewporter::WpViewporter> = self.globals.bind(&handle, 1..=1, ()).ok();
        let surface = compositor.create_surface(&handle, ());
        let shell_surface = shell.get_xdg_surface(&surface, &handle, ());
        let toplevel = shell_surface.get_toplevel(&handle, ());
        toplevel.set_title("Cupola".into());
        toplevel.set_app_id("cupola".into());
        if let Some((output, ..)) = &monitor {
            toplevel.set_fullscreen(Some(output));
        }
        surface.commit();
        while !self.events.is_configured {
            self.queue.blocking_dispatch(&mut self.events).map_err(|error| failed(&error))?;
        }
        // Pixels of the picture are pixels of the monitor, whatever units the compositor has.
        let (across, down) = self.events.proposed;
        if let Some(viewporter) = viewporter.filter(|_| monitor.is_some() && across > 0 && down > 0) {
            viewporter.get_viewport(&surface, &handle, ()).set_destination(across, down);
        }
        let bytes = 4 * u64::from(size.0) * u64::from(size.1);
        let all = i32::try_from(bytes * BUFFERS as u64).map_err(|_| failed(&"the picture is too large"))?;
        let file = anonymous_file(c"cupola-window", all as u64).map_err(|error| failed(&error))?;
        let pool = memory.create_pool(file.as_fd(), all, &handle, ());
        let buffer = |number: usize| {
            let (offset, row) = (number as i32 * (all / BUFFERS as i32), 4 * size.0 as i32);
            let format = wl_shm::Format::Xrgb8888;
            pool.create_buffer(offset, size.0 as i32, size.1 as i32, row, format, &handle, number)
        };
        let buffers = (0..BUFFERS).map(buffer).collect();
        pool.destroy();
        let monitor = monitor.map(|(_, number, size)| FilledMonitor { number, size, given: (across, down) });
        Ok(Window { surface, buffers, memory: file, size, monitor })
    }

    /// Shows a picture as [`super::presenter::Presenter::show`] does. A hidden window does not hold it up.
    ///
    /// # Errors
    /// The compositor is gone, it has closed the window, or the monitor is gone.
    pub fn show(&mut self, size: (u32, u32), rgba: &[u8]) -> Result<(), Failure> {
        if self.window.is_none() {
            self.window = Some(self.open_window(size)?);
        }
        let free = loop {
            match self.events.is_read.iter().position(|is_read| !is_read) {
                Some(free) => break free,
                None => self.wait()?,
            }
            std::thread::sleep(GLANCE);
        };
        let failed = failed(&self.name);
        let Some(window) = &self.window else { return Ok(()) };
        window.write(free, size, rgba).map_err(|error| failed(&error))?;
        window.surface.attach(Some(&window.buffers[free]), 0, 0);
        window.surface.damage_buffer(0, 0, window.size.0 as i32, window.size.1 as i32);
        // A hidden window gets no answer: one question at a time.
        if self.events.is_shown {
            window.surface.frame(&self.queue.handle(), ());
            self.events.is_shown = false;
        }
        window.surface.commit();
        self.events.is_read[free] = true;
        let begin = Instant::now();
        loop {
            self.wait()?;
            if self.events.is_shown || begin.elapsed() > HIDDEN {
                return Ok(());
            }
            std::thread::sleep(GLANCE);
        }
    }

    /// What happened to the window since the last call.
    ///
    /// # Errors
    /// As for [`Presenter::wait`].
    pub fn heard(&mut self) -> Result<Heard, Failure> {
        self.wait()?;
        Ok(Heard { is_pressed: std::mem::take(&mut self.events.is_pressed), is_uncovered: false })
    }

    /// Waits until the compositor has executed all requests.
    ///
    /// # Errors
    /// The compositor is gone, it has closed the window, or the monitor is gone or has another size.
    pub fn wait(&mut self) -> Result<(), Failure> {
        let failed = failed(&self.name);
        self.queue.roundtrip(&mut self.events).map_err(|error| failed(&error))?;
        if self.events.is_closed {
            return Err(failed(&"it has closed the window"));
        }
        let Some(filled) = self.window.as_ref().and_then(|window| window.monitor.as_ref()) else { return Ok(()) };
        if self.events.proposed != filled.given {
            return Err(failed(&"it has given the window another size"));
        }
        match self.events.outputs.iter().find(|output| output.number == filled.number) {
            Some(output) if output.seen() == filled.size => Ok(()),
            Some(output) => Err(failed(&format!("monitor {} has another size", output.name))),
            None => Err(failed(&"the monitor of the window is gone")),
        }
    }
}

impl Window {
    /// Writes a picture to a buffer. What it does not fill is black.
    fn write(&self, number: usize, picture: (u32, u32), rgba: &[u8]) -> std::io::Result<()> {
        let [across, down] = [self.size.0, self.size.1].map(|side| side as usize);
        let row = 4 * across;
        let mut bytes = vec![0; row * down];
        let shown = row.min(4 * picture.0 as usize);
        for (to, from) in bytes.chunks_exact_mut(row.max(1)).zip(rgba.chunks_exact((4 * picture.0 as usize).max(1))) {
            let (to, from) = (to[..shown].as_chunks_mut::<4>().0, from[..shown].as_chunks::<4>().0);
            to.iter_mut().zip(from).for_each(|(to, [red, green, blue, _])| *to = [*blue, *green, *red, 0]);
        }
        self.memory.write_all_at(&bytes, (number * bytes.len()) as u64)
    }
}
