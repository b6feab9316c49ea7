//! A rig that is being changed: a text with its history, and the file that the program follows.
//!
//! The rig's own file changes only when it is saved. The program follows a *working file* in a
//! private folder, which is written after each change that gives a valid rig.

use crate::tune;
use cupola::rig::{self, Rig};
use cupola::ring;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};
use toml_edit::{DocumentMut, Item, Value};

/// Number of steps that can be undone.
const STEPS: usize = 500;
/// Time within which changes of one gesture that follow each other are one step.
const ONE_GESTURE: Duration = Duration::from_secs(2);

/// A rig with its history.
pub struct Working {
    /// Name under which it was opened: a preset or a file.
    name: String,
    /// File of the rig; `None` for a preset.
    file: Option<PathBuf>,
    /// Folder to which paths in the rig are relative.
    folder: PathBuf,
    /// Content of the file when it was last read or written.
    saved: String,
    steps: Vec<String>,
    current: usize,
    gesture: Option<(String, Instant)>,
    rig: Rig,
    /// Changes only for the working file, which replace keys of the text: a pattern.
    shown_instead: Vec<String>,
    working_file: PathBuf,
    /// Checksum of the working file's text, by which the program's frames name it.
    sum: u64,
    version: u64,
}

impl Working {
    /// Opens a preset or a file, for a program that follows `working_file`.
    ///
    /// # Errors
    /// Description of the mistakes in the rig, or of the error of the working file.
    pub fn open(name: &str, working_file: &Path) -> Result<Self, String> {
        let preset = rig::presets().iter().find(|preset| preset.name == name);
        let (file, text) = match preset {
            Some(preset) => (None, preset.text.to_owned()),
            None => {
                // An invalid rig is refused with the usual message before it is read here.
                rig::load(name).map_err(|error| error.message)?;
                let file = std::path::absolute(name).map_err(|error| format!("{name}: {error}"))?;
                let text = rig::text_of_file(&file).map_err(|error| format!("{name}: {error}"))?;
                (Some(file), text)
            }
        };
        let folder = file.as_deref().and_then(Path::parent).unwrap_or(Path::new("")).to_owned();
        let rig = all_outputs(rig::parse(&text, name, &folder).map_err(|error| error.message)?);
        let mut working = Self {
            name: name.to_owned(),
            file,
            folder,
            saved: text.clone(),
            steps: vec![text],
            current: 0,
            gesture: None,
            rig,
            shown_instead: Vec::new(),
            working_file: working_file.to_owned(),
            sum: 0,
            version: 0,
        };
        working.write()?;
        Ok(working)
    }

    /// Name under which it was opened.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Current rig, without a pattern.
    pub fn rig(&self) -> &Rig {
        &self.rig
    }

    /// Text of the rig.
    pub fn text(&self) -> &str {
        &self.steps[self.current]
    }

    /// Checksum of the text that the program follows.
    pub fn sum(&self) -> u64 {
        self.sum
    }

    /// Number that grows with each change.
    pub fn version(&self) -> u64 {
        self.version
    }

    /// True if the rig's file lacks changes.
    pub fn is_changed(&self) -> bool {
        self.text() != self.saved
    }

    /// Numbers of steps that can be undone, and redone.
    pub fn steps(&self) -> (usize, usize) {
        (self.current, self.steps.len() - 1 - self.current)
    }

    /// Removes keys and applies changes such as `output.NAME.yaw=3`, all of them or none. Changes of
    /// the same `gesture` (a drag) that follow each other are one step.
    ///
    /// # Errors
    /// Message of the rig; then nothing is changed.
    pub fn set(&mut self, changes: &[String], remove: &[String], gesture: Option<&str>) -> Result<(), String> {
        let text = tune::without(self.text(), remove).and_then(|text| tune::changed(&text, changes));
        let text = text.map_err(|why| format!("{}: {why}", self.name))?;
        if text == self.text() {
            return Ok(());
        }
        let rig = self.parsed(&text)?;
        self.write_text(&text)?;
        let continues = self.gesture.take().is_some_and(|(last, at)| {
            gesture == Some(last.as_str()) && at.elapsed() < ONE_GESTURE && self.current + 1 == self.steps.len()
        });
        if continues && self.current > 0 {
            self.steps[self.current] = text;
        } else {
            self.steps.truncate(self.current + 1);
            self.steps.push(text);
            if self.steps.len() > STEPS {
                self.steps.remove(0);
            }
            self.current = self.steps.len() - 1;
        }
        self.gesture = gesture.map(|gesture| (gesture.to_owned(), Instant::now()));
        self.rig = rig;
        self.version += 1;
        Ok(())
    }

