//! Requirements of a program that is started with Cupola: the library and the loaders' files.

pub mod clock;
pub mod held;
pub mod library;
pub mod loader;
pub mod probe;

use std::ffi::OsString;
use std::process::Command;

/// Environment variables of a program: name and value, or `None` to remove the variable.
pub type Environment = Vec<(&'static str, Option<OsString>)>;

/// Sets and removes the variables for `command`.
pub fn apply(command: &mut Command, environment: &Environment) {
    for (name, value) in environment {
        match value {
            Some(value) => command.env(name, value),
            None => command.env_remove(name),
        };
    }
}
