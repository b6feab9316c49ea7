//! Typed values out of TOML, with the line of each, and the list of problems.

pub mod accepted_keys;
pub mod allowed;
mod numbers;
pub mod one_line;
pub mod problems;
pub mod reader;
pub mod syntax_hints;
