//! Processes that play files of calls, with and without Cupola.

use crate::display::Server;
use crate::environment::Environment;
use crate::failure::Failure;
use cupola::system::process;
use std::io::{BufRead, BufReader, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdout, Command, Stdio};

/// Answers of OpenGL to the lines of a file, and whether the process reached the file's end.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Answers {
    pub lines: Vec<String>,
    pub ended: bool,
}

impl Answers {
    /// Line in which the process crashed.
    pub fn crash(&self) -> Option<usize> {
        let (line, words) = self.lines.last()?.split_once(' ')?;
        if words.starts_with("signal") { line.parse().ok() } else { None }
    }
}

/// A process that plays files, restarted after each crash.
pub struct Player {
    program: PathBuf,
    questions: PathBuf,
    environment: Environment,
    running: Option<(Child, BufReader<ChildStdout>)>,
    /// Number of files that this process played.
    played: usize,
}

/// Greatest number of files that one process plays.
const MOST: usize = 200;

impl Player {
    /// `environment` is set after that of the X server.
    pub fn new(program: &Path, questions: &Path, server: &Server, environment: &Environment) -> Self {
        // With cached programs of an earlier run, Mesa links some that it refuses otherwise.
        let settings =
            [("LIBGL_ALWAYS_SOFTWARE", "1"), ("MESA_DEBUG", "silent"), ("MESA_SHADER_CACHE_DISABLE", "true")];
        let mut all: Environment =
            settings.map(|(name, value)| (name.to_owned(), Some(value.to_owned()))).into_iter().collect();
        let text = |value: Option<std::ffi::OsString>| value.map(|value| value.to_string_lossy().into_owned());
        all.extend(server.environment().into_iter().map(|(name, value)| (name.to_owned(), text(value))));
        all.extend_from_slice(environment);
        Self {
            program: program.to_owned(),
            questions: questions.to_owned(),
            environment: all,
            running: None,
            played: 0,
        }
    }

    /// Plays a file.
    pub fn play(&mut self, file: &Path) -> Result<Answers, Failure> {
        self.send(file)?;
        self.receive()
    }

    /// Begins to play a file, and starts a process if none runs. Processes end with the thread that
    /// starts them.
    pub fn send(&mut self, file: &Path) -> Result<(), Failure> {
        if self.played >= MOST {
            self.stop();
        }
        if self.running.is_none() {
            self.running = Some(self.start()?);
            self.played = 0;
        }
        self.played += 1;
        // A process that has ended does not read; its end is noticed when it should answer.
        let input = self.running.as_mut().and_then(|(child, _)| child.stdin.as_mut());
        let _ = input.map(|input| writeln!(input, "{}", file.display()));
        Ok(())
    }

    fn start(&self) -> Result<(Child, BufReader<ChildStdout>), Failure> {
        let mut command = Command::new(&self.program);
        command.arg(&self.questions).stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::null());
        for (name, value) in &self.environment {
            match value {
                Some(value) => command.env(name, value),
                None => command.env_remove(name),
            };
        }
        let child = process::end_with_parent(&mut command).spawn();
        let mut child = child.map_err(|error| Failure::new(format!("{}: {error}", self.program.display())))?;
        let output = child.stdout.take().ok_or_else(|| Failure::new("the player has no output"))?;
        Ok((child, BufReader::new(output)))
    }

    /// Waits for the answers to the file that was sent.
    pub fn receive(&mut self) -> Result<Answers, Failure> {
        let mut answers = Answers::default();
        let Some((_, output)) = &mut self.running else { return Ok(answers) };
        let mut line = Vec::new();
        while output.read_until(b'\n', &mut line).map_err(|error| Failure::new(error.to_string()))? > 0 {
            let text = String::from_utf8_lossy(&line).trim_end().to_owned();
            if text == "end" {
                answers.ended = true;
                break;
            }
            answers.lines.push(text);
            line.clear();
        }
        if !answers.ended {
            self.stop();
        }
        Ok(answers)
    }

    /// Ends the process.
    pub fn stop(&mut self) {
        if let Some((mut child, _)) = self.running.take() {
            // It may have ended by itself.
            let _ = child.kill();
            let _ = child.wait();
        }
    }
}

impl Drop for Player {
    fn drop(&mut self) {
        self.stop();
    }
}
