//! Typed values out of a parsed TOML table, each with its key path and line.
//!
//! The code walks through tables and does not deserialise with serde, because serde stops at the
//! first problem and has neither the key path nor the list of possible keys for a misspelt one.

use crate::rig::Node;
use crate::rig::reading::accepted_keys::Accepts;
use crate::rig::reading::problems::{Problems, closest};
use glam::DVec3;
use std::collections::BTreeSet;
use toml::de::{DeArray, DeTable, DeValue};

/// Numbers that a key may have.
pub(in crate::rig) struct Allowed {
    /// Least value.
    least: f64,
    /// Greatest value.
    greatest: f64,
    /// True for each end that is excluded: (least, greatest).
    open: (bool, bool),
    /// Description of the number, with its unit: "a radius in metres".
    what: &'static str,
}

impl Allowed {
    /// From `least` to `greatest`, both included.
    pub(in crate::rig) const fn closed(least: f64, greatest: f64, what: &'static str) -> Self {
        Self { least, greatest, open: (false, false), what }
    }

    /// Greater than `least`, up to and including `greatest`.
    pub(in crate::rig) const fn above(least: f64, greatest: f64, what: &'static str) -> Self {
        Self { least, greatest, open: (true, false), what }
    }

    /// Between `least` and `greatest`, both excluded.
    pub(in crate::rig) const fn between(least: f64, greatest: f64, what: &'static str) -> Self {
        Self { least, greatest, open: (true, true), what }
    }

    /// From and including `least`, less than `greatest`.
    pub(in crate::rig) const fn below(least: f64, greatest: f64, what: &'static str) -> Self {
        Self { least, greatest, open: (false, true), what }
    }

    /// Record of a key with these numbers.
    fn note(&self, count: Option<usize>, default: Option<f64>) -> Accepts {
        Accepts::Number { count, least: self.least, greatest: self.greatest, what: self.what, default }
    }

    /// Returns the reason why `value` is not allowed; `None` if it is allowed.
    pub(in crate::rig) fn refuse(&self, value: f64) -> Option<String> {
        if !value.is_finite() {
            return Some(format!("{value} is no number that can be used; expected {}, {}", self.what, self.words()));
        }
        let low = if self.open.0 { value > self.least } else { value >= self.least };
        let high = if self.open.1 { value < self.greatest } else { value <= self.greatest };
        (!(low && high)).then(|| format!("{value} is out of range; expected {}, {}", self.what, self.words()))
    }

    /// Range in words.
    fn words(&self) -> String {
        let low = if self.open.0 { "greater than" } else { "at least" };
        let high = if self.open.1 { "less than" } else { "at most" };
        format!("{low} {} and {high} {}", self.least, self.greatest)
    }
}

