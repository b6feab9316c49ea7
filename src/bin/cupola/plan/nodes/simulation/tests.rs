//! The simulation against numbers that are known without it.

use super::*;

const MS: Duration = Duration::from_millis(1);

fn show(count: usize) -> Show {
    Show {
        work: vec![8 * MS; count],
        jitter: Duration::ZERO,
        latency: MS / 10,
        cores: None,
        length: 16 * MS,
        is_paced: false,
        time_out: 100 * MS,
        frames: 400,
        failed: None,
    }
}

fn is_near(value: f64, expected: f64) -> bool {
    (value - expected).abs() < 0.05 * expected.max(0.1)
}

/// Without jitter everything is known: a frame takes the work, and two messages one after the
/// other.
#[test]
fn lock_step_takes_the_slowest_node_and_two_messages() {
    let alone = show(1).run();
    assert!(is_near(alone.interval, 8.005), "{alone:?}");
    let mut four = show(4);
    let seen = four.run();
    assert!(is_near(seen.interval, 8.2) && is_near(seen.apart.0, 0.1), "{seen:?}");
    four.work[2] = 12 * MS;
    let slow = four.run();
    assert!(is_near(slow.interval, 12.2), "{slow:?}");
    four.is_paced = true;
    assert!(is_near(four.run().interval, 16.0), "{:?}", four.run());
    // Four programs on two processors.
    let shared = Show { cores: Some(2), ..show(4) }.run();
    assert!(is_near(shared.interval, 16.2), "{shared:?}");
}

#[test]
fn chance_costs_more_the_more_nodes_there_are() {
    let with = |count: usize| Show { jitter: 2 * MS, ..show(count) }.run().interval;
    // The mean of the largest of n exponential numbers is the n-th harmonic number.
    let harmonic = |count: u32| (1..=count).map(|part| 1.0 / f64::from(part)).sum::<f64>();
    for count in [1, 4, 16] {
        let expected = 8.0 + 2.0 * harmonic(count) + if count > 1 { 0.2 } else { 0.0 };
        assert!((with(count as usize) - expected).abs() < 0.35, "{count}: {} {expected}", with(count as usize));
    }
}

#[test]
fn others_wait_for_a_node_that_stops_for_half_of_the_time_out() {
    let failed = |stopped| Some(Failed { node: 2, frame: 100, stopped });
    let paced = Show { is_paced: true, ..show(3) };
    let stopped = Show { failed: failed(Some(500 * MS)), ..paced.clone() }.run();
    assert!((50.0..82.0).contains(&stopped.longest), "{stopped:?}");
    assert!(stopped.left_out > 10 && stopped.back.is_some_and(|back| back < 600.0), "{stopped:?}");
    let killed = Show { failed: failed(None), ..paced.clone() }.run();
    assert!(killed.longest < 34.0 && killed.back.is_none(), "{killed:?}");
    let whole = paced.run();
    assert!(whole.longest < 17.0 && whole.left_out == 0, "{whole:?}");
}
