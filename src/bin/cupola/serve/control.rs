//! Requests to the server, from the page, `cupola ctl` and OSC.

use super::keys::keys;
use super::marks::{Marks, NewMark};
use super::pattern::{self, Choice};
use super::picture::{Pictures, Seen, Versions};
use super::program::{self, Launch, Program};
use super::scene::Scene;
use super::working::Working;
use crate::launch::held::Request;
use cupola::lock::Lock;
use cupola::rig::{self, Rig};
use serde_json::{Value, json};
use std::ffi::OsString;
use std::path::PathBuf;
use std::sync::{Arc, Mutex, MutexGuard};

/// A request to change something or to get information.
#[derive(Debug, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(tag = "do", rename_all = "lowercase", deny_unknown_fields)]
pub enum Command {
    /// Returns all information about rig and program.
    State {},
    /// Returns the keys of the rig with their values and ranges.
    Keys {},
    /// Returns the value of one key.
    Get {
        /// Key, for example `output.front.yaw`.
        key: String,
    },
    /// Changes and removes keys, all of them or none.
    Set {
        /// Changes in the form `KEY=VALUE`.
        #[serde(default)]
        changes: Vec<String>,
        /// Keys that are removed, before the changes.
        #[serde(default)]
        remove: Vec<String>,
        /// Consecutive changes with the same word are one step.
        #[serde(default)]
        gesture: Option<String>,
    },
    /// Reverts the last step.
    Undo {},
    /// Makes the reverted step again.
    Redo {},
    /// Writes the rig's file.
    Save {
        /// True if the file is overwritten even if another program has changed it.
        #[serde(default)]
        replace: bool,
    },
    /// Opens another rig.
    Rig {
        /// Name of a rig that the server was started with, or of a preset.
        name: String,
        /// True if unsaved changes of the current rig are discarded.
        #[serde(default)]
        replace: bool,
    },
    /// Shows a test pattern, or the program again.
    Pattern(Choice),
    /// Adds a mark for the calibration.
    Mark(NewMark),
    /// Removes the mark in a line of the file of marks.
    Unmark {
        /// Number of the line, from 1.
        line: usize,
    },
    /// Solves the outputs that have marks, and changes the rig accordingly.
    Solve {
        /// Other free parts, as for `cupola calibrate --solve`.
        #[serde(default)]
        parts: Vec<String>,
    },
    /// Starts a program that the server was started with; without a name, the only one.
    Start {
        /// Name of the program.
        #[serde(default)]
        program: Option<String>,
        /// Any other program with its arguments; only through the Unix socket.
        #[serde(default)]
        command: Option<Vec<String>>,
    },
    /// Stops the program.
    Stop {},
    /// Holds the program's time.
    Pause {},
    /// Lets the program's time go on.
    Resume {},
    /// Lets the program's time go on by single frames.
    Step {
        /// Number of frames.
        #[serde(default = "one")]
        frames: u64,
    },
    /// Ends the server; only through the Unix socket.
    Quit {},
}

fn one() -> u64 {
    1
}

/// The rig with everything that is computed from it.
struct Desk {
    working: Working,
    pattern: Choice,
    marks: Marks,
    patterns: u64,
    /// Sum of the versions of earlier rigs.
    before: u64,
    scene: Option<(u64, Arc<Scene>)>,
    /// Version at which the positions of the light changed last, and the rig with them.
    places: (u64, Rig),
}

/// State that all kinds of requests share.
pub struct Server {
    desk: Mutex<Desk>,
    /// The program.
    pub program: Program,
    /// Pictures of the program.
    pub pictures: Mutex<Pictures>,
    seen: Arc<Mutex<Seen>>,
    versions: Arc<Mutex<Versions>>,
    launch: Launch,
    programs: Vec<(String, Vec<OsString>)>,
    rigs: Vec<String>,
    pattern_folder: PathBuf,
}

