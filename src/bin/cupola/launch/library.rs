//! Location of `libcupola.so`, and a test whether it can be loaded.

use crate::failure::Failure;
use cupola::ABI_VERSION;
use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// Finds `libcupola.so`, or the name that packages without development files use: the path in
/// `CUPOLA_LIBRARY`, the folder of this command, or one of the library folders beside it.
pub fn find() -> Result<PathBuf, Failure> {
    if let Some(path) = std::env::var_os("CUPOLA_LIBRARY") {
        let path = PathBuf::from(path);
        return match path.canonicalize() {
            Ok(path) => Ok(path),
            Err(error) => Err(Failure::new(format!("CUPOLA_LIBRARY={}: {error}", path.display()))),
        };
    }
    let command = std::env::current_exe()
        .map_err(|error| Failure::new(format!("the path of this command is unknown: {error}")))?;
    let folder = command.parent().unwrap_or(Path::new("/"));
    let places = places(folder);
    places.iter().find_map(|place| place.canonicalize().ok()).ok_or_else(|| {
        let listed = places.iter().map(|place| format!("  {}", place.display())).collect::<Vec<_>>().join("\n");
        Failure::new(format!(
            "libcupola.so was not found. These paths were tried:\n{listed}\n\
             `cargo install` installs only the command: run `make && sudo make install` in the folder with Cupola's \
             sources, or set CUPOLA_LIBRARY to the path of a libcupola.so that `cargo build --release` has made there"
        ))
    })
}

/// Finds `libcupola_clock.so`: beside `libcupola.so`, or in the parent of the folder in which cargo
/// links tests.
pub fn find_clock() -> Result<PathBuf, Failure> {
    let library = find()?;
    let folder = library.parent().unwrap_or(Path::new("/"));
    let places = ["", ".."].map(|below| folder.join(below).join("libcupola_clock.so"));
    places.iter().find_map(|place| place.canonicalize().ok()).ok_or_else(|| {
        Failure::new(format!(
            "libcupola_clock.so, which --clock needs, was not found in {}; it is installed with libcupola.so, and built \
             by cargo build --package cupola_clock",
            folder.display()
        ))
    })
}

/// Possible paths of the library for a command in `folder`: beside it, as cargo places both, or in
/// the library folders of the prefix, as in distributions.
fn places(folder: &Path) -> Vec<PathBuf> {
    let of_debian = format!("lib/{}-linux-gnu", std::env::consts::ARCH);
    let of_prefix = ["lib", &of_debian, "lib64"].map(|lib| folder.join("..").join(lib));
    let folders = std::iter::once(folder.to_owned())
        .chain(of_prefix.iter().flat_map(|folder| [folder.clone(), folder.join("cupola")]));
    let names = ["libcupola.so".to_owned(), format!("libcupola.so.{ABI_VERSION}")];
    folders.flat_map(|folder| names.clone().map(|name| folder.join(name))).collect()
}

/// True if a file contains `bytes`. Stops reading as early as possible: the string table is near
/// the start of a library, which has 40 MB without optimisation.
fn contains(path: &Path, bytes: &[u8]) -> std::io::Result<bool> {
    let mut file = File::open(path)?;
    let (mut found, mut chunk) = (Vec::new(), vec![0; 1 << 16]);
    loop {
        let length = file.read(&mut chunk)?;
        if length == 0 {
            return Ok(false);
        }
        found.extend_from_slice(&chunk[..length]);
        if found.windows(bytes.len()).any(|window| window == bytes) {
            return Ok(true);
        }
        // The rest may be the beginning of `bytes`.
        found.drain(..found.len().saturating_sub(bytes.len() - 1));
    }
}

/// The reason why the dynamic linker or libglvnd would refuse `library` as a vendor with the entry
/// point `entry`; `None` if they would accept it.
pub fn refusal(library: &Path, entry: &str) -> Option<String> {
    // The string table of the file contains exported names, each between two zero bytes.
    match contains(library, format!("\0{entry}\0").as_bytes()) {
        Ok(true) => {}
        Ok(false) => return Some(format!("it does not export {entry}")),
        Err(error) => return Some(error.to_string()),
    }
    // The test runs in another process, since a broken library can crash the process that loads it.
    // The dynamic linker binds all symbols of a preloaded library. If it fails, it prints a message
    // and continues.
    let Ok(command) = std::env::current_exe() else { return None };
    let trial = Command::new(command)
        .arg("--version")
        .env("LD_PRELOAD", library)
        .env("LD_BIND_NOW", "1")
        .stdin(Stdio::null())
        .output();
    match trial {
        Ok(output) if output.status.success() && !String::from_utf8_lossy(&output.stderr).contains("LD_PRELOAD") => {
            None
        }
        Ok(output) => {
            let words = String::from_utf8_lossy(&output.stderr).trim().to_owned();
            Some(if words.is_empty() { format!("loading it ended with {}", output.status) } else { words })
        }
        Err(error) => Some(error.to_string()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn libraries_of_distributions_are_found() {
        let places = places(Path::new("/usr/bin"));
        assert_eq!(places[0], Path::new("/usr/bin/libcupola.so"));
        let debian = format!("/usr/bin/../lib/{}-linux-gnu/libcupola.so", std::env::consts::ARCH);
        for expected in [debian.as_str(), "/usr/bin/../lib64/libcupola.so.1", "/usr/bin/../lib/cupola/libcupola.so"] {
            assert!(places.iter().any(|place| place == Path::new(expected)), "{expected} in {places:?}");
        }
    }

    #[test]
    fn bytes_are_found_wherever_they_are() {
        let path = std::env::temp_dir().join(format!("cupola-contains-{}", std::process::id()));
        for at in [0, (1 << 16) - 3, 1 << 16, 200_000 - 6] {
            let mut content = vec![b'x'; 200_000];
            content[at..at + 6].copy_from_slice(b"\0name\0");
            std::fs::write(&path, content).expect("a file can be written");
            assert!(contains(&path, b"\0name\0").expect("a file"), "{at}");
            assert!(!contains(&path, b"\0names\0").expect("a file"), "{at}");
        }
        std::fs::remove_file(&path).expect("removed");
        assert!(contains(&path, b"x").is_err());
    }
}
