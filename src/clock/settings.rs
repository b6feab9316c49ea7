//! Settings from the environment.

use std::sync::OnceLock;

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
