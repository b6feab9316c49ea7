//! File of outcomes: one JSON object per line, appended as tests end, so that an interrupted run
//! can be continued.

use super::outcome::Outcome;
use crate::failure::Failure;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::fs::{File, OpenOptions};
use std::io::{BufRead, BufReader, Write};
use std::path::Path;

/// Name of the runs without Cupola.
pub const PLAIN: &str = "plain";

#[derive(Serialize, Deserialize)]
struct Line {
    test: String,
    /// Rig, or [`PLAIN`].
    rig: String,
    /// Digest of the library; empty for plain runs.
    library: String,
    #[serde(flatten)]
    outcome: Outcome,
}

/// Outcomes by test and rig, with their file.
pub struct Results {
    file: File,
    library: String,
    outcomes: BTreeMap<(String, String), Outcome>,
}

impl Results {
    /// Opens the file, or creates it. Outcomes with another library than `library` are skipped.
    pub fn open(path: &Path, library: String) -> Result<Self, Failure> {
        let failure = |error: std::io::Error| Failure::usage(format!("{}: {error}", path.display()));
        let file = OpenOptions::new().read(true).append(true).create(true).open(path).map_err(failure)?;
        let mut outcomes = BTreeMap::new();
        for line in BufReader::new(&file).lines() {
            // The last line of an interrupted run may be incomplete.
            let Ok(line) = serde_json::from_str::<Line>(&line.map_err(failure)?) else { continue };
            if line.rig == PLAIN || line.library == library {
                outcomes.insert((line.test, line.rig), line.outcome);
            }
        }
        Ok(Self { file, library, outcomes })
    }

    /// Outcome of a test with a rig, if it has run.
    pub fn get(&self, test: &str, rig: &str) -> Option<&Outcome> {
        self.outcomes.get(&(test.to_owned(), rig.to_owned()))
    }

    /// Stores an outcome.
    pub fn add(&mut self, test: &str, rig: &str, outcome: Outcome) -> Result<(), Failure> {
        let library = if rig == PLAIN { String::new() } else { self.library.clone() };
        let line = Line { test: test.to_owned(), rig: rig.to_owned(), library, outcome };
        let text = serde_json::to_string(&line).map_err(|error| Failure::new(error.to_string()))?;
        writeln!(self.file, "{text}").map_err(|error| Failure::new(format!("results cannot be written: {error}")))?;
        self.outcomes.insert((line.test, line.rig), line.outcome);
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::super::outcome::End;
    use super::*;

    #[test]
    fn results_are_kept_for_the_same_library() {
        let path = std::env::temp_dir().join(format!("cupola-conformance-{}", std::process::id()));
        let outcome = Outcome {
            result: "pass".into(),
            subtests: [("a".to_owned(), "fail".to_owned())].into(),
            end: End::Signal(6),
            seconds: 1.5,
            repeats: 1,
        };
        let Ok(mut results) = Results::open(&path, "1".into()) else { panic!() };
        assert!(results.add("t", PLAIN, outcome.clone()).is_ok());
        assert!(results.add("t", "fisheye", outcome.clone()).is_ok());
        assert!(results.file.write_all(b"{\"test\": \"cut").is_ok());
        let Ok(same) = Results::open(&path, "1".into()) else { panic!() };
        assert_eq!(same.get("t", "fisheye"), Some(&outcome));
        let Ok(other) = Results::open(&path, "2".into()) else { panic!() };
        assert_eq!((other.get("t", "fisheye"), other.get("t", PLAIN)), (None, Some(&outcome)));
        std::fs::remove_file(path).unwrap();
    }
}