    /// Undoes or redoes a step. Returns whether there was one.
    ///
    /// # Errors
    /// The working file cannot be written.
    pub fn step(&mut self, forward: bool) -> Result<bool, String> {
        let next = if forward { self.current.checked_add(1) } else { self.current.checked_sub(1) };
        let Some(text) = next.and_then(|next| self.steps.get(next)).cloned() else { return Ok(false) };
        let rig = self.parsed(&text)?;
        self.write_text(&text)?;
        self.current = next.unwrap_or_default();
        self.gesture = None;
        self.rig = rig;
        self.version += 1;
        Ok(true)
    }

    /// Writes the text to the rig's file.
    ///
    /// # Errors
    /// The rig is a preset, another program changed the file (unless `replace`), or it cannot be
    /// written.
    pub fn save(&mut self, replace: bool) -> Result<PathBuf, String> {
        let Some(file) = self.file.clone() else {
            return Err(format!(
                "{} is a preset and has no file; begin with a copy: cupola check {} --print > my.toml",
                self.name, self.name
            ));
        };
        let found = rig::text_of_file(&file);
        if !replace && found.is_ok_and(|found| found != self.saved) {
            return Err(format!("{} was changed by somebody else since it was opened; nothing was saved", self.name));
        }
        tune::replace(&file, self.text()).map_err(|error| format!("{}: {error}", self.name))?;
        self.saved = self.text().to_owned();
        self.gesture = None;
        self.version += 1;
        Ok(file)
    }

    /// Makes the program show something else: `changes` apply only to the working file.
    ///
    /// # Errors
    /// Message of the rig; then nothing is changed.
    pub fn show_instead(&mut self, changes: Vec<String>) -> Result<(), String> {
        let before = std::mem::replace(&mut self.shown_instead, changes);
        let written = self.write();
        if written.is_err() {
            self.shown_instead = before;
        } else {
            self.version += 1;
        }
        written
    }

    fn parsed(&self, text: &str) -> Result<Rig, String> {
        let rig = all_outputs(rig::parse(text, &self.name, &self.folder).map_err(|error| error.message)?);
        if rig.passthrough != self.rig.passthrough {
            return Err(format!("{}: passthrough needs a new start of the program; change it in the file", self.name));
        }
        Ok(rig)
    }

    fn write(&mut self) -> Result<(), String> {
        let text = self.text().to_owned();
        self.write_text(&text)
    }

    /// Writes the working file. Each text has a number of its own, so that the program's frames tell
    /// apart the same rig before and after an undone change.
    fn write_text(&mut self, text: &str) -> Result<(), String> {
        let mut document: DocumentMut = text.parse().map_err(|error| format!("{}: {error}", self.name))?;
        if document.get("name").is_none() {
            document.insert("name", Item::Value(Value::from(self.rig.name.as_str())));
        }
        let folder = if self.folder.as_os_str().is_empty() { Path::new("/") } else { &self.folder };
        tune::name_files_absolutely(document.as_table_mut(), folder);
        let text = tune::changed(&document.to_string(), &self.shown_instead)?;
        if !self.shown_instead.is_empty() {
            rig::parse(&text, &self.name, &self.folder).map_err(|error| error.message)?;
        }
        let text = format!("{}\n# change {}\n", text.trim_end(), self.version + 1);
        write_quickly(&self.working_file, &text)
            .map_err(|error| format!("{}: {error}", self.working_file.display()))?;
        self.sum = ring::text_sum(text.as_bytes());
        Ok(())
    }
}

/// Rig with the outputs of other windows among its outputs: the page shows all.
fn all_outputs(rig: Rig) -> Rig {
    rig.with_all_outputs().into_owned()
}

