//! The player that shows pictures and films.

use crate::failure::Failure;

/// Name of the player: it draws with OpenGL, keeps the picture's shape, and reads files of all
/// kinds.
pub const PLAYER: &str = "mpv";

/// Options of the player for a picture and nothing else. A software driver is accepted too.
pub const OPTIONS: [&str; 7] =
    ["--no-config", "--vo=gpu", "--gpu-sw=yes", "--no-osc", "--osd-level=0", "--no-border", "--keepaspect-window=no"];

/// Explains why the player cannot be started.
pub fn cannot_start(error: &std::io::Error) -> Failure {
    match error.kind() {
        std::io::ErrorKind::NotFound => Failure::new(format!(
            "the player {PLAYER} is not installed (Debian: apt install {PLAYER}); any other player can be used with \
             cupola run --content KIND -- PLAYER FILE"
        )),
        _ => Failure::new(format!("{PLAYER} cannot be started: {error}")),
    }
}
