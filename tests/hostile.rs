//! Hostile files: each is refused with its reason, within limits of memory and time.

use std::os::unix::fs::symlink;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Address space of the command in KiB, with the stacks of its threads.
const MEMORY: u64 = 1 << 20;
/// Time limit of the command in seconds.
const TIME: u64 = 20;

/// Runs the command within the limits and checks that it refuses its arguments with the message
/// `why`.
#[track_caller]
fn refused(arguments: &[&str], why: &str) {
    let script = format!("ulimit -v {MEMORY}; exec timeout {TIME} \"$@\"");
    let run = Command::new("sh")
        .args(["-c", &script, "sh", env!("CARGO_BIN_EXE_cupola")])
        .args(arguments)
        .output()
        .expect("a shell");
    let said = String::from_utf8_lossy(&run.stderr);
    let start: String = said.chars().take(2000).collect();
    assert!(matches!(run.status.code(), Some(1 | 2)), "{:?}: {start}", run.status);
    assert!(said.contains(why) && said.len() < 20_000, "not {why:?}, but: {start}");
}

/// Path in a folder that only these tests use.
fn file(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("hostile");
    std::fs::create_dir_all(&folder).expect("a folder");
    folder.join(name)
}

/// Writes a file with this content.
fn written(name: &str, content: impl AsRef<[u8]>) -> PathBuf {
    let path = file(name);
    std::fs::write(&path, content).expect("written");
    path
}

fn text(path: &Path) -> &str {
    path.to_str().expect("a path that is text")
}

/// Checks that `cupola check` refuses this rig.
#[track_caller]
fn rig_refused(name: &str, content: impl AsRef<[u8]>, why: &str) {
    refused(&["check", text(&written(name, content))], why);
}

/// Checks that `cupola convert` refuses this file and writes no rig.
#[track_caller]
fn file_refused(name: &str, content: impl AsRef<[u8]>, why: &str) {
    let (from, to) = (written(name, content), file(&format!("{name}.toml")));
    refused(&["convert", text(&from), text(&to)], why);
    assert!(!to.exists());
}

#[test]
fn rigs_with_too_much() {
    let outputs = "[[output]]\nkind = \"mesh\"\nfile = \"/dev/zero\"\n".repeat(20_000);
    rig_refused("outputs.toml", &outputs, "at most 64 outputs, not 20000");
    rig_refused("long.toml", outputs.repeat(2), "is longer than 1048576 bytes");
    refused(&["check", "/dev/zero"], "is longer than 1048576 bytes");
    rig_refused("keys.toml", format!("{} = 1", ["a"; 300_000].join(".")), "keys.toml:1");
    rig_refused("lists.toml", format!("a = {}", "[".repeat(500_000)), "lists.toml:1");
    rig_refused("names.toml", (0..50_000).map(|i| format!("viewe{i} = 1\n")).collect::<String>(), "more problems");
    rig_refused("numbers.toml", "[dome]\nradius = nan\n[[output]]\nkind=\"domemaster\"\n", "NaN is no number");
}

#[test]
fn rigs_that_name_what_is_no_file() {
    let pipe = file("pipe");
    drop(std::fs::remove_file(&pipe));
    assert!(Command::new("mkfifo").arg(&pipe).status().expect("mkfifo").success());
    let output = |key: &str| format!("[[output]]\nkind = \"domemaster\"\n{key}\n");
    for name in ["pipe", "/dev/zero", "."] {
        let why = "is no file";
        rig_refused("mask.toml", output(&format!("mask = {{ image = \"{name}\" }}")), "no file");
        rig_refused("black.toml", output(&format!("black = {{ image = \"{name}\" }}")), why);
        rig_refused("response.toml", output(&format!("blend = {{ transfer = {{ file = \"{name}\" }} }}")), why);
        rig_refused("screen.toml", format!("[screen]\nshape = \"mesh\"\nfile = \"{name}\"\n{}", output("")), why);
    }
    let link = file("pipe.pfm");
    drop(std::fs::remove_file(&link));
    symlink(&pipe, &link).expect("a link");
    rig_refused("mesh.toml", "[[output]]\nkind = \"mesh\"\nfile = \"pipe.pfm\"\n", "is no file");
}

