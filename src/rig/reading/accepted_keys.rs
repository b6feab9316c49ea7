//! What each key of a rig accepts, noted while a file is read.

use serde::Serialize;

/// A key that a rig file has or may have.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Key {
    /// Its path as in messages, for example `output[0].blend.ramp`.
    pub path: String,
    /// The file has it.
    pub given: bool,
    /// What it accepts.
    #[serde(flatten)]
    pub accepts: Accepts,
}

/// What a key accepts.
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
        /// What it is, with its unit.
        what: &'static str,
        /// What stands for it where the file has no such key, if that is one number.
        default: Option<f64>,
    },
    /// A list of whole numbers.
    Whole {
        /// Least and greatest of each.
        ranges: Vec<(u32, u32)>,
        /// What they are, with their unit.
        what: &'static str,
    },
    /// `true` or `false`.
    Truth {
        /// What stands for it where the file has no such key.
        default: bool,
    },
    /// One of these words.
    Word {
        /// The words.
        words: Vec<&'static str>,
    },
}
