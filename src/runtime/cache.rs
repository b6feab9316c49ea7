//! The result cache of the process: `CUPOLA_CACHE`.

use crate::cache::{Cache, this_user};
use crate::system::{build_id, variable};
use std::ffi::OsString;
use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;

/// Result cache of this process. It is in the folder that `CUPOLA_CACHE` names, otherwise in the
/// user's cache folder. It is only in memory if `CUPOLA_CACHE` is `0`, if there is no such folder,
/// or if this build of Cupola has no build ID.
pub fn of_process() -> &'static Cache {
    static CACHE: OnceLock<Cache> = OnceLock::new();
    CACHE.get_or_init(|| {
        // Unit tests do not touch the user's folder.
        let asked = if cfg!(test) { Some("0".into()) } else { variable("CUPOLA_CACHE") };
        let folder = match asked.filter(|value| !value.is_empty()) {
            Some(value) if value == "0" => None,
            // The program may change its folder while it runs.
            Some(value) => std::path::absolute(value).ok(),
            None => user_folder().map(|folder| folder.join("results")).filter(|folder| is_own(folder)),
        };
        match (folder, build_id()) {
            (Some(folder), Some(build)) => Cache::in_folder(folder, &build),
            _ => Cache::in_memory(),
        }
    })
}

/// True if a folder, or the one in which it would be made, belongs to this user. With `sudo` the
/// environment may name another user's home.
fn is_own(folder: &Path) -> bool {
    let there = folder.ancestors().find_map(|folder| folder.metadata().ok());
    there.is_some_and(|folder| Some(folder.uid()) == this_user())
}

/// Folder for files of Cupola that can be made again; `None` if the environment names none.
pub fn user_folder() -> Option<PathBuf> {
    folder_of(variable("XDG_CACHE_HOME"), variable("HOME"))
}

fn folder_of(cache: Option<OsString>, home: Option<OsString>) -> Option<PathBuf> {
    // The specification of these variables declares relative paths invalid.
    let absolute = |path: &OsString| Path::new(path).is_absolute();
    let cache = cache.filter(absolute).map(PathBuf::from);
    let home = || home.filter(absolute).map(|home| PathBuf::from(home).join(".cache"));
    Some(cache.or_else(home)?.join("cupola"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_folder_is_where_the_environment_says() {
        let of = |cache: Option<&str>, home: Option<&str>| folder_of(cache.map(Into::into), home.map(Into::into));
        assert_eq!(of(Some("/c"), Some("/h")), Some("/c/cupola".into()));
        assert_eq!(of(Some("c"), Some("/h")), Some("/h/.cache/cupola".into()));
        assert_eq!(of(None, Some("/h")), Some("/h/.cache/cupola".into()));
        assert_eq!(of(Some(""), None), None);
        assert_eq!(of(None, Some("")), None);
    }

    #[test]
    fn a_folder_of_this_user_s_is_told() {
        let made = std::env::temp_dir().join(format!("cupola-own-{}", std::process::id()));
        std::fs::create_dir(&made).expect("made");
        assert!(is_own(&made) && is_own(&made.join("not/there")));
        std::fs::remove_dir(&made).expect("removed");
    }

    #[test]
    fn a_build_has_a_name() {
        let id = build_id().expect("the linker writes one");
        assert!(id.len() >= 8 && Some(id) == build_id());
    }
}
