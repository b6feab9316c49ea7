//! Text files, line by line.

use crate::error::{Error, Result};
use crate::formats::reading::input::invalid;

/// Longest line, bytes: enough for a face with thousands of corners.
const LONGEST_LINE: usize = 1 << 16;

/// Lines of a text file that are not blank, with their numbers.
pub(in crate::formats) struct Lines<'a> {
    name: &'a str,
    rest: std::iter::Enumerate<std::str::Lines<'a>>,
    /// Number of the last returned line, from 1; 0 before the first.
    number: usize,
}

impl<'a> Lines<'a> {
    /// Starts with `bytes`, which must be UTF-8 (with or without a byte order mark), of the file
    /// `name`.
    pub(in crate::formats) fn new(name: &'a str, bytes: &'a [u8]) -> Result<Self> {
        let text = std::str::from_utf8(bytes).map_err(|error| {
            let line = 1 + bytes[..error.valid_up_to()].iter().filter(|&&byte| byte == b'\n').count();
            invalid(name, format!("line {line} is not text (UTF-8)"))
        })?;
        let text = text.strip_prefix('\u{feff}').unwrap_or(text);
        if let Some(index) = text.lines().position(|line| line.len() > LONGEST_LINE) {
            return Err(invalid(&format!("{name}:{}", index + 1), format!("is longer than {LONGEST_LINE} bytes")));
        }
        Ok(Self { name, rest: text.lines().enumerate(), number: 0 })
    }

    /// Returns the next line that is not blank, trimmed.
    pub(in crate::formats) fn next(&mut self) -> Option<&'a str> {
        for (index, line) in self.rest.by_ref() {
            self.number = index + 1;
            let line = line.trim();
            if !line.is_empty() {
                return Some(line);
            }
        }
        None
    }

    /// Returns the next line that is not blank; `what` describes it for the error at the file's
    /// end.
    pub(in crate::formats) fn expect(&mut self, what: &str) -> Result<&'a str> {
        self.next().ok_or_else(|| invalid(self.name, format!("ends after line {}; expected {what}", self.number)))
    }

    /// Error in the last returned line.
    pub(in crate::formats) fn wrong(&self, why: impl std::fmt::Display) -> Error {
        invalid(&format!("{}:{}", self.name, self.number), why)
    }

    /// Reads a finite number of the last returned line.
    pub(in crate::formats) fn number(&self, word: &str, what: &str) -> Result<f64> {
        let number = word.parse::<f64>().ok().filter(|number| number.is_finite());
        number.ok_or_else(|| self.wrong(format!("{} is no number that can be used; expected {what}", shown(word))))
    }

    /// Reads a whole number from `least` to `greatest` of the last returned line.
    pub(in crate::formats) fn count(&self, word: &str, what: &str, least: usize, greatest: usize) -> Result<usize> {
        let count = word.parse::<usize>().ok().filter(|count| (least..=greatest).contains(count));
        count.ok_or_else(|| {
            self.wrong(format!(
                "{} does not fit; expected {what}, a whole number from {least} to {greatest}",
                shown(word)
            ))
        })
    }
}

/// Word of a file in quotes, cut to a length that fits into a message.
pub(in crate::formats) fn shown(word: &str) -> String {
    format!("{:?}", word.chars().take(40).collect::<String>())
}
