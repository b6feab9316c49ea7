//! Reduced pictures of the program: all outputs of the newest frame in one JPEG.

mod compose;
mod versions;

pub use versions::Versions;

use super::program::Program;
use compose::{arrange, shrink};
use cupola::lock::Lock;
use cupola::ring::{Frame, Next, Picture, Reader};
use cupola::system::process;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

/// Permitted sides of the picture, pixels.
const SIDES: std::ops::RangeInclusive<u32> = 64..=2048;
/// Quality of the JPEG, 1 to 100.
const QUALITY: u8 = 82;
/// Shortest time between pictures, for all clients together. The page requests one when it has
/// painted.
const SHORTEST: Duration = Duration::from_millis(30);
/// Part of all processors' time that pictures may take while nobody changes the rig: one of so many.
/// With what the library and a browser do for them, a program on all processors loses about a tenth.
const PART: u32 = 120;
/// Longest pause of this kind: five pictures a second come in any case.
const LONGEST: Duration = Duration::from_millis(180);
/// Interval at which a change is noticed that ends a longer wait.
const GLANCE: Duration = Duration::from_millis(5);
/// Time after a read in which the next frame was published for a client that is still there. After
/// a longer one the frame that lies ready may be as old.
const READY: Duration = Duration::from_millis(500);
/// Interval at which the command looks for the program's file.
const LOOK: Duration = Duration::from_millis(50);

/// Rectangle of an output in the picture, pixels.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Place {
    name: String,
    x: u32,
    y: u32,
    width: u32,
    height: u32,
}

/// A reduced frame.
#[derive(Clone, Debug)]
pub struct Small {
    /// Number of the frame in the ring; with the number of the program it tells frames apart.
    pub number: u64,
    /// Number that the program gave it.
    pub index: u64,
    /// Version of the rig that it shows, if it is known.
    pub version: Option<u64>,
    /// Bytes of the JPEG.
    pub jpeg: Vec<u8>,
    /// Rectangles of the outputs.
    places: Vec<Place>,
    side: u32,
    made: Instant,
    /// Time that making it took.
    cost: Duration,
}

impl Small {
    /// Rectangles in the form `name:x,y,width,height;…`.
    pub fn layout(&self) -> String {
        let place = |p: &Place| format!("{}:{},{},{},{}", p.name, p.x, p.y, p.width, p.height);
        self.places.iter().map(place).collect::<Vec<_>>().join(";")
    }
}

/// Information about the program's frames, for readers that do not wait for the next one.
#[derive(Default)]
pub struct Seen {
    milliseconds: f64,
    sizes: Vec<(String, (u32, u32))>,
}

impl Seen {
    /// Mean time from frame to frame over the last half second or more, milliseconds; 0: not known.
    pub fn frame_milliseconds(&self) -> f64 {
        self.milliseconds
    }

    /// Size of an output's picture, if one was read.
    pub fn size_of(&self, name: &str) -> Option<(u32, u32)> {
        self.sizes.iter().find(|(known, _)| known == name).map(|(_, size)| *size)
    }
}

/// Reader of the frames of the running program.
pub struct Pictures {
    ring: PathBuf,
    seen: Arc<Mutex<Seen>>,
    versions: Arc<Mutex<Versions>>,
    reader: Option<Reader>,
    frame: Frame,
    newest: Option<Arc<Small>>,
    /// Sum of the frame numbers of earlier programs, so that numbers keep growing.
    before: u64,
    looked: Option<Instant>,
    /// Time at which the last frame was read.
    read: Option<Instant>,
    times: Times,
}

/// Times of the program's frames, from the numbers of the frames that were read.
#[derive(Default)]
struct Times {
    first: Option<(u64, u64)>,
    milliseconds: f64,
}

impl Times {
    fn add(&mut self, index: u64, nanoseconds: u64) {
        match self.first {
            Some((first, time)) if index > first && nanoseconds > time + 500_000_000 => {
                self.milliseconds = (nanoseconds - time) as f64 / 1e6 / (index - first) as f64;
                self.first = Some((index, nanoseconds));
            }
            Some((first, _)) if index >= first => {}
            _ => self.first = Some((index, nanoseconds)),
        }
    }
}

impl Pictures {
    /// Starts for the program that publishes at `ring`.
    pub fn new(ring: &Path) -> Self {
        Self {
            ring: ring.to_owned(),
            seen: Arc::default(),
            versions: Arc::default(),
            reader: None,
            frame: Frame::default(),
            newest: None,
            before: 0,
            looked: None,
            read: None,
            times: Times::default(),
        }
    }

    /// Information about the frames so far.
    pub fn seen(&self) -> Arc<Mutex<Seen>> {
        self.seen.clone()
    }

