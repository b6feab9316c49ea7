//! Writes pictures to the standard input of other programs, which encode, send or show them: for
//! `cupola stream` and for `cupola record --film` and `--pipe`.

mod format;
pub mod nut;
mod y4m;

pub use format::{Format, TimeBase, Writing};

use crate::failure::Failure;
use crate::launch::clock::Rate;
use cupola::ring::Picture;
use std::io::ErrorKind;
use std::process::{Child, Command, Stdio};

/// A program that receives pictures.
pub struct Receiver {
    child: Child,
    /// Name for messages.
    name: String,
    size: (u32, u32),
    writing: Writing,
}

/// Rate and format of the pictures.
#[derive(Clone, Copy, Debug)]
pub struct Form {
    pub format: Format,
    pub base: TimeBase,
    pub rate: Rate,
}

impl Receiver {
    /// Starts a program for pictures like `picture`. It inherits the standard error.
    pub fn start(command: &mut Command, form: Form, picture: &Picture) -> Result<Self, Failure> {
        let name = command.get_program().to_string_lossy().into_owned();
        let child = command.stdin(Stdio::piped()).spawn().map_err(|error| {
            let advice = if error.kind() == ErrorKind::NotFound { "; install it" } else { "" };
            Failure::new(format!("{name}, which takes the pictures, cannot be started: {error}{advice}"))
        })?;
        Ok(Self { child, name, size: picture.size, writing: Writing::new(form, picture.size) })
    }

    /// Makes a shell command from the user's text. Variables describe the pictures.
    pub fn shell(command: &str, rate: Rate, picture: &Picture) -> Command {
        let mut shell = Command::new("/bin/sh");
        shell.args(["-c", command]);
        shell.env("CUPOLA_OUTPUT", &picture.name).env("CUPOLA_FPS", format!("{}/{}", rate.frames, rate.seconds));
        shell.env("CUPOLA_WIDTH", picture.size.0.to_string()).env("CUPOLA_HEIGHT", picture.size.1.to_string());
        shell
    }

    /// Width and height of the pictures that it receives.
    pub fn size(&self) -> (u32, u32) {
        self.size
    }

    /// Writes a picture of this size, and waits until it is received. `time`: in units of the time
    /// base.
    pub fn add(&mut self, picture: &Picture, time: u64) -> Result<(), Failure> {
        let Some(input) = self.child.stdin.as_mut() else { return Ok(()) };
        let written = self.writing.add(input, &picture.rgba, time);
        written.map_err(|error| {
            let ended = if error.kind() == ErrorKind::BrokenPipe { " (it has ended)" } else { "" };
            Failure::new(format!("{} takes no more pictures: {error}{ended}", self.name))
        })
    }

    /// Ends the pictures and waits for the program's end.
    pub fn finish(&mut self) -> Result<(), Failure> {
        drop(self.child.stdin.take());
        let status = self.child.wait().map_err(|error| Failure::new(format!("{}: {error}", self.name)))?;
        match status.success() {
            true => Ok(()),
            false => Err(Failure::new(format!("{} failed with {status}", self.name))),
        }
    }
}

impl Drop for Receiver {
    fn drop(&mut self) {
        // The program ends when its input ends, and keeps its result.
        drop(self.child.stdin.take());
        let _ = self.child.wait();
    }
}
