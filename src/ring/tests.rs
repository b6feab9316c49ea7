use super::layout::{self, ACTIVE, ReaderWords, header};
use super::{Format, Frame, Next, Reader, Shape, Stamp, Writer, text_sum};
use crate::system::SharedMemory;
use std::path::PathBuf;
use std::time::{Duration, Instant};

const SOON: Duration = Duration::from_secs(20);

fn path(name: &str) -> PathBuf {
    let path = std::env::temp_dir().join(format!("cupola-ring-{name}-{}", std::process::id()));
    let _ = std::fs::remove_file(&path);
    path
}

fn shapes(sizes: &[(u32, u32)]) -> Vec<Shape> {
    sizes
        .iter()
        .enumerate()
        .map(|(i, size)| Shape { name: format!("output {i}"), size: *size, format: Format::Rgba8 })
        .collect()
}

/// The pixels of a picture of frame `index`.
fn pixels(index: u64, picture: usize, (width, height): (u32, u32)) -> Vec<u8> {
    let value = |i: u32| if i % 4 == 3 { 255 } else { (u64::from(i) * 7 + index * 31 + picture as u64 * 101) as u8 };
    (0..width * height * 4).map(value).collect()
}

fn publish(writer: &mut Writer, index: u64) {
    let all: Vec<_> = writer.shapes().iter().enumerate().map(|(i, shape)| pixels(index, i, shape.size)).collect();
    let widths: Vec<usize> = writer.shapes().iter().map(|shape| shape.size.0 as usize * 4).collect();
    writer.publish(Stamp { index, time: index * 1000, rig: index * 7 }, |pictures| {
        for (i, rgba) in all.iter().enumerate() {
            (0..).zip(rgba.chunks_exact(widths[i])).for_each(|(y, row)| pictures.row(i, y, row));
        }
    });
}

fn is_right(frame: &Frame) -> bool {
    let pictures = frame.pictures.iter().enumerate();
    (frame.time, frame.rig) == (frame.index * 1000, frame.index * 7)
        && !frame.pictures.is_empty()
        && pictures
            .into_iter()
            .all(|(i, p)| p.name == format!("output {i}") && p.rgba == pixels(frame.index, i, p.size))
}

#[test]
fn a_reader_gets_each_frame_with_all_its_pixels() {
    let path = path("each");
    let mut writer = Writer::create(&path, &shapes(&[(8, 4), (3, 5), (1, 1)]), 3, false).expect("a ring");
    let (mut reader, mut frame) = (Reader::open(&path).expect("a reader"), Frame::default());
    assert_eq!(reader.next(Duration::ZERO, &mut frame).expect("whole"), Next::Nothing);
    for index in 1..=10 {
        publish(&mut writer, index);
        assert_eq!(reader.next(SOON, &mut frame).expect("whole"), Next::Frame);
        assert!(frame.index == index && frame.number == index - 1 && is_right(&frame));
    }
    // The comparison notices a wrong pixel.
    frame.pictures[1].rgba[7] ^= 1;
    assert!(!is_right(&frame));
    // And the checksum of another rig.
    frame.pictures[1].rgba[7] ^= 1;
    assert!(is_right(&frame));
    frame.rig += 1;
    assert!(!is_right(&frame));
    publish(&mut writer, 11);
    assert_eq!(writer.readers(), (1, 0));
    writer.end();
    assert!(!path.exists());
    assert_eq!(reader.next(SOON, &mut frame).expect("whole"), Next::Frame, "what was published is still read");
    assert_eq!(reader.next(SOON, &mut frame).expect("whole"), Next::Ended);
}

