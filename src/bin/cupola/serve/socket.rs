//! Unix socket of `cupola ctl`: a line of JSON for a request, and a line for its answer.

use super::control::{Command, Server};
use serde_json::{Value, json};
use std::io::{BufRead, BufReader, Read, Write};
use std::os::unix::fs::{DirBuilderExt, MetadataExt, PermissionsExt};
use std::os::unix::net::{UnixListener, UnixStream};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Duration;

/// Longest request, bytes.
const LONGEST: u64 = 64 << 10;
/// Time after which a connection that sends nothing is closed.
const PATIENCE: Duration = Duration::from_secs(60);

/// Folder of sockets, which only this user can open.
///
/// # Errors
/// The folder cannot be created, or belongs to another user.
pub fn folder() -> std::io::Result<PathBuf> {
    let user = std::fs::metadata("/proc/self")?.uid();
    let runtime = std::env::var_os("XDG_RUNTIME_DIR").map(PathBuf::from).filter(|folder| folder.is_dir());
    let folder = runtime.map_or_else(|| PathBuf::from(format!("/tmp/cupola-{user}")), |folder| folder.join("cupola"));
    match std::fs::DirBuilder::new().mode(0o700).create(&folder) {
        Err(error) if error.kind() != std::io::ErrorKind::AlreadyExists => return Err(error),
        _ => {}
    }
    // Does not follow a link.
    let found = std::fs::symlink_metadata(&folder)?;
    if !found.is_dir() || found.uid() != user || found.mode() & 0o077 != 0 {
        let why = format!("{} is not a folder that only this user can open", folder.display());
        return Err(std::io::Error::other(why));
    }
    Ok(folder)
}

/// A socket that is removed when this is dropped.
pub struct Socket(PathBuf);

impl Socket {
    /// Path of the socket.
    pub fn path(&self) -> &Path {
        &self.0
    }
}

impl Drop for Socket {
    fn drop(&mut self) {
        // Somebody may have removed it already.
        let _ = std::fs::remove_file(&self.0);
    }
}

/// Answers requests at the usual path, or beside it if another server answers there.
///
/// # Errors
/// Errors of the system.
pub fn serve(server: Arc<Server>) -> std::io::Result<Socket> {
    let folder = folder()?;
    let mut path = folder.join("serve.sock");
    if UnixStream::connect(&path).is_ok() {
        path = folder.join(format!("serve-{}.sock", std::process::id()));
    }
    if path.exists() {
        std::fs::remove_file(&path)?;
    }
    let listener = UnixListener::bind(&path)?;
    std::fs::set_permissions(&path, std::fs::Permissions::from_mode(0o600))?;
    std::thread::spawn(move || {
        for stream in listener.incoming().flatten() {
            let server = server.clone();
            // If no thread can be started, this connection is closed.
            let _ = std::thread::Builder::new().spawn(move || converse(stream, &server));
        }
    });
    Ok(Socket(path))
}

fn converse(stream: UnixStream, server: &Server) -> std::io::Result<()> {
    stream.set_read_timeout(Some(PATIENCE))?;
    let mut answers = stream.try_clone()?;
    let mut requests = BufReader::new(stream);
    loop {
        let mut line = String::new();
        if requests.by_ref().take(LONGEST).read_line(&mut line)? == 0 {
            return Ok(());
        }
        writeln!(answers, "{}", answer(&line, server))?;
    }
}

fn answer(line: &str, server: &Server) -> Value {
    let command = serde_json::from_str::<Command>(line).map_err(|error| format!("this is not a request: {error}"));
    match command.and_then(|command| server.run(command, true)) {
        Ok(value) => json!({ "ok": value }),
        Err(message) => json!({ "error": message }),
    }
}

/// True if a server answers at the usual path.
pub fn is_there() -> bool {
    folder().is_ok_and(|folder| UnixStream::connect(folder.join("serve.sock")).is_ok())
}

/// Sends one request to a server.
///
/// # Errors
/// No server answers, or the server refused the request.
pub fn ask(path: Option<&Path>, command: &Command) -> Result<Value, String> {
    let usual = || folder().map(|folder| folder.join("serve.sock")).map_err(|error| error.to_string());
    let path = path.map_or_else(usual, |path| Ok(path.to_owned()))?;
    let failed = |error: std::io::Error| {
        format!(
            "no cupola serve answers at {}: {error}; start it with cupola serve, and give the socket that it prints with --socket",
            path.display()
        )
    };
    let mut stream = UnixStream::connect(&path).map_err(failed)?;
    let request = serde_json::to_string(command).map_err(|error| error.to_string())?;
    writeln!(stream, "{request}").map_err(failed)?;
    let mut line = String::new();
    BufReader::new(stream).read_line(&mut line).map_err(failed)?;
    let mut answer: Value =
        serde_json::from_str(&line).map_err(|error| format!("the answer is not understood: {error}"))?;
    match answer.get("error").and_then(Value::as_str) {
        Some(message) => Err(message.to_owned()),
        None => Ok(answer["ok"].take()),
    }
}
