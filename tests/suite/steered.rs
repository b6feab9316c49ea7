//! Keyboard and mouse on several nodes: `cupola node --input`, `cupola input`.

use crate::display;
use crate::harness::tests;
use crate::nodes::{IN_OWN_FOLDER, PATIENT, Show, are_equal, children, kill, rig, until};
use crate::programs::{Finished, Run, built, library, scratch};
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use x11rb::connection::Connection;
use x11rb::protocol::xkb::{BoolCtrl, ConnectionExt as _, ID};
use x11rb::protocol::xproto::{ConnectionExt as _, InputFocus, KEY_PRESS_EVENT, KEY_RELEASE_EVENT, Window};
use x11rb::protocol::xtest::ConnectionExt as _;
use x11rb::rust_connection::RustConnection;

tests! {
    keyboard_and_mouse_reach_all_nodes_in_the_same_frame,
    a_key_that_one_node_gets_is_named,
    a_node_that_was_stopped_gets_its_keys_in_their_frames,
    a_node_that_is_killed_leaves_the_keyboard_as_it_was,
    nodes_without_an_x_server_of_their_own_are_told,
    a_window_prints_what_is_done_in_it,
}

const LINES: &str = "\
# Seen in the frame after the one that is named.
3: key Left
5: key Left down
7: key left up
10: key w down
15: key w up
16: move 0.5 0.25
17: button 1 down
17: move 0.9 0.9
17: move 0.25 0.75
18: shift 3 -7
20: button 1 up
20: key Nonsense
21: key 0xff53
";

/// Lines that the program writes for these events. Frames count from 0.
const COMES: &str = "\
3 press Left
4 release Left
5 press Left
7 release Left
10 press w
15 release w
16 at 48 24
17 button 1
17 at 24 72
18 at 27 65
20 button 0
21 press Right
22 release Right
";

/// Runs the program on nodes with an X server each. The program's answers are in `node-N/answers`.
fn steered(rig: &Path, count: usize, input: Option<&str>) -> Option<Finished> {
    display::get()?;
    let own = ["--at", "0,0", "--answers", "answers"];
    let run = Run { frames: 0, size: (96, 96), extra: &own, ..Run::new("steered") };
    let mut command = Command::new(env!("CARGO_BIN_EXE_cupola"));
    command.env("CUPOLA_LIBRARY", library()).args(["node", "--local", &count.to_string(), "--headless"]);
    command.args(["--unpaced", PATIENT[0], PATIENT[1], "--size", "96x96", "--rig"]).arg(rig);
    if let Some(lines) = input {
        let file = scratch("input").join("lines");
        std::fs::write(&file, lines).expect("written");
        command.arg("--input").arg(file);
    }
    command.args(["--offscreen", "--capture", "capture.png", "--frames", "30", "--", "sh", "-c", IN_OWN_FOLDER]);
    let place = display::place();
    command.arg(built().join(run.program)).args(run.arguments(&place));
    Some(Finished::of(command, run.program, "node")?.expect_success())
}

fn keyboard_and_mouse_reach_all_nodes_in_the_same_frame() {
    let rig = rig();
    let Some(three) = steered(&rig, 3, Some(LINES)) else { return };
    let Some(one) = steered(&rig, 1, Some(LINES)) else { return };
    for (finished, count) in [(&three, 3), (&one, 1)] {
        for node in 0..count {
            assert_eq!(finished.text(&format!("node-{node}/answers")), COMES, "node {node} of {count}");
        }
    }
    assert!(are_equal(&rig, &three, &one));
    let words = three.words();
    assert!(words.contains("all alike") && !words.contains("draws something else"), "{words}");
    assert_eq!(words.matches("Nonsense: there is no such key").count(), 1, "{words}");
    assert!(!words.contains("do not reach"), "{words}");
    // Negative control: the pictures depend on the events and on the frames in which the events
    // come.
    let Some(without) = steered(&rig, 3, None) else { return };
    assert!(!are_equal(&rig, &three, &without));
    let Some(later) = steered(&rig, 3, Some(&LINES.replace("15: key w up", "16: key w up"))) else { return };
    assert!(!are_equal(&rig, &three, &later));
}

/// A named pipe for lines.
struct Pipe(PathBuf);

impl Pipe {
    fn new() -> Self {
        let path = scratch("pipe").join("lines");
        let status = Command::new("mkfifo").arg(&path).status().expect("mkfifo starts");
        assert!(status.success());
        Self(path)
    }

    fn write(&self, lines: &str) {
        let mut pipe = std::fs::OpenOptions::new().write(true).open(&self.0).expect("a pipe");
        pipe.write_all(lines.as_bytes()).expect("written");
    }
}

/// A show of the program with an X server per node. A pipe gives the events.
fn show(count: usize, pipe: &Pipe) -> Option<Show> {
    let input = ["--headless", "--size", "96x96", "--input", pipe.0.to_str().expect("a UTF-8 path")];
    Show::start(count, &input, "steered", &["--at", "0,0", "--answers", "answers"])
}

