//! Files that are written where others may have put something, files in memory, and free space.

use std::ffi::{CStr, CString};
use std::fs::{File, OpenOptions};
use std::io;
use std::os::fd::FromRawFd;
use std::os::unix::ffi::OsStrExt;
use std::os::unix::fs::OpenOptionsExt;
use std::path::Path;

/// Opens a file for writing and empties it, or creates it. A link is not followed: otherwise
/// anybody with the right to write to the folder could choose which file is overwritten.
///
/// # Errors
/// Errors of the system, and links; but `/dev/stdout` and similar links are followed.
pub fn create(path: &Path) -> io::Result<File> {
    let mut options = OpenOptions::new();
    options.write(true).create(true).truncate(true);
    if path.starts_with("/dev") {
        return options.open(path);
    }
    options.custom_flags(libc::O_NOFOLLOW).open(path).map_err(|error| match error.raw_os_error() {
        Some(libc::ELOOP) => io::Error::other("it is a link; expected a file, or no file yet"),
        _ => error,
    })
}

/// Makes a file of `bytes` zeroes in memory, without a place in any folder. `name` is shown in lists
/// of open files.
///
/// # Errors
/// Those of the system.
pub fn anonymous_file(name: &CStr, bytes: u64) -> io::Result<File> {
    // SAFETY: a NUL-terminated name that lives during the call.
    let descriptor = unsafe { libc::memfd_create(name.as_ptr(), libc::MFD_CLOEXEC) };
    if descriptor < 0 {
        return Err(io::Error::last_os_error());
    }
    // SAFETY: a new descriptor, which nothing else has.
    let file = unsafe { File::from_raw_fd(descriptor) };
    file.set_len(bytes)?;
    Ok(file)
}

/// Number of bytes that this user can still write on the file system of a folder.
///
/// # Errors
/// Those of the system.
pub fn free_bytes(folder: &Path) -> io::Result<u64> {
    let name = CString::new(folder.as_os_str().as_bytes())?;
    // SAFETY: all zeroes is a valid value of this structure of numbers.
    let mut answer: libc::statvfs = unsafe { std::mem::zeroed() };
    // SAFETY: a NUL-terminated name and a structure that both live during the call.
    match unsafe { libc::statvfs(name.as_ptr(), &mut answer) } {
        0 => Ok(answer.f_bavail * answer.f_frsize),
        _ => Err(io::Error::last_os_error()),
    }
}

#[cfg(test)]
mod tests {
    use super::create;
    use std::io::Write;

    #[test]
    fn links_are_not_followed() {
        let folder = std::env::temp_dir().join(format!("cupola-file-{}", std::process::id()));
        std::fs::create_dir_all(&folder).expect("a folder");
        let (victim, link, dangling) = (folder.join("victim"), folder.join("link"), folder.join("dangling"));
        std::fs::write(&victim, "kept").expect("written");
        std::os::unix::fs::symlink(&victim, &link).expect("a link");
        std::os::unix::fs::symlink(folder.join("made"), &dangling).expect("a link");
        for path in [&link, &dangling] {
            assert!(create(path).expect_err("a link").to_string().contains("is a link"));
        }
        assert!(!folder.join("made").exists());
        assert_eq!(std::fs::read(&victim).expect("a file"), b"kept");
        create(&victim).and_then(|mut file| file.write_all(b"new")).expect("written");
        assert_eq!(std::fs::read(&victim).expect("a file"), b"new");
        std::fs::remove_dir_all(&folder).expect("removed");
        create("/dev/null".as_ref()).expect("a device");
    }
}