#[test]
fn a_reader_may_begin_with_the_newest_frame() {
    let path = path("newest");
    let mut writer = Writer::create(&path, &shapes(&[(4, 4)]), 3, false).expect("a ring");
    let mut frame = Frame::default();
    let mut early = Reader::open_at_newest(&path).expect("a reader");
    assert_eq!(early.next(Duration::ZERO, &mut frame).expect("whole"), Next::Nothing);
    (1..=2).for_each(|index| publish(&mut writer, index));
    let mut late = Reader::open_at_newest(&path).expect("a reader");
    let mut usual = Reader::open(&path).expect("a reader");
    assert_eq!(late.next(Duration::ZERO, &mut frame).expect("whole"), Next::Frame);
    assert!(frame.index == 2 && is_right(&frame));
    assert_eq!(late.next(Duration::ZERO, &mut frame).expect("whole"), Next::Nothing);
    // Control.
    assert_eq!(usual.next(Duration::ZERO, &mut frame).expect("whole"), Next::Nothing);
    drop((early, usual, late));
    // The writer publishes meanwhile: no reader finds a slot that was used again.
    std::thread::scope(|scope| {
        let thread = scope.spawn(|| {
            for _ in 0..2000 {
                let mut reader = Reader::open_at_newest(&path).expect("a reader");
                assert_eq!(reader.next(SOON, &mut frame).expect("whole"), Next::Frame);
                assert!(is_right(&frame));
            }
        });
        for index in 3.. {
            publish(&mut writer, index);
            if thread.is_finished() {
                break;
            }
        }
    });
}

#[test]
fn both_sides_count_what_a_slow_reader_loses() {
    let path = path("slow");
    let mut writer = Writer::create(&path, &shapes(&[(16, 16)]), 4, false).expect("a ring");
    let (mut slow, mut quick, mut frame) =
        (Reader::open(&path).expect("a reader"), Reader::open(&path).expect("a reader"), Frame::default());
    let mut seen = Vec::new();
    for index in 1..=50 {
        publish(&mut writer, index);
        assert_eq!(quick.next(SOON, &mut frame).expect("whole"), Next::Frame);
        if index % 9 == 0 {
            assert_eq!(slow.next(SOON, &mut frame).expect("whole"), Next::Frame);
            assert!(is_right(&frame));
            seen.push(frame.number);
        }
    }
    while slow.next(Duration::ZERO, &mut frame).expect("whole") == Next::Frame {
        seen.push(frame.number);
    }
    assert!(seen.is_sorted_by(|a, b| a < b));
    assert_eq!(slow.lost() + seen.len() as u64, 50);
    assert_eq!((quick.lost(), writer.readers()), (0, (2, slow.lost())));
    assert!(slow.lost() > 20);
}

#[test]
fn frames_that_come_at_once_are_whole_or_lost() {
    let path = path("race");
    let mut writer = Writer::create(&path, &shapes(&[(64, 33), (7, 7)]), 3, false).expect("a ring");
    let mut readers: Vec<_> = (0..2).map(|_| Reader::open(&path).expect("a reader")).collect();
    let totals: Vec<(u64, u64)> = std::thread::scope(|scope| {
        let tasks: Vec<_> = readers
            .iter_mut()
            .map(|reader| {
                scope.spawn(move || {
                    let (mut frame, mut seen, mut last) = (Frame::default(), 0, None);
                    while reader.next(SOON, &mut frame).expect("whole") == Next::Frame {
                        assert!(is_right(&frame), "frame {}", frame.number);
                        assert!(last < Some(frame.number));
                        (last, seen) = (Some(frame.number), seen + 1);
                    }
                    (seen, reader.lost())
                })
            })
            .collect();
        (1..=3000).for_each(|index| publish(&mut writer, index));
        let lost = writer.readers().1;
        writer.end();
        let totals: Vec<_> = tasks.into_iter().map(|task| task.join().expect("no panic")).collect();
        assert_eq!(lost, totals.iter().map(|(_, lost)| lost).sum::<u64>());
        totals
    });
    assert!(totals.iter().all(|(seen, lost)| seen + lost == 3000), "{totals:?}");
}