/// Events that the program of a node has received.
fn answers(show: &Show, node: usize) -> String {
    std::fs::read_to_string(show.directory.join(format!("node-{node}/answers"))).unwrap_or_default()
}

fn has_come(show: &Show, node: usize, what: &str) {
    until(what, || answers(show, node).contains(what).then_some(()));
}

/// Connects to the X server of a process.
fn server_of(process: u32) -> (RustConnection, Window) {
    let variables = std::fs::read(format!("/proc/{process}/environ")).expect("a process");
    let name = variables.split(|byte| *byte == 0).find_map(|variable| variable.strip_prefix(b"DISPLAY="));
    connection(std::str::from_utf8(name.expect("a display")).expect("a name"))
}

fn connection(name: &str) -> (RustConnection, Window) {
    let (connection, number) = x11rb::connect(Some(name)).expect("an X server");
    let root = connection.setup().roots[number].root;
    (connection, root)
}

fn press(connection: &RustConnection, code: u8, is_down: bool) {
    let kind = if is_down { KEY_PRESS_EVENT } else { KEY_RELEASE_EVENT };
    connection.xtest_fake_input(kind, code, 0, x11rb::NONE, 0, 0, 0).expect("sent").check().expect("pressed");
}

/// Code of the key for this symbol.
fn code(connection: &RustConnection, symbol: u32) -> u8 {
    let (least, most) = (connection.setup().min_keycode, connection.setup().max_keycode);
    let map = connection.get_keyboard_mapping(least, most - least + 1).expect("sent").reply().expect("a keyboard");
    let keys = map.keysyms.chunks(map.keysyms_per_keycode.into());
    (least..=most).zip(keys).find(|(_, symbols)| symbols[0] == symbol).expect("a key").0
}

/// The X server repeats keys again after the command of a node was killed.
fn a_node_that_is_killed_leaves_the_keyboard_as_it_was() {
    let Some(display) = display::own(24) else { return };
    let run = Run { frames: 0, size: (96, 96), ..Run::new("by_time") };
    let mut command = Command::new(env!("CARGO_BIN_EXE_cupola"));
    command.args(["node", "--local", "1", "--input", "/dev/null", "--rig"]).arg(rig()).arg("--");
    let place = display::place();
    command.arg(built().join(run.program)).args(run.arguments(&place));
    command.env("CUPOLA_LIBRARY", library()).env("DISPLAY", &display.name).env("LIBGL_ALWAYS_SOFTWARE", "1");
    command.stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null());
    let mut launcher = command.spawn().expect("cupola starts");
    let (server, _) = connection(&display.name);
    server.xkb_use_extension(1, 0).expect("sent").reply().expect("the extension");
    let repeats = |wanted: bool| {
        let controls = server.xkb_get_controls(ID::USE_CORE_KBD.into()).expect("sent").reply().expect("a keyboard");
        let repeats = u32::from(controls.enabled_controls & BoolCtrl::REPEAT_KEYS) != 0;
        (repeats == wanted).then_some(())
    };
    // Control: it is switched off before.
    until("keys are not repeated", || repeats(false));
    let node = children(launcher.id(), "cupola")[0];
    let program = until("the program starts", || children(node, run.program).first().copied());
    kill("KILL", node);
    until("keys are repeated", || repeats(true));
    let _ = Command::new("sh").args(["-c", &format!("kill -s KILL {program} 2>/dev/null")]).status();
    launcher.wait().expect("it ends");
}

/// Negative control: a key is pressed on one machine only.
fn a_key_that_one_node_gets_is_named() {
    let pipe = Pipe::new();
    let Some(show) = show(2, &pipe) else { return };
    pipe.write("key w down\n");
    (0..2).for_each(|node| has_come(&show, node, "press w"));
    // After this time the X server would have repeated the key.
    std::thread::sleep(std::time::Duration::from_millis(1500));
    pipe.write("key w up\nmove 0.5 0.5\n");
    (0..2).for_each(|node| has_come(&show, node, " at 48 48"));
    show.goes_on(1, 20);
    assert_eq!(answers(&show, 0), answers(&show, 1));
    assert_eq!(answers(&show, 0).matches("press w").count(), 1, "{}", answers(&show, 0));
    assert!(!show.words().contains("draws something else"), "{}", show.words());
    let (server, _) = server_of(show.nodes[1].program);
    press(&server, code(&server, 0xff51), true);
    show.says("draws something else than the others");
}

