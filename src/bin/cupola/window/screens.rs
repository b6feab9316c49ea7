//! Screens on which the outputs of a rig are seen: the window that they share, and windows of their
//! own. For pictures that Cupola makes itself, without a program.

use super::presenter::{Filled, Heard, Presenter};
use crate::failure::Failure;
use cupola::rig::{Output, Rig, WindowSwaps};

/// A window of one or several outputs. It opens with the first picture.
pub struct Screen {
    presenter: Presenter,
    /// Number of the output that it shows alone; `None` = the window that outputs share.
    pub output: Option<usize>,
}

impl Screen {
    /// Opens the screens of these outputs. The window that outputs share is at the upper left corner
    /// of `display` (`None` = `$DISPLAY`), and has the size of its first picture. Outputs that this
    /// machine does not show are left out, see [`is_seen`](Self::is_seen).
    ///
    /// # Errors
    /// A screen or a monitor does not exist.
    pub fn open(rig: &Rig, outputs: impl Iterator<Item = usize>, display: Option<&str>) -> Result<Vec<Self>, Failure> {
        let mut screens: Vec<Self> = Vec::new();
        for number in outputs.filter(|number| Self::is_seen(&rig.outputs[*number])) {
            let output = &rig.outputs[number];
            let alone = output.own_window.as_ref().map(|_| number);
            if screens.iter().any(|screen| screen.output == alone) {
                continue;
            }
            let own = output.own_window.as_ref();
            let monitor = own.and_then(|own| own.monitor.as_deref());
            let filled = Filled::of(monitor, own.is_some_and(|own| own.fullscreen), (0, 0));
            let display = own.and_then(|own| own.display.as_deref()).or(display);
            screens.push(Self { presenter: Presenter::open(display, &filled, WindowSwaps::default())?, output: alone });
        }
        Ok(screens)
    }

    /// True if a window of this machine shows the output.
    pub fn is_seen(output: &Output) -> bool {
        output.shown || output.own_window.is_some()
    }

    /// Shows a picture, as [`Presenter::show`] does.
    ///
    /// # Errors
    /// Those of [`Presenter::show`].
    pub fn show(&mut self, size: (u32, u32), rgba: &[u8]) -> Result<(), Failure> {
        self.presenter.show(size, rgba)
    }

    /// Lets the window take the keyboard, so that [`heard`](Self::heard) answers.
    ///
    /// # Errors
    /// The X server is gone, or no picture was shown yet.
    pub fn take_keyboard(&self) -> Result<(), Failure> {
        self.presenter.take_keyboard()
    }

    /// What happened to the window since the last call.
    ///
    /// # Errors
    /// The server is gone, or the window or its monitor is.
    pub fn heard(&mut self) -> Result<Heard, Failure> {
        self.presenter.heard()
    }
}
