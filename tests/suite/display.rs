//! Two X servers that the whole suite shares, and Wayland compositors.

use crate::harness::missing;
use std::io::{BufRead, BufReader, Read, Write};
use std::os::unix::net::UnixStream;
use std::path::PathBuf;
use std::process::{Child, Command, Stdio};
use std::sync::atomic::{AtomicU32, Ordering};
use std::sync::{Condvar, Mutex, OnceLock};
use std::time::{Duration, Instant};
use x11rb::connection::Connection;
use x11rb::protocol::randr::{ConnectionExt as _, MonitorInfo};
use x11rb::protocol::xproto::{
    ConnectionExt as _, CreateWindowAux, ImageFormat, KEY_PRESS_EVENT, KEY_RELEASE_EVENT, WindowClass,
};
use x11rb::protocol::xtest::ConnectionExt as _;

/// A private X server: the name of its display, and the connection that keeps it running.
pub struct Display {
    /// Value for the variable `DISPLAY`.
    pub name: String,
    process: u32,
    _connection: UnixStream,
}

impl Display {
    /// Ends the server, as if its screen were disconnected.
    pub fn kill(self) {
        // `kill` is built into the shell. A minimal Debian has no such program.
        let _ = Command::new("sh").args(["-c", &format!("kill -s KILL {}", self.process)]).status();
    }

    /// Ends the server, and starts another one of the same name after `pause`.
    pub fn restart(self, pause: Duration) -> Self {
        let _ = Command::new("sh").args(["-c", &format!("kill -s TERM {}", self.process)]).status();
        std::thread::sleep(pause);
        let begin = Instant::now();
        loop {
            match start(24, Some(&self.name)) {
                Ok(display) => return display,
                Err(why) => assert!(begin.elapsed() < Duration::from_secs(20), "{why}"),
            }
            std::thread::sleep(Duration::from_millis(50));
        }
    }

    /// Red, green and blue of the pixels at the upper left corner of the screen, row by row from the
    /// top.
    pub fn pixels(&self, size: (u32, u32)) -> Vec<[u8; 3]> {
        self.pixels_at((0, 0), size)
    }

    /// As [`pixels`](Self::pixels), of a rectangle with this upper left corner.
    pub fn pixels_at(&self, (x, y): (u16, u16), (width, height): (u32, u32)) -> Vec<[u8; 3]> {
        let (connection, root) = self.connect();
        let (x, y, width, height) = (x as i16, y as i16, width as u16, height as u16);
        let image = connection.get_image(ImageFormat::Z_PIXMAP, root, x, y, width, height, u32::MAX).expect("sent");
        let data = image.reply().expect("an image").data;
        data.as_chunks::<4>().0.iter().map(|[blue, green, red, _]| [*red, *green, *blue]).collect()
    }
}

impl Display {
    /// Connection to the server, and the root window of its screen.
    fn connect(&self) -> (x11rb::rust_connection::RustConnection, u32) {
        let (connection, number) = x11rb::connect(Some(&self.name)).expect("a screen");
        let root = connection.setup().roots[number].root;
        (connection, root)
    }

    /// Adds a monitor with this upper left corner and size to the screen, as `xrandr --setmonitor` does.
    pub fn add_monitor(&self, name: &str, (x, y): (u16, u16), (width, height): (u32, u32)) {
        let (connection, root) = self.connect();
        let name = connection.intern_atom(false, name.as_bytes()).expect("sent").reply().expect("an atom").atom;
        let monitor = MonitorInfo {
            name,
            x: x as i16,
            y: y as i16,
            width: width as u16,
            height: height as u16,
            ..MonitorInfo::default()
        };
        connection.randr_set_monitor(root, monitor).expect("sent").check().expect("a monitor");
    }

    /// Removes a monitor, as `xrandr --delmonitor` does.
    pub fn remove_monitor(&self, name: &str) {
        let (connection, root) = self.connect();
        let name = connection.intern_atom(true, name.as_bytes()).expect("sent").reply().expect("an atom").atom;
        connection.randr_delete_monitor(root, name).expect("sent").check().expect("no monitor");
    }

