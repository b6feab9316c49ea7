//! Keyboard and mouse events: lines of text, and the frames in which they reach the programs.
//!
//! Node 0 reads the lines (`--input`). It decides at the end of which frame each event reaches the
//! programs of all nodes.

pub mod keys;
pub mod screen;

use crate::failure::Failure;
use std::collections::VecDeque;
use std::fs::OpenOptions;
use std::io::{BufRead, BufReader, Read};
use std::os::unix::fs::FileTypeExt;
use std::path::Path;

/// Event of keyboard or mouse.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Event {
    /// The key with this symbol of X.
    Key { symbol: u32, is_down: bool },
    /// A button of the mouse, from 1.
    Button { number: u8, is_down: bool },
    /// Position of the pointer, in parts of the window's width and height from its top left corner.
    Place { x: f64, y: f64 },
    /// Movement of the mouse in pixels.
    Shift { x: i32, y: i32 },
}

impl Event {
    /// Returns the event as numbers of a message.
    pub fn words(&self) -> [u64; 3] {
        match *self {
            Self::Key { symbol, is_down } => [1, symbol.into(), is_down.into()],
            Self::Button { number, is_down } => [2, number.into(), is_down.into()],
            Self::Place { x, y } => [3, x.to_bits(), y.to_bits()],
            Self::Shift { x, y } => [4, i64::from(x) as u64, i64::from(y) as u64],
        }
    }

    /// Reads the numbers of a message; `None` for those of another release.
    pub fn of([kind, first, second]: [u64; 3]) -> Option<Self> {
        Some(match kind {
            1 => Self::Key { symbol: first as u32, is_down: second != 0 },
            2 => Self::Button { number: first as u8, is_down: second != 0 },
            3 => Self::Place { x: f64::from_bits(first), y: f64::from_bits(second) },
            4 => Self::Shift { x: first as i32, y: second as i32 },
            _ => return None,
        })
    }

    /// Joins the next event with this one, if that makes no difference to programs.
    fn join(&mut self, next: &Self) -> bool {
        match (self, next) {
            (Self::Place { x, y }, Self::Place { x: next_x, y: next_y }) => (*x, *y) = (*next_x, *next_y),
            (Self::Shift { x, y }, Self::Shift { x: more_x, y: more_y }) => {
                (*x, *y) = (x.saturating_add(*more_x), y.saturating_add(*more_y));
            }
            _ => return false,
        }
        true
    }

    /// Returns the release of the key or the button.
    pub fn released(&self) -> Self {
        match *self {
            Self::Key { symbol, .. } => Self::Key { symbol, is_down: false },
            Self::Button { number, .. } => Self::Button { number, is_down: false },
            other => other,
        }
    }
}

/// Writes the line of the event.
impl std::fmt::Display for Event {
    fn fmt(&self, to: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let way = |is_down: bool| if is_down { "down" } else { "up" };
        match *self {
            Self::Key { symbol, is_down } => write!(to, "key {} {}", keys::name(symbol), way(is_down)),
            Self::Button { number, is_down } => write!(to, "button {number} {}", way(is_down)),
            Self::Place { x, y } => write!(to, "move {x:.5} {y:.5}"),
            Self::Shift { x, y } => write!(to, "shift {x} {y}"),
        }
    }
}

/// A line of input.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Line {
    /// Number of the earliest frame at whose end the event reaches the programs.
    frame: u64,
    event: Event,
    /// The key or the button is released at the end of the next frame.
    is_short: bool,
}

