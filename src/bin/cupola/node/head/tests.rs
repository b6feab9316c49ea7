//! Arrivals at times that are given, and what follows from them.

use super::*;

const MS: u64 = 1_000_000;

fn head(count: usize) -> Head {
    Head::new(count, Duration::from_millis(50), None)
}

fn at(frame: u64) -> Arrival {
    Arrival { frame, digest: frame, time: frame * 16 * MS, went: 0, size: (640, 480) }
}

fn released(actions: &[Action]) -> Option<u64> {
    actions.iter().rev().find_map(|action| match action {
        Action::Release { frame, .. } => Some(*frame),
        _ => None,
    })
}

fn said(actions: &[Action]) -> String {
    let words = actions.iter().filter_map(|action| match action {
        Action::Say(words) => Some(words.as_str()),
        _ => None,
    });
    words.collect::<Vec<_>>().join("\n")
}

#[test]
fn a_frame_is_released_when_all_have_come() {
    let mut head = head(3);
    for frame in 1..5 {
        assert_eq!(released(&head.arrived(2, at(frame), 0)), None);
        assert_eq!(released(&head.arrived(0, at(frame), 10)), None);
        assert_eq!(released(&head.tick(49 * MS)), None);
        assert_eq!(head.arrived(1, at(frame), 20), [Action::Release { frame, time: 0 }]);
    }
}

#[test]
fn windows_of_different_sizes_are_told_in_any_order() {
    for order in [[0, 1, 2], [1, 0, 2], [2, 1, 0]] {
        let mut head = head(3);
        let size = |node: usize| if node == 1 { (640, 481) } else { (640, 480) };
        let arrive = |node| head.arrived(node, Arrival { size: size(node), ..at(1) }, 0);
        let words = order.map(arrive).map(|actions| said(&actions)).concat();
        assert_eq!(words.matches("the window of node").count(), 1, "{order:?}: {words}");
        assert!(words.contains("node 1 has 640x481 pixels, that of node 0 640x480"), "{order:?}: {words}");
    }
}

#[test]
fn others_go_on_without_one_that_is_late_and_it_comes_back() {
    let mut head = head(3);
    for frame in 1..20 {
        (0..3).for_each(|node| drop(head.arrived(node, at(frame), 0)));
    }
    head.arrived(0, at(20), 0);
    head.arrived(1, at(20), 5 * MS);
    assert_eq!(released(&head.tick(49 * MS)), None);
    let actions = head.tick(51 * MS);
    assert_eq!(released(&actions), Some(20));
    assert!(said(&actions).contains("node 2 has not reached frame 20"), "{actions:?}");
    for frame in 21..100 {
        head.arrived(0, at(frame), 60 * MS);
        assert_eq!(head.arrived(1, at(frame), 60 * MS), [Action::Release { frame, time: 0 }]);
        // It draws what it has missed: nobody waits for that.
        assert_eq!(head.arrived(2, at(frame - 1), 60 * MS), []);
    }
    head.arrived(0, at(100), 70 * MS);
    assert!(said(&head.arrived(2, at(100), 71 * MS)).contains("node 2 is in step again at frame 100"));
    // It is waited for again. What was told once is not told again.
    assert_eq!(released(&head.tick(90 * MS)), None);
    assert_eq!(released(&head.arrived(1, at(100), 91 * MS)), Some(100));
    head.arrived(0, at(101), 100 * MS);
    head.arrived(1, at(101), 100 * MS);
    assert_eq!(head.tick(160 * MS), [Action::Release { frame: 101, time: 0 }]);
}

#[test]
fn a_node_that_is_gone_is_not_waited_for() {
    let mut head = head(3);
    (0..2).for_each(|node| drop(head.arrived(node, at(1), 0)));
    assert_eq!(released(&head.gone(2, MS)), Some(1));
    assert_eq!((head.left(), released(&head.gone(2, MS))), (2, None));
    head.arrived(1, at(2), 0);
    assert_eq!(released(&head.gone(0, MS)), Some(2));
    assert_eq!(released(&head.arrived(1, at(3), 0)), Some(3));
}

/// Node 0 was stopped, and the others went on alone.
#[test]
fn all_meet_at_the_frame_of_the_one_that_is_ahead() {
    let mut head = head(3);
    (0..3).for_each(|node| drop(head.arrived(node, at(1), 0)));
    assert_eq!(released(&head.arrived(1, at(120), 0)), Some(119));
    assert_eq!(released(&head.arrived(2, at(117), 0)), None);
    assert_eq!(released(&head.arrived(2, at(120), 0)), None);
    assert_eq!(released(&head.arrived(0, at(120), 0)), Some(120));
}