    /// Covers a part of the screen with a window for a moment.
    pub fn cover(&self, (x, y): (u16, u16), (width, height): (u32, u32)) {
        let (connection, root) = self.connect();
        let window = connection.generate_id().expect("a number");
        let looks = CreateWindowAux::new().override_redirect(1).background_pixel(0xff_00ff);
        let (x, y, width, height) = (x as i16, y as i16, width as u16, height as u16);
        let kind = WindowClass::INPUT_OUTPUT;
        let made = connection.create_window(0, window, root, x, y, width, height, 0, kind, 0, &looks);
        made.expect("sent").check().expect("a window");
        connection.map_window(window).expect("sent").check().expect("it is shown");
        connection.destroy_window(window).expect("sent").check().expect("it is gone");
    }

    /// Presses and releases a key, for the window that has the keyboard.
    pub fn press_key(&self) {
        let (connection, root) = self.connect();
        let key = connection.setup().min_keycode + 16;
        for event in [KEY_PRESS_EVENT, KEY_RELEASE_EVENT] {
            let sent = connection.xtest_fake_input(event, key, 0, root, 0, 0, 0).expect("sent");
            sent.check().expect("a key");
        }
    }
}

/// Width and height of a place. Some programs open a second window 300 pixels to the right of the
/// first, of up to 384 × 192 pixels.
pub const PLACE: (usize, usize) = (700, 400);
/// Columns and rows of places on the screen. There are more places than tests that usually run at
/// the same time.
const PLACES: (usize, usize) = (4, 4);

/// A part of the screen that one program has to itself: it is free again when this value is
/// dropped, so that the value must live as long as the program runs. The X server returns the
/// pixels of the topmost window.
pub struct Place {
    index: usize,
    /// Upper left corner of the place.
    pub corner: (usize, usize),
}

static TAKEN: Mutex<[bool; PLACES.0 * PLACES.1]> = Mutex::new([false; PLACES.0 * PLACES.1]);
static GIVEN_BACK: Condvar = Condvar::new();

/// Waits for a free place on the screen.
pub fn place() -> Place {
    let mut taken = TAKEN.lock().expect("no holder of the lock can panic");
    loop {
        if let Some(index) = taken.iter().position(|taken| !taken) {
            taken[index] = true;
            return Place { index, corner: (index % PLACES.0 * PLACE.0, index / PLACES.0 * PLACE.1) };
        }
        taken = GIVEN_BACK.wait(taken).expect("no holder of the lock can panic");
    }
}

impl Drop for Place {
    fn drop(&mut self) {
        if let Ok(mut taken) = TAKEN.lock() {
            taken[self.index] = false;
        }
        GIVEN_BACK.notify_one();
    }
}

/// Starts the server at the first call. `None` if Xvfb is not installed.
pub fn get() -> Option<&'static Display> {
    static DISPLAY: OnceLock<Result<Display, String>> = OnceLock::new();
    started(&DISPLAY)
}

/// The server for programs that choose the place of their window, as vkcube does. On the other
/// server they would cover windows of other tests.
pub fn for_installed_programs() -> Option<&'static Display> {
    static DISPLAY: OnceLock<Result<Display, String>> = OnceLock::new();
    started(&DISPLAY)
}