#[test]
fn headers_that_promise_too_much() {
    file_refused("sizes.pfm", "PF\n4294967295 4294967295\n-1.0\n", "expected 1 to 67108864 pixels");
    file_refused("bytes.pfm", "PF\n8192 8192\n-1.0\n", "says 8192 × 8192 pixels");
    let mut vwf = b"vwf1".to_vec();
    [u32::MAX, 16, 0].iter().for_each(|number| vwf.extend(number.to_le_bytes()));
    file_refused("blocks.vwf", &vwf, "expected at most 1024");
    file_refused("nodes.data", "2\n16384 16384\n0 0 0 0 1\n", "ends after line 3");
    file_refused("nodes.ol", "OPENMESH Version 1.1\nVERTICES 99999999999\n", "does not fit");
    file_refused("nodes.csv", "0;0;0;0;16384;16384\n", "16385 columns and 16385 rows");
}

#[test]
fn lines_and_words_without_end() {
    let long = "1 ".repeat(4 << 20);
    for name in ["line.data", "line.ol", "line.csv"] {
        file_refused(name, &long, "is longer than 65536 bytes");
    }
    file_refused("keys.ol", format!("OPENMESH Version 1.1\n{}", "SOMETHING 1\n".repeat(1 << 20)), "one unknown key");
    let screen = |model: &str| {
        written("model.obj", model);
        "[screen]\nshape = \"mesh\"\nfile = \"model.obj\"\n[[output]]\nkind = \"domemaster\"\n".to_owned()
    };
    rig_refused("face.toml", screen(&format!("v 0 0 0\nf {}", "1 ".repeat(8 << 20))), "is longer than 65536 bytes");
    rig_refused("corners.toml", screen(&"v 0 0 0\n".repeat(13 << 20)), "corners; expected a coarser model");
}

#[test]
fn documents_that_are_deep_wide_or_long() {
    let document = |inner: &str| format!("<MPCDI profile=\"a3\" version=\"1.0\"><display>{inner}</display></MPCDI>");
    let many = |item: &dyn Fn(usize) -> String, count| (0..count).map(item).collect::<String>();
    let attributes = many(&|i| format!(" a{i}=\"\""), 200_000);
    file_refused("attributes.xml", document(&format!("<a{attributes}/>")), "too many attributes");
    let spaces = many(&|i| format!("<a xmlns:n{i}=\"{i}\">"), 50_000);
    file_refused("namespaces.xml", document(&spaces), "too many namespaces");
    file_refused("deep.xml", document(&"<a>".repeat(400_000)), "is not XML");
    let regions = "<region id=\"a\" Xresolution=\"1\" Yresolution=\"1\"/>".repeat(20_000);
    file_refused("regions.xml", document(&regions), "expected 1 to 256");
    file_refused("long.xml", document(&" ".repeat(5 << 20)), "expected at most 4194304");
    file_refused("entities.xml", format!("<!DOCTYPE a [<!ENTITY b \"b\">]>{}", document("")), "is not XML");
    file_refused("deep.json", "[".repeat(1 << 20), "this is no JSON");
    file_refused("long.json", " ".repeat(17 << 20), "is longer than 16777216 bytes");
}

/// A configuration with these windows.
fn configuration(windows: &[String]) -> String {
    format!("{{ \"nodes\": [{{ \"address\": \"a\", \"windows\": [{}] }}] }}", windows.join(","))
}

fn window(side: u32, viewports: &[&str]) -> String {
    format!("{{ \"size\": {{ \"x\": {side}, \"y\": {side} }}, \"viewports\": [{}] }}", viewports.join(","))
}

fn mirror(mesh: &str) -> String {
    let meshes = ["bottom", "left", "right", "top"].map(|face| format!("\"{face}\": \"{mesh}\"")).join(",");
    format!("{{ \"projection\": {{ \"type\": \"SphericalMirrorProjection\", \"mesh\": {{ {meshes} }} }} }}")
}

