//! Keys and numbers in one line, as on the command line and in the environment:
//! `yaw=90,move=0,0,-20`.

use crate::error::{Error, ErrorKind, Result};
use crate::rig::reading::allowed::Allowed;
use crate::rig::reading::problems::closest;
use glam::DVec3;

/// A line, with its subject.
pub(in crate::rig) struct OneLine<'a> {
    /// Subject of the line.
    pub what: &'static str,
    /// Example of a correct line.
    pub example: &'static str,
    /// The line.
    pub text: &'a str,
}

/// A key of a line with its numbers.
pub(in crate::rig) struct Entry<'a> {
    line: &'a OneLine<'a>,
    /// The key.
    pub key: &'a str,
    numbers: Vec<f64>,
}

impl<'a> OneLine<'a> {
    /// Returns the keys with their numbers, in the line's order.
    ///
    /// # Errors
    /// [`ErrorKind::InvalidArgument`] for numbers that have no key or cannot be read, and for
    /// repeated keys.
    pub fn entries(&'a self) -> Result<Vec<Entry<'a>>> {
        let mut entries: Vec<Entry<'a>> = Vec::new();
        for part in self.text.split(',').map(str::trim) {
            if part.is_empty() && self.text.trim().is_empty() {
                continue;
            }
            let number = match part.split_once('=') {
                Some((key, number)) => {
                    let key = key.trim();
                    if entries.iter().any(|entry| entry.key == key) {
                        return Err(self.wrong(format!("`{key}` is given twice")));
                    }
                    entries.push(Entry { line: self, key, numbers: Vec::new() });
                    number.trim()
                }
                None => part,
            };
            let value = number.parse().map_err(|_| self.wrong(format!("{number:?} is not a number")))?;
            match entries.last_mut() {
                Some(entry) => entry.numbers.push(value),
                None => return Err(self.wrong(format!("{part:?} has no key before it"))),
            }
        }
        Ok(entries)
    }

    /// Error of a key that is not in `known`.
    pub fn unknown(&self, key: &str, known: &[&str]) -> Error {
        let hint = closest(key, known)
            .map_or_else(|| format!("possible keys: {}", known.join(", ")), |meant| format!("did you mean `{meant}`?"));
        self.wrong(format!("`{key}` is unknown; {hint}"))
    }

    fn wrong(&self, why: String) -> Error {
        let Self { what, example, text } = self;
        Error::new(ErrorKind::InvalidArgument, format!("{what} {text:?}: {why}; expected for example {example}"))
    }
}

impl Entry<'_> {
    /// Returns the only number.
    pub fn number(&self, allowed: &Allowed) -> Result<f64> {
        match self.numbers[..] {
            [number] => self.allowed(number, allowed),
            _ => Err(self.line.wrong(format!("`{}` takes one number, not {}", self.key, self.numbers.len()))),
        }
    }

    /// Returns the three numbers.
    pub fn vector(&self, allowed: &Allowed) -> Result<DVec3> {
        let [x, y, z] = self.numbers[..] else {
            return Err(self.line.wrong(format!("`{}` takes three numbers, not {}", self.key, self.numbers.len())));
        };
        Ok(DVec3::new(self.allowed(x, allowed)?, self.allowed(y, allowed)?, self.allowed(z, allowed)?))
    }

    fn allowed(&self, number: f64, allowed: &Allowed) -> Result<f64> {
        match allowed.refuse(number) {
            None => Ok(number),
            Some(why) => Err(self.line.wrong(format!("`{}`: {why}", self.key))),
        }
    }
}
