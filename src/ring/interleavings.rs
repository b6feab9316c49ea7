//! Tries all orders of the steps of a writer and of a reader that takes the place of a dead one.
//!
//! `loom` would need its own atomics in place of those in the mapped file, and has no locks that
//! end with a process. So this is a model of one place, with a step for each word or lock that is
//! touched, in the order of `Writer::move_on`, `Writer::free` and `Reader::begin`.

use super::layout::{ACTIVE, FREE};

/// Number of frames that were published, and the oldest one that the writer keeps.
const PUBLISHED: u64 = 5;
const OLDEST: u64 = 3;

/// Variant of the writer.
#[derive(Clone, Copy, PartialEq)]
enum Rule {
    /// Frees the place of a dead reader without its lock.
    FreesAtOnce,
    /// Frees it with the lock.
    Locks,
    /// Moves the cursor although the reader is dead, and then counts the frames.
    Counts,
}

#[derive(Clone, Debug)]
struct World {
    state: u64,
    cursor: u64,
    lost: u64,
    locked: bool,
    /// Next step of each side; `None`: it has finished.
    writer: Option<u8>,
    reader: Option<u8>,
    /// True if the reader has this place.
    has_place: bool,
    /// Number of the next frame, as the reader counts.
    next: u64,
}

/// A reader that died left its state and its cursor.
const START: World = World {
    state: ACTIVE,
    cursor: 1,
    lost: 0,
    locked: false,
    writer: Some(0),
    reader: Some(0),
    has_place: false,
    next: 0,
};

fn write(world: &mut World, rule: Rule) {
    world.writer = match world.writer {
        Some(0) if world.state == FREE || world.cursor >= OLDEST => None,
        Some(0) if rule == Rule::Counts => Some(4),
        Some(0) => (!world.locked).then_some(1),
        Some(1) if rule == Rule::FreesAtOnce => {
            world.state = FREE;
            None
        }
        Some(1) if world.locked => None,
        Some(1) => {
            world.locked = true;
            Some(2)
        }
        Some(2) => {
            world.state = FREE;
            Some(3)
        }
        Some(3) => {
            world.locked = false;
            None
        }
        Some(4) if world.cursor == START.cursor => {
            world.cursor = OLDEST;
            Some(5)
        }
        Some(5) => {
            world.lost += OLDEST - START.cursor;
            None
        }
        _ => None,
    };
}

fn read(world: &mut World) {
    let step = world.reader.unwrap_or(0);
    match step {
        // Another place is free.
        0 if world.locked => return world.reader = None,
        0 => (world.locked, world.has_place) = (true, true),
        1 => world.state = FREE,
        2 => world.lost = 0,
        3 => world.cursor = PUBLISHED,
        4 => world.state = ACTIVE,
        5 => world.cursor = world.cursor.max(PUBLISHED),
        _ => world.next = world.cursor,
    }
    world.reader = (step < 6).then_some(step + 1);
}

/// Ends of all orders.
fn ends(world: &World, rule: Rule, found: &mut Vec<World>) {
    if world.writer.is_none() && world.reader.is_none() {
        found.push(world.clone());
    }
    for is_writer in [true, false] {
        let mut after = world.clone();
        match is_writer {
            true if world.writer.is_some() => write(&mut after, rule),
            false if world.reader.is_some() => read(&mut after),
            _ => continue,
        }
        ends(&after, rule, found);
    }
}

fn all_ends(rule: Rule) -> Vec<World> {
    let mut found = Vec::new();
    ends(&START, rule, &mut found);
    assert!(found.len() > 10 && found.iter().any(|end| end.has_place));
    found
}

#[test]
fn a_reader_keeps_the_place_of_one_that_died() {
    let loses_it = |end: &World| end.has_place && end.state != ACTIVE;
    assert!(!all_ends(Rule::Locks).iter().any(loses_it));
    assert!(!all_ends(Rule::Counts).iter().any(loses_it));
    // The control: without the lock the writer forgets a reader that lives.
    assert!(all_ends(Rule::FreesAtOnce).iter().any(loses_it));
}

#[test]
fn a_reader_does_not_inherit_losses() {
    for rule in [Rule::Locks, Rule::Counts] {
        assert!(all_ends(rule).iter().all(|end| !end.has_place || end.cursor == end.next));
    }
    // The control: the word in the file may hold the losses of the dead reader.
    assert!(all_ends(Rule::Counts).iter().any(|end| end.has_place && end.lost != 0));
}
