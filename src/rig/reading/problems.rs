//! Problems of a rig file: their list, and guesses at the intended word.

use super::accepted_keys::{Accepts, DefaultValue, Key};
use std::collections::BTreeMap;
use std::ops::Range;

/// Greatest number of problems that a message lists.
const SHOWN: usize = 20;

/// Problems found so far, and the line of every key that was read.
pub(in crate::rig) struct Problems {
    /// Byte offset at which each line starts.
    line_starts: Vec<usize>,
    /// Line of each key path.
    lines: BTreeMap<String, usize>,
    /// Names of outputs by their index, as far as the file has them.
    names: BTreeMap<usize, String>,
    /// Line, key path, and message of each problem.
    found: Vec<(usize, String, String)>,
    /// Keys that were read, if they are recorded.
    keys: Option<Vec<Key>>,
}

impl Problems {
    /// Starts with no problems in `text`.
    pub(in crate::rig) fn new(text: &str) -> Self {
        let newlines = text.bytes().enumerate().filter(|(_, byte)| *byte == b'\n').map(|(at, _)| at + 1);
        Self {
            line_starts: std::iter::once(0).chain(newlines).collect(),
            lines: BTreeMap::new(),
            names: BTreeMap::new(),
            found: Vec::new(),
            keys: None,
        }
    }

    /// Starts with no problems, and records each key.
    pub(in crate::rig) fn noting_keys(text: &str) -> Self {
        Self { keys: Some(Vec::new()), ..Self::new(text) }
    }

    /// Records a key, if keys are recorded.
    pub(in crate::rig) fn note_key(
        &mut self,
        path: impl FnOnce() -> String,
        given: bool,
        accepts: impl FnOnce() -> Accepts,
        default: impl FnOnce() -> Option<DefaultValue>,
    ) {
        if let Some(keys) = &mut self.keys {
            keys.push(Key { path: path(), given, accepts: accepts(), default: default() });
        }
    }

    /// Recorded keys, each once, in the order in which they were read.
    pub(in crate::rig) fn keys(self) -> Vec<Key> {
        let mut keys = self.keys.unwrap_or_default();
        let mut seen = std::collections::BTreeSet::new();
        keys.retain(|key| seen.insert(key.path.clone()));
        keys
    }

    /// Stores the line of the key `path`.
    pub(in crate::rig) fn place(&mut self, path: &str, span: &Range<usize>) {
        let line = self.line_at(span.start);
        self.lines.insert(path.to_owned(), line);
    }

    /// Stores the name of an output.
    pub(in crate::rig) fn name_output(&mut self, index: usize, name: &str) {
        self.names.insert(index, name.to_owned());
    }

    /// Name of the output of a key, in brackets.
    fn name_of(&self, path: &str) -> String {
        let index = path.strip_prefix("output[").and_then(|rest| rest.split_once(']')?.0.parse().ok());
        let name = index.and_then(|index: usize| self.names.get(&index));
        name.map_or_else(String::new, |name| format!(" ({name})"))
    }

    /// Adds a problem of the key `path`. If the file does not have the key, the line of its nearest
    /// parent is used.
    pub(in crate::rig) fn add(&mut self, path: &str, why: impl Into<String>) {
        let mut parent = path;
        let line = loop {
            if let Some(line) = self.lines.get(parent) {
                break *line;
            }
            match parent.rfind(['.', '[']) {
                Some(cut) => parent = &parent[..cut],
                None => break 1,
            }
        };
        self.found.push((line, path.to_owned(), why.into()));
    }

    /// Adds a problem of the text at `span`, which belongs to no key.
    pub(in crate::rig) fn add_at(&mut self, span: Option<Range<usize>>, why: impl Into<String>) {
        let line = span.map_or(1, |span| self.line_at(span.start));
        self.found.push((line, String::new(), why.into()));
    }

    /// True if there are no problems.
    pub(in crate::rig) fn is_empty(&self) -> bool {
        self.found.is_empty()
    }

    /// Message for the user: one `file:line: key: reason` per problem, in the file's order.
    pub(in crate::rig) fn message(&self, file_name: &str) -> String {
        let mut found: Vec<_> = self.found.iter().collect();
        found.sort_by_key(|(line, _, _)| *line);
        let mut lines: Vec<String> = found
            .iter()
            .take(SHOWN)
            .map(|(line, path, why)| {
                let separator = if path.is_empty() { "" } else { ": " };
                format!("{file_name}:{line}: {path}{}{separator}{why}", self.name_of(path))
            })
            .collect();
        if found.len() > SHOWN {
            lines.push(format!("… and {} more problems", found.len() - SHOWN));
        }
        lines.join("\n")
    }

    /// Returns all problems in one line, without line numbers.
    pub(in crate::rig) fn reasons(&self) -> String {
        let found = self.found.iter().map(|(_, path, why)| format!("{path}: {why}"));
        found.collect::<Vec<_>>().join("; ")
    }

    /// Line number of a byte, from 1.
    fn line_at(&self, offset: usize) -> usize {
        self.line_starts.partition_point(|start| *start <= offset).max(1)
    }
}

/// The most similar one of `known` to `word`, if one is similar enough.
pub(in crate::rig) fn closest<'a>(word: &str, known: &[&'a str]) -> Option<&'a str> {
    let word = word.to_lowercase();
    let allowed = (word.chars().count() / 3).max(1);
    known
        .iter()
        .map(|candidate| (edit_distance(&word, candidate), *candidate))
        .filter(|(distance, candidate)| {
            let extends = word.len() >= 3 && (candidate.starts_with(&word) || word.starts_with(candidate));
            *distance <= allowed || extends
        })
        .min_by_key(|(distance, _)| *distance)
        .map(|(_, candidate)| candidate)
}

/// Number of single-character insertions, deletions, replacements and swaps of neighbours that turn
/// `a` into `b` (optimal string alignment distance).
fn edit_distance(a: &str, b: &str) -> usize {
    let (a, b): (Vec<char>, Vec<char>) = (a.chars().take(64).collect(), b.chars().take(64).collect());
    let mut rows = vec![vec![0; b.len() + 1]; a.len() + 1];
    rows[0] = (0..=b.len()).collect();
    for (i, row) in rows.iter_mut().enumerate() {
        row[0] = i;
    }
    for i in 1..=a.len() {
        for j in 1..=b.len() {
            let replaced = rows[i - 1][j - 1] + usize::from(a[i - 1] != b[j - 1]);
            let mut best = replaced.min(rows[i - 1][j] + 1).min(rows[i][j - 1] + 1);
            if i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1] {
                best = best.min(rows[i - 2][j - 2] + 1);
            }
            rows[i][j] = best;
        }
    }
    rows[a.len()][b.len()]
}