    /// Versions of the rig, as they are written for the program.
    pub fn versions(&self) -> Arc<Mutex<Versions>> {
        self.versions.clone()
    }

    /// True if the frame that was read shows nothing of a change that was just made, and one that
    /// does will come soon.
    fn is_outdated(&self) -> bool {
        self.versions.locked().is_outdated(self.frame.rig, self.newest.as_ref().and_then(|newest| newest.version))
    }

    fn note(&self) {
        let mut seen = self.seen.locked();
        seen.milliseconds = self.times.milliseconds;
        let pictures = &self.frame.pictures;
        let is_known =
            |((name, size), picture): (&(String, _), &Picture)| *name == picture.name && *size == picture.size;
        if seen.sizes.len() != pictures.len() || !seen.sizes.iter().zip(pictures).all(is_known) {
            seen.sizes = pictures.iter().map(|picture| (picture.name.clone(), picture.size)).collect();
        }
    }

    /// Shortest time from `newest` to the next picture.
    fn pause(&self, newest: &Small) -> Duration {
        let processors = std::thread::available_parallelism().map_or(1, |count| count.get() as u32);
        match self.versions.locked().are_changing() {
            true => SHORTEST,
            false => (newest.cost * PART / processors).clamp(SHORTEST, LONGEST),
        }
    }

    /// Returns a frame newer than `after`, `side` pixels wide and high; `None` if none comes within
    /// `limit`.
    pub fn next(&mut self, after: u64, side: u32, limit: Duration) -> Option<Arc<Small>> {
        let side = side.clamp(*SIDES.start(), *SIDES.end());
        let end = Instant::now() + limit;
        if let Some(newest) = &self.newest {
            if newest.side == side && newest.number > after && newest.made.elapsed() < self.pause(newest) {
                return Some(newest.clone());
            }
            while newest.made.elapsed() < self.pause(newest) {
                if Instant::now() > end {
                    return None;
                }
                std::thread::sleep(GLANCE);
            }
        }
        // The program publishes a new frame when the last one is read.
        let mut old = self.read.is_some_and(|read| read.elapsed() > READY);
        let mut found = false;
        loop {
            let left = end.saturating_duration_since(Instant::now());
            let is_new = self.read(left.min(LOOK));
            if is_new && self.is_outdated() {
                continue;
            }
            found |= is_new;
            if is_new && old && !left.is_zero() {
                old = false;
                continue;
            }
            match is_new || found && left.is_zero() {
                true => {
                    let small = Arc::new(process::in_background(|| self.small(side)));
                    self.newest = Some(small.clone());
                    return Some(small);
                }
                false if left.is_zero() => {
                    return self.newest.clone().filter(|newest| newest.number > after && newest.side == side);
                }
                false => {}
            }
        }
    }

    /// Reads the newest frame. Returns whether one came.
    fn read(&mut self, limit: Duration) -> bool {
        let Some(reader) = &mut self.reader else {
            self.open(limit);
            return false;
        };
        reader.skip_to_newest();
        match reader.next(limit, &mut self.frame) {
            Ok(Next::Frame) => {
                self.read = Some(Instant::now());
                self.times.add(self.frame.index, self.frame.time);
                self.note();
                true
            }
            Ok(Next::Nothing) => false,
            Ok(Next::Ended) | Err(_) => {
                self.before += self.frame.number + 1;
                (self.reader, self.times) = (None, Times::default());
                self.note();
                false
            }
        }
    }

    /// Opens the program's file, if there is one after a while.
    fn open(&mut self, limit: Duration) {
        let wait = self.looked.map_or(Duration::ZERO, |looked| LOOK.saturating_sub(looked.elapsed()));
        std::thread::sleep(wait.min(limit));
        self.looked = Some(Instant::now());
        if self.ring.exists() {
            // The file may not be complete yet.
            self.reader = Reader::open(&self.ring).ok();
        }
    }

    fn small(&self, side: u32) -> Small {
        let begin = Instant::now();
        let (rgb, places) = self.composed(side);
        let mut jpeg = Vec::new();
        let encoder = jpeg_encoder::Encoder::new(&mut jpeg, QUALITY);
        // Fails only for sides beyond 65535, and for errors of writing to memory.
        let _ = encoder.encode(&rgb, side as u16, side as u16, jpeg_encoder::ColorType::Rgb);
        let number = self.before + self.frame.number + 1;
        let version = self.versions.locked().of(self.frame.rig);
        Small {
            number,
            index: self.frame.index,
            version,
            jpeg,
            places,
            side,
            made: Instant::now(),
            cost: begin.elapsed(),
        }
    }