fn a_node_that_was_stopped_gets_its_keys_in_their_frames() {
    let pipe = Pipe::new();
    let Some(show) = show(3, &pipe) else { return };
    pipe.write("key w down\n");
    (0..3).for_each(|node| has_come(&show, node, "press w"));
    // A machine stops responding: both the command and the program are stopped.
    kill("STOP", show.nodes[2].sidecar);
    kill("STOP", show.nodes[2].program);
    for lines in ["key w up\nkey Left down\n", "key Left up\nmove 0.1 0.2\n", "key Right\n"] {
        show.goes_on(0, 15);
        pipe.write(lines);
    }
    has_come(&show, 0, "release Right");
    assert!(!answers(&show, 2).contains("Left"));
    let before = show.nodes[2].newest();
    kill("CONT", show.nodes[2].sidecar);
    // If a program gets no answer when it continues, it goes on alone. So the command continues
    // first.
    until("its command goes on", || (show.nodes[2].newest() > before + 30).then_some(()));
    kill("CONT", show.nodes[2].program);
    show.says("node 2 is in step again");
    has_come(&show, 2, "release Right");
    assert_eq!(answers(&show, 2), answers(&show, 0));
    show.goes_on(2, 20);
    let words = show.words();
    assert!(!words.contains("draws something else") && !words.contains("was on its own"), "{words}");
    // Only the command is stopped. Its program continues without the events, and gets them later in
    // their order.
    kill("STOP", show.nodes[2].sidecar);
    show.says("node 2: the other nodes do not answer in time");
    for line in ["key a down\n", "key a up\n"] {
        pipe.write(line);
        (0..3).for_each(|node| show.goes_on(node, 10));
    }
    assert!(!answers(&show, 2).contains("press a"));
    kill("CONT", show.nodes[2].sidecar);
    show.says("node 2: the program was on its own, and gets what keyboard and mouse had for it after frame");
    has_come(&show, 2, "release a");
    let come = |node: usize| {
        let all = answers(&show, node);
        all.lines().map(|line| line.split_once(' ').expect("a frame").1.to_owned()).collect::<Vec<_>>()
    };
    assert_eq!(come(2), come(0));
    assert_ne!(answers(&show, 2), answers(&show, 0));
}

/// Two programs on one server would get the events of each other.
fn nodes_without_an_x_server_of_their_own_are_told() {
    let pipe = Pipe::new();
    let input = ["--size", "96x96", "--input", pipe.0.to_str().expect("a UTF-8 path")];
    let Some(show) = Show::start(2, &input, "steered", &["--answers", "answers"]) else { return };
    show.says("keyboard and mouse do not reach the program: its X server");
    show.says("each needs an X server of its own");
    pipe.write("key w down\n");
    show.goes_on(0, 20);
    let words = show.words();
    assert_eq!(words.matches("do not reach").count(), 1, "{words}");
}

/// The window of `cupola input`, on a separate server.
fn a_window_prints_what_is_done_in_it() {
    let Some(display) = display::own(24) else { return };
    let mut command = Command::new(env!("CARGO_BIN_EXE_cupola"));
    command.args(["input", "--size", "200x100", "--display", &display.name]);
    let log = scratch("window").join("lines");
    command.stdout(std::fs::File::create(&log).expect("a file")).stdin(Stdio::null());
    let mut window = command.spawn().expect("cupola starts");
    let lines = || std::fs::read_to_string(&log).expect("a file");
    let (server, root) = connection(&display.name);
    let own = until("a window opens", || {
        let children = server.query_tree(root).ok()?.reply().ok()?.children;
        let is_seen = |id: &Window| {
            let looks = server.get_window_attributes(*id).ok().and_then(|sent| sent.reply().ok());
            looks.is_some_and(|looks| looks.map_state == x11rb::protocol::xproto::MapState::VIEWABLE)
        };
        children.into_iter().find(is_seen)
    });
    let focus = |window: Window| {
        server.set_input_focus(InputFocus::POINTER_ROOT, window, x11rb::CURRENT_TIME).expect("sent").check()
    };
    focus(own).expect("focus");
    let (w, shift) = (code(&server, 0x77), code(&server, 0xffe1));
    for (key, is_down) in [(shift, true), (w, true), (w, false)] {
        press(&server, key, is_down);
    }
    server.warp_pointer(x11rb::NONE, own, 0, 0, 0, 0, 50, 25).expect("sent").check().expect("moved");
    until("the pointer comes", || lines().contains("move 0.25250 0.25500").then_some(()));
    // Keys that are held are released when another window gets the keyboard.
    focus(root).expect("focus");
    until("a key is released", || lines().contains("key Shift_L up").then_some(()));
    let keys: Vec<String> = lines().lines().filter(|line| line.starts_with("key")).map(str::to_owned).collect();
    assert_eq!(keys, ["key Shift_L down", "key w down", "key w up", "key Shift_L up"]);
    // A second window on the server would get the same events.
    let mut second = Command::new(env!("CARGO_BIN_EXE_cupola"));
    let output = second.args(["input", "--display", &display.name]).output().expect("cupola starts");
    assert!(String::from_utf8_lossy(&output.stderr).contains("on another X server"), "{output:?}");
    let _ = window.kill();
    let _ = window.wait();
}
