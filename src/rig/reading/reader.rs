//! Typed values out of a parsed TOML table, each with its key path and line.
//!
//! The code walks through tables and does not deserialise with serde, because serde stops at the
//! first problem and has neither the key path nor the list of possible keys for a misspelt one.

use crate::rig::Node;
use crate::rig::reading::accepted_keys::{Accepts, DefaultValue};
use crate::rig::reading::problems::{Problems, closest};
use std::collections::BTreeSet;
use toml::de::{DeTable, DeValue};

/// A table of the file that is being read.
pub(in crate::rig) struct Section<'a> {
    table: &'a DeTable<'a>,
    path: String,
    pub(super) asked: BTreeSet<&'static str>,
}

impl<'a> Section<'a> {
    /// The table `table` at the key path `path` (empty for the file itself).
    pub(in crate::rig) fn new(table: &'a DeTable<'a>, path: String) -> Self {
        Self { table, path, asked: BTreeSet::new() }
    }

    /// Path of `key` in this table.
    pub(in crate::rig) fn path(&self, key: &str) -> String {
        if self.path.is_empty() { key.to_owned() } else { format!("{}.{key}", self.path) }
    }

    /// True if the file has the key.
    pub(in crate::rig) fn has(&self, key: &str) -> bool {
        self.table.contains_key(key)
    }

    /// True if the file has the key, and it is a table.
    pub(in crate::rig) fn is_table(&self, key: &str) -> bool {
        self.table.get(key).is_some_and(|value| value.get_ref().is_table())
    }

    /// True if the file has the key, and it is a list.
    pub(in crate::rig) fn is_list(&self, key: &str) -> bool {
        self.table.get(key).is_some_and(|value| value.get_ref().is_array())
    }

    /// True if the value of `key` is this text.
    pub(in crate::rig) fn is_text(&self, key: &str, text: &str) -> bool {
        self.table.get(key).is_some_and(|value| value.get_ref().as_str() == Some(text))
    }

    /// Marks `key` as known, and stores its line. Its value is neither read nor recorded.
    pub(in crate::rig) fn know(&mut self, key: &'static str, problems: &mut Problems) {
        self.value(key, problems);
    }

