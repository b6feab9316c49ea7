//! What strangers send to `cupola serve` and `cupola node`. The first byte says what follows: requests of HTTP, a packet
//! of OSC, lines of the control socket, or lines of input. This file is a module of the command.

use super::access::Access;
use super::control::{Command, Server};
use super::program::{Launch, Program};
use super::{http, osc};
use crate::node::input::{self, Event, Queue};
use std::sync::LazyLock;

static ACCESS: LazyLock<Access> =
    LazyLock::new(|| Access::new(([127, 0, 0, 1], 8640).into()).expect("the system has random numbers"));

/// Runs requests that only change the rig.
fn run(commands: Vec<Command>) {
    if !commands.iter().any(|command| matches!(command, Command::Set { .. })) {
        return;
    }
    let folder = std::env::temp_dir().join(format!("cupola-fuzz-{}", std::process::id()));
    std::fs::create_dir_all(&folder).expect("a folder");
    let launch = Launch {
        options: Vec::new(),
        working_file: folder.join("rig.toml"),
        ring: folder.join("ring"),
        statistics: folder.join("statistics.json"),
        clock: folder.join("clock"),
    };
    let (program, _orders) = Program::new();
    let rigs = vec!["planetarium-2".to_owned()];
    let server = Server::new(rigs, Vec::new(), launch, program, None, &folder).expect("a preset");
    for command in commands {
        let changes = matches!(
            command,
            Command::State {}
                | Command::Keys {}
                | Command::Get { .. }
                | Command::Set { .. }
                | Command::Undo {}
                | Command::Redo {}
                | Command::Rig { .. }
                | Command::Mark(_)
                | Command::Unmark { .. }
        );
        if changes {
            let _ = server.run(command, false);
        }
    }
}

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    let Some((kind, bytes)) = bytes.split_first() else { return };
    let run = |commands| {
        // Running them takes a hundred times as long as reading them.
        if kind & 4 != 0 {
            run(commands);
        }
    };
    match kind % 4 {
        0 => {
            let (mut stream, mut held, mut commands) = (bytes, Vec::new(), Vec::new());
            while let Ok(Ok(Some(request))) = http::read(&mut stream, &mut held, &ACCESS) {
                assert!(request.body.len() <= bytes.len() && !request.has_token, "nobody knows the word");
                let _ = request.value("side").and_then(|value| value.parse::<u64>().ok());
                commands.extend(serde_json::from_slice::<Command>(&request.body));
            }
            run(commands);
        }
        1 => {
            let messages = osc::messages(bytes);
            run(messages.iter().filter_map(|message| osc::command(message).ok()).collect());
        }
        2 => {
            let lines = std::str::from_utf8(bytes).unwrap_or_default().lines();
            run(lines.filter_map(|line| serde_json::from_str(line).ok()).collect());
        }
        _ => {
            let mut queue = Queue::default();
            input::read(
                bytes,
                |line| {
                    if !queue.is_full() {
                        queue.add(line);
                    }
                },
                |_| {},
            );
            for event in (0..8).flat_map(|frame| queue.take(frame)) {
                assert_eq!(Event::of(event.words()), Some(event), "nodes get what was read");
            }
        }
    }
});
