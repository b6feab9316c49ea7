//! Common parts of the readers: texts line by line, binary files value by value, limits, and the
//! form of errors.

pub(super) mod bytes;
pub(super) mod input;
pub(super) mod text;
