//! Several nodes: `cupola node`.

use crate::display;
use crate::harness::{note, tests};
use crate::programs::{Finished, Run, built, library, scratch};
use cupola::nodes::Page;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

tests! {
    four_nodes_show_what_one_process_shows,
    with_their_own_clocks_nodes_differ,
    a_program_that_reads_past_the_clock_is_named,
    programs_with_other_names_are_alike,
    a_vulkan_program_that_differs_is_named,
    a_vulkan_node_leaves_out_views_of_others,
    a_vulkan_node_draws_everything_if_queries_count,
    shaders_of_draws_write_the_same_on_all_vulkan_nodes,
    a_show_that_the_user_ends_has_not_failed,
    stopped_and_killed_nodes_do_not_stop_the_others,
    the_others_wait_no_longer_than_the_time_out,
}

/// A time-out that no node exceeds on a busy machine.
pub const PATIENT: [&str; 2] = ["--time-out", "60000"];

/// The preset with small pictures.
pub fn rig() -> PathBuf {
    let preset = cupola::rig::presets().iter().find(|preset| preset.name == "planetarium-6").expect("a preset");
    let text = preset.text.replace("size = [1920, 1080]", "size = [96, 54]");
    assert_ne!(text, preset.text);
    let path = scratch("rig").join("dome.toml");
    std::fs::write(&path, text).expect("written");
    path
}

/// Runs the program that moves by time and random numbers, with `cupola run` or `cupola node`.
pub fn by_time(rig: &Path, mode: &str, frames: usize, cupola: &[&str]) -> Option<Finished> {
    let run = Run { frames: 0, size: (96, 96), extra: &["--mode", mode], ..Run::new("by_time") };
    let mut command = Command::new(env!("CARGO_BIN_EXE_cupola"));
    command.env("CUPOLA_LIBRARY", library()).args(cupola).arg("--rig").arg(rig);
    command.args(["--offscreen", "--capture", "capture.png", "--frames", &frames.to_string(), "--"]);
    let place = display::place();
    command.arg(built().join(run.program)).args(run.arguments(&place));
    Some(Finished::of(command, run.program, cupola[0])?.expect_success())
}

/// Whether the pictures of all outputs are the same, byte for byte.
pub fn are_equal(rig: &Path, one: &Finished, other: &Finished) -> bool {
    let rig = cupola::rig::load(&rig.to_string_lossy()).expect("a rig");
    let bytes = |finished: &Finished, name: &str| {
        let file = finished.directory.join(format!("capture-{name}.png"));
        std::fs::read(&file).unwrap_or_else(|error| panic!("{}: {error}", file.display()))
    };
    assert_eq!(rig.outputs.len(), 6);
    rig.outputs.iter().all(|output| bytes(one, &output.name) == bytes(other, &output.name))
}

fn four_nodes_show_what_one_process_shows() {
    let rig = rig();
    let mut before = None;
    for frames in [1, 40] {
        let nodes = ["node", "--local", "4", "--unpaced", "--seed", "7", PATIENT[0], PATIENT[1]];
        let Some(nodes) = by_time(&rig, "draw", frames, &nodes) else { return };
        let Some(one) = by_time(&rig, "draw", frames, &["run", "--clock", "60", "--seed", "7"]) else { return };
        assert!(are_equal(&rig, &nodes, &one), "frame {frames}");
        let words = nodes.words();
        note(format_args!("{words}"));
        assert!(
            words.contains("node 1 of 4") && words.contains(&format!("{} frames on 4 nodes", frames - 1)),
            "{words}"
        );
        assert!(words.contains("all alike") && !words.contains("draws something else"), "{words}");
        // Control: the pictures change.
        assert!(before.is_none_or(|before| !are_equal(&rig, &before, &nodes)));
        before = Some(nodes);
    }
}

/// Negative control of the test above.
fn with_their_own_clocks_nodes_differ() {
    let rig = rig();
    let nodes = ["node", "--local", "2", "--own-clocks", PATIENT[0], PATIENT[1]];
    let Some(nodes) = by_time(&rig, "draw", 6, &nodes) else { return };
    let Some(one) = by_time(&rig, "draw", 6, &["run"]) else { return };
    assert!(!are_equal(&rig, &nodes, &one));
    assert!(nodes.words().contains("draws something else than the others"), "{}", nodes.words());
}

