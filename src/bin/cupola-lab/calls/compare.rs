//! Comparison of the answers of OpenGL and Vulkan with and without Cupola.

use super::player::{Answers, Player};
use crate::failure::Failure;
use std::path::PathBuf;

/// A player without Cupola and one with it.
pub struct Pair {
    pub plain: Player,
    pub ours: Player,
    /// File for the played lines.
    pub file: PathBuf,
}

/// Answers to a line that differ.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Difference {
    /// Number of the line, from 1.
    pub line: usize,
    /// Kind of the difference: the command or question, and the part of the answers that differs.
    pub kind: String,
    pub plain: String,
    pub ours: String,
}

/// Result of an episode.
pub enum Outcome {
    Same,
    /// The first difference.
    Different(Difference),
    /// Line in which the driver crashed without Cupola.
    Crashed(usize),
}

impl Pair {
    fn write(&self, lines: &[String]) -> Result<(), Failure> {
        let failure = |error: std::io::Error| Failure::new(format!("{}: {error}", self.file.display()));
        std::fs::write(&self.file, lines.join("\n") + "\n").map_err(failure)
    }

    /// Plays lines with and without Cupola at the same time, and finds the first difference.
    pub fn compare(&mut self, lines: &[String]) -> Result<Outcome, Failure> {
        Ok(self.compare_knowing(lines, |_| false)?.1)
    }

    /// Plays lines as [`Self::compare`]. Also returns the calls before the first difference whose
    /// answers differ in a kind that `is_known`.
    pub fn compare_knowing(
        &mut self,
        lines: &[String],
        is_known: impl Fn(&str) -> bool,
    ) -> Result<(Vec<Difference>, Outcome), Failure> {
        self.write(lines)?;
        self.plain.send(&self.file)?;
        self.ours.send(&self.file)?;
        let (plain, ours) = std::thread::scope(|scope| {
            let plain = scope.spawn(|| self.plain.receive());
            let ours = self.ours.receive();
            (plain.join().unwrap_or_else(|_| Err(Failure::new("a player's thread panicked"))), ours)
        });
        Ok(outcome(&plain?, &ours?, lines, is_known))
    }

    /// Plays lines as [`Self::compare`], in a new process with Cupola.
    pub fn compare_anew(&mut self, lines: &[String]) -> Result<Outcome, Failure> {
        self.ours.stop();
        self.compare(lines)
    }

    /// Plays lines without Cupola.
    pub fn play_plain(&mut self, lines: &[String]) -> Result<Answers, Failure> {
        self.write(lines)?;
        self.plain.play(&self.file)
    }
}

fn number(line: &str) -> usize {
    line.split(' ').next().and_then(|word| word.parse().ok()).unwrap_or(0)
}

/// Finds the calls before the first other difference whose answers differ in a kind that
/// `is_known`, and the first other difference between answers to the lines.
pub fn outcome(
    plain: &Answers,
    ours: &Answers,
    lines: &[String],
    is_known: impl Fn(&str) -> bool,
) -> (Vec<Difference>, Outcome) {
    let is_crash = |line: &str| line.split(' ').nth(1) == Some("signal");
    let is_call = |line: usize| lines.get(line.wrapping_sub(1)).is_some_and(|line| line.contains(' '));
    let mut known = Vec::new();
    let difference = plain.lines.iter().zip(&ours.lines).find(|(plain, ours)| {
        if plain == ours {
            return false;
        }
        let line = number(plain);
        if is_crash(plain) || is_crash(ours) || line != number(ours) || !is_call(line) {
            return true;
        }
        let kind = kind(plain, ours, lines);
        if !is_known(&kind) {
            return true;
        }
        known.push(Difference { line, kind, plain: plain.to_string(), ours: ours.to_string() });
        false
    });
    (known, first(difference, plain, ours, lines))
}

/// Returns the outcome for the first difference between lines of answers.
fn first(difference: Option<(&String, &String)>, plain: &Answers, ours: &Answers, lines: &[String]) -> Outcome {
    let is_crash = |line: &str| line.split(' ').nth(1) == Some("signal");
    match difference {
        Some((plain, _)) if is_crash(plain) => Outcome::Crashed(number(plain)),
        Some((plain, ours)) => Outcome::Different(Difference {
            line: number(plain).min(number(ours)),
            kind: kind(plain, ours, lines),
            plain: plain.clone(),
            ours: ours.clone(),
        }),
        None if plain.lines.len() > ours.lines.len() => {
            let line = ours.lines.last().map_or(0, |line| number(line)) + 1;
            let ours = "the process ended".to_owned();
            Outcome::Different(Difference {
                line,
                kind: "end".to_owned(),
                plain: plain.lines[plain.lines.len() - 1].clone(),
                ours,
            })
        }
        None if !plain.ended || plain.lines.len() < ours.lines.len() => {
            Outcome::Crashed(plain.lines.last().map_or(0, |line| number(line)))
        }
        None => Outcome::Same,
    }
}

/// Command of a line: after the word for the result, if there is one.
pub fn command(line: &str) -> &str {
    line.split(' ').find(|word| word.starts_with("gl")).or(line.split(' ').next()).unwrap_or(line)
}

/// Command or question of the line, and the part of its answers that differs.
fn kind(plain: &str, ours: &str, lines: &[String]) -> String {
    let line = lines.get(number(plain).min(number(ours)).wrapping_sub(1)).map_or("", String::as_str);
    let command = match plain.split_once(" = ") {
        // The answer belongs to a question.
        Some((question, _)) => question.split_once(' ').map_or("", |(_, question)| question).to_owned(),
        None => command(line).to_owned(),
    };
    let answers = |text: &str| -> Vec<String> {
        let answer = text.split_once(" = ").map_or(text, |(_, answer)| answer);
        answer.split(' ').map(str::to_owned).collect()
    };
    let (plain, ours) = (answers(plain), answers(ours));
    if ours.iter().any(|word| word == "signal") {
        return format!("{command}: crash");
    }
    let what = if command.contains(' ') { ["error", "result", "output"] } else { ["line", "error", "result"] };
    let at = plain.iter().zip(&ours).position(|(plain, ours)| plain != ours);
    let at = at.unwrap_or(plain.len().min(ours.len()));
    match ours.get(at).filter(|word| ["VUID-", "UNASSIGNED-", "SYNC-"].iter().any(|kind| word.starts_with(kind))) {
        Some(message) => format!("{command}: {message}"),
        None => format!("{command}: {}", what.get(at).unwrap_or(&"output")),
    }
}