#[test]
fn a_writer_that_waits_loses_nothing() {
    let path = path("waits");
    let mut writer = Writer::create(&path, &shapes(&[(9, 9)]), 3, true).expect("a ring");
    let mut reader = Reader::open(&path).expect("a reader");
    std::thread::scope(|scope| {
        let task = scope.spawn(move || {
            let (mut frame, mut next) = (Frame::default(), 1);
            while reader.next(SOON, &mut frame).expect("whole") == Next::Frame {
                assert!(frame.index == next && is_right(&frame));
                next += 1;
                if next % 10 == 0 {
                    std::thread::sleep(Duration::from_millis(3));
                }
            }
            (next - 1, reader.lost())
        });
        for index in 1..=100 {
            // The window changes its size twice.
            if index == 40 || index == 41 {
                writer.reshape(&shapes(&[(index as u32, 5), (4, 4)])).expect("a new file");
            }
            publish(&mut writer, index);
        }
        writer.drain(SOON);
        writer.end();
        assert_eq!(task.join().expect("no panic"), (100, 0));
    });
}

#[test]
fn a_live_ring_that_changes_its_size_counts_on() {
    let path = path("reshaped");
    let mut writer = Writer::create(&path, &shapes(&[(5, 5)]), 3, false).expect("a ring");
    let (mut reader, mut frame) = (Reader::open(&path).expect("a reader"), Frame::default());
    (1..=2).for_each(|index| publish(&mut writer, index));
    writer.reshape(&shapes(&[(6, 2), (1, 9)])).expect("a new file");
    (3..=9).for_each(|index| publish(&mut writer, index));
    let mut seen = Vec::new();
    while reader.next(Duration::ZERO, &mut frame).expect("whole") == Next::Frame {
        assert!(is_right(&frame));
        seen.push(frame.index);
    }
    assert_eq!((seen, reader.lost()), (vec![1, 2, 7, 8, 9], 4));
    // A newcomer finds the new file.
    let mut newcomer = Reader::open(&path).expect("a reader");
    publish(&mut writer, 10);
    assert_eq!(newcomer.next(SOON, &mut frame).expect("whole"), Next::Frame);
    assert!(frame.index == 10 && frame.pictures.len() == 2);
    writer.end();
}

#[test]
fn a_change_of_size_just_before_the_end_loses_nothing_offline() {
    for waits in [true, false] {
        let path = path(&format!("changed-at-the-end-{waits}"));
        let mut writer = Writer::create(&path, &shapes(&[(5, 5)]), 3, waits).expect("a ring");
        let (mut reader, mut frame) = (Reader::open(&path).expect("a reader"), Frame::default());
        publish(&mut writer, 1);
        writer.reshape(&shapes(&[(6, 2)])).expect("a new file");
        publish(&mut writer, 2);
        let ending = std::thread::spawn(|| writer.end());
        if !waits {
            ending.join().expect("ended");
        }
        // A slow reader: the program has called `end` before the first frame is read.
        std::thread::sleep(Duration::from_millis(50));
        let mut seen = Vec::new();
        let end = loop {
            match reader.next(SOON, &mut frame).expect("whole") {
                Next::Frame => seen.push(frame.index),
                other => break other,
            }
        };
        let expected: &[u64] = if waits { &[1, 2] } else { &[1] };
        assert_eq!((end, &seen[..]), (Next::Ended, expected), "waits: {waits}");
    }
}

#[test]
fn whoever_ends_without_a_word_blocks_nobody() {
    let path = path("killed");
    let mut writer = Writer::create(&path, &shapes(&[(2, 2)]), 3, true).expect("a ring");
    let memory = SharedMemory::open(&path).expect("the file");
    let words = ReaderWords::new(&memory, 0);
    // A reader that took its entry and then died: its lock is gone, its words are still there.
    words.is_active().store(ACTIVE, std::sync::atomic::Ordering::Release);
    let started = Instant::now();
    (1..=9).for_each(|index| publish(&mut writer, index));
    assert!(started.elapsed() < SOON, "the writer goes on");
    assert_eq!(words.is_active().load(std::sync::atomic::Ordering::Acquire), layout::FREE);
    // The writer's process ends without `end`.
    let (mut reader, mut frame) = (Reader::open(&path).expect("a reader"), Frame::default());
    drop(writer);
    assert_eq!(reader.next(SOON, &mut frame).expect("whole"), Next::Ended);
    // Its file does not keep the next program from publishing.
    Writer::create(&path, &shapes(&[(2, 2)]), 3, true).expect("a ring").end();
}