/// A table of the file that is being read.
pub(in crate::rig) struct Section<'a> {
    table: &'a DeTable<'a>,
    path: String,
    asked: BTreeSet<&'static str>,
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

    fn value(&mut self, key: &'static str, problems: &mut Problems) -> Option<&'a DeValue<'a>> {
        self.asked.insert(key);
        let (name, value) = self.table.get_key_value(key)?;
        problems.place(&self.path(key), &name.span());
        Some(value.get_ref())
    }

    /// Reads a number; `default` if the key is absent (or wrong, after adding the problem).
    pub(in crate::rig) fn number(
        &mut self,
        key: &'static str,
        allowed: &Allowed,
        default: f64,
        problems: &mut Problems,
    ) -> f64 {
        problems.note_key(|| self.path(key), self.has(key), || allowed.note(None, Some(default)));
        self.optional_number(key, allowed, problems).unwrap_or(default)
    }

    /// Reads a number that may be absent.
    pub(in crate::rig) fn optional_number(
        &mut self,
        key: &'static str,
        allowed: &Allowed,
        problems: &mut Problems,
    ) -> Option<f64> {
        problems.note_key(|| self.path(key), self.has(key), || allowed.note(None, None));
        let value = self.value(key, problems)?;
        checked_number(value, allowed, &self.path(key), problems)
    }

    /// Reads a number that must be present.
    pub(in crate::rig) fn required_number(
        &mut self,
        key: &'static str,
        allowed: &Allowed,
        problems: &mut Problems,
    ) -> f64 {
        problems.note_key(|| self.path(key), self.has(key), || allowed.note(None, None));
        if !self.has(key) {
            self.asked.insert(key);
            problems.add(&self.path(key), format!("is missing; expected {}, {}", allowed.what, allowed.words()));
        }
        self.number(key, allowed, allowed.least, problems)
    }

    /// Reads `COUNT` numbers in an array; `None` if the key is absent or wrong.
    pub(in crate::rig) fn numbers<const COUNT: usize>(
        &mut self,
        key: &'static str,
        allowed: &Allowed,
        problems: &mut Problems,
    ) -> Option<[f64; COUNT]> {
        problems.note_key(|| self.path(key), self.has(key), || allowed.note(Some(COUNT), None));
        let value = self.value(key, problems)?;
        let path = self.path(key);
        let array = sized_array(value, COUNT, allowed.what, &path, problems)?;
        let mut numbers = [0.0; COUNT];
        let mut good = true;
        for (index, item) in array.iter().enumerate() {
            let item_path = format!("{path}[{index}]");
            problems.place(&item_path, &item.span());
            match checked_number(item.get_ref(), allowed, &item_path, problems) {
                Some(number) => numbers[index] = number,
                None => good = false,
            }
        }
        good.then_some(numbers)
    }

    /// Reads a list of pairs of numbers; `None` if the key is absent or wrong.
    pub(in crate::rig) fn number_pairs(
        &mut self,
        key: &'static str,
        allowed: &Allowed,
        problems: &mut Problems,
    ) -> Option<Vec<[f64; 2]>> {
        let value = self.value(key, problems)?;
        let path = self.path(key);
        let Some(array) = value.as_array() else {
            problems.add(&path, format!("{} is not a list; expected [[…, …], …]: {}", describe(value), allowed.what));
            return None;
        };
        let mut pairs = Vec::with_capacity(array.len());
        let mut good = true;
        for (index, item) in array.iter().enumerate() {
            let item_path = format!("{path}[{index}]");
            problems.place(&item_path, &item.span());
            let pair = sized_array(item.get_ref(), 2, allowed.what, &item_path, problems);
            let numbers: Vec<f64> = pair
                .into_iter()
                .flat_map(|pair| pair.iter())
                .filter_map(|number| checked_number(number.get_ref(), allowed, &item_path, problems))
                .collect();
            match numbers[..] {
                [first, second] => pairs.push([first, second]),
                _ => good = false,
            }
        }
        good.then_some(pairs)
    }

    /// Reads three numbers; zero if the key is absent or wrong.
    pub(in crate::rig) fn vector(&mut self, key: &'static str, allowed: &Allowed, problems: &mut Problems) -> DVec3 {
        problems.note_key(|| self.path(key), self.has(key), || allowed.note(Some(3), Some(0.0)));
        self.numbers::<3>(key, allowed, problems).map_or(DVec3::ZERO, DVec3::from_array)
    }

    /// Reads one to `most` different vectors; `None` if the key is absent or wrong.
    pub(in crate::rig) fn vectors(
        &mut self,
        key: &'static str,
        most: usize,
        allowed: &Allowed,
        problems: &mut Problems,
    ) -> Option<Vec<DVec3>> {
        let value = self.value(key, problems)?;
        let path = self.path(key);
        let Some(list) = value.as_array().filter(|list| (1..=most).contains(&list.len())) else {
            problems.add(
                &path,
                format!("{} does not fit; expected 1 to {most} of [x, y, z]: {}", describe(value), allowed.what),
            );
            return None;
        };
        let mut vectors: Vec<DVec3> = Vec::with_capacity(list.len());
        for (index, item) in list.iter().enumerate() {
            let path = format!("{path}[{index}]");
            problems.place(&path, &item.span());
            let array = sized_array(item.get_ref(), 3, allowed.what, &path, problems)?;
            let mut vector = [0.0; 3];
            for (number, value) in vector.iter_mut().zip(array.iter()) {
                *number = checked_number(value.get_ref(), allowed, &path, problems)?;
            }
            let vector = DVec3::from_array(vector);
            if vectors.contains(&vector) {
                problems.add(&path, "repeats another vector; expected different vectors".to_owned());
                return None;
            }
            vectors.push(vector);
        }
        Some(vectors)
    }

    /// Reads `COUNT` whole numbers of pixels, each within its own range.
    pub(in crate::rig) fn pixels<const COUNT: usize>(
        &mut self,
        key: &'static str,
        ranges: [(u32, u32); COUNT],
        what: &'static str,
        problems: &mut Problems,
    ) -> Option<[u32; COUNT]> {
        problems.note_key(|| self.path(key), self.has(key), || Accepts::Whole { ranges: ranges.to_vec(), what });
        let value = self.value(key, problems)?;
        let path = self.path(key);
        let array = sized_array(value, COUNT, what, &path, problems)?;
        let mut pixels = [0; COUNT];
        let mut good = true;
        for (index, item) in array.iter().enumerate() {
            let item_path = format!("{path}[{index}]");
            problems.place(&item_path, &item.span());
            let (least, greatest) = ranges[index];
            let number = item.get_ref().as_integer().and_then(|i| i64::from_str_radix(i.as_str(), i.radix()).ok());
            match number.and_then(|number| u32::try_from(number).ok()).filter(|n| (least..=greatest).contains(n)) {
                Some(number) => pixels[index] = number,
                None => {
                    let is = describe(item.get_ref());
                    problems.add(
                        &item_path,
                        format!("{is} is not possible; expected {what}, each a whole number: this one from {least} to {greatest}"),
                    );
                    good = false;
                }
            }
        }
        good.then_some(pixels)
    }

    /// Reads a truth value; `default` if the key is absent or wrong.
    pub(in crate::rig) fn boolean(&mut self, key: &'static str, default: bool, problems: &mut Problems) -> bool {
        problems.note_key(|| self.path(key), self.has(key), || Accepts::Truth { default });
        let Some(value) = self.value(key, problems) else { return default };
        value.as_bool().unwrap_or_else(|| {
            problems.add(&self.path(key), format!("{} is neither true nor false (without quotes)", describe(value)));
            default
        })
    }

    /// Reads text that may be absent.
    pub(in crate::rig) fn text(&mut self, key: &'static str, what: &str, problems: &mut Problems) -> Option<&'a str> {
        let value = self.value(key, problems)?;
        if value.as_str().is_none() {
            problems.add(&self.path(key), format!("{} is not text; expected {what} in quotes", describe(value)));
        }
        value.as_str()
    }

    /// Reads a machine: its number, or its name.
    pub(in crate::rig) fn node(&mut self, key: &'static str, problems: &mut Problems) -> Option<Node> {
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

    /// Reads one of a few words.
    pub(in crate::rig) fn choice<T: Clone>(
        &mut self,
        key: &'static str,
        choices: &[(&'static str, T)],
        problems: &mut Problems,
    ) -> Option<T> {
        let noted = || Accepts::Word { words: choices.iter().map(|(word, _)| *word).collect() };
        problems.note_key(|| self.path(key), self.has(key), noted);
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

    /// Reads a table in this one; `None` if the key is absent or wrong.
    pub(in crate::rig) fn section(&mut self, key: &'static str, problems: &mut Problems) -> Option<Section<'a>> {
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

/// Reads `value` as a number in `allowed`; otherwise the problem is added.
fn checked_number(value: &DeValue, allowed: &Allowed, path: &str, problems: &mut Problems) -> Option<f64> {
    let number = match value {
        DeValue::Integer(integer) => i64::from_str_radix(integer.as_str(), integer.radix()).ok().map(|i| i as f64),
        DeValue::Float(float) => float.as_str().parse().ok(),
        _ => None,
    };
    let Some(number) = number else {
        let quotes = if value.is_str() { " without quotes or unit" } else { "" };
        problems.add(
            path,
            format!("{} is not a number; expected {}{quotes}, {}", describe(value), allowed.what, allowed.words()),
        );
        return None;
    };
    if let Some(why) = allowed.refuse(number) {
        problems.add(path, why);
        return None;
    }
    Some(number)
}

/// Reads `value` as an array of `count` items; otherwise the problem is added.
fn sized_array<'a>(
    value: &'a DeValue<'a>,
    count: usize,
    what: &str,
    path: &str,
    problems: &mut Problems,
) -> Option<&'a DeArray<'a>> {
    let array = value.as_array().filter(|array| array.len() == count);
    if array.is_none() {
        let example = vec!["…"; count].join(", ");
        problems.add(path, format!("{} does not fit; expected {count} numbers, [{example}]: {what}", describe(value)));
    }
    array
}

/// Describes `value` as the file's author would.
fn describe(value: &DeValue) -> String {
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
