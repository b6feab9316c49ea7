//! Values that each key of a rig accepts, recorded while a file is read.

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
        /// Value that replaces a missing key, if it is one number.
        default: Option<f64>,
    },
    /// A list of whole numbers.
    Whole {
        /// Least and greatest value of each.
        ranges: Vec<(u32, u32)>,
        /// Description of the numbers, with their unit.
        what: &'static str,
    },
    /// `true` or `false`.
    Truth {
        /// Value that replaces a missing key.
        default: bool,
    },
    /// One of these words.
    Word {
        /// The words.
        words: Vec<&'static str>,
    },
}
