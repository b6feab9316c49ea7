//! Errors, with a message for the user and a number for C.

use std::fmt;

/// A result with Cupola's error.
pub type Result<T> = std::result::Result<T, Error>;

/// The class of an [`Error`]; its number is the C status code and never changes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[repr(u32)]
pub enum ErrorKind {
    /// An argument is null, out of range or of the wrong size.
    InvalidArgument = 1,
    /// A rig file contains something impossible, unknown or misspelt.
    InvalidRig = 2,
    /// A file could not be read or written.
    Io = 3,
    /// The graphics driver lacks something that is needed, or refused a request.
    Graphics = 4,
    /// A call came in the wrong order, for example an end without a begin.
    InvalidState = 5,
    /// A defect of Cupola itself.
    Internal = 6,
}

/// An error: what happened, where, and what to do about it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Error {
    /// The class of the error.
    pub kind: ErrorKind,
    /// Message for the user: what happened, where (file, key, line), and what is expected.
    pub message: String,
}

impl Error {
    /// Makes an error of `kind` with `message`.
    pub fn new(kind: ErrorKind, message: impl Into<String>) -> Self {
        Self { kind, message: message.into() }
    }
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.message)
    }
}

impl std::error::Error for Error {}
