//! The command `convert`, for tests of calibration files.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

pub fn cupola(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_cupola")).args(arguments).output().unwrap()
}

/// Converts a file and returns the command's answer.
#[track_caller]
pub fn convert(from: &str, to: &Path, more: &[&str]) -> serde_json::Value {
    // An earlier run may have left files, therefore `--force`.
    let output = cupola(&[&["convert", from, to.to_str().unwrap(), "--json", "--force"], more].concat());
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    serde_json::from_slice(&output.stdout).unwrap()
}

/// Path of a file in a folder that only the calling test program uses.
pub fn file(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(env!("CARGO_CRATE_NAME"));
    std::fs::create_dir_all(&folder).unwrap();
    folder.join(name)
}