#[test]
fn frames_follow_the_real_time() {
    let mut head = Head::new(1, Duration::from_millis(50), Some(Duration::from_millis(16)));
    // Frames at the start take no time, and none is left out.
    for frame in 1..10 {
        let time = frame * 16 * MS;
        assert_eq!(head.arrived(0, at(frame), frame * 7000 * MS), [Action::Release { frame, time }]);
    }
    let start = 90_000 * MS;
    assert_eq!(head.arrived(0, at(10), start), [Action::Release { frame: 10, time: 160 * MS }]);
    assert_eq!(head.arrived(0, at(11), start + MS), []);
    assert_eq!(head.tick(start + 15 * MS), []);
    assert_eq!(head.tick(start + 16 * MS), [Action::Release { frame: 11, time: 176 * MS }]);
    // Too slow by two frames and a half.
    assert_eq!(head.arrived(0, at(12), start + 72 * MS), [Action::Release { frame: 12, time: 224 * MS }]);
}

#[test]
fn the_one_that_draws_something_else_is_named() {
    let mut head = head(3);
    for frame in 1..30 {
        let other = |node: usize| u64::from(node == 1 && (4..8).contains(&frame));
        let actions: Vec<Action> = (0..3)
            .flat_map(|node| head.arrived(node, Arrival { digest: frame + 100 * other(node), ..at(frame) }, 0))
            .collect();
        let words = said(&actions);
        assert_eq!(words.contains("node 1 draws something else than the others in frame 4"), frame == 4, "{words}");
        assert_eq!(words.contains("node 1 draws the same as the others again since frame 8"), frame == 18, "{words}");
        assert_eq!(words.is_empty(), frame != 4 && frame != 18, "{frame}: {words}");
    }
    assert!(head.summary(false).contains("node 1 differed in 4 frames from 4 to 7"), "{}", head.summary(false));
}

#[test]
fn keyboard_and_mouse_come_with_the_frame_that_is_released() {
    let mut head = head(2);
    let line = |text: &str| Line::parse(text).expect("is understood").expect("says something");
    head.add_input(line("key a down"));
    head.add_input(line("3: key a up"));
    let key = |is_down: bool| Event::Key { symbol: 0x61, is_down };
    for frame in 1..5 {
        assert_eq!(head.arrived(0, at(frame), 0), []);
        let expected = match frame {
            1 => vec![Action::Input { frame, event: key(true) }],
            3 => vec![Action::Input { frame, event: key(false) }],
            _ => Vec::new(),
        };
        let actions = head.arrived(1, at(frame), 0);
        assert_eq!(actions, [expected, vec![Action::Release { frame, time: 0 }]].concat());
    }
}

#[test]
fn keyboard_and_mouse_reach_idle_programs() {
    let mut head = head(2);
    let line = |text: &str| Line::parse(text).expect("is understood").expect("says something");
    let key = |is_down: bool| Action::Input { frame: 1, event: Event::Key { symbol: 0x61, is_down } };
    head.arrived(0, at(1), 0);
    head.arrived(1, at(1), 10 * MS);
    head.add_input(line("key a"));
    head.add_input(line("3: key a"));
    assert_eq!(head.tick(110 * MS), []);
    assert_eq!(head.tick(111 * MS), [key(true)]);
    assert_eq!(head.tick(200 * MS), []);
    assert_eq!(head.tick(212 * MS), [key(false)]);
    // A line that waits for its frame.
    assert_eq!(head.tick(500 * MS), []);
    // One program draws: the next events come with its frame.
    head.arrived(0, at(2), 501 * MS);
    head.add_input(line("move 0.5 0.5"));
    assert_eq!(head.tick(700 * MS), []);
    head.arrived(1, at(2), 701 * MS);
    let key = Action::Input { frame: 3, event: Event::Key { symbol: 0x61, is_down: true } };
    head.arrived(0, at(3), 702 * MS);
    assert!(head.arrived(1, at(3), 703 * MS).contains(&key));
}

#[test]
fn windows_of_different_sizes_are_told() {
    let mut head = head(2);
    head.arrived(0, at(1), 0);
    let words = said(&head.arrived(1, Arrival { size: (800, 600), ..at(1) }, 0));
    assert!(words.contains("800x600") && words.contains("640x480"), "{words}");
}
