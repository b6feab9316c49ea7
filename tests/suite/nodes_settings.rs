//! Settings of several nodes that are those of node 0.

use crate::display;
use crate::harness::tests;
use crate::nodes::{PATIENT, rig};
use crate::programs::{Finished, Run, built, library, scratch};
use std::process::Command;

tests! {
    nodes_take_seed_size_and_clock_of_node_0,
    a_node_without_node_0_starts_no_program,
}

/// Starts a node of two as `cupola node --local 2` does, but with options of its own.
fn node(number: usize, folder: &std::path::Path, options: &[&str]) -> Option<Finished> {
    let run = Run { frames: 0, extra: &["--mode", "draw"], ..Run::new("by_time") };
    let mut command = Command::new(env!("CARGO_BIN_EXE_cupola"));
    command.env("CUPOLA_NODE", format!("{number}/2")).env("CUPOLA_NODE_SOCKET", folder.join("socket"));
    command.env("CUPOLA_LIBRARY", library()).args(["node", "--unpaced", "--frames", "20"]).args(PATIENT);
    command.args(options).arg("--rig").arg(rig()).arg("--");
    let place = display::place();
    command.arg(built().join(run.program)).args(run.arguments(&place));
    Finished::of(command, run.program, "node")
}

/// The program draws by random numbers and time.
fn nodes_take_seed_size_and_clock_of_node_0() {
    let folder = scratch("settings");
    let [first, other] = std::thread::scope(|scope| {
        let options: [&[&str]; 2] = [
            &["--seed", "7", "--size", "192x128", "--clock-start", "2030-01-01"],
            &["--seed", "8", "--size", "128x96", "--clock", "30"],
        ];
        let folder = &folder;
        let start = |number: usize| scope.spawn(move || node(number, folder, options[number]));
        [0, 1].map(start).map(|node| node.join().expect("a node"))
    });
    let (Some(first), Some(other)) = (first, other) else { return };
    let (first, other) = (first.expect_success(), other.expect_success());
    let words = other.words();
    let said = "node 1 takes the settings of node 0: --clock 60 instead of --clock 30, --seed 7 instead of --seed 8, \
                --clock-start 1893456000 s after 1970 instead of the usual --clock-start, --size 192x128 instead of \
                --size 128x96";
    assert!(words.contains(said), "{words}");
    let words = first.words();
    assert!(words.contains("all alike") && !words.contains("takes the settings"), "{words}");
    assert!(!words.contains("draws something else") && !words.contains("the window of node"), "{words}");
}

/// Node 0 ends before it has sent anything.
fn a_node_without_node_0_starts_no_program() {
    let folder = scratch("alone");
    let socket = folder.join("socket");
    let listener = std::os::unix::net::UnixListener::bind(&socket).expect("a socket");
    let other = std::thread::scope(|scope| {
        let other = scope.spawn(|| node(1, &folder, &[]));
        // It says its number, and hears nothing.
        let mut socket = listener.accept().expect("node 1").0;
        std::io::Read::read_exact(&mut socket, &mut [0; 8]).expect("its number");
        drop(socket);
        other.join().expect("a node")
    });
    let Some(other) = other else { return };
    assert!(!other.succeeded(), "{}", other.words());
    assert!(other.words().contains("node 1: node 0 does not send its settings"), "{}", other.words());
}
