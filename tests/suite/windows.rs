//! Outputs in separate windows: `cupola window`.

use crate::display::{self, Compositor, Display};
use crate::finished::Finished;
use crate::harness::tests;
use crate::programs::{Run, built, library, scratch, vendor};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

tests! {
    outputs_on_two_screens_are_those_of_one_window,
    a_monitor_of_a_wayland_compositor_shows_an_output,
    patterns_are_shown_on_all_screens_until_a_key_is_pressed,
    a_window_that_is_too_small_is_told_with_the_size_that_fits,
    the_driver_gets_swap_interval_and_swap_group,
    a_driver_swaps_a_window_of_its_own,
}

/// A window of 256 × 256 pixels is divided among six projectors of 1920 × 1080. Nothing is told of
/// a size that the user has chosen, of projectors whose size the rig does not say, and of frames in
/// which the window may still grow.
fn a_window_that_is_too_small_is_told_with_the_size_that_fits() {
    let told = |finished: &Finished| finished.words().matches("gives output front 85 × 128 of its 1920 × 1080").count();
    let run = Run { frames: 30, cupola_frames: 30, ..Run::new("core330_mvp") };
    let Some(finished) = run.under("planetarium-6").map(Finished::expect_success) else { return };
    assert_eq!(told(&finished), 1, "{}", finished.words());
    assert!(finished.words().contains("--size 5760x2160"), "{}", finished.words());
    let chosen = Run { cupola: &["--size", "256x256"], ..run.clone() };
    let early = Run { frames: 10, cupola_frames: 10, ..run.clone() };
    for (run, rig) in [(chosen, "planetarium-6"), (early, "planetarium-6"), (run, "fisheye")] {
        let Some(finished) = run.under(rig).map(Finished::expect_success) else { return };
        assert!(!finished.words().contains("of its"), "{rig}: {}", finished.words());
    }
    // Vulkan's programs are told by the same words.
    let run = Run { frames: 30, extra: &["--pass", "1", "--matrix", "block"], ..Run::new("vk_cube") };
    let Some(finished) = run.vulkan_under("planetarium-6") else { return };
    assert_eq!(told(&finished), 1, "{}", finished.words());
}

const SIZE: (u32, u32) = (96, 54);

/// The preset with small projectors. With another screen the last three have no place in the
/// program's window, and the last one has a window of its own on that screen.
fn rig(other: Option<&Display>) -> PathBuf {
    let preset = cupola::rig::presets().iter().find(|preset| preset.name == "planetarium-6").expect("a preset");
    let mut number = 0;
    let line = |line: &str| {
        if !line.starts_with("size = ") {
            return format!("{line}\n");
        }
        let (x, y) = (number % 3 * SIZE.0, number / 3 * SIZE.1);
        number += 1;
        let place = match other.filter(|_| number > 3) {
            Some(other) if number == 6 => format!("display = \"{}\"", other.name),
            Some(_) => "shown = false".to_owned(),
            None => format!("window = [{x}, {y}, {}, {}]", SIZE.0, SIZE.1),
        };
        format!("size = [{}, {}]\n{place}\n", SIZE.0, SIZE.1)
    };
    let text: String = preset.text.lines().map(line).collect();
    let path = scratch("windows").join("dome.toml");
    std::fs::write(&path, text).expect("written");
    path
}

/// A process that ends with the test, and the part of the screen that it has until then.
struct Running(Child, Option<display::Place>);

impl Drop for Running {
    fn drop(&mut self) {
        // `cupola run` passes the signal on to its program.
        let _ = Command::new("sh").args(["-c", &format!("kill -s TERM {} 2>/dev/null", self.0.id())]).status();
        let _ = self.0.wait();
    }
}

fn start(program: &mut Command) -> Running {
    Running(program.stdin(Stdio::null()).stdout(Stdio::null()).spawn().expect("a program starts"), None)
}

/// Pixels at the upper left corner of a screen.
fn pixels(display: &Display) -> Vec<u8> {
    display.pixels(SIZE).into_flattened()
}

/// Command `cupola window` for an output.
fn window(output: &str, display: &Display, published: &Path) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_cupola"));
    command.args(["window", output, "--display", &display.name, "--published"]).arg(published);
    command
}

/// Starts a program that publishes its frames without an end.
fn publish(run: &Run, rig: &Path, published: &Path) -> Running {
    let mut program = Command::new(env!("CARGO_BIN_EXE_cupola"));
    program.env("CUPOLA_LIBRARY", library()).env("DISPLAY", &display::get().expect("a display").name);
    program
        .env("LIBGL_ALWAYS_SOFTWARE", "1")
        .env("CUPOLA_CACHE", Path::new(env!("CARGO_TARGET_TMPDIR")).join("results"));
    program.arg("run").arg("--rig").arg(rig).arg(format!("--publish={}", published.display())).arg("--");
    let endless = Run { frames: 0, ..run.clone() };
    let place = display::place();
    program.arg(built().join(run.program)).args(endless.arguments(&place));
    let mut running = start(&mut program);
    running.1 = Some(place);
    running
}