impl Line {
    /// Reads a line; `None` for an empty line and a comment.
    ///
    /// # Errors
    /// A message with what was expected.
    pub fn parse(text: &str) -> Result<Option<Self>, String> {
        let text = text.trim();
        if text.is_empty() || text.starts_with('#') {
            return Ok(None);
        }
        let (frame, rest) = match text.split_once(':') {
            Some((number, rest)) if !number.is_empty() && number.bytes().all(|byte| byte.is_ascii_digit()) => {
                let frame = number.parse().map_err(|_| format!("{number}: the number of the frame is too large"))?;
                (frame, rest)
            }
            _ => (0, text),
        };
        let words: Vec<&str> = rest.split_whitespace().collect();
        let usual = "expected key NAME [down|up], button NUMBER [down|up], move X Y or shift X Y";
        let (is_down, is_short) = match words.get(2) {
            None => (true, true),
            Some(&"down") => (true, false),
            Some(&"up") => (false, false),
            Some(_) if matches!(words[0], "key" | "button") => return Err(usual.to_owned()),
            Some(_) => (false, false),
        };
        let part = |text: &str| {
            let part = text.parse().ok().filter(|part| (0.0..=1.0).contains(part));
            part.ok_or_else(|| format!("{text}: expected a part of the window's width or height, 0 to 1"))
        };
        let pixels = |text: &str| {
            let pixels = text.parse().ok().filter(|pixels: &i32| pixels.abs() <= 0x7fff);
            pixels.ok_or_else(|| format!("{text}: expected a whole number of pixels"))
        };
        let event = match words[..] {
            ["key", name] | ["key", name, _] => {
                let symbol = keys::symbol(name).ok_or_else(|| {
                    format!("{name}: there is no such key; expected a sign, a name such as Left or F1, or 0x…")
                })?;
                Event::Key { symbol, is_down }
            }
            ["button", number] | ["button", number, _] => {
                let number = number.parse().ok().filter(|number| (1..=32).contains(number));
                Event::Button { number: number.ok_or("expected the number of a button, 1 to 32")?, is_down }
            }
            ["move", x, y] => Event::Place { x: part(x)?, y: part(y)? },
            ["shift", x, y] => Event::Shift { x: pixels(x)?, y: pixels(y)? },
            _ => return Err(usual.to_owned()),
        };
        let is_short = is_short && matches!(event, Event::Key { .. } | Event::Button { .. });
        Ok(Some(Self { frame, event, is_short }))
    }
}

/// Most events at the end of one frame. The rest waits for the next one.
const MOST: usize = 256;
/// Number of lines that wait, at most. A source that is faster waits.
const MOST_LINES: usize = 4096;

/// Lines that no frame has taken yet.
#[derive(Default)]
pub struct Queue {
    lines: VecDeque<Line>,
    /// Releases at the end of the next frame.
    short: Vec<Event>,
}

impl Queue {
    /// Adds a line. Lines reach the programs in their order.
    pub fn add(&mut self, line: Line) {
        self.lines.push_back(line);
    }

    /// True if no line should be added before some are taken.
    pub fn is_full(&self) -> bool {
        self.lines.len() >= MOST_LINES
    }

    /// Takes the events that reach the programs at the end of this frame.
    pub fn take(&mut self, frame: u64) -> Vec<Event> {
        let mut taken = std::mem::take(&mut self.short);
        while let Some(line) = self.lines.front().filter(|line| line.frame <= frame && taken.len() < MOST) {
            let Line { event, is_short, .. } = *line;
            if self.short.contains(&event.released()) {
                // A program has to see that the key was up in between.
                break;
            }
            self.lines.pop_front();
            if is_short {
                self.short.push(event.released());
            }
            if !taken.last_mut().is_some_and(|last| last.join(&event)) {
                taken.push(event);
            }
        }
        taken
    }
}

/// Opens a source of lines: a file, a named pipe, or `-` for the standard input.
///
/// # Errors
/// It cannot be read.
pub fn open(source: &Path) -> Result<Box<dyn Read + Send>, Failure> {
    if is_standard(source) {
        return Ok(Box::new(std::io::stdin()));
    }
    let failed = |error: std::io::Error| Failure::usage(format!("--input {}: {error}", source.display()));
    let is_pipe = std::fs::metadata(source).map_err(failed)?.file_type().is_fifo();
    // With a writer of its own a pipe does not end when the one who has written a line closes it.
    Ok(Box::new(OpenOptions::new().read(true).write(is_pipe).open(source).map_err(failed)?))
}

/// True if the source of lines is the standard input.
pub fn is_standard(source: &Path) -> bool {
    source.as_os_str() == "-"
}

/// Longest line, bytes.
const LONGEST: u64 = 1000;

