//! Random Vulkan commands: Vulkan answers as without Cupola, and the validation layer between
//! Cupola and the driver writes no message. `cupola-lab calls --vulkan` makes and compares the
//! commands.

use crate::display;
use crate::harness::{note, tests};
use crate::programs::{library, scratch, vulkan_apps};
use crate::vulkan_faults::layers;
use std::path::{Path, PathBuf};
use std::process::Command;

tests! {
    random_vulkan_commands_have_the_same_answers,
    what_vulkan_commands_found_before_has_the_same_answers,
    a_vulkan_command_that_is_lost_is_found,
}

/// Compares the answers without Cupola and with it. Returns whether the laboratory succeeded, and
/// its output. `None` if that is not possible.
fn compare(folder: &Path, arguments: &[&str]) -> Option<(bool, String)> {
    display::get()?;
    let mut command = Command::new(env!("CARGO_BIN_EXE_cupola-lab"));
    command.env("CUPOLA_LIBRARY", library()).args(["calls", "--vulkan", "--keep", "--player"]);
    command.arg(vulkan_apps()?.join("vk_player")).arg("--folder").arg(folder).args(arguments);
    let output = command.output().expect("the laboratory can be started");
    let words = String::from_utf8_lossy(&output.stdout).into_owned() + &String::from_utf8_lossy(&output.stderr);
    Some((output.status.success(), words))
}

fn expect_same(arguments: &[&str]) {
    let Some((same, words)) = compare(&scratch("vulkan-calls"), arguments) else { return };
    assert!(same, "{words}");
    let calls = words.lines().find_map(|line| line.split_once(" calls in ")?.0.parse::<usize>().ok());
    note(format_args!("{} commands", calls.unwrap_or(0)));
    assert!(calls.is_some_and(|calls| calls > 0), "{words}");
}

fn list(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/calls/vulkan").join(name)
}

fn random_vulkan_commands_have_the_same_answers() {
    expect_same(&["--rig", "identity", "--episodes", "1", "--calls", "200"]);
    expect_same(&["--followed", "--seed", "100", "--episodes", "2", "--calls", "150"]);
}

fn what_vulkan_commands_found_before_has_the_same_answers() {
    let files = std::fs::read_dir(list("")).expect("the lists of commands");
    let files = files.filter_map(|entry| Some(entry.ok()?.path().to_str()?.to_owned()));
    let mut files: Vec<_> = files.filter(|path| path.ends_with(".calls")).collect();
    files.sort();
    assert!(!files.is_empty());
    let arguments: Vec<&str> = ["--replay"].into_iter().chain(files.iter().map(String::as_str)).collect();
    expect_same(&arguments);
}

/// Negative control: one command between Cupola and the driver is lost in each run. It is a draw of
/// the program or a command that Cupola records.
fn a_vulkan_command_that_is_lost_is_found() {
    let (folder, file) = (scratch("vulkan-calls"), list("scene.calls"));
    let Some([above, below]) = layers() else { return };
    let path = format!("VK_ADD_LAYER_PATH={above}:{}/cupola/lib:{below}", folder.display());
    let layers = "VK_INSTANCE_LAYERS=VK_LAYER_TEST_above:VK_LAYER_CUPOLA_dome:VK_LAYER_TEST_below";
    let mut arguments = vec!["--validation", "off", "--set", &path, "--set", layers, "--replay"];
    arguments.push(file.to_str().expect("a UTF-8 path"));
    let Some((same, words)) = compare(&folder, &arguments) else { return };
    assert!(same, "without a fault: {words}");
    let faults = CONTROLS.map(|fault| format!("FAULTS={fault} 0"));
    for fault in &faults {
        arguments.extend(["--in-turn", fault]);
    }
    let Some((_, words)) = compare(&folder, &arguments) else { return };
    for fault in &faults {
        assert!(words.lines().any(|line| line == format!("different with {fault}")), "{fault} is not found:\n{words}");
    }
}

/// Function and number of the call that is lost.
const CONTROLS: [&str; 5] = [
    "program vkCmdDraw 1 1",
    "program vkCmdCopyImageToBuffer 1 1",
    "call vkCmdDrawIndexed 1 1",
    "call vkCmdBindDescriptorSets 1 1",
    "call vkCmdSetViewport 3 3",
];
