//! Results of a finished run of a program: its status, words, files and pictures.

use crate::display::{self, Display};
use crate::harness::note;
use crate::picture::Picture;
use crate::programs::scratch;
use std::collections::{BTreeMap, BTreeSet};
use std::os::unix::process::{CommandExt, ExitStatusExt};
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::time::{Duration, Instant};

/// Time after which a program is ended. No program of the suite needs a tenth of it.
const TIME_LIMIT: Duration = Duration::from_secs(120);

/// Results of a run.
pub struct Finished {
    /// Folder of the run. Relative file names in the program's options are in it.
    pub directory: PathBuf,
    what: String,
    output: Output,
}

impl Finished {
    pub fn of(command: Command, program: &str, rig: &str) -> Option<Self> {
        Some(Self::on(display::get()?, command, program, rig))
    }

    /// Runs a program on `display`.
    pub fn on(display: &Display, mut command: Command, program: &str, rig: &str) -> Self {
        command.env("DISPLAY", &display.name);
        Self::run(command, program, rig)
    }

    /// Runs a program. Ends it and panics after the time limit.
    pub fn run(mut command: Command, program: &str, rig: &str) -> Self {
        let what = format!("{program} ({rig})");
        let directory = command.get_current_dir().map_or_else(|| scratch(program), Path::to_owned);
        let log = |name: &str| std::fs::File::create(directory.join(name)).expect("a log file can be made");
        // The tests do not use the user's own cache. That programs may share a cache is part of the
        // test.
        if !command.get_envs().any(|(name, _)| name == "CUPOLA_CACHE") {
            command.env("CUPOLA_CACHE", Path::new(env!("CARGO_TARGET_TMPDIR")).join("results"));
        }
        let mut child = command
            .current_dir(&directory)
            .env("LIBGL_ALWAYS_SOFTWARE", "1")
            .process_group(0)
            .stdin(Stdio::null())
            .stdout(log("stdout.log"))
            .stderr(log("stderr.log"))
            .spawn()
            .unwrap_or_else(|error| panic!("{what} does not start: {error}"));
        let started = Instant::now();
        let status = loop {
            if let Some(status) = child.try_wait().expect("a child can be waited for") {
                break status;
            }
            if started.elapsed() > TIME_LIMIT {
                // Kills the whole process group, since the program is a child of `cupola run`.
                // `kill` is built into the shell. A minimal Debian has no such program.
                let _ = Command::new("sh").args(["-c", &format!("kill -s KILL -- -{}", child.id())]).status();
                let _ = child.wait();
                panic!("{what} hangs; its files are in {}", directory.display());
            }
            std::thread::sleep(Duration::from_millis(5));
        };
        let read = |name: &str| std::fs::read(directory.join(name)).unwrap_or_default();
        let output = Output { status, stdout: read("stdout.log"), stderr: read("stderr.log") };
        Self { directory, what, output }
    }

    /// Panics with the output of the program unless it ended with exit status 0.
    pub fn expect_success(self) -> Self {
        assert!(
            self.output.status.success(),
            "{}: {}\n{}{}\nfiles in {}",
            self.what,
            self.output.status,
            String::from_utf8_lossy(&self.output.stdout),
            String::from_utf8_lossy(&self.output.stderr),
            self.directory.display()
        );
        self
    }

    /// Whether it ended with exit status 0.
    pub fn succeeded(&self) -> bool {
        self.output.status.success()
    }

    /// Exit status as shells give it: 128 plus the number of the signal if a signal ended the
    /// program.
    pub fn status(&self) -> i32 {
        let status = self.output.status;
        status.code().or(status.signal().map(|signal| 128 + signal)).unwrap_or(-1)
    }

    /// Kinds of messages of the validation layer.
    pub fn kinds_of_messages(&self) -> BTreeSet<String> {
        let kind = |line: &str| line.split(['(', ' ']).next().unwrap_or_default().to_owned();
        let is_message = |line: &&str| ["VUID", "UNASSIGNED", "SYNC"].iter().any(|kind| line.starts_with(kind));
        self.messages().lines().filter(is_message).map(kind).collect()
    }

