//! The player that shows pictures and films.

use crate::failure::Failure;

/// The player: one that draws with OpenGL, keeps the picture's shape, and takes files of all kinds.
pub const PLAYER: &str = "mpv";

/// Its options for a picture and nothing else. A driver without hardware is taken, too.
pub const OPTIONS: [&str; 7] =
    ["--no-config", "--vo=gpu", "--gpu-sw=yes", "--no-osc", "--osd-level=0", "--no-border", "--keepaspect-window=no"];

/// Why the player cannot be started.
pub fn cannot_start(error: &std::io::Error) -> Failure {
    match error.kind() {
        std::io::ErrorKind::NotFound => Failure::new(format!(
            "the player {PLAYER} is not installed (Debian: apt install {PLAYER}); any other player can be used with \
             cupola run --content KIND -- PLAYER FILE"
        )),
        _ => Failure::new(format!("{PLAYER} cannot be started: {error}")),
    }
}
