//! The environment that `cupola run` gives to programs.

use crate::failure::Failure;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Variables with their values; without a value they are unset.
pub type Environment = Vec<(String, Option<String>)>;

/// Environment of programs with a rig. Files for the loaders are in `folder`.
pub fn of_rig(name: &str, folder: &Path) -> Result<Environment, Failure> {
    let mut command = Command::new(beside_this("cupola")?);
    command.args(["run", "--print-environment", "--rig", name]).env("XDG_CACHE_HOME", folder);
    let output = command.output().map_err(|error| Failure::new(format!("cupola cannot be started: {error}")))?;
    if !output.status.success() {
        return Err(Failure::usage(String::from_utf8_lossy(&output.stderr).trim()));
    }
    let text = String::from_utf8_lossy(&output.stdout);
    let variable = |line: &str| {
        if let Some(name) = line.strip_prefix("unset ") {
            return Some((name.to_owned(), None));
        }
        let (name, value) = line.strip_prefix("export ")?.split_once("='")?;
        Some((name.to_owned(), Some(value.strip_suffix('\'')?.replace(r"'\''", "'"))))
    };
    Ok(text.lines().filter_map(variable).collect())
}

/// Path of a file in the folder of this command.
pub fn beside_this(name: &str) -> Result<PathBuf, Failure> {
    let this = std::env::current_exe().map_err(|error| Failure::new(error.to_string()))?;
    Ok(this.with_file_name(name))
}
