//! The error type of the commands: a message for the user and an exit code.

use std::process::ExitCode;

/// A message for the user and the exit code that goes with it.
#[derive(Debug)]
pub struct Failure {
    /// The message; each line is printed after the name of the command.
    pub message: String,
    /// Exit code of the process.
    pub code: u8,
}

impl Failure {
    /// A failure with exit code 1.
    pub fn new(message: impl Into<String>) -> Self {
        Self { message: message.into(), code: 1 }
    }

    /// An error in what the user gave, with exit code 2.
    pub fn usage(message: impl Into<String>) -> Self {
        Self { message: message.into(), code: 2 }
    }
}

impl From<cupola::Error> for Failure {
    fn from(error: cupola::Error) -> Self {
        let code = match error.kind {
            cupola::ErrorKind::InvalidArgument | cupola::ErrorKind::InvalidRig | cupola::ErrorKind::Io => 2,
            _ => 1,
        };
        Self { message: error.message, code }
    }
}

/// Prints a failure to standard error under the name of the command. Returns the exit code of the
/// process.
pub fn exit_code(command: &str, result: Result<ExitCode, Failure>) -> ExitCode {
    result.unwrap_or_else(|failure| {
        for line in failure.message.lines() {
            eprintln!("{command}: {line}");
        }
        ExitCode::from(failure.code)
    })
}