/// Waits until a screen shows these pixels.
fn expect_pixels(display: &Display, expected: &[u8], what: &str) {
    let begin = Instant::now();
    while pixels(display) != expected {
        assert!(begin.elapsed() < Duration::from_secs(40), "{what} is not shown");
        std::thread::sleep(Duration::from_millis(20));
    }
}

fn outputs_on_two_screens_are_those_of_one_window() {
    let run = Run { size: (288, 108), ..Run::new("immediate") };
    let Some(other) = display::own(24) else { return };
    let (whole, apart) = (rig(None), rig(Some(&other)));
    let (Some(one), Some(two)) = (run.under(&whole.to_string_lossy()), run.under(&apart.to_string_lossy())) else {
        return;
    };
    let outputs = cupola::rig::load(&whole.to_string_lossy()).expect("a rig").outputs;
    for output in &outputs[..3] {
        let file = format!("capture-{}.png", output.name);
        assert_eq!(one.picture(&file).difference(&two.picture(&file)).0, 0, "{}", output.name);
    }
    let published = scratch("published").join("ring");
    let mut program = publish(&run, &apart, &published);
    let mut seen = Vec::new();
    // The window of the last output opened by itself.
    for output in [&outputs[5], &outputs[3], &outputs[4]] {
        let file = one.directory.join(format!("capture-{}.png", output.name));
        let expected = image::open(file).expect("a picture").into_rgb8().into_raw();
        // Control: the three pictures differ.
        assert!(!seen.contains(&expected));
        let _window = (output.name != outputs[5].name).then(|| start(&mut window(&output.name, &other, &published)));
        expect_pixels(&other, &expected, &output.name);
        seen.push(expected);
    }
    // A mirror: the pixels go through a pipe, which could also lead to another machine.
    let cupola = env!("CARGO_BIN_EXE_cupola");
    let output = format!("--output {} --published {}", outputs[3].name, published.display());
    let pipe = format!("{cupola} stream - {output} 2>/dev/null | {cupola} window --stdin --display {}", other.name);
    let mirror = start(Command::new("sh").args(["-c", &pipe]));
    expect_pixels(&other, &seen[1], "the mirror");
    drop(mirror);
    // A monitor is disconnected: its window closes.
    other.add_monitor("DP-9", MONITOR, SIZE);
    let mut command = window(&outputs[4].name, &other, &published);
    let mut shown = start(command.args(["--monitor", "DP-9"]).stderr(Stdio::piped()));
    let begin = Instant::now();
    while other.pixels_at(MONITOR, SIZE).into_flattened() != seen[2] {
        assert!(begin.elapsed() < Duration::from_secs(40), "the monitor does not show its output");
        std::thread::sleep(Duration::from_millis(20));
    }
    other.remove_monitor("DP-9");
    assert!(ends(&mut shown).contains("no monitor \"DP-9\""));
    // The screen is disconnected: its window ends with an error, and the program keeps running.
    let mut shown = start(window(&outputs[3].name, &other, &published).stderr(Stdio::piped()));
    expect_pixels(&other, &seen[1], "the output");
    let other = other.restart(Duration::from_millis(300));
    assert!(ends(&mut shown).contains("the X screen"));
    let mut reader = cupola::ring::Reader::open(&published).expect("the program publishes");
    let mut frame = cupola::ring::Frame::default();
    for _ in 0..10 {
        let next = reader.next(Duration::from_secs(40), &mut frame).expect("whole");
        assert_eq!(next, cupola::ring::Next::Frame, "the program does not draw on");
    }
    // The window that the program opened comes back with its screen.
    expect_pixels(&other, &seen[0], "the output whose screen came back");
    assert!(program.0.try_wait().expect("the state of the program can be read").is_none(), "the program has ended");
}