fn a_program_that_reads_past_the_clock_is_named() {
    let nodes = ["node", "--local", "2", "--unpaced", PATIENT[0], PATIENT[1]];
    // The program reads the counter from its third frame on: for a matrix, a number in a shader, the
    // text of a shader, the pixels of a texture, vertices in its own memory, a colour, a lamp, or a texture of
    // several layers.
    for mode in ["counter", "uniform", "shader", "texture", "array", "vector", "light", "layers"] {
        let Some(nodes) = by_time(&rig(), mode, 6, &nodes) else { return };
        let words = "node 1 draws something else than the others in frame 3";
        assert!(nodes.words().contains(words), "{mode}: {}", nodes.words());
    }
}

/// The driver gives the program other names of objects on each node, as Cupola has others there.
fn programs_with_other_names_are_alike() {
    let nodes = ["node", "--local", "2", "--unpaced", PATIENT[0], PATIENT[1]];
    let Some(nodes) = by_time(&rig(), "late", 8, &nodes) else { return };
    assert!(nodes.words().contains("all alike"), "{}", nodes.words());
}

/// Runs `vk_cube` on so many nodes.
fn cube_on_nodes(folder: &Path, nodes: &str, options: &[&str], before: &[&str]) -> Option<Finished> {
    on_nodes(folder, ("vk_cube", 0), nodes, options, before)
}

