//! Numbers out of a parsed TOML table: one, a fixed number of them in a list, pairs, vectors, pixels.

use super::accepted_keys::{Accepts, DefaultValue};
use super::allowed::Allowed;
use super::problems::Problems;
use super::reader::{Section, describe};
use glam::DVec3;
use toml::de::{DeArray, DeValue};

impl<'a> Section<'a> {
    /// Reads a number; `default` if the key is absent (or wrong, after adding the problem).
    pub(in crate::rig) fn number(
        &mut self,
        key: &'static str,
        allowed: &Allowed,
        default: f64,
        problems: &mut Problems,
    ) -> f64 {
        self.checked_number(key, allowed, default, problems).unwrap_or(default)
    }

    /// Reads a number; `default` if the key is absent, `None` if it is wrong.
    pub(in crate::rig) fn checked_number(
        &mut self,
        key: &'static str,
        allowed: &Allowed,
        default: f64,
        problems: &mut Problems,
    ) -> Option<f64> {
        let noted = || Some(DefaultValue::Number(default));
        problems.note_key(|| self.path(key), self.has(key), || allowed.note(None), noted);
        let number = self.optional_number(key, allowed, problems);
        if self.has(key) { number } else { Some(default) }
    }

    /// Reads an angle in degrees and returns it in radians; `default` radians if the key is absent
    /// or wrong.
    pub(in crate::rig) fn angle(
        &mut self,
        key: &'static str,
        allowed: &Allowed,
        default: f64,
        problems: &mut Problems,
    ) -> f64 {
        let noted = || Some(DefaultValue::angle(default));
        problems.note_key(|| self.path(key), self.has(key), || allowed.note(None), noted);
        self.optional_number(key, allowed, problems).map_or(default, f64::to_radians)
    }

    /// Reads a number that may be absent.
    pub(in crate::rig) fn optional_number(
        &mut self,
        key: &'static str,
        allowed: &Allowed,
        problems: &mut Problems,
    ) -> Option<f64> {
        problems.note_key(|| self.path(key), self.has(key), || allowed.note(None), || None);
        let value = self.value(key, problems)?;
        in_range(value, allowed, &self.path(key), problems)
    }

    /// Reads a number that must be present.
    pub(in crate::rig) fn required_number(
        &mut self,
        key: &'static str,
        allowed: &Allowed,
        problems: &mut Problems,
    ) -> f64 {
        problems.note_key(|| self.path(key), self.has(key), || allowed.note(None), || None);
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
        problems.note_key(|| self.path(key), self.has(key), || allowed.note(Some(COUNT)), || None);
        let value = self.value(key, problems)?;
        let path = self.path(key);
        let array = sized_array(value, COUNT, allowed.what, &path, problems)?;
        let mut numbers = [0.0; COUNT];
        let mut good = true;
        for (index, item) in array.iter().enumerate() {
            let item_path = format!("{path}[{index}]");
            problems.place(&item_path, &item.span());
            match in_range(item.get_ref(), allowed, &item_path, problems) {
                Some(number) => numbers[index] = number,
                None => good = false,
            }
        }
        good.then_some(numbers)
    }

    /// Reads `COUNT` numbers in an array; `default` if the key is absent, `None` if it is wrong.
    pub(in crate::rig) fn checked_numbers<const COUNT: usize>(
        &mut self,
        key: &'static str,
        allowed: &Allowed,
        default: [f64; COUNT],
        problems: &mut Problems,
    ) -> Option<[f64; COUNT]> {
        let noted = || Some(DefaultValue::Numbers(default.to_vec()));
        problems.note_key(|| self.path(key), self.has(key), || allowed.note(Some(COUNT)), noted);
        let numbers = self.numbers(key, allowed, problems);
        if self.has(key) { numbers } else { Some(default) }
    }

    /// Reads `COUNT` numbers in an array; `default` if the key is absent or wrong.
    pub(in crate::rig) fn numbers_or<const COUNT: usize>(
        &mut self,
        key: &'static str,
        allowed: &Allowed,
        default: [f64; COUNT],
        problems: &mut Problems,
    ) -> [f64; COUNT] {
        self.checked_numbers(key, allowed, default, problems).unwrap_or(default)
    }

    /// Reads a list of pairs of numbers; `None` if the key is absent or wrong.
    pub(in crate::rig) fn number_pairs(
        &mut self,
        key: &'static str,
        allowed: &Allowed,
        problems: &mut Problems,
    ) -> Option<Vec<[f64; 2]>> {
        self.note_value(key, &[], format!("[[…, …], …]: {}", allowed.what), problems);
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
                .filter_map(|number| in_range(number.get_ref(), allowed, &item_path, problems))
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
        DVec3::from_array(self.numbers_or(key, allowed, [0.0; 3], problems))
    }

    /// Reads one to `most` different vectors; `None` if the key is absent or wrong.
    pub(in crate::rig) fn vectors(
        &mut self,
        key: &'static str,
        most: usize,
        allowed: &Allowed,
        problems: &mut Problems,
    ) -> Option<Vec<DVec3>> {
        self.note_value(key, &[], format!("1 to {most} of [x, y, z]: {}", allowed.what), problems);
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
                *number = in_range(value.get_ref(), allowed, &path, problems)?;
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
        problems.note_key(
            || self.path(key),
            self.has(key),
            || Accepts::Whole { ranges: ranges.to_vec(), what },
            || None,
        );
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
}

/// Reads `value` as a number in `allowed`; otherwise the problem is added.
fn in_range(value: &DeValue, allowed: &Allowed, path: &str, problems: &mut Problems) -> Option<f64> {
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