impl Server {
    /// Opens the first of `rigs`.
    ///
    /// # Errors
    /// Description of the mistakes in the rig.
    pub fn new(
        rigs: Vec<String>,
        programs: Vec<(String, Vec<OsString>)>,
        launch: Launch,
        program: Program,
        marks: Option<PathBuf>,
        folder: &std::path::Path,
    ) -> Result<Self, String> {
        let name = rigs.first().map_or("fisheye", String::as_str);
        let working = Working::open(name, &launch.working_file)?;
        let marks = Marks::open(marks, working.rig())?;
        let places = (0, working.rig().clone());
        let desk = Desk { working, pattern: Choice::default(), marks, patterns: 0, before: 0, scene: None, places };
        let pictures = Pictures::new(&launch.ring);
        let versions = pictures.versions();
        versions.locked().note(desk.working.sum(), desk.version());
        Ok(Self {
            desk: Mutex::new(desk),
            program,
            seen: pictures.seen(),
            versions,
            pictures: Mutex::new(pictures),
            launch,
            programs,
            rigs,
            pattern_folder: folder.join("pattern"),
        })
    }

    /// Executes a request. `is_trusted`: the sender may start any program, because this user can do
    /// so anyway.
    ///
    /// # Errors
    /// Reason of the refusal; nothing has changed then.
    pub fn run(&self, command: Command, is_trusted: bool) -> Result<Value, String> {
        let mut desk = self.desk();
        match command {
            Command::State {} => {}
            Command::Keys {} => return Ok(Value::Array(keys(&desk.working))),
            Command::Get { key } => {
                let found = keys(&desk.working).into_iter().find(|known| known["key"] == *key);
                return found.ok_or_else(|| {
                    format!("{}: there is no key {key}; cupola ctl keys lists them", desk.working.name())
                });
            }
            Command::Set { changes, remove, gesture } => {
                desk.working.set(&changes, &remove, gesture.as_deref())?;
                self.draw_again(&mut desk)?;
            }
            Command::Undo {} | Command::Redo {} => {
                desk.working.step(command == Command::Redo {})?;
                self.draw_again(&mut desk)?;
            }
            Command::Save { replace } => drop(desk.working.save(replace)?),
            Command::Rig { name, replace } => self.open(&mut desk, &name, replace)?,
            Command::Pattern(choice) => self.show(&mut desk, choice)?,
            Command::Mark(mark) => {
                let Desk { marks, working, .. } = &mut *desk;
                marks.add(&mark, working.rig(), &self.sizes(working.rig()))?;
            }
            Command::Unmark { line } => {
                let Desk { marks, working, .. } = &mut *desk;
                marks.remove(line, working.rig())?;
            }
            Command::Solve { parts } => {
                let (changes, words) = desk.marks.solve(desk.working.rig(), desk.working.text(), &parts)?;
                desk.working.set(&changes, &[], None)?;
                self.draw_again(&mut desk)?;
                let mut state = self.state(&mut desk);
                state["solved"] = words.into();
                return Ok(state);
            }
            Command::Start { program, command } => self.start(program, command, is_trusted)?,
            Command::Stop {} => self.program.stop(),
            Command::Pause {} => self.launch.hold(Request::Hold)?,
            Command::Resume {} => self.launch.hold(Request::Release)?,
            Command::Step { frames } => self.launch.hold(Request::Step(frames))?,
            Command::Quit {} if is_trusted => self.program.leave(),
            Command::Quit {} => return Err("only cupola ctl on the same machine ends the server".to_owned()),
        }
        Ok(self.state(&mut desk))
    }

    fn open(&self, desk: &mut Desk, name: &str, replace: bool) -> Result<(), String> {
        let is_preset = rig::presets().iter().any(|preset| preset.name == name);
        if !is_preset && !self.rigs.iter().any(|known| known == name) {
            return Err(format!("{name}: the server was not started with this rig"));
        }
        if desk.working.is_changed() && !replace {
            return Err(format!("{} has changes that are not saved", desk.working.name()));
        }
        let before = desk.version();
        desk.working = Working::open(name, &self.launch.working_file)?;
        (desk.pattern, desk.before, desk.scene) = (Choice::default(), before + 1, None);
        Ok(())
    }

    fn show(&self, desk: &mut Desk, choice: Choice) -> Result<(), String> {
        let changes = if choice.is_none() {
            Vec::new()
        } else {
            desk.patterns += 1;
            let rig = desk.working.rig();
            pattern::changes(rig, &self.sizes(rig), &choice, &self.pattern_folder, desk.patterns)?
        };
        desk.working.show_instead(changes)?;
        pattern::tidy(&self.pattern_folder, desk.patterns);
        desk.pattern = choice;
        Ok(())
    }

    /// Draws the pattern again after a change of the rig.
    fn draw_again(&self, desk: &mut Desk) -> Result<(), String> {
        let choice = desk.pattern.clone();
        if choice.is_none() { Ok(()) } else { self.show(desk, choice) }
    }

