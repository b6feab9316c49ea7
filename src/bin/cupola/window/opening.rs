//! Outputs with windows of their own. `cupola run` and mirrors open them through `cupola window`,
//! and open them again when their screens come back.

use crate::launch::{Environment, apply};
use cupola::rig::{Output, OwnWindow, Rig, WindowSwaps};
use cupola::system::process;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// Interval at which the end of a window is checked.
const LOOK: Duration = Duration::from_millis(50);
/// Time until a window that has ended is opened again.
const PAUSE: Duration = Duration::from_secs(1);
/// Time after which an open window counts as working: its next error is reported.
const WORKED: Duration = Duration::from_secs(3);

/// The windows of a run.
#[derive(Default)]
pub struct Windows {
    threads: Vec<JoinHandle<()>>,
    is_over: Arc<AtomicBool>,
}

impl Windows {
    /// Opens a window for each output that has its own, as soon as pictures are published.
    /// `display`: variables of the X server for the program.
    pub fn open(rig: &Rig, published: &Path, display: &Environment) -> Self {
        let here = rig.beside.iter().chain(&rig.outputs).filter(|output| output.here);
        let own = here.filter_map(|output| Some((output, output.own_window.as_ref()?)));
        let mut windows = Self::default();
        own.for_each(|(output, own)| windows.add(Opening::new((output, own), rig.window, published, display)));
        windows
    }

    /// Like [`Windows::open`], and also opens windows for the outputs that a program's window would
    /// show, at their places in it.
    pub fn open_all(rig: &Rig, published: &Path, display: &Environment) -> Self {
        let usual = OwnWindow { display: None, monitor: None, fullscreen: false };
        let places = rig.layout(rig.extent().unwrap_or_default());
        let shown = rig.outputs.iter().zip(places).filter(|(output, _)| output.here && output.shown);
        let shown = shown.filter(|(output, _)| output.own_window.is_none()).map(|(output, place)| Opening {
            at: Some((place.x, place.y)),
            ..Opening::new((output, &usual), rig.window, published, display)
        });
        let mut windows = Self::open(rig, published, display);
        shown.for_each(|opening| windows.add(opening));
        windows
    }

    fn add(&mut self, opening: Opening) {
        let is_over = Arc::clone(&self.is_over);
        self.threads.push(std::thread::spawn(move || opening.keep_open(&is_over)));
    }

    /// Closes the windows after the end of the program.
    pub fn close(self) {
        self.is_over.store(true, Ordering::SeqCst);
        for thread in self.threads {
            // A thread that panicked has printed its message.
            let _ = thread.join();
        }
    }
}

/// Parameters of a window.
struct Opening {
    output: String,
    own: OwnWindow,
    swaps: WindowSwaps,
    /// Upper left corner on the screen; `None`: that of the screen.
    at: Option<(u32, u32)>,
    published: PathBuf,
    display: Environment,
}

impl Opening {
    fn new((output, own): (&Output, &OwnWindow), swaps: WindowSwaps, published: &Path, display: &Environment) -> Self {
        Self {
            output: output.name.clone(),
            own: own.clone(),
            swaps,
            at: None,
            published: published.to_owned(),
            display: display.clone(),
        }
    }

    /// Starts `cupola window`; `loud`: with its messages.
    fn start(&self, loud: bool) -> std::io::Result<Child> {
        let mut command = Command::new(std::env::current_exe()?);
        apply(&mut command, &self.display);
        command.args(["window", &self.output, "--quiet", "--published"]).arg(&self.published);
        if let Some(display) = &self.own.display {
            command.args(["--display", display]);
        }
        if let Some(monitor) = &self.own.monitor {
            command.args(["--monitor", monitor]);
        }
        if let Some((x, y)) = self.at {
            command.args(["--at", &format!("{x},{y}")]);
        }
        let WindowSwaps { interval, group, barrier } = self.swaps;
        for (option, value) in [("--swap-interval", interval), ("--swap-group", group), ("--swap-barrier", barrier)] {
            if let Some(value) = value {
                command.args([option, &value.to_string()]);
            }
        }
        if self.own.fullscreen {
            command.arg("--fullscreen");
        }
        command.stdin(Stdio::null()).stdout(Stdio::null());
        if !loud {
            command.stderr(Stdio::null());
        }
        // This thread lives as long as the window may.
        process::end_with_parent(&mut command).spawn()
    }

    /// Keeps the window open until the program has ended.
    fn keep_open(&self, is_over: &AtomicBool) {
        let mut loud = true;
        while !is_over.load(Ordering::SeqCst) {
            let begin = Instant::now();
            match self.start(loud) {
                Ok(child) => {
                    let has_failed = wait(child, is_over);
                    if has_failed && (loud || begin.elapsed() > WORKED) {
                        let output = &self.output;
                        eprintln!(
                            "cupola: the window of {output} is closed; it is opened again when its screen is there"
                        );
                    }
                }
                Err(error) if loud => eprintln!("cupola: the window of {} cannot be opened: {error}", self.output),
                Err(_) => {}
            }
            loud = begin.elapsed() > WORKED;
            let pause = Instant::now();
            while pause.elapsed() < PAUSE && !is_over.load(Ordering::SeqCst) {
                std::thread::sleep(LOOK);
            }
        }
    }
}

/// Waits for the end of a window, and ends it when the program has ended. Returns whether it
/// failed.
fn wait(mut child: Child, is_over: &AtomicBool) -> bool {
    loop {
        match child.try_wait() {
            Ok(None) if is_over.load(Ordering::SeqCst) => {
                // The window may have ended meanwhile.
                let _ = process::terminate(&child);
                let _ = child.wait();
                return false;
            }
            Ok(None) => std::thread::sleep(LOOK),
            Ok(Some(status)) => return !status.success(),
            Err(_) => return true,
        }
    }
}