    /// Panics unless the file has `count` numbers of resident pages, and unless the greatest of the
    /// last quarter exceeds that of the second quarter by no more than a set of atlases.
    pub fn expect_flat_memory(&self, file: &str, count: usize) {
        let pages: Vec<u64> = self.text(file).lines().map(|line| line.parse().expect("a number of pages")).collect();
        note(format_args!("{}: resident pages: {pages:?}", self.what));
        assert_eq!(pages.len(), count, "{}", self.what);
        let quarter = count / 4;
        let (early, late) = (pages[quarter..2 * quarter].iter().max(), pages[count - quarter..].iter().max());
        let (Some(early), Some(late)) = (early, late) else { panic!("too few numbers") };
        assert!(*late < early + 4096, "{}: resident pages grow from {early} to {late}: {pages:?}", self.what);
    }

    /// Panics unless the validation layer was loaded and wrote no message.
    pub fn expect_no_validation_messages(self) -> Self {
        let words = self.words();
        assert!(words.contains("VK_LAYER_KHRONOS_validation"), "{}: the layer is not loaded:\n{words}", self.what);
        let messages = String::from_utf8_lossy(&self.output.stdout);
        assert!(messages.is_empty(), "{}: the validation layer says:\n{messages}", self.what);
        self
    }

    /// Whether the run wrote this file.
    pub fn wrote(&self, name: &str) -> bool {
        self.directory.join(name).exists()
    }

    /// The text that the program wrote to stderr.
    pub fn words(&self) -> std::borrow::Cow<'_, str> {
        String::from_utf8_lossy(&self.output.stderr)
    }

    /// A text that the run wrote.
    pub fn text(&self, name: &str) -> String {
        let path = self.directory.join(name);
        std::fs::read_to_string(&path).unwrap_or_else(|error| panic!("{}: {}: {error}", self.what, path.display()))
    }

    /// The text that the program wrote to stdout. The validation layer writes its messages there.
    pub fn messages(&self) -> std::borrow::Cow<'_, str> {
        String::from_utf8_lossy(&self.output.stdout)
    }

    /// A picture that the run wrote.
    pub fn picture(&self, name: &str) -> Picture {
        let path = self.directory.join(name);
        assert!(
            path.exists(),
            "{}: there is no {}\n{}",
            self.what,
            path.display(),
            String::from_utf8_lossy(&self.output.stderr)
        );
        Picture::load(&path)
    }

    /// Captured pictures of all outputs, by the names of their files. There is at least one.
    pub fn captures(&self) -> BTreeMap<String, Picture> {
        let files = std::fs::read_dir(&self.directory).expect("the folder of a run").flatten();
        let names = files.filter_map(|file| file.file_name().into_string().ok());
        let captures = names.filter(|name| name.starts_with("capture") && name.ends_with(".png"));
        let pictures: BTreeMap<String, Picture> = captures.map(|name| (name.clone(), self.picture(&name))).collect();
        assert!(!pictures.is_empty(), "{}: nothing is captured\n{}", self.what, self.words());
        pictures
    }

    /// Answer of `cupola simulate` for the captured pictures, on a dome of `size` × `size` pixels.
    pub fn simulate(&self, rig: &str, size: u32) -> serde_json::Value {
        let output = Command::new(env!("CARGO_BIN_EXE_cupola"))
            .current_dir(&self.directory)
            .args(["simulate", rig, "--captures", ".", "-o", "dome.png", "--json", "--size", &size.to_string()])
            .output()
            .unwrap_or_else(|error| panic!("{}: {error}", self.what));
        assert!(output.status.success(), "{}: {}", self.what, String::from_utf8_lossy(&output.stderr));
        serde_json::from_slice(&output.stdout).unwrap_or_else(|error| panic!("{}: {error}", self.what))
    }

    /// The statistics that `cupola run` wrote.
    pub fn statistics(&self) -> serde_json::Value {
        let path = self.directory.join("stats.json");
        let text =
            std::fs::read_to_string(&path).unwrap_or_else(|error| panic!("{}: {}: {error}", self.what, path.display()));
        serde_json::from_str(&text).unwrap_or_else(|error| panic!("{}: {}: {error}", self.what, path.display()))
    }

    /// Panics unless the statistics say that Cupola itself caused no GL error.
    pub fn expect_no_gl_errors(self) -> Self {
        let statistics = self.statistics();
        assert_eq!(
            statistics["own_errors"].as_u64(),
            Some(0),
            "{}: GL errors of Cupola's own: {statistics:#}",
            self.what
        );
        self
    }
}

impl Drop for Finished {
    /// Removes the files of the run unless the test fails.
    fn drop(&mut self) {
        if !std::thread::panicking() {
            let _ = std::fs::remove_dir_all(&self.directory);
        }
    }
}