    fn start(&self, program: Option<String>, command: Option<Vec<String>>, is_trusted: bool) -> Result<(), String> {
        if let Some(command) = command {
            let name = command
                .first()
                .filter(|_| is_trusted)
                .ok_or("only cupola ctl on the same machine starts any program")?;
            self.program.start(name, command.iter().map(OsString::from).collect());
            return Ok(());
        }
        let found = match &program {
            Some(name) => self.programs.iter().find(|(known, _)| known == name),
            None => self.programs.first(),
        };
        let (name, command) = found.ok_or_else(|| match program {
            Some(name) => format!("{name}: the server was not started with this program"),
            None => "the server was started without a program".to_owned(),
        })?;
        self.program.start(name, command.clone());
        Ok(())
    }

    fn desk(&self) -> MutexGuard<'_, Desk> {
        self.desk.locked()
    }

    fn seen(&self) -> MutexGuard<'_, Seen> {
        self.seen.locked()
    }

    /// Sizes of the outputs: those of the program's pictures, otherwise those of the rig.
    fn sizes(&self, rig: &rig::Rig) -> Vec<(u32, u32)> {
        let seen = self.seen();
        let size = |(index, output): (usize, &rig::Output)| {
            output.size.or_else(|| seen.size_of(&output.name)).unwrap_or_else(|| crate::map::native_size(rig, index))
        };
        rig.outputs.iter().enumerate().map(size).collect()
    }

    /// Current scene, with its number.
    pub fn scene(&self) -> (u64, Arc<Scene>) {
        let (version, rig, before) = {
            let desk = self.desk();
            let version = desk.version();
            if let Some((_, scene)) = desk.scene.as_ref().filter(|(made, _)| *made == version) {
                return (version, scene.clone());
            }
            (version, desk.working.rig().clone(), desk.scene.as_ref().map(|(_, scene)| scene.clone()))
        };
        // Changes do not wait for the computation.
        let scene = Arc::new(Scene::new(&rig, self.sizes(&rig), before.as_deref()));
        let mut desk = self.desk();
        if desk.version() == version {
            desk.scene = Some((version, scene.clone()));
        }
        (version, scene)
    }

    fn state(&self, desk: &mut Desk) -> Value {
        self.versions.locked().note(desk.working.sum(), desk.version());
        let places = desk.places();
        let working = &desk.working;
        let (undo, redo) = working.steps();
        let presets = rig::presets().iter().map(|preset| preset.name.to_owned());
        let statistics = std::fs::read(&self.launch.statistics).ok();
        let statistics: Option<Value> = statistics.and_then(|bytes| serde_json::from_slice(&bytes).ok());
        let status = self.program.status();
        json!({
            "version": desk.version(),
            "places": places,
            "rig": {
                "name": working.name(),
                "title": working.rig().name,
                "changed": working.is_changed(),
                "undo": undo,
                "redo": redo,
                "outputs": working.rig().outputs.iter().map(|output| output.name.as_str()).collect::<Vec<_>>(),
            },
            "rigs": self.rigs.iter().cloned().chain(presets).collect::<Vec<_>>(),
            "pattern": desk.pattern,
            "marks": desk.marks.state(working.rig(), &self.sizes(working.rig())),
            "program": status,
            "programs": self.programs.iter().map(|(name, _)| name.as_str()).collect::<Vec<_>>(),
            "frame_milliseconds": self.seen().frame_milliseconds(),
            "memory": { "program": self.program.memory(), "server": program::own_memory() },
            "statistics": statistics.filter(|_| status.runs),
            "clock": self.launch.time().filter(|_| status.runs),
        })
    }
}

impl Desk {
    fn version(&self) -> u64 {
        self.before + self.working.version()
    }

    /// Version at which the contents of the scene changed last. The program's camera, the views and
    /// the light of outputs do not count.
    fn places(&mut self) -> u64 {
        let rig = self.working.rig();
        let mut same = rig.clone();
        let before = &self.places.1;
        (same.camera, same.views, same.overlay) = (before.camera, before.views.clone(), before.overlay);
        for (output, before) in same.outputs.iter_mut().zip(&before.outputs) {
            output.blend = before.blend.clone();
        }
        if same != *before {
            self.places = (self.version(), rig.clone());
        }
        self.places.0
    }
}