/// The compositor is found by its name, or by the variable. Its monitor is a window of an X screen, where the test
/// reads the pixels of its corner: the picture is smaller.
fn a_monitor_of_a_wayland_compositor_shows_an_output() {
    let run = Run { size: (288, 108), ..Run::new("immediate") };
    let Some(screen) = display::own(24) else { return };
    let Some(compositor) = Compositor::start_on(&screen) else { return };
    let whole = rig(None);
    let Some(one) = run.under(&whole.to_string_lossy()) else { return };
    let outputs = cupola::rig::load(&whole.to_string_lossy()).expect("a rig").outputs;
    let published = scratch("published-wayland").join("ring");
    let _program = publish(&run, &whole, &published);
    let environment = compositor.environment();
    let window = |output: &str, monitor: &str| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_cupola"));
        command.args(["window", output, "--monitor", monitor, "--published"]).arg(&published);
        command.envs(environment.clone()).env("DISPLAY", &screen.name).stderr(Stdio::piped());
        command
    };
    let mut seen = Vec::new();
    for output in &outputs[3..5] {
        let file = one.directory.join(format!("capture-{}.png", output.name));
        let expected = image::open(file).expect("a picture").into_rgb8().into_raw();
        // Control: the pictures differ.
        assert!(!seen.contains(&expected));
        let _window = start(&mut window(&output.name, "screen0"));
        expect_pixels(&screen, &expected, &output.name);
        seen.push(expected);
    }
    let mut missing = start(&mut window(&outputs[3].name, "DP-1"));
    assert!(ends(&mut missing).contains("has no monitor \"DP-1\", but screen0"));
    let mut named = window(&outputs[3].name, "screen0");
    named.env_remove("WAYLAND_DISPLAY").args(["--display", Compositor::SOCKET]);
    let mut shown = start(&mut named);
    expect_pixels(&screen, &seen[0], "the output on the named compositor");
    drop(compositor);
    assert!(ends(&mut shown).contains("the Wayland compositor"));
}

/// Waits for the end of a process that fails, and returns its messages.
fn ends(process: &mut Running) -> String {
    let begin = Instant::now();
    let status = loop {
        if let Some(status) = process.0.try_wait().expect("its state can be read") {
            break status;
        }
        assert!(begin.elapsed() < Duration::from_secs(40), "it does not end");
        std::thread::sleep(Duration::from_millis(20));
    };
    let mut words = String::new();
    std::io::Read::read_to_string(process.0.stderr.as_mut().expect("a pipe"), &mut words).expect("text");
    assert!(!status.success(), "{status}: {words}");
    words
}

/// Corner of a monitor in the middle of a screen.
const MONITOR: (u16, u16) = (200, 100);

/// Three projectors share the window, one has the corner of another screen, one a monitor of that screen, and
/// one is not shown.
fn patterns_are_shown_on_all_screens_until_a_key_is_pressed() {
    let (Some(first), Some(other)) = (display::own(24), display::own(24)) else { return };
    other.add_monitor("DP-7", MONITOR, SIZE);
    let rig = rig(Some(&other));
    let text = std::fs::read_to_string(&rig).expect("a rig");
    let own = format!("display = \"{}\"\nmonitor = \"DP-7\"", other.name);
    std::fs::write(&rig, text.replacen("shown = false", &own, 1)).expect("written");
    let loaded = cupola::rig::load(&rig.to_string_lossy()).expect("a rig");
    let outputs = &loaded.with_all_outputs().outputs;
    let folder = scratch("patterns");
    let mut command = Command::new(env!("CARGO_BIN_EXE_cupola"));
    command.env("DISPLAY", &first.name).arg("pattern").arg(&rig).arg("--show").arg("-o").arg(&folder);
    let mut shown = start(command.stderr(Stdio::piped()));
    let picture = |name: &str| image::open(folder.join(name)).expect("a picture").into_rgb8();
    let file = |output: usize| format!("{}.png", outputs[output].name);
    let is_shown = || {
        folder.join("window.png").exists()
            && first.pixels((3 * SIZE.0, SIZE.1)).into_flattened() == picture("window.png").into_raw()
            && pixels(&other) == picture(&file(5)).into_raw()
            && other.pixels_at(MONITOR, SIZE).into_flattened() == picture(&file(3)).into_raw()
    };
    let wait = |what: &str| {
        let begin = Instant::now();
        while !is_shown() {
            assert!(begin.elapsed() < Duration::from_secs(40), "{what}");
            std::thread::sleep(Duration::from_millis(50));
        }
    };
    wait("the patterns are not shown");
    other.cover((0, 0), SIZE);
    wait("what another window has covered is not shown again");
    // Control: pictures of projectors differ, and the output that is not shown has a picture in its file only.
    assert_ne!(picture(&file(5)), picture(&file(3)));
    assert_eq!(picture(&file(4)).dimensions(), SIZE);
    assert!(shown.0.try_wait().expect("its state can be read").is_none(), "it ended without a key");
    other.press_key();
    let begin = Instant::now();
    let status = loop {
        if let Some(status) = shown.0.try_wait().expect("its state can be read") {
            break status;
        }
        assert!(begin.elapsed() < Duration::from_secs(40), "a key does not close the patterns");
        std::thread::sleep(Duration::from_millis(20));
    };
    let mut words = String::new();
    std::io::Read::read_to_string(shown.0.stderr.as_mut().expect("a pipe"), &mut words).expect("text");
    assert!(status.success(), "{status}: {words}");
    assert!(words.contains(&format!("{} is not shown", outputs[4].name)), "{words}");
}

