//! Settings from the environment.

use super::page::{Page, WORDS};
use std::os::fd::AsRawFd;
use std::sync::OnceLock;
use std::sync::atomic::AtomicU64;

/// The clock of this process.
pub struct Settings {
    /// Frames and the number of seconds that they last: `CUPOLA_CLOCK=FRAMES/SECONDS`.
    pub rate: (u64, u64),
    /// Start of the program's time, in nanoseconds since 1970: `CUPOLA_CLOCK_START`.
    pub start: u64,
    /// Seed of random numbers: `CUPOLA_SEED`.
    pub seed: u64,
}

/// Start if the environment names none: noon of 2000-01-01 UTC.
const START: u64 = 946_728_000_000_000_000;

/// Settings of this process; `None` without a virtual clock.
pub fn settings() -> Option<&'static Settings> {
    static SETTINGS: OnceLock<Option<Settings>> = OnceLock::new();
    SETTINGS
        .get_or_init(|| {
            let text = |name: &str| std::env::var(name).ok();
            let rate = text("CUPOLA_CLOCK")?;
            let (frames, seconds) = rate.split_once('/')?;
            let rate: (u64, u64) = (frames.parse().ok()?, seconds.parse().ok()?);
            let number = |name: &str| text(name)?.parse().ok();
            (rate.0 > 0 && rate.1 > 0).then(|| Settings {
                rate,
                start: number("CUPOLA_CLOCK_START").unwrap_or(START),
                seed: number("CUPOLA_SEED").unwrap_or(0),
            })
        })
        .as_ref()
}

/// Page by which another process holds the time of this one: `CUPOLA_CLOCK_PAGE`, a file.
pub fn page() -> Option<Page<'static>> {
    static PAGE: OnceLock<Option<Page<'static>>> = OnceLock::new();
    *PAGE.get_or_init(|| {
        let path = std::env::var_os("CUPOLA_CLOCK_PAGE")?;
        let file = std::fs::OpenOptions::new().read(true).write(true).open(path).ok()?;
        let bytes = WORDS * size_of::<u64>();
        if file.metadata().ok()?.len() < bytes as u64 {
            return None;
        }
        let (access, file) = (libc::PROT_READ | libc::PROT_WRITE, file.as_raw_fd());
        // SAFETY: maps new pages of an open file, which is long enough; nothing else lies there.
        let address = unsafe { libc::mmap(std::ptr::null_mut(), bytes, access, libc::MAP_SHARED, file, 0) };
        if address == libc::MAP_FAILED {
            return None;
        }
        // SAFETY: so many words are mapped, and stay so for as long as the process lives.
        Page::new(unsafe { std::slice::from_raw_parts(address.cast::<AtomicU64>(), WORDS) })
    })
}
