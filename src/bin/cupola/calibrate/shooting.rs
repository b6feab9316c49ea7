//! Patterns on the projectors, and a camera that is told to photograph each.

use super::patterns::Patterns;
use super::{Arguments, photographs};
use crate::failure::Failure;
use crate::terminal;
use crate::window::screens::Screen;
use cupola::rig::Rig;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::Duration;

/// Text in the camera's command that stands for the photograph's file without its ending.
const FILE: &str = "{}";

/// Longest pause before a photograph, seconds.
const LONGEST_PAUSE: f64 = 60.0;

/// Shows all patterns and photographs them into `folder`. Returns the number of photographs.
///
/// # Errors
/// The folder has photographs already, an output has no window, or the camera's command fails.
pub fn run(arguments: &Arguments, rig: &Rig, command: &str, folder: &Path) -> Result<usize, Failure> {
    if !command.contains(FILE) {
        return Err(Failure::usage(format!(
            "--camera {command:?}: {FILE} is missing, which stands for the photograph's file without ending, for \
             example gphoto2 --capture-image-and-download --filename {FILE}.jpg"
        )));
    }
    if !(0.0..=LONGEST_PAUSE).contains(&arguments.pause) {
        return Err(Failure::usage(format!("--pause {}: expected 0 to {LONGEST_PAUSE} seconds", arguments.pause)));
    }
    let patterns = Patterns::new(rig, arguments)?;
    std::fs::create_dir_all(folder)
        .map_err(|error| Failure::usage(format!("the folder {} cannot be created: {error}", folder.display())))?;
    let known = photographs::files(folder)?.len();
    if known > 0 {
        return Err(Failure::usage(format!(
            "{} has {known} photographs already; give another folder, or leave out --camera to use them",
            folder.display()
        )));
    }
    let mut screens = screens(arguments, rig, &patterns)?;
    let bar = terminal::progress(patterns.count() as u64, "photographs");
    for (number, pattern) in patterns.all().enumerate() {
        let (size, values) = (patterns.size(&pattern), patterns.values(&pattern));
        let own = rig.outputs[pattern.output].own_window.as_ref().map(|_| pattern.output);
        for screen in &mut screens {
            screen.show((screen.screen.output == own).then_some((size, &values)))?;
        }
        std::thread::sleep(Duration::from_secs_f64(arguments.pause));
        let file = photograph(command, folder, &pattern.name).and_then(|file| match number {
            // Before all others are made.
            0 => photographs::read(&file).map(|_| ()).map_err(|failure| failure.message),
            _ => Ok(()),
        });
        if let Err(why) = file {
            bar.finish_and_clear();
            return Err(Failure::new(format!("photograph {} ({}): {why}", number + 1, pattern.name)));
        }
        bar.inc(1);
    }
    bar.finish_and_clear();
    Ok(patterns.count())
}

/// A window of patterns.
struct Shown {
    screen: Screen,
    /// Size in pixels while it shows no pattern.
    size: (u32, u32),
    is_black: bool,
}

impl Shown {
    /// Shows grey values, or black.
    fn show(&mut self, pattern: Option<((u32, u32), &Vec<u8>)>) -> Result<(), Failure> {
        match pattern {
            Some((size, values)) => {
                let rgba: Vec<u8> = values.iter().flat_map(|value| [*value, *value, *value, u8::MAX]).collect();
                self.is_black = false;
                self.screen.show(size, &rgba)
            }
            None if self.is_black => Ok(()),
            None => {
                self.is_black = true;
                self.screen.show(self.size, &vec![0; self.size.0 as usize * self.size.1 as usize * 4])
            }
        }
    }
}

/// Opens the screens of all projectors.
fn screens(arguments: &Arguments, rig: &Rig, patterns: &Patterns<'_>) -> Result<Vec<Shown>, Failure> {
    let outputs = || patterns.all().map(|pattern| pattern.output);
    if let Some(unseen) = outputs().find(|output| !Screen::is_seen(&rig.outputs[*output])) {
        return Err(Failure::usage(format!(
            "the patterns of {} cannot be shown: it has shown = false, and neither display nor monitor nor fullscreen; \
             write them with --patterns, and show them on its machine",
            rig.outputs[unseen].name
        )));
    }
    let shown = |screen: Screen| {
        let is_seen = |output: usize| match screen.output {
            Some(own) => own == output,
            None => rig.outputs[output].own_window.is_none(),
        };
        let size = patterns.all().find(|pattern| is_seen(pattern.output)).map_or((1, 1), |first| patterns.size(&first));
        Shown { screen, size, is_black: false }
    };
    let screens = Screen::open(rig, outputs(), arguments.display.as_deref())?;
    Ok(screens.into_iter().map(shown).collect())
}

/// Runs the camera's command, and returns the photograph.
fn photograph(command: &str, folder: &Path, name: &str) -> Result<PathBuf, String> {
    // As an argument of the shell, the name may have spaces.
    let script = command.replace(FILE, "\"$1\"");
    let run = Command::new("sh").args(["-c", &script, "sh"]).arg(folder.join(name)).stdin(Stdio::null()).output();
    let run = run.map_err(|error| format!("the command of --camera cannot be started: {error}"))?;
    if !run.status.success() {
        let words = String::from_utf8_lossy(&run.stderr);
        let last = words.trim_end().lines().last().map(|line| format!(": {line}")).unwrap_or_default();
        return Err(format!("the command of --camera failed ({}){last}", run.status));
    }
    let made = photographs::files(folder).map_err(|failure| failure.message)?;
    made.into_iter()
        .find(|file| file.file_stem().is_some_and(|stem| stem == name))
        .ok_or_else(|| format!("the command of --camera made no file {name}.jpg or {name}.png in {}", folder.display()))
}
