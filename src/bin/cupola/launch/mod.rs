//! What a program needs to be started with Cupola: the library, its place before the driver, a display.

pub mod display;
pub mod library;
pub mod loader;
pub mod probe;

use std::ffi::OsString;
use std::process::Command;

/// Variables for a program: name and value, or `None` to remove it.
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