#[test]
fn what_is_no_ring_is_refused() {
    let path = path("refused");
    let text = |result: crate::Result<()>| result.expect_err("refused").message;
    let create = |shapes: &[Shape]| Writer::create(&path, shapes, 3, false).map(Writer::end);
    assert!(text(Reader::open(&path).map(drop)).contains(&path.display().to_string()));
    std::fs::write(&path, "a letter that somebody wrote").expect("written");
    assert!(text(Reader::open(&path).map(drop)).contains("no file of published frames"));
    assert!(text(create(&shapes(&[(2, 2)]))).contains("is not one of published frames"));
    assert_eq!(std::fs::read(&path).expect("still there"), b"a letter that somebody wrote");
    std::fs::remove_file(&path).expect("removed");
    assert!(text(create(&shapes(&[(u32::MAX, u32::MAX)]))).contains(&path.display().to_string()));
    assert!(text(create(&shapes(&[(1, 1); 65]))).contains("at most 64"));
    assert!(!path.exists(), "nothing is left behind");
    let first = Writer::create(&path, &shapes(&[(2, 2)]), 3, false).expect("a ring");
    assert!(text(create(&shapes(&[(2, 2)]))).contains("another program publishes"));
    let readers: Vec<_> = (0..layout::READERS).map(|_| Reader::open(&path).expect("a reader")).collect();
    assert!(text(Reader::open(&path).map(drop)).contains("16 readers"));
    drop(readers);
    // Numbers that point beyond the file.
    let memory = SharedMemory::open(&path).expect("the file");
    for (word, wrong) in [(header::SLOTS, 0), (header::SLOTS, 1 << 40), (header::SLOT_WORDS, 1), (header::VERSION, 9)] {
        let right = layout::value(&memory, word);
        layout::set(&memory, word, wrong);
        assert!(Reader::open(&path).is_err(), "word {word} = {wrong}");
        layout::set(&memory, word, right);
    }
    let (mut reader, mut frame) = (Reader::open(&path).expect("a reader"), Frame::default());
    let (mut writer, table) = (first, layout::FIRST_SLOT + layout::slot::TABLE);
    for (word, wrong, message) in [
        (layout::picture::WIDTH, 1 << 20, "damaged"),
        (layout::picture::PIXELS, u64::MAX, "damaged"),
        (layout::picture::FORMAT, 7, "the format 7, which this version of Cupola does not know"),
    ] {
        let right = layout::value(&memory, table + word);
        layout::set(&memory, table + word, wrong);
        (0..3).for_each(|index| publish(&mut writer, index));
        let found = (0..3).map(|_| reader.next(Duration::ZERO, &mut frame)).find(Result::is_err);
        assert!(found.expect("it is found").expect_err("damaged").message.contains(message));
        layout::set(&memory, table + word, right);
        reader = Reader::open(&path).expect("a reader");
    }
    writer.end();
}

