//! Options of the virtual clock, and its library.

use super::held::Held;
use super::{Environment, library};
use crate::failure::Failure;
use std::ffi::OsString;
use std::path::PathBuf;
use std::time::{SystemTime, UNIX_EPOCH};

/// Options of the virtual clock.
#[derive(clap::Args)]
#[group(skip)]
pub struct Options {
    /// Let the program's clocks go on by 1/FPS with each frame
    #[arg(long, value_name = "FPS", value_parser = rate)]
    pub clock: Option<Rate>,
    /// Seed of the program's random numbers with --clock [default: 0]
    #[arg(long, value_name = "N")]
    seed: Option<u64>,
    /// Start of the program's dates with --clock, or now [default: 2000-01-01T12:00:00]
    #[arg(long, value_name = "DATE", value_parser = start)]
    clock_start: Option<Start>,
    /// Hold the program's time after its first frame, for `cupola ctl step`
    #[arg(long, requires = "clock")]
    pub pause: bool,
    /// File by which `cupola serve` holds the program's time.
    #[arg(long, value_name = "FILE", hide = true)]
    clock_page: Option<PathBuf>,
}

/// A frame rate.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Rate {
    /// Number of frames.
    pub frames: u64,
    /// Seconds in which they are shown.
    pub seconds: u64,
}

/// Start of the program's time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Start {
    /// Time at which the program starts.
    Now,
    /// Seconds since 1970.
    At(u64),
}

impl Options {
    /// True if the program's dates start at the time of its start.
    pub fn starts_now(&self) -> bool {
        self.clock_start == Some(Start::Now)
    }

    /// Seed, and start of the dates in seconds since 1970; 0: the usual one.
    pub fn numbers(&self) -> (u64, u64) {
        let start = match self.clock_start {
            Some(Start::At(seconds)) => seconds,
            Some(Start::Now) | None => 0,
        };
        (self.seed.unwrap_or(0), start)
    }

    /// Sets the rate, and the numbers of [`Options::numbers`]. `None`: the program has its own clock.
    pub fn set(&mut self, rate: Option<Rate>, (seed, start): (u64, u64)) {
        self.clock = rate;
        self.seed = rate.map(|_| seed);
        self.clock_start = rate.filter(|_| start > 0).map(|_| Start::At(start));
    }

    /// Page by which other processes hold the program's time; `None` without a clock.
    pub fn held(&self) -> Result<Option<Held>, Failure> {
        let Some(rate) = self.clock else { return Ok(None) };
        match Held::new(self.clock_page.as_deref(), rate, self.pause) {
            Ok(held) => Ok(Some(held)),
            Err(error) if self.pause => Err(Failure::new(format!("--pause: the page of the clock: {error}"))),
            // Without it the time goes on as usual.
            Err(_) => Ok(None),
        }
    }

    /// Environment variables of the clock; empty without a clock.
    pub fn environment(&self) -> Result<Environment, Failure> {
        let Some(rate) = self.clock else {
            return match self.seed.is_some() || self.clock_start.is_some() {
                true => {
                    Err(Failure::usage("--seed and --clock-start are for --clock: give it too, for example --clock 60"))
                }
                false => Ok(Vec::new()),
            };
        };
        let mut preload: OsString = library::find_clock()?.into();
        if let Some(others) = std::env::var_os("LD_PRELOAD").filter(|others| !others.is_empty()) {
            preload.push(":");
            preload.push(others);
        }
        let mut environment: Environment = vec![
            ("LD_PRELOAD", Some(preload)),
            ("CUPOLA_CLOCK", Some(format!("{}/{}", rate.frames, rate.seconds).into())),
            ("CUPOLA_SEED", Some(self.seed.unwrap_or(0).to_string().into())),
        ];
        let start = match self.clock_start {
            None => return Ok(environment),
            Some(Start::At(seconds)) => u128::from(seconds) * 1_000_000_000,
            Some(Start::Now) => SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |since| since.as_nanos()),
        };
        environment.push(("CUPOLA_CLOCK_START", Some(start.to_string().into())));
        Ok(environment)
    }
}

