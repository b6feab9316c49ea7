//! Windows that show pictures pixel for pixel, of an X server or a Wayland compositor.

use super::wayland;
use super::x11;
use crate::failure::Failure;
use cupola::rig::WindowSwaps;

/// Part of a screen that a window fills.
#[derive(Clone, Debug)]
pub enum Filled {
    /// As many pixels as the picture has, with the upper left corner at this place on the screen.
    Picture { x: i16, y: i16 },
    /// The whole screen.
    Screen,
    /// The monitor with this name, as xrandr or the Wayland compositor lists it.
    Monitor(String),
}

impl Filled {
    /// The monitor with this name, else the whole screen if it is wanted, else a picture at `corner`.
    pub fn of(monitor: Option<&str>, fullscreen: bool, corner: (i16, i16)) -> Self {
        match monitor {
            Some(monitor) => Self::Monitor(monitor.to_owned()),
            None if fullscreen => Self::Screen,
            None => Self::Picture { x: corner.0, y: corner.1 },
        }
    }
}

/// What happened to a window.
#[derive(Clone, Copy, Debug, Default)]
pub struct Heard {
    /// True if a key or a button of the mouse was pressed in it.
    pub is_pressed: bool,
    /// True if a part of its picture was lost, because another window covered it.
    pub is_uncovered: bool,
}

/// A window, which opens with the first picture and closes with this value.
pub enum Presenter {
    /// On an X screen.
    X11(Box<x11::Presenter>),
    /// On a Wayland compositor.
    Wayland(Box<wayland::Presenter>),
}

impl Presenter {
    /// Connects to an X screen, for example `:0.1`, or to a Wayland compositor, for example
    /// `wayland-0`. `None`: the compositor of `$WAYLAND_DISPLAY` for a monitor, or if there is no
    /// `$DISPLAY`; else `$DISPLAY`.
    ///
    /// # Errors
    /// The screen, the compositor or the monitor does not exist, or cannot show such pictures.
    pub fn open(display: Option<&str>, filled: &Filled, swaps: WindowSwaps) -> Result<Self, Failure> {
        let x11 = || Ok(Self::X11(Box::new(x11::Presenter::open(display, filled, swaps)?)));
        let Some(socket) = socket(display, filled, swaps) else { return x11() };
        let opened = wayland::Presenter::open(&socket, filled);
        // The variable of the compositor may be that of another session.
        if opened.is_err()
            && display.is_none()
            && let Ok(window) = x11()
        {
            return Ok(window);
        }
        let window = opened?;
        if swaps.group.is_some() || swaps.interval.is_some_and(|interval| interval != 1) {
            eprintln!(
                "cupola: {socket} is a Wayland compositor, which shows whole pictures, one in each refresh: swap \
                 interval and swap group are for X screens"
            );
        }
        Ok(Self::Wayland(Box::new(window)))
    }

    /// Shows a picture with red, green, blue and one more byte for each pixel. It waits until the X
    /// screen has it; with Wayland until the compositor asks for the next one, at most a tenth of a
    /// second. The picture is not scaled: what does not fit into the window is left out on the right
    /// and below. A message says if the size of the first picture is not that of the window.
    ///
    /// # Errors
    /// The server or the monitor is gone, or it refuses or has closed the window.
    pub fn show(&mut self, size: (u32, u32), rgba: &[u8]) -> Result<(), Failure> {
        match self {
            Self::X11(window) => window.show(size, rgba),
            Self::Wayland(window) => window.show(size, rgba),
        }
    }

    /// Lets the open window have the keyboard and the mouse's buttons. A Wayland compositor decides
    /// that alone.
    ///
    /// # Errors
    /// The X server is gone.
    pub fn take_keyboard(&self) -> Result<(), Failure> {
        match self {
            Self::X11(window) => window.take_keyboard(),
            Self::Wayland(_) => Ok(()),
        }
    }

    /// What happened to the window since the last call.
    ///
    /// # Errors
    /// As for [`Presenter::wait`].
    pub fn heard(&mut self) -> Result<Heard, Failure> {
        match self {
            Self::X11(window) => window.heard(),
            Self::Wayland(window) => window.heard(),
        }
    }

    /// Waits until the server has executed all requests.
    ///
    /// # Errors
    /// The server is gone, or it has closed the window, or the monitor is gone or has another place
    /// or size.
    pub fn wait(&mut self) -> Result<(), Failure> {
        match self {
            Self::X11(window) => window.wait(),
            Self::Wayland(window) => window.wait(),
        }
    }
}

/// Value of an environment variable, if it is not empty.
fn set(name: &str) -> Option<String> {
    std::env::var(name).ok().filter(|value| !value.is_empty())
}

/// Socket of the Wayland compositor that shows the window; `None`: an X server does. Windows with
/// places, and those over several monitors, are possible only there.
fn socket(display: Option<&str>, filled: &Filled, swaps: WindowSwaps) -> Option<String> {
    match display {
        // Names of X screens have a colon.
        Some(display) => (!display.contains(':')).then(|| display.to_owned()),
        None if set("DISPLAY").is_none() => set("WAYLAND_DISPLAY"),
        None => set("WAYLAND_DISPLAY").filter(|_| matches!(filled, Filled::Monitor(_)) && swaps.group.is_none()),
    }
}

/// Says if a picture does not fill its place on the screen.
pub(super) fn report_size(picture: (u32, u32), place: (u32, u32)) {
    if picture != place {
        eprintln!(
            "cupola: the picture has {}x{} pixels, its place on the screen {}x{}: it is not scaled (size of the \
             output in the rig)",
            picture.0, picture.1, place.0, place.1
        );
    }
}
