//! A private X server for `--headless`.

use super::Environment;
use crate::failure::Failure;
use cupola::system::process;
use std::io::{BufRead, BufReader};
use std::os::unix::process::CommandExt;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::sync::mpsc;
use std::time::Duration;

/// How long the server may take to start.
const PATIENCE: Duration = Duration::from_secs(30);

/// A running Xvfb; dropping it ends it.
pub struct Server {
    child: Child,
    display: String,
}

impl Server {
    /// Starts Xvfb with one screen of `size` pixels; what it has to say goes to a file in `folder`.
    pub fn start(size: (u32, u32), folder: &Path) -> Result<Self, Failure> {
        let words = folder.join("Xvfb.txt");
        let log =
            std::fs::File::create(&words).map_err(|error| Failure::new(format!("{}: {error}", words.display())))?;
        let mut command = Command::new("Xvfb");
        command
            .args(["-displayfd", "1", "-noreset", "-nolisten", "tcp", "-screen", "0"])
            .arg(format!("{}x{}x24", size.0, size.1))
            .stdin(Stdio::null())
            .stdout(Stdio::piped())
            .stderr(log)
            // Ctrl-C is for the program; the server has to outlive it.
            .process_group(0);
        let child = process::end_with_parent(&mut command).spawn();
        let mut child = child.map_err(|error| match error.kind() {
            std::io::ErrorKind::NotFound => Failure::new(
                "--headless needs Xvfb, which is not installed (Debian and Ubuntu: package xvfb; \
                 Fedora: xorg-x11-server-Xvfb; Arch: xorg-server-xvfb)",
            ),
            _ => Failure::new(format!("Xvfb cannot be started: {error}")),
        })?;
        let (sender, receiver) = mpsc::channel();
        if let Some(output) = child.stdout.take() {
            std::thread::spawn(move || {
                let mut line = String::new();
                // The receiver may have given up by then.
                let _ = sender.send(BufReader::new(output).read_line(&mut line).map(|_| line));
            });
        }
        let number = receiver.recv_timeout(PATIENCE).ok().and_then(Result::ok).unwrap_or_default();
        let server = Self { child, display: format!(":{}", number.trim()) };
        if number.trim().is_empty() {
            // Ended first, so that it has written all of its reasons.
            drop(server);
            let reason = std::fs::read_to_string(&words).unwrap_or_default();
            return Err(Failure::new(format!("Xvfb did not start:\n{}", reason.trim())));
        }
        Ok(server)
    }

    /// The variables that lead a program to this server, and not to the user's own display.
    pub fn environment(&self) -> Environment {
        vec![("DISPLAY", Some(self.display.clone().into())), ("WAYLAND_DISPLAY", None), ("XAUTHORITY", None)]
    }
}

impl Drop for Server {
    fn drop(&mut self) {
        // Asked and not killed, so that it removes its lock file; it may have ended by itself.
        let _ = process::terminate(&self.child);
        let _ = self.child.wait();
    }
}