/// The driver gets the rig's swap interval and swap group once for the window, and a refusal is
/// told.
fn the_driver_gets_swap_interval_and_swap_group() {
    let Some(folder) = vendor() else { return };
    let preset = cupola::rig::presets().iter().find(|preset| preset.name == "identity-captured").expect("a preset");
    let run = |keys: &str, fault: &str| {
        let path = scratch("swaps").join("rig.toml");
        std::fs::write(&path, format!("{}\n[window]\n{keys}\n", preset.text)).expect("written");
        let environment = [("LD_LIBRARY_PATH", folder), ("CUPOLA_GLX_REAL", "calls"), ("CALLS_FAULT", fault)];
        let run = Run { frames: 4, cupola_frames: 1000, environment: &environment, ..Run::new("core330_mvp") };
        let finished = run.under(path.to_str().expect("Unicode"))?.expect_success();
        Some(finished.words().into_owned())
    };
    let Some(words) = run("swap_interval = 2\nswap_group = 3\nswap_barrier = 4", "swaps 1") else { return };
    for line in ["swap interval 2", "swap group 3", "swap group 3 at barrier 4"] {
        assert_eq!(words.lines().filter(|told| *told == line).count(), 1, "{line}: {words}");
    }
    assert!(words.contains("the window has joined swap group 3 and barrier 4"), "{words}");
    // Controls: a rig without these keys, a driver that refuses, and one that has no swap groups.
    let without = run("", "swaps 1").expect("a display");
    assert!(!without.contains("swap"), "{without}");
    for fault in ["swaps 0", "none 0"] {
        let refused = run("swap_group = 3\nswap_barrier = 4", fault).expect("a display");
        assert!(refused.contains("does not let the window join group 3"), "{fault}: {refused}");
        assert!(!refused.contains("at barrier"), "{fault}: {refused}");
    }
}

/// With a swap interval and a swap group, a driver shows the pictures of `cupola window`, byte for
/// byte, and gets both on the thread that swaps. A driver that refuses shows them as well.
fn a_driver_swaps_a_window_of_its_own() {
    let (Some(folder), Some(other)) = (vendor(), display::own(24)) else { return };
    let run = Run { size: (288, 108), ..Run::new("immediate") };
    let (whole, apart) = (rig(None), rig(Some(&other)));
    let Some(one) = run.under(&whole.to_string_lossy()) else { return };
    let outputs = cupola::rig::load(&whole.to_string_lossy()).expect("a rig").outputs;
    let published = scratch("swapped").join("ring");
    let _program = publish(&run, &apart, &published);
    let picture = |output: &cupola::rig::Output| {
        let file = one.directory.join(format!("capture-{}.png", output.name));
        image::open(file).expect("a picture").into_rgb8().into_raw()
    };
    let mut seen = Vec::new();
    // The window of the last output opens by itself at the same place, before the others, which lie
    // above it then.
    expect_pixels(&other, &picture(&outputs[5]), &outputs[5].name);
    for (output, fault, refuses) in [(&outputs[3], "swaps 1", false), (&outputs[4], "swaps 0", true)] {
        let mut command = window(&output.name, &other, &published);
        command.args(["--swap-interval", "0", "--swap-group", "3", "--swap-barrier", "4"]);
        let variables = [("LD_LIBRARY_PATH", folder), ("__GLX_VENDOR_LIBRARY_NAME", "calls"), ("CALLS_FAULT", fault)];
        let mut shown = start(command.envs(variables).stderr(Stdio::piped()));
        let expected = picture(output);
        assert!(!seen.contains(&expected), "control: the pictures differ");
        expect_pixels(&other, &expected, &output.name);
        seen.push(expected);
        crate::nodes::kill("KILL", shown.0.id());
        shown.0.wait().expect("it ends");
        let mut words = String::new();
        std::io::Read::read_to_string(shown.0.stderr.as_mut().expect("a pipe"), &mut words).expect("text");
        for (line, comes) in
            [("swap interval 0", true), ("swap group 3", true), ("swap group 3 at barrier 4", !refuses)]
        {
            assert_eq!(words.lines().filter(|told| *told == line).count(), usize::from(comes), "{line}: {words}");
        }
        assert_eq!(words.contains("does not let the window join swap group 3"), refuses, "{words}");
    }
}