#[test]
fn deep_pictures_are_for_readers_that_ask_for_them() {
    let path = path("deep");
    let shape = Shape { name: "output".into(), size: (3, 2), format: Format::Rgba16 };
    let mut writer = Writer::create(&path, &[shape], 3, false).expect("a ring");
    let (reader, usual) = (Reader::open(&path).expect("a reader"), Reader::open(&path).expect("a reader"));
    let (mut reader, mut usual, mut frame) = (reader.taking_deep(), usual, Frame::default());
    let colors: Vec<u16> = (0..24).map(|i| if i % 4 == 3 { u16::MAX } else { 40_000 + i }).collect();
    let bytes: Vec<u8> = colors.iter().flat_map(|color| color.to_ne_bytes()).collect();
    let mut transparent = bytes.clone();
    transparent[6] = 0;
    writer.publish(Stamp { index: 1, time: 1000, rig: 7 }, |pictures| {
        (0..).zip(transparent.chunks_exact(24)).for_each(|(y, row)| pictures.row(0, y, row));
    });
    assert_eq!(reader.next(SOON, &mut frame).expect("whole"), Next::Frame);
    assert!(frame.pictures[0].rgba == bytes && frame.pictures[0].format == Format::Rgba16);
    let refused = usual.next(SOON, &mut frame).expect_err("a picture of 16 bits").message;
    assert!(refused.contains("16 bits for each colour"), "{refused}");
    // A format of a later version.
    let memory = SharedMemory::open(&path).expect("memory");
    let entry = layout::FIRST_SLOT + layout::slot::TABLE + layout::picture::FORMAT;
    layout::set(&memory, entry, 9);
    let refused = usual.next(SOON, &mut frame).expect_err("a picture of an unknown format").message;
    assert!(refused.contains("the format 9"), "{refused}");
    writer.end();
}

#[test]
fn a_driver_gets_the_memory_of_a_whole_picture() {
    let path = path("memory");
    let sizes = [(3, 5), (4, 2)];
    let mut writer = Writer::create(&path, &shapes(&sizes), 3, false).expect("a ring");
    let reader = Reader::open(&path).expect("a reader");
    assert!(writer.has_readers());
    writer.publish(Stamp::default(), |pictures| {
        let [first, second] = [0, 1].map(|number| pictures.memory(number).expect("a picture"));
        assert!(first.1 >= 3 * 5 * 4 && second.1 >= 4 * 2 * 4);
        assert_eq!(first.0.addr() % 4096, 0, "pixels begin at a page");
        assert_eq!(first.0.addr() + first.1, second.0.addr());
        assert!(pictures.memory(2).is_none());
    });
    drop(reader);
    assert!(!writer.has_readers());
    writer.end();
}

#[test]
fn frames_are_awaited_while_a_living_reader_has_read_all() {
    let path = path("awaited");
    let mut writer = Writer::create(&path, &shapes(&[(4, 4)]), 3, false).expect("a ring");
    assert!(!writer.is_awaited(), "nobody reads");
    let mut readers = [0, 1].map(|_| Reader::open(&path).expect("a reader"));
    assert!(writer.is_awaited());
    publish(&mut writer, 1);
    assert!(!writer.is_awaited(), "nobody has read the frame");
    let mut frame = Frame::default();
    assert_eq!(readers[1].next(SOON, &mut frame).expect("a ring"), Next::Frame);
    assert!(writer.is_awaited(), "one of two has");
    publish(&mut writer, 2);
    readers[1].skip_to_newest();
    assert!(!writer.is_awaited());
    // A reader that is gone is forgotten after some frames.
    assert_eq!(readers[0].next(SOON, &mut frame).expect("a ring"), Next::Frame);
    assert_eq!(readers[0].next(SOON, &mut frame).expect("a ring"), Next::Frame);
    drop(readers);
    (3..8).for_each(|index| publish(&mut writer, index));
    assert!(!writer.is_awaited());
    writer.end();
}

/// Values of the algorithm's authors (Fowler, Noll and Vo).
#[test]
fn the_checksum_of_a_text_is_fnv_1a() {
    assert_eq!(text_sum(b""), 0xCBF2_9CE4_8422_2325);
    assert_eq!(text_sum(b"a"), 0xAF63_DC4C_8601_EC8C);
    assert_eq!(text_sum(b"foobar"), 0x8594_4171_F739_67E8);
    assert_ne!(text_sum(b"yaw = 1"), text_sum(b"yaw = 2"));
}
