//! A private X server.

use crate::failure::Failure;
use cupola::system::process;
use std::ffi::OsString;
use std::io::{BufRead, BufReader};
use std::os::unix::process::CommandExt;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::sync::mpsc;
use std::time::Duration;

/// Time limit for the start of the server.
const PATIENCE: Duration = Duration::from_secs(30);

/// A running Xvfb. It ends when this is dropped.
pub struct Server {
    child: Child,
    display: String,
}

impl Server {
    /// Starts Xvfb with one screen of `size` pixels. Its messages go to a file in `folder`.
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
            // Ctrl-C must reach the program but not the server, which has to outlive the program.
            .process_group(0);
        let child = process::end_with_parent(&mut command).spawn();
        let mut child = child.map_err(|error| match error.kind() {
            std::io::ErrorKind::NotFound => Failure::new(
                "a private X server needs Xvfb, which is not installed (Debian and Ubuntu: package xvfb; \
                 Fedora: xorg-x11-server-Xvfb; Arch: xorg-server-xvfb)",
            ),
            _ => Failure::new(format!("Xvfb cannot be started: {error}")),
        })?;
        let (sender, receiver) = mpsc::channel();
        if let Some(output) = child.stdout.take() {
            std::thread::spawn(move || {
                let mut line = String::new();
                // The receiver may have timed out.
                let _ = sender.send(BufReader::new(output).read_line(&mut line).map(|_| line));
            });
        }
        let number = receiver.recv_timeout(PATIENCE).ok().and_then(Result::ok).unwrap_or_default();
        let server = Self { child, display: format!(":{}", number.trim()) };
        if number.trim().is_empty() {
            // The server ends first, so that it has written all of its messages.
            drop(server);
            let reason = std::fs::read_to_string(&words).unwrap_or_default();
            return Err(Failure::new(format!("Xvfb did not start:\n{}", reason.trim())));
        }
        Ok(server)
    }

    /// Environment variables that make a program use this server instead of the user's display.
    pub fn environment(&self) -> Vec<(&'static str, Option<OsString>)> {
        vec![("DISPLAY", Some(self.display.clone().into())), ("WAYLAND_DISPLAY", None), ("XAUTHORITY", None)]
    }
}

impl Drop for Server {
    fn drop(&mut self) {
        // SIGTERM lets the server remove its lock file. It may have ended by itself.
        let _ = process::terminate(&self.child);
        let _ = self.child.wait();
    }
}