/// Runs a program of Vulkan on so many nodes, for so many frames (0: without an end).
fn on_nodes(
    folder: &Path,
    (program, frames): (&'static str, usize),
    nodes: &str,
    options: &[&str],
    before: &[&str],
) -> Option<Finished> {
    let run = Run { frames, size: (96, 96), ..Run::new(program) };
    let mut command = Command::new(env!("CARGO_BIN_EXE_cupola"));
    command.env("CUPOLA_LIBRARY", library()).args(["node", "--local", nodes, "--unpaced", PATIENT[0], PATIENT[1]]);
    command.arg("--rig").arg(rig()).args(options).arg("--").args(before);
    let place = display::place();
    command.arg(folder.join(run.program)).args(run.arguments(&place));
    Some(Finished::of(command, run.program, "node")?.expect_success())
}

/// With `0` all nodes have the same direction. With the number of the node each has another
/// direction.
fn a_vulkan_program_that_differs_is_named() {
    let Some(folder) = crate::programs::vulkan_apps() else { return };
    for (yaw, words) in
        [("0", "all alike"), ("${CUPOLA_NODE%/*}", "node 1 draws something else than the others in frame 1:")]
    {
        let shell = ["sh", "-c", &format!("exec \"$0\" \"$@\" --yaw {yaw}")];
        let Some(finished) = cube_on_nodes(folder, "2", &["--frames", "4"], &shell) else { return };
        assert!(finished.words().contains(words), "{yaw}: {}", finished.words());
        assert!(!finished.words().contains("different sizes"), "{}", finished.words());
    }
    // The second node's window is a pixel higher.
    let shell = ["sh", "-c", "exec \"$0\" \"$@\" --size 96x9$((6 + ${CUPOLA_NODE%/*}))"];
    let finished = cube_on_nodes(folder, "2", &["--frames", "4"], &shell).expect("a display");
    assert!(finished.words().contains("windows of different sizes"), "{}", finished.words());
}

/// Draws go only to the views that a node's outputs show. The pictures are those of nodes that draw
/// all views.
fn a_vulkan_node_leaves_out_views_of_others() {
    let Some(folder) = crate::programs::vulkan_apps() else { return };
    let run = |options: &[&str]| {
        let options = [&["--frames", "4", "--capture", "capture.png", "--stats", "stats.json"], options].concat();
        cube_on_nodes(folder, "6", &options, &[])
    };
    let Some(one) = run(&[]) else { return };
    let all = run(&["--no-cull"]).expect("a display");
    assert!(are_equal(&rig(), &one, &all));
    for node in 0..6 {
        let count = |finished: &Finished| draws_left_out(finished, node);
        note(format_args!("node {node}: {} draws left out", count(&one)));
        assert!(count(&one) >= 4 && count(&all) == 0, "node {node}");
    }
}

/// Number of draws that a node left out of views, from its statistics.
fn draws_left_out(finished: &Finished, node: u32) -> u64 {
    let text = std::fs::read_to_string(finished.directory.join(format!("stats-node-{node}.json")));
    let counts: serde_json::Value = serde_json::from_str(&text.expect("statistics")).expect("JSON");
    counts["draws_out_of_sight"].as_u64().expect("a number")
}

/// In a program whose queries count, no draw is left out, so that programs that depend on the counts
/// do the same everywhere: a draw that is left out would not hide what is counted behind it.
fn a_vulkan_node_draws_everything_if_queries_count() {
    let Some(folder) = crate::programs::vulkan_apps() else { return };
    let shell = ["sh", "-c", "exec \"$0\" \"$@\" --counts counts-${CUPOLA_NODE%/*}.txt"];
    let run = |options: &[&str]| {
        let options = [&["--stats", "stats.json"], options].concat();
        on_nodes(folder, ("vk_queries", 4), "6", &options, &shell)
    };
    let Some(one) = run(&[]) else { return };
    let all = run(&["--no-cull"]).expect("a display");
    for node in 0..6 {
        let counts = |finished: &Finished| finished.text(&format!("counts-{node}.txt"));
        assert!(counts(&all).lines().any(|line| line == "hidden 0 0"), "node {node}: {}", counts(&all));
        assert_eq!(counts(&one), counts(&all), "node {node}");
        assert_eq!(draws_left_out(&one, node), 0, "node {node}");
    }
}

/// A node leaves a draw out of the views that it does not show, but not what its shaders write. This
/// program's swapchain is older than its pipeline, so that there is no tile for its own picture.
fn shaders_of_draws_write_the_same_on_all_vulkan_nodes() {
    let Some(folder) = crate::programs::vulkan_apps() else { return };
    let shell = ["sh", "-c", "exec \"$0\" \"$@\" --answers answers-${CUPOLA_NODE%/*}.txt"];
    let Some(nodes) = on_nodes(folder, ("vk_writes", 4), "6", &["--stats", "stats.json"], &shell) else { return };
    let text = nodes.text("answers-0.txt");
    let first = crate::vulkan_queries::written(&text);
    assert!(first["vertices"] == 4 * 36 && first["fragments"] > 0, "{first:?}");
    for node in 1..6 {
        let text = nodes.text(&format!("answers-{node}.txt"));
        let mut other = crate::vulkan_queries::written(&text);
        // Views have other sizes on other nodes.
        for name in ["fragments", "sums"] {
            assert!(other.insert(name, first[name]) > Some(0), "node {node}");
        }
        assert_eq!(other, first, "node {node}");
    }
    assert!((0..6).any(|node| draws_left_out(&nodes, node) > 0), "nothing is left out");
}

/// Child processes that run this program.
pub fn children(parent: u32, program: &str) -> Vec<u32> {
    let text = std::fs::read_to_string(format!("/proc/{parent}/task/{parent}/children")).unwrap_or_default();
    let name = |id: &u32| std::fs::read_to_string(format!("/proc/{id}/comm")).unwrap_or_default();
    text.split_whitespace().filter_map(|id| id.parse().ok()).filter(|id| name(id).trim() == program).collect()
}

pub fn kill(signal: &str, process: u32) {
    // `kill` is built into the shell. A minimal Debian has no such program.
    let status = Command::new("sh").args(["-c", &format!("kill -s {signal} {process}")]).status();
    assert!(status.expect("a shell").success(), "{signal} {process}");
}

/// A running node of a show.
pub struct RunningNode {
    pub sidecar: u32,
    pub program: u32,
    page: Page,
}

impl RunningNode {
    /// Newest frame that all nodes may show, as far as the node's command knows.
    pub fn newest(&self) -> u64 {
        self.page.newest()
    }

    /// Frame whose end the node's program has reached.
    pub fn frame(&self) -> u64 {
        let newest = || self.page.arrival(u64::MAX, Duration::ZERO).map(|arrival| arrival.frame);
        std::iter::from_fn(|| Some(newest())).flatten().next().expect("the node reaches further frames")
    }
}

/// Starts the program of a node in a separate folder, `node-N`.
pub const IN_OWN_FOLDER: &str = "folder=node-${CUPOLA_NODE%/*} && mkdir -p $folder && cd $folder && exec \"$0\" \"$@\"";

/// Nodes with a time-out of 0.3 s.
pub struct Show {
    launcher: Child,
    pub nodes: Vec<RunningNode>,
    pub directory: PathBuf,
    _place: display::Place,
}

/// Waits for a result that comes within seconds.
pub fn until<T>(what: &str, mut found: impl FnMut() -> Option<T>) -> T {
    let begin = Instant::now();
    loop {
        if let Some(found) = found() {
            return found;
        }
        assert!(begin.elapsed() < Duration::from_secs(40), "{what}");
        std::thread::sleep(Duration::from_millis(5));
    }
}

impl Show {
    /// Starts `count` nodes with options of `cupola node` and a program.
    pub fn start(count: usize, cupola: &[&str], program: &str, arguments: &[&str]) -> Option<Self> {
        let display = display::get()?;
        let run = Run { frames: 0, size: (96, 96), extra: arguments, ..Run::new(program) };
        let directory = scratch("show");
        let mut command = Command::new(env!("CARGO_BIN_EXE_cupola"));
        command.args(["node", "--local", &count.to_string(), "--time-out", "300", "--rig"]).arg(rig());
        command.args(cupola).args(["--", "sh", "-c", IN_OWN_FOLDER]);
        let place = display::place();
        command.arg(built().join(run.program)).args(run.arguments(&place));
        command.env("CUPOLA_LIBRARY", library()).env("DISPLAY", &display.name).env("LIBGL_ALWAYS_SOFTWARE", "1");
        command.env("CUPOLA_CACHE", Path::new(env!("CARGO_TARGET_TMPDIR")).join("results")).current_dir(&directory);
        let log = std::fs::File::create(directory.join("log")).expect("a file");
        command.stderr(log).stdin(Stdio::null()).stdout(Stdio::null());
        let launcher = command.spawn().expect("cupola starts");
        let mut show = Self { launcher, nodes: Vec::new(), directory, _place: place };
        let sidecars = || Some(children(show.launcher.id(), "cupola")).filter(|ids| ids.len() == count);
        let sidecars = until("all nodes start", sidecars);
        for sidecar in sidecars {
            let mut path = cupola::ring::default_path().into_os_string();
            path.push(format!("-node-{sidecar}"));
            let page = until("a page is made", || Page::open(path.as_ref()).ok());
            let process = until("a program starts", || children(sidecar, program).first().copied());
            show.nodes.push(RunningNode { sidecar, program: process, page });
        }
        until("all nodes show frames", || show.nodes.iter().all(|node| node.page.released() > 15).then_some(()));
        Some(show)
    }

    pub fn words(&self) -> String {
        std::fs::read_to_string(self.directory.join("log")).expect("a log")
    }

    pub fn says(&self, words: &str) {
        until(&format!("{words}:\n{}", self.words()), || self.words().contains(words).then_some(()));
    }

    /// The longest time between two frames of a node, in the next two seconds.
    fn longest_pause(&self, node: usize) -> Duration {
        let (begin, mut changed, mut longest) = (Instant::now(), Instant::now(), Duration::ZERO);
        let mut before = self.nodes[node].frame();
        while begin.elapsed() < Duration::from_secs(2) {
            let frame = self.nodes[node].frame();
            longest = longest.max(changed.elapsed());
            if frame != before {
                (before, changed) = (frame, Instant::now());
            }
            std::thread::sleep(Duration::from_millis(1));
        }
        longest
    }

    /// Waits until a node has shown `count` more frames.
    pub fn goes_on(&self, node: usize, count: u64) {
        let before = self.nodes[node].frame();
        until("a node goes on", || (self.nodes[node].frame() > before + count).then_some(()));
    }
}

impl Drop for Show {
    fn drop(&mut self) {
        let _ = self.launcher.kill();
        let _ = self.launcher.wait();
        for RunningNode { sidecar, program, .. } in &self.nodes {
            for process in [sidecar, program] {
                let _ = Command::new("sh").args(["-c", &format!("kill -s KILL {process} 2>/dev/null")]).status();
            }
            let mut path = cupola::ring::default_path().into_os_string();
            path.push(format!("-node-{sidecar}"));
            let _ = std::fs::remove_file(path);
        }
    }
}

fn a_show_that_the_user_ends_has_not_failed() {
    let Some(mut show) = Show::start(2, &[], "by_time", &[]) else { return };
    kill("INT", show.launcher.id());
    until("the show ends", || show.launcher.try_wait().expect("its state can be read"));
    let words = show.words();
    assert!(!words.contains("has ended with an error"), "{words}");
}

fn stopped_and_killed_nodes_do_not_stop_the_others() {
    let Some(show) = Show::start(4, &[], "by_time", &[]) else { return };
    // A program ends by a signal. Its command stays, and the others go on in step.
    kill("KILL", show.nodes[3].program);
    show.says("the program of node 3 has ended with an error: the others go on without it");
    (0..3).for_each(|node| show.goes_on(node, 20));
    assert!(Path::new(&format!("/proc/{}", show.nodes[3].sidecar)).exists(), "the command of node 3 has ended");
    let distance = |one: usize, other: usize| show.nodes[one].frame().abs_diff(show.nodes[other].frame());
    // A machine stops responding for two seconds: both the command and the program are stopped.
    kill("STOP", show.nodes[2].sidecar);
    kill("STOP", show.nodes[2].program);
    let stopped = show.nodes[2].frame();
    note(format_args!("longest pause of node 0, with a time-out of 300 ms: {:?}", show.longest_pause(0)));
    (0..2).for_each(|node| show.goes_on(node, 40));
    assert_eq!(show.nodes[2].frame(), stopped);
    show.says("node 2 has not reached frame");
    kill("CONT", show.nodes[2].program);
    kill("CONT", show.nodes[2].sidecar);
    show.says("node 2 is in step again");
    until("it is in step", || (distance(1, 2) <= 1).then_some(()));
    // Only the command is stopped. Its program continues without it and joins again.
    kill("STOP", show.nodes[2].sidecar);
    show.says("node 2: the other nodes do not answer in time");
    (0..3).for_each(|node| show.goes_on(node, 20));
    kill("CONT", show.nodes[2].sidecar);
    show.says("node 2: this program is in step with the other nodes again");
    until("it is in step", || (distance(1, 2) <= 1).then_some(()));
    // A command ends. Its program continues alone.
    kill("KILL", show.nodes[1].sidecar);
    show.says("node 1 has ended unexpectedly");
    show.says("node 1: this program has lost the other nodes");
    (0..3).for_each(|node| show.goes_on(node, 20));
    // The launcher is killed. Nothing changes.
    kill("KILL", show.launcher.id());
    note(format_args!("longest pause of node 0 without the launcher: {:?}", show.longest_pause(0)));
    (0..3).for_each(|node| show.goes_on(node, 20));
    until("the others are in step", || (distance(0, 2) <= 1).then_some(()));
    // The command of node 0 is killed.
    kill("KILL", show.nodes[0].sidecar);
    show.says("node 2: node 0 cannot be reached any more");
    show.says("node 2: this program has lost the other nodes");
    (0..3).for_each(|node| show.goes_on(node, 20));
    let words = show.words();
    for said in [
        "the program of node 3 has ended",
        "node 2 has not reached",
        "node 2: the other nodes do not answer",
        "node 1: this program has lost",
    ] {
        assert_eq!(words.matches(said).count(), 1, "{said}:\n{words}");
    }
}

/// The time-out is 300 ms, and a frame takes 1/60 s.
fn the_others_wait_no_longer_than_the_time_out() {
    let Some(show) = Show::start(2, &[], "by_time", &[]) else { return };
    let mut pauses = Vec::new();
    // Other programs of this machine may disturb an attempt.
    for _ in 0..5 {
        kill("STOP", show.nodes[1].sidecar);
        kill("STOP", show.nodes[1].program);
        pauses.push(show.longest_pause(0));
        kill("CONT", show.nodes[1].program);
        kill("CONT", show.nodes[1].sidecar);
        until("it is in step", || (show.nodes[0].frame().abs_diff(show.nodes[1].frame()) <= 1).then_some(()));
        // They wait for it again.
        show.goes_on(0, 20);
        // Longer than usual frames, so that they have waited.
        let pause = pauses.last().expect("a pause");
        if (100..=317).contains(&pause.as_millis()) {
            return;
        }
    }
    panic!("longest pauses of node 0: {pauses:?}");
}