    /// Records a key whose value no other kind describes. `words` are accepted too; the first one
    /// replaces a missing key.
    pub(in crate::rig) fn note_value(
        &self,
        key: &str,
        words: &[&'static str],
        what: impl Into<String>,
        problems: &mut Problems,
    ) {
        let accepts = || Accepts::Value { words: words.to_vec(), what: what.into() };
        let default = || words.first().map(|word| DefaultValue::Word(word));
        problems.note_key(|| self.path(key), self.has(key), accepts, default);
    }

    /// Value of `key`, if the file has it; its line is stored.
    pub(super) fn value(&mut self, key: &'static str, problems: &mut Problems) -> Option<&'a DeValue<'a>> {
        self.asked.insert(key);
        let (name, value) = self.table.get_key_value(key)?;
        problems.place(&self.path(key), &name.span());
        Some(value.get_ref())
    }

    /// Reads a truth value; `default` if the key is absent or wrong.
    pub(in crate::rig) fn boolean(&mut self, key: &'static str, default: bool, problems: &mut Problems) -> bool {
        problems.note_key(|| self.path(key), self.has(key), || Accepts::Truth, || Some(DefaultValue::Truth(default)));
        let Some(value) = self.value(key, problems) else { return default };
        value.as_bool().unwrap_or_else(|| {
            problems.add(&self.path(key), format!("{} is neither true nor false (without quotes)", describe(value)));
            default
        })
    }

    /// Reads text that may be absent.
    pub(in crate::rig) fn text(&mut self, key: &'static str, what: &str, problems: &mut Problems) -> Option<&'a str> {
        let noted = || Accepts::Text { what: what.to_owned() };
        problems.note_key(|| self.path(key), self.has(key), noted, || None);
        let value = self.value(key, problems)?;
        if value.as_str().is_none() {
            problems.add(&self.path(key), format!("{} is not text; expected {what} in quotes", describe(value)));
        }
        value.as_str()
    }

    /// Reads a machine: its number, or its name.
    pub(in crate::rig) fn node(&mut self, key: &'static str, problems: &mut Problems) -> Option<Node> {
        self.note_value(key, &[], "the node's number, from 0, or its host name", problems);
        let value = self.value(key, problems)?;
        let number = value.as_integer().and_then(|i| u32::from_str_radix(i.as_str(), i.radix()).ok());
        let host = value.as_str().filter(|name| !name.is_empty());
        let node = number.map(Node::Number).or_else(|| host.map(|name| Node::Host(name.to_owned())));
        if node.is_none() {
            let why =
                "is neither a whole number nor text; expected the node's number, from 0, or its host name in quotes";
            problems.add(&self.path(key), format!("{} {why}", describe(value)));
        }
        node
    }

    /// Reads a list of texts; empty if the key is absent or wrong.
    pub(in crate::rig) fn texts(&mut self, key: &'static str, what: &str, problems: &mut Problems) -> Vec<String> {
        let Some(value) = self.value(key, problems) else { return Vec::new() };
        let texts = value.as_array().and_then(|list| {
            let texts =
                list.iter().map(|item| item.get_ref().as_str().filter(|text| !text.is_empty()).map(str::to_owned));
            texts.collect::<Option<Vec<String>>>().filter(|texts| !texts.is_empty())
        });
        texts.unwrap_or_else(|| {
            let why = format!("{} does not fit; expected a list of texts in quotes: {what}", describe(value));
            problems.add(&self.path(key), why);
            Vec::new()
        })
    }

    /// Reads all keys, whatever their names, with their texts.
    pub(in crate::rig) fn all_texts(self, what: &str, problems: &mut Problems) -> Vec<(String, String)> {
        let mut texts = Vec::new();
        for (key, value) in self.table.iter() {
            let name: &str = key.get_ref();
            let path = self.path(name);
            problems.place(&path, &key.span());
            match value.get_ref().as_str() {
                Some(text) => texts.push((name.to_owned(), text.to_owned())),
                None => {
                    problems.add(&path, format!("{} is not text; expected {what} in quotes", describe(value.get_ref())))
                }
            }
        }
        texts
    }

    /// Reads one of a few words; `None` if the key is absent or wrong.
    pub(in crate::rig) fn choice<T: Clone>(
        &mut self,
        key: &'static str,
        choices: &[(&'static str, T)],
        problems: &mut Problems,
    ) -> Option<T> {
        let noted = || Accepts::Word { words: choices.iter().map(|(word, _)| *word).collect() };
        problems.note_key(|| self.path(key), self.has(key), noted, || None);
        let value = self.value(key, problems)?;
        let words: Vec<&str> = choices.iter().map(|(word, _)| *word).collect();
        let listed = words.iter().map(|word| format!("\"{word}\"")).collect::<Vec<_>>().join(", ");
        let word = value.as_str().unwrap_or_default();
        let found = choices.iter().find(|(known, _)| *known == word).map(|(_, choice)| choice.clone());
        if found.is_none() {
            let hint = closest(word, &words).map_or(String::new(), |meant| format!("; did you mean \"{meant}\"?"));
            problems.add(&self.path(key), format!("{} is not one of {listed}{hint}", describe(value)));
        }
        found
    }

    /// Reads one of a few words; `default` if the key is absent, `None` if it is wrong.
    pub(in crate::rig) fn checked_choice<T: Clone + PartialEq>(
        &mut self,
        key: &'static str,
        choices: &[(&'static str, T)],
        default: T,
        problems: &mut Problems,
    ) -> Option<T> {
        let noted = || Accepts::Word { words: choices.iter().map(|(word, _)| *word).collect() };
        let word = || choices.iter().find(|(_, choice)| *choice == default).map(|(word, _)| DefaultValue::Word(word));
        problems.note_key(|| self.path(key), self.has(key), noted, word);
        let chosen = self.choice(key, choices, problems);
        if self.has(key) { chosen } else { Some(default) }
    }

    /// Reads one of a few words; `default` if the key is absent or wrong.
    pub(in crate::rig) fn choice_or<T: Clone + PartialEq>(
        &mut self,
        key: &'static str,
        choices: &[(&'static str, T)],
        default: T,
        problems: &mut Problems,
    ) -> T {
        self.checked_choice(key, choices, default.clone(), problems).unwrap_or(default)
    }

    /// Reads a table in this one; `None` if the key is absent or wrong.
    pub(in crate::rig) fn section(&mut self, key: &'static str, problems: &mut Problems) -> Option<Section<'a>> {
        problems.note_key(|| self.path(key), self.has(key), || Accepts::Table, || None);
        let value = self.value(key, problems)?;
        let table = value.as_table();
        if table.is_none() {
            problems.add(&self.path(key), format!("{} is not a table; expected [{}]", describe(value), self.path(key)));
        }
        table.map(|table| Section::new(table, self.path(key)))
    }

    /// Reads the tables of an array of tables; empty if the key is absent or wrong.
    pub(in crate::rig) fn sections(
        &mut self,
        key: &'static str,
        example: &str,
        problems: &mut Problems,
    ) -> Vec<Section<'a>> {
        let Some(value) = self.value(key, problems) else { return Vec::new() };
        let path = self.path(key);
        let Some(array) = value.as_array() else {
            problems.add(&path, format!("{} is not a list of tables; expected {example}", describe(value)));
            return Vec::new();
        };
        let mut sections = Vec::new();
        for (index, item) in array.iter().enumerate() {
            let item_path = format!("{path}[{index}]");
            problems.place(&item_path, &item.span());
            match item.get_ref().as_table() {
                Some(table) => sections.push(Section::new(table, item_path)),
                None => {
                    problems.add(&item_path, format!("{} is not a table; expected {example}", describe(item.get_ref())))
                }
            }
        }
        sections
    }

    /// Adds a problem for every key that was not read. `elsewhere` lists keys with the places where
    /// they belong.
    pub(in crate::rig) fn finish(self, elsewhere: &[(&str, &str)], problems: &mut Problems) {
        let known: Vec<&str> = self.asked.iter().copied().collect();
        for (key, _) in self.table.iter().filter(|(key, _)| !self.asked.contains(key.get_ref().as_ref())) {
            let name = key.get_ref().as_ref();
            let path = self.path(name);
            problems.place(&path, &key.span());
            let hint = match (elsewhere.iter().find(|(other, _)| *other == name), closest(name, &known)) {
                (Some((_, place)), _) => format!("it belongs to {place}"),
                (None, Some(meant)) => format!("did you mean `{meant}`?"),
                (None, None) => format!("possible here: {}", known.join(", ")),
            };
            problems.add(&path, format!("unknown key; {hint}"));
        }
    }
}

/// Describes `value` as the file's author would.
pub(super) fn describe(value: &DeValue) -> String {
    match value {
        DeValue::String(text) => format!("{:?}", text.chars().take(60).collect::<String>()),
        DeValue::Integer(integer) => integer.to_string(),
        DeValue::Float(float) => float.to_string(),
        DeValue::Boolean(boolean) => boolean.to_string(),
        DeValue::Datetime(_) => "a date".to_owned(),
        DeValue::Array(array) => format!("a list of {}", array.len()),
        DeValue::Table(_) => "a table".to_owned(),
    }
}