#[test]
fn configurations_with_too_many_or_too_large_viewports() {
    let fisheye = "{ \"projection\": { \"type\": \"FisheyeProjection\" } }";
    let windows: Vec<String> = (0..64).map(|_| window(100, &[fisheye; 64])).collect();
    file_refused("viewports.json", configuration(&windows), "one viewport too many");
    file_refused(
        "large.json",
        configuration(&[window(1_000_000, &[&mirror("a.data")])]),
        "has a place that no screen has",
    );
    let windows: Vec<String> = (0..2).map(|_| window(16384, &[fisheye])).collect();
    file_refused("pixels.json", configuration(&windows), "one viewport too many");
}

#[test]
fn configurations_that_name_files_elsewhere() {
    let outside = std::env::temp_dir().join(format!("cupola-outside-{}.data", std::process::id()));
    std::fs::write(&outside, "2\n2 2\n0 0 0 0 1\n1 0 1 0 1\n0 1 0 1 1\n1 1 1 1 1\n").expect("written");
    let link = file("linked.data");
    drop(std::fs::remove_file(&link));
    symlink(&outside, &link).expect("a link");
    for name in [text(&outside), "../secret.data", "a/../../secret.data"] {
        file_refused("elsewhere.json", configuration(&[window(8, &[&mirror(name)])]), "leads out of");
    }
    file_refused(
        "elsewhere.json",
        configuration(&[window(8, &[&mirror("linked.data")])]),
        "is a link that leads out of",
    );
    std::fs::remove_file(&outside).expect("removed");
}

#[test]
fn links_are_not_written_through() {
    let folder = file("links");
    drop(std::fs::remove_dir_all(&folder));
    std::fs::create_dir_all(&folder).expect("a folder");
    let victim = written("victim", "kept");
    for (name, arguments) in [
        ("map.pfm", &["convert", "fisheye", "--size", "8x8", "--values", "directions"][..]),
        ("rig.toml", &["convert", "planetarium-2", "--size", "8x8"]),
        ("map.pfm", &["map", "fisheye", "--exact", "--size", "8x8", "--out"]),
    ] {
        let link = folder.join(name);
        symlink(&victim, &link).expect("a link");
        refused(&[arguments, &[text(&link)]].concat(), "is a link");
        std::fs::remove_file(&link).expect("removed");
    }
    // Names that are derived from the given name.
    let beside = folder.join("rig-left.pfm");
    symlink(&victim, &beside).expect("a link");
    let outputs = ["left", "right"].map(|name| format!("[[output]]\nkind = \"domemaster\"\nname = \"{name}\"\n"));
    let rig = written("two.toml", outputs.concat());
    refused(&["convert", text(&rig), text(&folder.join("rig.pfm")), "--size", "8x8"], "is a link");
    assert_eq!(std::fs::read(&victim).expect("a file"), b"kept");
}

#[test]
fn rigs_in_named_pipes_are_refused_and_other_pipes_are_read() {
    let (pipe, out) = (file("rig.fifo"), file("rig-of-a-pipe.mpcdi"));
    drop(std::fs::remove_file(&pipe));
    assert!(Command::new("mkfifo").arg(&pipe).status().expect("mkfifo").success());
    // Nobody writes to the pipe: a command that opened it would wait until its time is over.
    let (name, why) = (text(&pipe), "it is a named pipe");
    refused(&["check", name], why);
    refused(&["check", name, "--print"], why);
    refused(&["plan", name], why);
    refused(&["tune", name, "viewer.yaw=1"], why);
    refused(&["convert", name, text(&out)], why);
    refused(&["map", name, "-o", "map.pfm"], why);
    refused(&["simulate", name, "--white", "-o", "dome.png"], why);
    refused(&["run", "--rig", name, "true"], why);
    // Pipes of the shell are links in /dev/fd.
    for script in
        ["\"$0\" check fisheye --print | \"$0\" check /dev/stdin", "\"$0\" check <(\"$0\" check fisheye --print)"]
    {
        let arguments = ["-c", script, env!("CARGO_BIN_EXE_cupola")];
        let output = Command::new("timeout").args(["20", "bash"]).args(arguments).output().expect("a shell");
        let said = String::from_utf8_lossy(&output.stdout);
        assert!(output.status.success() && said.contains("is a valid rig"), "{script}: {output:?}");
    }
}
