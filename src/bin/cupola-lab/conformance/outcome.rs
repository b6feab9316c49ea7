//! Result of one run of a test, and differences between two of them.

use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, BTreeSet};

/// Result of one run of a test.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Outcome {
    /// Result that the test printed: pass, warn, fail or skip; empty if it printed none.
    pub result: String,
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub subtests: BTreeMap<String, String>,
    pub end: End,
    pub seconds: f64,
    /// Number of runs before this one that differed from the plain run.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub repeats: u32,
}

#[allow(clippy::trivially_copy_pass_by_ref, reason = "serde's signature")]
fn is_zero(number: &u32) -> bool {
    *number == 0
}

/// End of a process.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum End {
    Exit(i32),
    Signal(i32),
    /// The process was killed because it did not end.
    Hung,
}

/// Difference of two outcomes of a test.
#[derive(Clone, Debug, PartialEq)]
pub struct Difference {
    pub plain: String,
    pub ours: String,
    /// Names of the subtests that differ.
    pub subtests: Vec<String>,
}

impl Outcome {
    /// Adds the result in a line of a test's output.
    pub fn hear(&mut self, line: &str) {
        let Some(text) = line.trim_start().strip_prefix("PIGLIT: ") else { return };
        let Ok(serde_json::Value::Object(said)) = serde_json::from_str(text) else { return };
        if let Some(result) = said.get("result").and_then(|result| result.as_str()) {
            result.clone_into(&mut self.result);
        }
        for (name, result) in said.get("subtest").and_then(|subtests| subtests.as_object()).into_iter().flatten() {
            self.subtests.insert(name.clone(), result.as_str().unwrap_or_default().to_owned());
        }
    }

    /// Describes the outcome without subtests. Numbers of signals are left out, because chance
    /// determines which one ends a process.
    pub fn words(&self) -> String {
        let end = match (&self.end, self.result.is_empty()) {
            // Exit codes repeat the printed results.
            (End::Exit(_), false) => return self.result.clone(),
            (End::Exit(code), true) => return format!("exit {code}"),
            (End::Signal(_), true) => return "crash".to_owned(),
            (End::Hung, true) => return "timeout".to_owned(),
            (End::Signal(_), false) => "killed at exit",
            (End::Hung, false) => "hangs at exit",
        };
        format!("{}, {end}", self.result)
    }

    /// Difference between the outcomes without and with Cupola.
    pub fn difference(plain: &Self, ours: &Self) -> Option<Difference> {
        let names = plain.subtests.keys().chain(ours.subtests.keys());
        let differs = |name: &&String| plain.subtests.get(*name) != ours.subtests.get(*name);
        let subtests: BTreeSet<String> = names.filter(differs).cloned().collect();
        let found = Difference { plain: plain.words(), ours: ours.words(), subtests: subtests.into_iter().collect() };
        (found.plain != found.ours || !found.subtests.is_empty()).then_some(found)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn outcome(lines: &[&str], end: End) -> Outcome {
        let mut outcome = Outcome { result: String::new(), subtests: BTreeMap::new(), end, seconds: 0.0, repeats: 0 };
        lines.iter().for_each(|line| outcome.hear(line));
        outcome
    }

    const PASS: &str = r#"PIGLIT: {"result": "pass" }"#;

    #[test]
    fn each_way_to_differ_is_a_difference() {
        let subtest = |result: &str| format!(r#"PIGLIT: {{"subtest": {{"a, b" : "{result}"}}}}"#);
        let plain = outcome(&[&subtest("pass"), "Probe", PASS], End::Exit(0));
        assert_eq!(Outcome::difference(&plain, &plain.clone()), None);
        let passed = outcome(&[&subtest("fail"), PASS], End::Exit(0));
        let found = Outcome::difference(&plain, &passed).unwrap();
        assert_eq!((found.ours.as_str(), found.subtests), ("pass", vec!["a, b".to_owned()]));
        let ours = |lines: &[&str], end: End| {
            let mut all = vec![subtest("pass")];
            all.extend(lines.iter().map(|line| (*line).to_owned()));
            let all: Vec<&str> = all.iter().map(String::as_str).collect();
            Outcome::difference(&plain, &outcome(&all, end)).map(|found| found.ours)
        };
        assert_eq!(ours(&[PASS], End::Exit(0)), None);
        assert_eq!(ours(&[PASS], End::Signal(11)).unwrap(), "pass, killed at exit");
        assert_eq!(ours(&[], End::Signal(11)).unwrap(), "crash");
        assert_eq!(ours(&[PASS], End::Hung).unwrap(), "pass, hangs at exit");
        assert_eq!(ours(&[], End::Hung).unwrap(), "timeout");
        assert_eq!(ours(&[], End::Exit(1)).unwrap(), "exit 1");
        assert_eq!(ours(&[r#"PIGLIT: {"result": "fail" }"#], End::Exit(1)).unwrap(), "fail");
    }
}
