//! Known differences: a TOML file with the reason of each, and the comparison with the found ones.

use super::outcome::Difference;
use crate::failure::Failure;
use serde::Deserialize;
use std::collections::BTreeMap;
use std::path::Path;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    #[serde(default)]
    known: Vec<Known>,
}

/// Tests that differ for one reason.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Known {
    tests: Vec<String>,
    rigs: Vec<String>,
    /// Outcome without Cupola.
    plain: String,
    /// Outcome with Cupola.
    ours: String,
    /// Subtests that differ; `None`: any.
    subtests: Option<Vec<String>>,
    reason: String,
    /// True if the tests do not differ in each run.
    #[serde(default)]
    sometimes: bool,
}

/// Differences by test and rig; `None` if a test has run and does not differ.
pub type Found = BTreeMap<(String, String), Option<Difference>>;

/// Reads a file of known differences.
pub fn read(path: &Path) -> Result<Vec<Known>, Failure> {
    let text = std::fs::read_to_string(path).map_err(|error| Failure::usage(format!("{}: {error}", path.display())))?;
    parse(&text).map_err(|why| Failure::usage(format!("{}: {why}", path.display())))
}

fn parse(text: &str) -> Result<Vec<Known>, String> {
    let file: File = toml::from_str(text).map_err(|error| error.to_string())?;
    match file.known.iter().find(|known| known.reason.trim().is_empty()) {
        Some(known) => Err(format!("{}: no reason is given", known.tests.join(", "))),
        None => Ok(file.known),
    }
}

/// Lists mistakes: differences that are not known, and known ones that were not found.
pub fn judge(found: &Found, known: &[Known]) -> Vec<String> {
    let mut wrong = Vec::new();
    for ((test, rig), difference) in found {
        let lines = known.iter().filter(|known| known.tests.contains(test) && known.rigs.contains(rig));
        match difference {
            Some(difference) if !lines.clone().any(|known| known.is(difference)) => {
                wrong.push(format!("{test}, {rig}: {}", difference.words()));
            }
            Some(_) => {}
            None => wrong.extend(lines.filter(|known| !known.sometimes).map(|known| {
                format!("{test}, {rig}: differs no longer; remove it from the known differences ({})", known.reason)
            })),
        }
    }
    wrong
}

impl Known {
    fn is(&self, difference: &Difference) -> bool {
        self.plain == difference.plain
            && self.ours == difference.ours
            && self.subtests.as_ref().is_none_or(|subtests| *subtests == difference.subtests)
    }
}

impl Difference {
    /// The difference in one line.
    fn words(&self) -> String {
        let subtests = match self.subtests.len() {
            0 => String::new(),
            1..=4 => format!("; subtests {}", self.subtests.join("; ")),
            more => format!("; {more} subtests: {}; …", self.subtests[..3].join("; ")),
        };
        format!("{} instead of {}{subtests}", self.ours, self.plain)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const KNOWN: &str = r#"
        [[known]]
        tests = ["a", "b"]
        rigs = ["fisheye"]
        plain = "pass"
        ours = "fail"
        subtests = ["one"]
        reason = "the driver's fault"
    "#;

    fn difference(ours: &str, subtests: &[&str]) -> Option<Difference> {
        let subtests = subtests.iter().map(|name| (*name).to_owned()).collect();
        Some(Difference { plain: "pass".to_owned(), ours: ours.to_owned(), subtests })
    }

    fn judged(found: &[(&str, &str, Option<Difference>)], known: &str) -> Vec<String> {
        let found = found.iter().map(|(test, rig, of)| (((*test).to_owned(), (*rig).to_owned()), of.clone())).collect();
        judge(&found, &parse(known).unwrap())
    }

    #[test]
    fn known_differences_are_allowed() {
        assert_eq!(judged(&[("a", "fisheye", difference("fail", &["one"]))], KNOWN), [""; 0]);
        assert_eq!(judged(&[("c", "fisheye", None)], KNOWN), [""; 0]);
    }

    #[test]
    fn a_difference_that_is_not_known_is_wrong() {
        let wrong = |test: &str, rig: &str, of: Option<Difference>| judged(&[(test, rig, of)], KNOWN).len();
        assert_eq!(wrong("c", "fisheye", difference("fail", &["one"])), 1);
        assert_eq!(wrong("a", "identity", difference("fail", &["one"])), 1);
        assert_eq!(wrong("a", "fisheye", difference("crash", &["one"])), 1);
        assert_eq!(wrong("a", "fisheye", difference("fail", &["one", "two"])), 1);
        assert_eq!(judged(&[("a", "fisheye", difference("fail", &["one"]))], "").len(), 1);
    }

    #[test]
    fn a_known_difference_that_is_gone_is_wrong() {
        assert_eq!(judged(&[("b", "fisheye", None)], KNOWN).len(), 1);
        assert_eq!(judged(&[("b", "fisheye", None)], &format!("{KNOWN}sometimes = true")), [""; 0]);
    }

    #[test]
    fn each_known_difference_has_a_reason() {
        assert!(parse(&KNOWN.replace("the driver's fault", " ")).is_err());
        assert!(parse(&KNOWN.replace("reason", "why")).is_err());
    }
}