/// Reads lines until they end. Those that are not understood go to `say`.
pub fn read(source: impl Read, mut add: impl FnMut(Line), say: impl Fn(&str)) {
    let mut source = BufReader::new(source);
    let mut bytes = Vec::new();
    // The rest of a line that was too long is skipped.
    let mut is_rest = false;
    loop {
        bytes.clear();
        match source.by_ref().take(LONGEST).read_until(b'\n', &mut bytes) {
            Ok(0) => return,
            Ok(_) => {}
            Err(error) => return say(&format!("keyboard and mouse cannot be read any more: {error}")),
        }
        let is_part = bytes.len() as u64 == LONGEST && !bytes.ends_with(b"\n");
        if std::mem::replace(&mut is_rest, is_part) {
            continue;
        }
        if is_part {
            say(&format!("a line of input is left out: it has more than {LONGEST} bytes"));
            continue;
        }
        let text = String::from_utf8_lossy(&bytes);
        match Line::parse(&text) {
            Ok(Some(line)) => add(line),
            Ok(None) => {}
            Err(message) => say(&format!("a line of input is left out: {}: {message}", text.trim())),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn line(text: &str) -> Line {
        Line::parse(text).expect("is understood").expect("says something")
    }

    const LEFT: Event = Event::Key { symbol: 0xff51, is_down: true };

    #[test]
    fn lines_are_read() {
        assert_eq!(line("key Left"), Line { frame: 0, event: LEFT, is_short: true });
        assert_eq!(line(" 120: key Left down\n"), Line { frame: 120, event: LEFT, is_short: false });
        let colon = Event::Key { symbol: 0x3a, is_down: false };
        assert_eq!(line("7: key : up"), Line { frame: 7, event: colon, is_short: false });
        assert_eq!(line("button 3 up").event, Event::Button { number: 3, is_down: false });
        assert_eq!(line("move 0.25 1"), Line { frame: 0, event: Event::Place { x: 0.25, y: 1.0 }, is_short: false });
        assert_eq!(line("shift -3 4").event, Event::Shift { x: -3, y: 4 });
        assert_eq!([Line::parse(""), Line::parse("  # key Left")], [Ok(None), Ok(None)]);
        for (wrong, expected) in [
            ("key", "expected key NAME"),
            ("key Lefft", "no such key"),
            ("key Left sideways", "expected key NAME"),
            ("button 0", "expected the number of a button"),
            ("move 0.5", "expected key NAME"),
            ("move 0.5 1.5", "1.5: expected a part"),
            ("move NaN 0", "NaN: expected a part"),
            ("shift 1e9 0", "whole number"),
            ("x: key Left", "expected key NAME"),
            ("99999999999999999999: key Left", "too large"),
        ] {
            let message = Line::parse(wrong).expect_err(wrong);
            assert!(message.contains(expected), "{wrong}: {message}");
        }
    }

    #[test]
    fn lines_and_messages_say_the_same() {
        let events = [
            LEFT,
            LEFT.released(),
            Event::Button { number: 32, is_down: true },
            Event::Place { x: 0.5, y: 0.0 },
            Event::Shift { x: -32767, y: 7 },
        ];
        for event in events {
            assert_eq!(line(&event.to_string()), Line { frame: 0, event, is_short: false });
            assert_eq!(Event::of(event.words()), Some(event));
        }
        assert_eq!(Event::of([0, 1, 1]), None);
    }

    #[test]
    fn events_wait_for_their_frame_and_keep_their_order() {
        let mut queue = Queue::default();
        for text in ["key Left down", "3: key a", "key Left up", "key a"] {
            queue.add(line(text));
        }
        let a = Event::Key { symbol: 0x61, is_down: true };
        assert_eq!(queue.take(1), [LEFT]);
        assert_eq!(queue.take(2), []);
        // The second stroke of a key comes when the first one is over.
        assert_eq!(queue.take(4), [a, LEFT.released()]);
        assert_eq!(queue.take(5), [a.released(), a]);
        assert_eq!(queue.take(6), [a.released()]);
        assert_eq!(queue.take(7), []);
    }

    #[test]
    fn what_moves_within_a_frame_is_one_event() {
        let mut queue = Queue::default();
        for text in ["move 0 0", "move 0.5 1", "button 1 down", "shift 1 2", "shift 3 4", "move 0 0"] {
            queue.add(line(text));
        }
        let button = Event::Button { number: 1, is_down: true };
        let (place, end) = (Event::Place { x: 0.5, y: 1.0 }, Event::Place { x: 0.0, y: 0.0 });
        assert_eq!(queue.take(1), [place, button, Event::Shift { x: 4, y: 6 }, end]);
        (0..MOST + 1).for_each(|_| {
            queue.add(line("button 1 down"));
            queue.add(line("button 1 up"));
        });
        assert_eq!([queue.take(2).len(), queue.take(3).len(), queue.take(4).len()], [MOST, MOST, 2]);
        (1..MOST_LINES).for_each(|_| queue.add(line("shift 1 0")));
        assert!(!queue.is_full());
        queue.add(line("shift 1 0"));
        assert!(queue.is_full());
        queue.take(5);
        assert!(!queue.is_full());
    }

    #[test]
    fn lines_that_are_not_understood_are_told_and_left_out() {
        let said = std::cell::RefCell::new(Vec::new());
        let mut lines = Vec::new();
        let text = format!("key Left down\nkeys\n{}key a\nkey Left up", "x".repeat(3000));
        read(text.as_bytes(), |line| lines.push(line), |words| said.borrow_mut().push(words.to_owned()));
        assert_eq!(lines, [line("key Left down"), line("key Left up")]);
        let said = said.into_inner();
        assert!(said.len() == 2 && said[0].contains("keys: expected") && said[1].contains("1000 bytes"), "{said:?}");
    }
}