/// Writes like [`tune::replace`], but without waiting for the disk: the file lives only as long as
/// this process.
fn write_quickly(path: &Path, text: &str) -> std::io::Result<()> {
    let next = path.with_extension("next");
    std::fs::write(&next, text)?;
    std::fs::rename(next, path)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::launch::loader::Scratch;

    const RIG: &str = "# mine\n[dome]\nradius = 4.0 # wide\n\n[[output]]\nname = \"all\"\nkind = \"domemaster\"\n";

    fn opened(scratch: &Scratch) -> Working {
        let file = scratch.path().join("dome.toml");
        std::fs::write(&file, RIG).expect("written");
        Working::open(file.to_str().expect("a path"), &scratch.path().join("working.toml")).expect("a rig")
    }

    #[test]
    fn outputs_of_other_windows_are_among_the_outputs() {
        let scratch = Scratch::new().expect("a folder");
        let mut working = opened(&scratch);
        let output = |name: &str| format!("\n[[output]]\nname = \"{name}\"\nkind = \"domemaster\"\nsize = [9, 9]\n");
        let text = format!("{RIG}{}shown = false\n{}fullscreen = true\n", output("film"), output("second"));
        std::fs::write(scratch.path().join("dome.toml"), text).expect("written");
        working = Working::open(working.name(), &scratch.path().join("working.toml")).expect("a rig");
        change(&mut working, "output.second.yaw=5", None).expect_err("no key of a domemaster");
        change(&mut working, "output.second.size=[7, 7]", None).expect("valid");
        let names = working.rig().outputs.iter().map(|output| (output.name.as_str(), output.size));
        assert_eq!(names.collect::<Vec<_>>(), [("all", None), ("film", Some((9, 9))), ("second", Some((7, 7)))]);
    }

    fn change(working: &mut Working, change: &str, gesture: Option<&str>) -> Result<(), String> {
        working.set(&[change.to_owned()], &[], gesture)
    }

    #[test]
    fn the_file_changes_when_it_is_saved_and_keeps_its_comments() {
        let scratch = Scratch::new().expect("a folder");
        let mut working = opened(&scratch);
        let read = |name: &str| std::fs::read_to_string(scratch.path().join(name)).expect("a file");
        change(&mut working, "dome.radius=5", None).expect("valid");
        assert!(read("working.toml").contains("radius = 5") && read("dome.toml") == RIG && working.is_changed());
        working.save(false).expect("saved");
        assert_eq!(read("dome.toml"), RIG.replace("4.0", "5"));
        assert!(!working.is_changed());
        // Changes of another program are not lost.
        std::fs::write(scratch.path().join("dome.toml"), "# theirs\n").expect("written");
        change(&mut working, "dome.radius=6", None).expect("valid");
        assert!(working.save(false).is_err() && read("dome.toml") == "# theirs\n");
        working.save(true).expect("saved");
        assert!(read("dome.toml").contains("radius = 6 # wide"));
    }

    #[test]
    fn a_wrong_change_is_refused_with_its_line_and_changes_nothing() {
        let scratch = Scratch::new().expect("a folder");
        let mut working = opened(&scratch);
        let before = std::fs::read(scratch.path().join("working.toml")).expect("a file");
        for wrong in ["dome.radius=-1", "dome.radios=3", "output.none.eye=0", "dome", "output.all.kind=\"x\""] {
            assert!(change(&mut working, wrong, None).is_err(), "{wrong}");
        }
        let message = change(&mut working, "dome.radius=-1", None).expect_err("wrong");
        assert!(message.contains("dome.toml:3: dome.radius: -1 is out of range"), "{message}");
        assert_eq!(std::fs::read(scratch.path().join("working.toml")).expect("a file"), before);
        assert_eq!((working.version(), working.steps()), (0, (0, 0)));
    }

    #[test]
    fn a_gesture_is_one_step_and_steps_can_be_undone() {
        let scratch = Scratch::new().expect("a folder");
        let mut working = opened(&scratch);
        for radius in 1..20 {
            change(&mut working, &format!("dome.radius={radius}"), Some("dome.radius")).expect("valid");
        }
        change(&mut working, "dome.tilt=10", None).expect("valid");
        assert_eq!(working.steps(), (2, 0));
        assert!(working.step(false).expect("written") && working.text().contains("radius = 19"));
        assert!(working.step(false).expect("written") && working.text() == RIG);
        assert!(!working.step(false).expect("none left"));
        assert!(working.step(true).expect("written") && working.text().contains("radius = 19"));
        change(&mut working, "dome.tilt=20", None).expect("valid");
        assert_eq!(working.steps(), (2, 0));
        for step in 0..2 * STEPS {
            change(&mut working, &format!("dome.tilt={}", step % 90), None).expect("valid");
        }
        assert_eq!(working.steps().0, STEPS - 1);
    }

    #[test]
    fn a_removed_key_is_one_step_and_comes_back() {
        let scratch = Scratch::new().expect("a folder");
        let mut working = opened(&scratch);
        working.set(&[], &["dome.radius".to_owned()], None).expect("valid");
        assert_eq!(working.text(), RIG.replace("[dome]\nradius = 4.0 # wide", "# wide"));
        assert_eq!(working.rig().dome.radius, 5.0);
        working.step(false).expect("written");
        assert_eq!((working.text(), working.rig().dome.radius), (RIG, 4.0));
        // What the rig needs, or does not have, is not removed, and a change beside it is not made.
        for key in ["output.all.kind", "dome.tilt", "output.none.eye"] {
            assert!(working.set(&["dome.radius=7".to_owned()], &[key.to_owned()], None).is_err(), "{key}");
        }
        assert_eq!((working.text(), working.steps()), (RIG, (0, 1)));
        // Removal and change together: neither of them is valid alone.
        let other = ["output.all.kind=\"perspective\"", "output.all.fov=[90, 60]"].map(str::to_owned);
        change(&mut working, "output.all.aperture=170", None).expect("valid");
        assert!(working.set(&other, &[], None).is_err());
        working.set(&other, &["output.all.aperture".to_owned()], None).expect("valid");
        assert!(working.text().contains("perspective") && !working.text().contains("aperture"));
    }
}
