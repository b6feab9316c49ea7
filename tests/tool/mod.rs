//! A command of this package, started by tests without the user's `CUPOLA…` variables.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// A command and its name.
pub struct Tool {
    /// Path of the executable.
    pub path: &'static str,
    /// Name with which its messages begin, and the name of the folder for files of its tests.
    pub name: &'static str,
}

impl Tool {
    /// Runs the command to its end.
    pub fn run(&self, arguments: &[&str]) -> Output {
        let mut command = Command::new(self.path);
        for (name, _) in std::env::vars_os().filter(|(name, _)| name.to_string_lossy().starts_with("CUPOLA")) {
            command.env_remove(name);
        }
        command.args(arguments).output().unwrap()
    }

    /// Standard output of a run that succeeds.
    #[track_caller]
    pub fn answer(&self, arguments: &[&str]) -> String {
        let output = self.run(arguments);
        assert!(output.status.success(), "{arguments:?}: {}", String::from_utf8_lossy(&output.stderr));
        String::from_utf8(output.stdout).unwrap()
    }

    /// The same answer, parsed as JSON.
    #[track_caller]
    pub fn json(&self, arguments: &[&str]) -> serde_json::Value {
        serde_json::from_str(&self.answer(arguments)).unwrap()
    }

    /// Checks that the command refuses the arguments with exit code 2 and a message that contains
    /// `expected`.
    #[track_caller]
    pub fn refused(&self, arguments: &[&str], expected: &str) {
        let output = self.run(arguments);
        let said = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {said}");
        assert!(said.starts_with(&format!("{}: ", self.name)) && said.contains(expected), "{arguments:?}: {said}");
    }

    /// Path of a file for one test.
    pub fn file(&self, name: &str) -> PathBuf {
        let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(self.name);
        std::fs::create_dir_all(&folder).unwrap();
        folder.join(name)
    }
}
