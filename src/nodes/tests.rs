//! A program and its command, on two threads.

use super::{Arrival, FIRST_FRAMES, Gate, Page, Passed, Said};
use std::path::PathBuf;
use std::time::{Duration, Instant};

const LONG: Duration = Duration::from_secs(30);
const LENGTH: Duration = Duration::from_millis(3);

fn pages(name: &str, limit: Duration) -> (Page, Page) {
    let path: PathBuf = std::env::temp_dir().join(format!("cupola-page-{name}-{}", std::process::id()));
    let command = Page::create(&path, limit, LENGTH).expect("a page");
    let program = Page::open(&path).expect("the same page");
    std::fs::remove_file(&path).expect("removed");
    (command, program)
}

fn release(page: &Page, frame: u64, time: u64) {
    page.announce(frame, time);
    page.release(frame);
}

fn passes(gate: &mut Gate) -> Passed {
    gate.pass(7, 8, (3, 2))
}

#[test]
fn a_program_goes_on_when_its_command_says_so() {
    let (command, program) = pages("go", LONG);
    let mut gate = Gate::new(program);
    let thread = std::thread::spawn(move || (passes(&mut gate), passes(&mut gate)));
    let arrival = |known: u64| loop {
        if let Some(arrival) = command.arrival(known, LONG) {
            return arrival;
        }
    };
    assert_eq!(arrival(0), Arrival { frame: 1, digest: 7, time: 8, went: 0, size: (3, 2) });
    assert_eq!(command.arrival(1, Duration::from_millis(10)), None);
    assert!(!thread.is_finished());
    release(&command, 1, 100);
    assert!(arrival(1).went > 0);
    // The others are three frames ahead.
    release(&command, 5, 500);
    let (first, second) = thread.join().expect("no panic");
    assert_eq!(first, Passed { frame: 1, time: Some(100), is_late: false, said: None });
    assert_eq!(second, Passed { frame: 2, time: None, is_late: true, said: None });
}

/// What the program has to get at the end of a frame is given to it before it passes.
#[test]
fn a_late_program_stops_where_it_is_not_let_go() {
    let (command, program) = pages("late", LONG);
    assert_eq!((command.process(), command.arrived()), (0, 0));
    let mut gate = Gate::new(program);
    assert_eq!(command.process(), std::process::id());
    command.announce(5, 500);
    command.release(2);
    let thread = std::thread::spawn(move || [(); 3].map(|()| passes(&mut gate)));
    while command.arrived() < 3 {
        std::thread::yield_now();
    }
    std::thread::sleep(Duration::from_millis(20));
    assert!(!thread.is_finished());
    command.release(5);
    // It shows none of them: the others are ahead.
    assert!(thread.join().expect("no panic").iter().all(|passed| passed.is_late && passed.said.is_none()));
}

#[test]
fn a_program_without_an_answer_goes_on_and_comes_back() {
    let (command, program) = pages("alone", Duration::from_millis(30));
    let mut gate = Gate::new(program);
    release(&command, FIRST_FRAMES, 0);
    assert!((0..FIRST_FRAMES).all(|_| passes(&mut gate).said.is_none()));
    let begin = Instant::now();
    assert_eq!(passes(&mut gate).said, Some(Said::Alone));
    assert!(begin.elapsed() >= Duration::from_millis(30));
    // The program keeps its rate, and does not wait again.
    let begin = Instant::now();
    assert!((0..4).all(|_| passes(&mut gate).said.is_none()));
    assert!(begin.elapsed() >= LENGTH * 3 && begin.elapsed() < LONG);
    // The others answer, and the program waits for them.
    let next = FIRST_FRAMES + 6;
    release(&command, next, 0);
    assert_eq!(passes(&mut gate), Passed { frame: next, time: None, is_late: false, said: Some(Said::InStep) });
    assert_eq!(passes(&mut gate).said, Some(Said::Alone));
    drop(command);
    assert_eq!(passes(&mut gate).said, Some(Said::Left));
    assert_eq!(passes(&mut gate).said, None);
}

#[test]
fn a_program_whose_command_ends_does_not_wait_to_the_end() {
    let (command, program) = pages("left", LONG);
    let mut gate = Gate::new(program);
    let thread = std::thread::spawn(move || passes(&mut gate).said);
    assert_eq!(command.arrival(0, LONG).map(|arrival| arrival.frame), Some(1));
    drop(command);
    assert_eq!(thread.join().expect("no panic"), Some(Said::Left));
}

#[test]
fn other_files_are_no_pages() {
    let path = std::env::temp_dir().join(format!("cupola-page-other-{}", std::process::id()));
    std::fs::write(&path, [0; 65536]).expect("written");
    let error = Page::open(&path).map(|_| ()).expect_err("no page").to_string();
    std::fs::remove_file(&path).expect("removed");
    assert!(error.contains("no page of this release"), "{error}");
}