fn started(display: &'static OnceLock<Result<Display, String>>) -> Option<&'static Display> {
    let refused = |reason: &&String| missing(format_args!("no X server: {reason}"));
    display.get_or_init(|| start(24, None)).as_ref().inspect_err(refused).ok()
}

/// A separate server for programs that choose the place of their window. Its screen has `depth`
/// bits per pixel (30: ten per colour). `None` if it cannot be started.
pub fn own(depth: u32) -> Option<Display> {
    let refused = |reason: &String| missing(format_args!("no X server of {depth} bits: {reason}"));
    start(depth, None).inspect_err(refused).ok()
}

/// The server ends by itself (`-terminate`) when its last client has gone. The connection of this
/// process ends with this process. `name`: that of the display; `None`: any free one.
fn start(depth: u32, name: Option<&str>) -> Result<Display, String> {
    let mut server = Command::new("Xvfb")
        .args(name)
        .args(["-displayfd", "1", "-nolisten", "tcp", "-terminate", "-screen", "0"])
        .arg(format!("{}x{}x{depth}", PLACES.0 * PLACE.0, PLACES.1 * PLACE.1))
        .stdout(Stdio::piped())
        .stderr(Stdio::null())
        .spawn()
        .map_err(|error| format!("cannot start Xvfb: {error}"))?;
    let mut number = String::new();
    let output = server.stdout.take().ok_or("Xvfb has no output")?;
    BufReader::new(output).read_line(&mut number).map_err(|error| error.to_string())?;
    let number = number.trim();
    if number.is_empty() {
        return Err("Xvfb ended at once".into());
    }
    let connection = connect(number).map_err(|error| format!("cannot connect to Xvfb: {error}"))?;
    Ok(Display { name: format!(":{number}"), process: server.id(), _connection: connection })
}

/// Opens a client connection (X11 protocol, "Connection Setup"): little-endian, version 11.0, no
/// authorisation.
fn connect(number: &str) -> std::io::Result<UnixStream> {
    let mut stream = UnixStream::connect(format!("/tmp/.X11-unix/X{number}"))?;
    stream.write_all(&[b'l', 0, 11, 0, 0, 0, 0, 0, 0, 0, 0, 0])?;
    let mut answer = [0_u8; 8];
    stream.read_exact(&mut answer)?;
    if answer[0] != 1 {
        return Err(std::io::Error::other("the server refuses the connection"));
    }
    Ok(stream)
}

/// A Wayland compositor without a visible screen, with a folder of its own.
pub struct Compositor {
    process: Child,
    folder: PathBuf,
}

impl Compositor {
    /// Width and height of its screen.
    pub const SIZE: (usize, usize) = (320, 240);
    /// Name of its socket.
    pub const SOCKET: &str = "wayland-cupola";

    /// Starts a compositor without a visible screen. `None` if it cannot be started.
    pub fn start() -> Option<Self> {
        Self::started_with(&["--backend=headless-backend.so"], "")
    }

    /// Starts a compositor whose monitor `screen0` is a window at the upper left corner of a screen.
    pub fn start_on(display: &Display) -> Option<Self> {
        Self::started_with(&["--backend=x11-backend.so", "--use-pixman"], &display.name)
    }

    fn started_with(backend: &[&str], display: &str) -> Option<Self> {
        let refused = |reason: &String| missing(format_args!("no Wayland compositor: {reason}"));
        Self::started(backend, display).inspect_err(refused).ok()
    }

    fn started(backend: &[&str], display: &str) -> Result<Self, String> {
        static NUMBER: AtomicU32 = AtomicU32::new(0);
        let number = NUMBER.fetch_add(1, Ordering::Relaxed);
        // The folder is not in the target folder, because the path of a socket is limited to about
        // a hundred characters.
        let folder = std::env::temp_dir().join(format!("cupola-wayland-{}-{number}", std::process::id()));
        std::fs::create_dir_all(&folder).map_err(|error| error.to_string())?;
        let process = Command::new("weston")
            .args(backend)
            .args(["--no-config", "--idle-time=0"])
            .arg(format!("--socket={}", Self::SOCKET))
            .args([format!("--width={}", Self::SIZE.0), format!("--height={}", Self::SIZE.1)])
            .env("XDG_RUNTIME_DIR", &folder)
            .env("DISPLAY", display)
            .stdin(Stdio::null())
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .map_err(|error| format!("cannot start weston: {error}"))?;
        let mut this = Self { process, folder };
        let started = Instant::now();
        while UnixStream::connect(this.folder.join(Self::SOCKET)).is_err() {
            if let Ok(Some(status)) = this.process.try_wait() {
                return Err(format!("weston ended at once, {status}"));
            }
            if started.elapsed() > Duration::from_secs(60) {
                return Err("weston does not answer".into());
            }
            std::thread::sleep(Duration::from_millis(20));
        }
        Ok(this)
    }

    /// Variables for the environment of the compositor's programs.
    pub fn environment(&self) -> [(&'static str, PathBuf); 2] {
        [("XDG_RUNTIME_DIR", self.folder.clone()), ("WAYLAND_DISPLAY", Self::SOCKET.into())]
    }
}

impl Drop for Compositor {
    fn drop(&mut self) {
        let _ = self.process.kill();
        let _ = self.process.wait();
        let _ = std::fs::remove_dir_all(&self.folder);
    }
}
