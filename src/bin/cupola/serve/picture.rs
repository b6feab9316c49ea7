//! Reduced pictures of the program: all outputs of the newest frame in one JPEG.

use super::program::Program;
use cupola::lock::Lock;
use cupola::ring::{Frame, Next, Picture, Reader};
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
    /// Bytes of the JPEG.
    pub jpeg: Vec<u8>,
    /// Rectangles of the outputs.
    places: Vec<Place>,
    side: u32,
    made: Instant,
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

    /// Returns a frame newer than `after`, `side` pixels wide and high; `None` if none comes within
    /// `limit`.
    pub fn next(&mut self, after: u64, side: u32, limit: Duration) -> Option<Arc<Small>> {
        let side = side.clamp(*SIDES.start(), *SIDES.end());
        let end = Instant::now() + limit;
        if let Some(newest) = &self.newest {
            if newest.side == side && newest.number > after && newest.made.elapsed() < SHORTEST {
                return Some(newest.clone());
            }
            std::thread::sleep(SHORTEST.saturating_sub(newest.made.elapsed()));
        }
        // The program publishes a new frame when the last one is read.
        let mut old = self.read.is_some_and(|read| read.elapsed() > READY);
        let mut found = false;
        loop {
            let left = end.saturating_duration_since(Instant::now());
            let is_new = self.read(left.min(LOOK));
            found |= is_new;
            if is_new && old && !left.is_zero() {
                old = false;
                continue;
            }
            match is_new || found && left.is_zero() {
                true => {
                    let small = Arc::new(self.small(side));
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
        let (rgb, places) = self.composed(side);
        let mut jpeg = Vec::new();
        let encoder = jpeg_encoder::Encoder::new(&mut jpeg, QUALITY);
        // Fails only for sides beyond 65535, and for errors of writing to memory.
        let _ = encoder.encode(&rgb, side as u16, side as u16, jpeg_encoder::ColorType::Rgb);
        let number = self.before + self.frame.number + 1;
        Small { number, index: self.frame.index, jpeg, places, side, made: Instant::now() }
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

/// Rectangles of pictures of these sizes in a square, in rows, each as large as it fits: x, y,
/// width, height.
fn arrange(sizes: &[(u32, u32)], side: u32) -> Vec<(u32, u32, u32, u32)> {
    let widest = sizes.iter().map(|size| f64::from(size.0) / f64::from(size.1.max(1))).fold(0.01, f64::max);
    let most = sizes.len().max(1) as u32;
    // Takes the number of columns that makes the pictures largest.
    let scale = |columns: u32| {
        let rows = most.div_ceil(columns);
        (f64::from(side / columns)).min(f64::from(side / rows) * widest)
    };
    let columns = (1..=most).max_by(|a, b| scale(*a).total_cmp(&scale(*b))).unwrap_or(1);
    let (cell, row) = (side / columns, side / most.div_ceil(columns));
    let place = |(index, &(width, height)): (u32, &(u32, u32))| {
        let (width, height) = (f64::from(width.max(1)), f64::from(height.max(1)));
        let factor = (f64::from(cell) / width).min(f64::from(row) / height).min(1.0);
        let fit = |length: f64, most: u32| ((length * factor).round() as u32).clamp(1, most.max(1));
        (index % columns * cell, index / columns * row, fit(width, cell), fit(height, row))
    };
    (0..).zip(sizes).map(place).collect()
}

/// Writes means of a picture's pixels into a rectangle of a square of three bytes for each pixel.
fn shrink(rgba: &[u8], (width, height): (u32, u32), to: &mut [u8], side: u32, place: (u32, u32, u32, u32)) {
    let (x, y, columns, rows) = place;
    if rgba.len() < 4 * width as usize * height as usize || width == 0 || height == 0 {
        return;
    }
    let cut = |index: u32, parts: u32, length: u32| (u64::from(index) * u64::from(length) / u64::from(parts)) as usize;
    for row in 0..rows {
        let (top, bottom) = (cut(row, rows, height), cut(row + 1, rows, height).max(cut(row, rows, height) + 1));
        for column in 0..columns {
            let left = cut(column, columns, width);
            let right = cut(column + 1, columns, width).max(left + 1);
            let mut sum = [0_u32; 3];
            for line in top..bottom {
                let pixels = &rgba[4 * (line * width as usize + left)..4 * (line * width as usize + right)];
                for pixel in pixels.chunks_exact(4) {
                    sum.iter_mut().zip(pixel).for_each(|(sum, value)| *sum += u32::from(*value));
                }
            }
            let count = ((bottom - top) * (right - left)) as u32;
            let at = 3 * ((y + row) as usize * side as usize + (x + column) as usize);
            to[at..at + 3].iter_mut().zip(sum).for_each(|(to, sum)| *to = ((sum + count / 2) / count) as u8);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::launch::loader::Scratch;
    use cupola::ring::{Format, Shape, Writer};

    #[test]
    fn places_do_not_overlap_and_keep_shapes() {
        for sizes in
            [vec![(512, 512)], vec![(1920, 1080); 6], vec![(4096, 512), (100, 400), (1, 1)], vec![(640, 480); 17]]
        {
            let places = arrange(&sizes, 512);
            for (index, (&(x, y, width, height), size)) in places.iter().zip(&sizes).enumerate() {
                assert!(x + width <= 512 && y + height <= 512, "{sizes:?}: {places:?}");
                let shape = f64::from(width) / f64::from(height) * f64::from(size.1) / f64::from(size.0);
                assert!(width < 20 || height < 20 || (shape - 1.0).abs() < 0.05, "{sizes:?}: {places:?}");
                for &(x2, y2, width2, height2) in &places[..index] {
                    assert!(x >= x2 + width2 || x2 >= x + width || y >= y2 + height2 || y2 >= y + height);
                }
            }
        }
    }

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
            writer.publish(index, index * 1_000_000_000, |to| {
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