    /// Draws all outputs of the frame into a square of three bytes for each pixel.
    fn composed(&self, side: u32) -> (Vec<u8>, Vec<Place>) {
        let sizes: Vec<(u32, u32)> = self.frame.pictures.iter().map(|picture| picture.size).collect();
        let mut rgb = vec![0; 3 * side as usize * side as usize];
        let mut places = Vec::new();
        for (picture, (x, y, width, height)) in self.frame.pictures.iter().zip(arrange(&sizes, side)) {
            shrink(&picture.rgba, picture.size, &mut rgb, side, (x, y, width, height));
            places.push(Place { name: picture.name.clone(), x, y, width, height });
        }
        (rgb, places)
    }
}

/// Waits for a frame newer than `after`. The lock is held only briefly, so that other clients get
/// it too.
pub fn wait(pictures: &Mutex<Pictures>, program: &Program, after: u64, side: u32) -> Option<Arc<Small>> {
    let started = Instant::now();
    loop {
        let found = {
            let mut pictures = pictures.locked();
            pictures.next(after, side, Duration::from_millis(100))
        };
        let limit = if program.status().runs { Duration::from_secs(5) } else { Duration::from_millis(500) };
        if found.is_some() || started.elapsed() > limit {
            return found;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::launch::loader::Scratch;
    use cupola::ring::{Format, Shape, Stamp, Writer};

    #[test]
    fn pictures_are_those_that_were_published() {
        let scratch = Scratch::new().expect("a folder");
        let ring = scratch.path().join("ring");
        let mut pictures = Pictures::new(&ring);
        assert!(pictures.next(0, 128, Duration::from_millis(60)).is_none());
        let shapes = [("left", (200, 100)), ("right", (100, 100))];
        let shapes = shapes.map(|(name, size)| Shape { name: name.to_owned(), size, format: Format::Rgba8 });
        let mut writer = Writer::create(&ring, &shapes, 3, false).expect("a ring");
        let colors: [[u8; 4]; 2] = [[200, 40, 40, 255], [40, 40, 200, 255]];
        let publish = |writer: &mut Writer, index: u64| {
            let rig = 7 * index;
            writer.publish(Stamp { index, time: index * 1_000_000_000, rig }, |to| {
                for (number, color) in colors.iter().enumerate() {
                    let row: Vec<u8> = color.repeat(shapes[number].size.0 as usize);
                    (0..100).for_each(|y| to.row(number, y, &row));
                }
            });
        };
        // The reader opens the file, and gets the frames that are published from then on.
        assert!(pictures.next(0, 128, Duration::from_millis(60)).is_none());
        publish(&mut writer, 1);
        let small = pictures.next(0, 128, Duration::from_millis(200)).expect("a frame");
        publish(&mut writer, 3);
        let next = pictures.next(small.number, 128, Duration::from_millis(200)).expect("a frame");
        let seen = pictures.seen();
        let seen = seen.lock().expect("no panic");
        assert!(next.number > small.number && (seen.frame_milliseconds() - 1000.0).abs() < 1e-9);
        assert_eq!(seen.size_of("left"), Some((200, 100)));
        drop(seen);
        // After a while the frame that lies ready is old, and the one after it is taken.
        publish(&mut writer, 4);
        std::thread::sleep(READY + Duration::from_millis(100));
        std::thread::scope(|scope| {
            scope.spawn(|| {
                while !writer.is_awaited() {
                    std::thread::yield_now();
                }
                publish(&mut writer, 9);
            });
            assert_eq!(pictures.next(next.number, 128, Duration::from_secs(20)).expect("a frame").index, 9);
        });
        // If none comes, the old one is shown.
        publish(&mut writer, 10);
        std::thread::sleep(READY + Duration::from_millis(100));
        let next = pictures.next(next.number, 128, Duration::from_millis(60)).expect("a frame");
        assert_eq!(next.index, 10);
        let (rgb, places) = pictures.composed(128);
        for (place, color) in places.iter().zip(colors) {
            for (x, y) in [(0, 0), (place.width / 2, place.height / 2), (place.width - 1, place.height - 1)] {
                let at = 3 * ((place.y + y) * 128 + place.x + x) as usize;
                assert_eq!(rgb[at..at + 3], color[..3], "{} {x} {y}", place.name);
            }
        }
        assert!(next.jpeg.starts_with(&[0xFF, 0xD8]) && next.layout().starts_with("left:0,0,"));
        writer.end();
        // The numbers of the next program's frames are greater.
        let mut writer = Writer::create(&ring, &shapes, 3, false).expect("a ring");
        assert!(pictures.next(next.number, 128, Duration::from_millis(150)).is_none());
        publish(&mut writer, 1);
        assert!(pictures.next(next.number, 128, Duration::from_millis(300)).expect("a frame").number > next.number);
    }
}
