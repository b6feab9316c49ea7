//! Values of a configuration, with their paths for messages.

use super::MOST;
use crate::error::Result;
use crate::formats::reading::input::invalid;
use glam::DVec3;
use serde_json::Value;

/// A value of the file, and its path.
pub(super) struct Key<'a> {
    pub(super) name: &'a str,
    pub(super) path: String,
    pub(super) value: &'a Value,
}

impl<'a> Key<'a> {
    fn path_of(&self, key: &str) -> String {
        if self.path.is_empty() { key.to_owned() } else { format!("{}.{key}", self.path) }
    }

    pub(super) fn wrong(&self, why: impl std::fmt::Display) -> crate::Error {
        invalid(&format!("{}: {}", self.name, self.path), why)
    }

    pub(super) fn optional(&self, key: &str) -> Option<Self> {
        self.value.get(key).map(|value| Self { name: self.name, path: self.path_of(key), value })
    }

    pub(super) fn required(&self, key: &str) -> Result<Self> {
        let missing = || invalid(self.name, format!("{} is missing", self.path_of(key)));
        self.optional(key).ok_or_else(missing)
    }

    /// Items of a list; none if it is absent.
    pub(super) fn list(&self, key: &str) -> Result<Vec<Self>> {
        let Some(list) = self.optional(key) else { return Ok(Vec::new()) };
        let items = list.value.as_array().filter(|items| items.len() <= MOST);
        let items = items.ok_or_else(|| list.wrong(format!("is no list of at most {MOST} items")))?;
        let item = |(index, value)| Self { name: self.name, path: format!("{}[{index}]", list.path), value };
        Ok(items.iter().enumerate().map(item).collect())
    }

    pub(super) fn text(&self) -> Result<String> {
        self.value.as_str().map(str::to_owned).ok_or_else(|| self.wrong("is no text"))
    }

    pub(super) fn truth(&self) -> Result<bool> {
        self.value.as_bool().ok_or_else(|| self.wrong("is neither true nor false"))
    }

    pub(super) fn number(&self, least: f64, greatest: f64) -> Result<f64> {
        let number = self.value.as_f64().filter(|number| (least..=greatest).contains(number));
        number.ok_or_else(|| self.wrong(format!("is no number from {least} to {greatest}")))
    }

    pub(super) fn pair(&self) -> Result<[f64; 2]> {
        let part = |name| self.required(name)?.number(-1e6, 1e6);
        Ok([part("x")?, part("y")?])
    }

    pub(super) fn vector(&self) -> Result<DVec3> {
        let part = |name| self.required(name)?.number(-1e6, 1e6);
        Ok(DVec3::new(part("x")?, part("y")?, part("z")?))
    }
}