/// Parses frames per second: `60`, `59.94` or `60000/1001`.
pub fn rate(text: &str) -> Result<Rate, String> {
    let number = |text: &str| text.parse::<u64>().ok().filter(|number| (1..=1_000_000_000).contains(number));
    let parsed = if let Some((frames, seconds)) = text.split_once('/') {
        number(frames).zip(number(seconds))
    } else if let Some((whole, digits)) = text.split_once('.') {
        let scale = u32::try_from(digits.len()).ok().filter(|length| *length <= 6).map(|length| 10_u64.pow(length));
        number(&format!("{whole}{digits}")).zip(scale)
    } else {
        number(text).map(|frames| (frames, 1))
    };
    let rate = parsed.map(|(frames, seconds)| Rate { frames, seconds });
    rate.filter(|rate| rate.frames <= rate.seconds.saturating_mul(10_000))
        .ok_or_else(|| "expected frames per second up to 10000, for example 60, 59.94 or 60000/1001".to_owned())
}

/// Parses a start: `now`, or a date with or without a time, in UTC.
fn start(text: &str) -> Result<Start, String> {
    if text == "now" {
        return Ok(Start::Now);
    }
    let expected = || "expected now, or a date from 1990 to 2100 in UTC, for example 2030-12-24T18:00:00".to_owned();
    let (date, time) = text.trim_end_matches('Z').split_once(['T', ' ']).unwrap_or((text, "0:0:0"));
    let numbers = |text: &str, separator: char| -> Option<Vec<u64>> {
        text.split(separator).map(|part| part.parse().ok()).collect()
    };
    let (date, time) = numbers(date, '-').zip(numbers(time, ':')).ok_or_else(expected)?;
    let ([year, month, day], [hour, minute, rest @ ..]) = (&date[..], &time[..]) else { return Err(expected()) };
    let second = rest.first().copied().unwrap_or(0);
    let is_leap = |year: u64| year.is_multiple_of(4) && (!year.is_multiple_of(100) || year.is_multiple_of(400));
    let february = if is_leap(*year) { 29 } else { 28 };
    let months = [31, february, 31, 30, 31, 30, 31, 31, 30, 31, 30, 31];
    let place = month.checked_sub(1).and_then(|place| usize::try_from(place).ok()).filter(|place| *place < 12);
    let Some(place) = place.filter(|place| (1..=months[*place]).contains(day)) else { return Err(expected()) };
    if !(1990..=2100).contains(year) || *hour > 23 || *minute > 59 || second > 59 || rest.len() > 1 {
        return Err(expected());
    }
    let days = (1970..*year).map(|year| if is_leap(year) { 366 } else { 365 }).sum::<u64>()
        + months[..place].iter().sum::<u64>()
        + day
        - 1;
    Ok(Start::At(((days * 24 + hour) * 60 + minute) * 60 + second))
}

#[cfg(test)]
mod tests {
    use super::{Rate, Start, rate, start};

    #[test]
    fn rates_are_exact() {
        assert_eq!(rate("60"), Ok(Rate { frames: 60, seconds: 1 }));
        assert_eq!(rate("59.94"), Ok(Rate { frames: 5994, seconds: 100 }));
        assert_eq!(rate("60000/1001"), Ok(Rate { frames: 60000, seconds: 1001 }));
        for wrong in ["", "0", "-1", "1e3", "60/0", "1.2345678", "20000", "60/"] {
            assert!(rate(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn starts_are_dates() {
        assert_eq!(start("now"), Ok(Start::Now));
        assert_eq!(start("2000-01-01T12:00:00"), Ok(Start::At(946_728_000)));
        assert_eq!(start("2024-02-29"), Ok(Start::At(1_709_164_800)));
        assert_eq!(start("2030-12-24 18:00Z"), Ok(Start::At(1_924_365_600)));
        for wrong in ["", "2023-02-29", "1970-01-01", "2030-13-01", "2030-01-01T24:00:00", "2030-01", "1-1-1"] {
            assert!(start(wrong).is_err(), "{wrong}");
        }
    }
}
