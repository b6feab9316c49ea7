//! `cupola play`: shows already projected pictures and films, with a player.

pub mod player;

use crate::failure::Failure;
use crate::launch::loader::Scratch;
use crate::play::player::PLAYER;
use crate::run::{self, Options};
use std::ffi::OsString;
use std::os::unix::ffi::{OsStrExt, OsStringExt};
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};

/// Relative tolerance of the aspect (width divided by height) of a picture.
const SHAPE: f64 = 0.02;

/// Play a picture, a folder of pictures or a film that is already projected: a domemaster, an
/// equirectangular picture, the faces of a cube, or a flat one.
#[derive(clap::Args)]
#[command(after_help = "\
Without --content, and if the rig has no [content], the shape of the picture decides: 1:1 is a domemaster, 2:1 an
equirectangular picture, 6:1 the faces of a cube, everything else flat. The player is mpv; arguments after `--` are
passed to it, as in `cupola play FILM -- --start=9`. Any other player can be used with `cupola run --content KIND --
PLAYER FILE`.")]
pub struct Arguments {
    #[command(flatten)]
    options: Options,
    /// Pictures of a folder per second
    #[arg(long, value_name = "N", default_value_t = 30.0)]
    fps: f64,
    /// End after the last picture instead of beginning again
    #[arg(long)]
    once: bool,
    /// Picture, folder or film
    #[arg(value_name = "FILE|FOLDER")]
    file: PathBuf,
    /// More arguments of the player, after `--`
    #[arg(trailing_var_arg = true, allow_hyphen_values = true, value_name = "PLAYER ARGUMENT")]
    player: Vec<OsString>,
}

/// Runs the subcommand. Returns the exit code of the player.
pub fn run(arguments: Arguments) -> Result<ExitCode, Failure> {
    let Arguments { mut options, fps, once, file, player: more } = arguments;
    if !(fps.is_finite() && fps > 0.0) {
        return Err(Failure::usage(format!("--fps {fps}: expected a number above 0")));
    }
    let scratch = Scratch::new()?;
    let mut source = Source::of(&file, fps, scratch.path())?;
    if options.content.is_none() && options.rig()?.content.is_none() {
        let (width, height) = source.size()?;
        let kind = kind_of(f64::from(width) / f64::from(height));
        eprintln!(
            "cupola: {} has {width} × {height} pixels and is shown as {kind}; --content changes that",
            file.display()
        );
        options.content = Some(kind.to_owned());
    }
    let mut program: Vec<OsString> = std::iter::once(PLAYER).chain(player::OPTIONS).map(OsString::from).collect();
    program.push(if once { "--image-display-duration=5" } else { "--image-display-duration=inf" }.into());
    program.push(if once { "--loop-playlist=no" } else { "--loop-playlist=inf" }.into());
    match options.size.or(if options.headless { options.rig()?.extent() } else { None }) {
        Some((width, height)) => program.push(format!("--geometry={width}x{height}").into()),
        None => program.push("--fullscreen".into()),
    }
    program.extend(more);
    program.append(&mut source.arguments);
    run::start(options, &program, None)
}

/// Word for content of this aspect.
fn kind_of(aspect: f64) -> &'static str {
    let is = |shape: f64| (aspect / shape - 1.0).abs() < SHAPE;
    match aspect {
        _ if is(1.0) => "domemaster",
        _ if is(2.0) => "equirectangular",
        _ if is(6.0) => "cubemap",
        _ => "flat",
    }
}

/// Files for the player.
struct Source {
    /// Arguments for the player.
    arguments: Vec<OsString>,
}

impl Source {
    fn of(file: &Path, fps: f64, scratch: &Path) -> Result<Self, Failure> {
        let unreadable = |error: std::io::Error| Failure::usage(format!("{}: {error}", file.display()));
        let file = std::path::absolute(file).map_err(unreadable)?;
        if !std::fs::metadata(&file).map_err(unreadable)?.is_dir() {
            return Ok(Self { arguments: vec!["--".into(), file.into()] });
        }
        let entries = std::fs::read_dir(&file).map_err(unreadable)?;
        let mut pictures: Vec<PathBuf> =
            entries.flatten().map(|entry| entry.path()).filter(|p| is_picture(p)).collect();
        pictures.sort();
        if pictures.is_empty() {
            return Err(Failure::usage(format!(
                "{}: the folder has no pictures (PNG, JPEG, TIFF, EXR)",
                file.display()
            )));
        }
        // The names are in a list, because they may contain characters that are patterns for the
        // player.
        let list = scratch.join("pictures.txt");
        let lines = pictures.iter().flat_map(|picture| [picture.as_os_str().as_bytes(), b"\n"].concat());
        std::fs::write(&list, lines.collect::<Vec<u8>>()).map_err(unreadable)?;
        let address = OsString::from_vec([b"mf://@", list.as_os_str().as_bytes()].concat());
        Ok(Self { arguments: vec![format!("--mf-fps={fps}").into(), "--".into(), address] })
    }

    /// Width and height in pixels, as the player finds them.
    fn size(&self) -> Result<(u32, u32), Failure> {
        let asked = ["--no-config", "--vo=null", "--ao=null", "--frames=1", "--msg-level=all=error,term-msg=info"];
        let output = Command::new(PLAYER)
            .args(asked)
            .arg("--term-playing-msg=cupola ${width} ${height}")
            .args(&self.arguments)
            .output()
            .map_err(|error| player::cannot_start(&error))?;
        let words = String::from_utf8_lossy(&output.stdout);
        let size = words.lines().find_map(|line| {
            let (width, height) = line.trim().strip_prefix("cupola ")?.split_once(' ')?;
            Some((width.parse().ok()?, height.parse().ok()?))
        });
        size.filter(|(width, height)| *width > 0 && *height > 0)
            .ok_or_else(|| Failure::usage(format!("{PLAYER} finds no picture in it: {}", words.trim())))
    }
}

/// True if a file has the extension of a picture.
fn is_picture(file: &Path) -> bool {
    let extension = file.extension().map(|extension| extension.to_string_lossy().to_ascii_lowercase());
    extension.is_some_and(|e| ["png", "jpg", "jpeg", "tif", "tiff", "exr", "tga", "bmp", "webp"].contains(&e.as_str()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shapes_are_kinds() {
        for (width, height, kind) in [
            (4096.0, 4096.0, "domemaster"),
            (4096.0, 4112.0, "domemaster"),
            (7680.0, 3840.0, "equirectangular"),
            (6144.0, 1024.0, "cubemap"),
            (1920.0, 1080.0, "flat"),
            (1080.0, 1920.0, "flat"),
        ] {
            assert_eq!(kind_of(width / height), kind);
        }
    }

    #[test]
    fn pictures_of_a_folder_are_sorted_and_others_left_out() {
        let scratch = Scratch::new().expect("a folder");
        let empty = Source::of(scratch.path(), 25.0, scratch.path()).map(|_| ()).expect_err("no pictures");
        assert!(format!("{empty:?}").contains("no pictures"), "{empty:?}");
        for name in ["b,1.png", "a%2.JPG", "notes.txt"] {
            std::fs::write(scratch.path().join(name), "").expect("a file");
        }
        let source = Source::of(scratch.path(), 25.0, scratch.path()).expect("pictures");
        assert_eq!(source.arguments[0], "--mf-fps=25");
        let list = std::fs::read_to_string(scratch.path().join("pictures.txt")).expect("a list");
        let names: Vec<_> = list.lines().map(|line| line.rsplit('/').next().unwrap_or_default()).collect();
        assert_eq!(names, ["a%2.JPG", "b,1.png"]);
    }
}
