//! Values that each key of a rig accepts and its default, recorded while a file is read.

use serde::Serialize;

/// A key that a rig file has or may have.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Key {
    /// Path of the key as in messages, for example `output[0].blend.ramp`.
    pub path: String,
    /// True if the file has it.
    pub given: bool,
    /// Values that it accepts.
    #[serde(flatten)]
    pub accepts: Accepts,
    /// Value that replaces a missing key; `None` if the key is required, or if nothing does.
    pub default: Option<DefaultValue>,
}

/// Value that replaces a missing key, in the units of the file.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(untagged)]
pub enum DefaultValue {
    /// One number.
    Number(f64),
    /// A list of numbers.
    Numbers(Vec<f64>),
    /// `true` or `false`.
    Truth(bool),
    /// A word.
    Word(&'static str),
}

impl DefaultValue {
    /// The angle of `radians` in degrees. What the conversion adds to a number is rounded away.
    pub(super) fn angle(radians: f64) -> Self {
        Self::Number((radians.to_degrees() * 1e9).round() / 1e9)
    }
}

/// Writes the value as a rig file has it, for example `[0, 0.5]`.
impl std::fmt::Display for DefaultValue {
    fn fmt(&self, to: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Number(number) => write!(to, "{number}"),
            Self::Numbers(numbers) => {
                let numbers: Vec<String> = numbers.iter().map(f64::to_string).collect();
                write!(to, "[{}]", numbers.join(", "))
            }
            Self::Truth(truth) => write!(to, "{truth}"),
            Self::Word(word) => write!(to, "{word:?}"),
        }
    }
}

/// Values that a key accepts.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(tag = "type", rename_all = "lowercase")]
pub enum Accepts {
    /// One number, or `count` of them in a list.
    Number {
        /// Length of the list; `None`: the number alone.
        count: Option<usize>,
        /// Least number.
        least: f64,
        /// Greatest number.
        greatest: f64,
        /// Description of the number, with its unit.
        what: &'static str,
    },
    /// A list of whole numbers.
    Whole {
        /// Least and greatest value of each.
        ranges: Vec<(u32, u32)>,
        /// Description of the numbers, with their unit.
        what: &'static str,
    },
    /// `true` or `false`.
    Truth,
    /// One of these words.
    Word {
        /// The words.
        words: Vec<&'static str>,
    },
    /// Text.
    Text {
        /// Description of the text.
        what: String,
    },
    /// A value that the other kinds do not describe: a list, a table in braces, or one of several
    /// kinds.
    Value {
        /// Words that are accepted too.
        words: Vec<&'static str>,
        /// Description of the value.
        what: String,
    },
    /// A table. Its keys have their own paths.
    Table,
}
