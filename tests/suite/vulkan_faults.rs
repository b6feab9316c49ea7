//! Faults of the Vulkan driver: whatever the driver refuses or lacks, the program keeps running and
//! shows its own picture.
//!
//! Two layers (`tests/apps/layers`), above and below Cupola, distinguish Cupola's calls from the
//! program's and have one fault in each run. The rig does not change the picture, so the window
//! must show the same as without Cupola. The validation layer below reports objects that were not
//! destroyed, or that were used although their creation was refused. `CUPOLA_ALL_FAULTS=1` tries
//! each fault in each way of drawing instead of a sample.

use crate::display;
use crate::harness::{note, tests};
use crate::picture::Picture;
use crate::programs::{Finished, Run, library, scratch, vulkan_apps};
use std::collections::{BTreeMap, BTreeSet};
use std::process::Command;
use std::sync::OnceLock;

tests! {
    calls_that_are_refused,
    functions_that_are_missing,
    answers_that_are_absurd,
    swapchains_that_are_out_of_date,
    a_fault_of_the_program_s_own_calls_is_seen,
    swapchains_have_the_rig_s_swap_interval,
    windows_join_a_present_barrier,
}

const RIG: &str = "identity-captured";

/// Programs that use different parts of Cupola. The sample of faults uses the first.
const WAYS: [(&str, &[&str]); 7] = [
    ("vk_cube", &["--follow", "--pass", "1", "--matrix", "push"]),
    ("vk_cube", &["--follow", "--pass", "dynamic", "--matrix", "block", "--samples", "4", "--once"]),
    ("vk_cube", &["--follow", "--pass", "imageless", "--matrix", "dynamic", "--secondary"]),
    ("vk_cube", &["--follow", "--pass", "2", "--matrix", "copied", "--srgb"]),
    ("vk_scenes", &["--way", "post"]),
    ("vk_queries", &[]),
    ("vk_writes", &[]),
];

type Way = (&'static str, &'static [&'static str]);

/// Results of a run of a program.
struct Outcome {
    succeeded: bool,
    window: Option<Picture>,
    /// Number of calls of each function by Cupola and by the program.
    calls: BTreeMap<String, (u64, u64)>,
    /// Lines that Cupola wrote to the log.
    words: Vec<String>,
    /// Present modes of the swapchains, if the fault is `told`.
    modes: BTreeSet<String>,
    /// What reached the driver of a present barrier, if the fault is `barrier`.
    barriers: Vec<String>,
    /// Kinds of messages of the validation layer.
    messages: BTreeSet<String>,
}

/// Greatest number of lines in the log after a fault that happens once.
const ONCE: usize = 1;

/// Greatest number of lines if a fault lasts: each part of Cupola that gives up writes one. First
/// the picture is flat, then it is the program's own, then frames are lost.
const ALWAYS: usize = 3;

/// Message of the validation layer if an image is presented without having been drawn to.
const NOTHING_DRAWN: &str = "VUID-VkPresentInfoKHR-pImageIndices-01296";

impl Outcome {
    /// Lists what is wrong. `most` is the greatest number of lines in the log.
    fn faults(&self, right: &Picture, most: usize) -> Vec<String> {
        let loses = most == ALWAYS && self.words.iter().any(|line| line.contains("frames are lost"));
        let messages: Vec<_> = self.messages.iter().filter(|kind| !(loses && *kind == NOTHING_DRAWN)).collect();
        let own = self.window.as_ref().is_some_and(|window| {
            let (_, worst) = window.difference(right);
            worst <= 1
        });
        let faults = [
            (!self.succeeded, "the program fails".to_owned()),
            (!own, "the window does not show the program's picture".to_owned()),
            (self.words.len() > most, format!("{} lines in the log", self.words.len())),
            (!messages.is_empty(), format!("messages: {messages:?}")),
        ];
        faults.into_iter().filter_map(|(is, what)| is.then_some(what)).collect()
    }
}

/// Folders with the descriptions of the layers above and below Cupola. There are two, because the
/// loader orders layers by the order in which it finds them.
pub fn layers() -> Option<&'static [String; 2]> {
    static FOLDERS: OnceLock<[String; 2]> = OnceLock::new();
    if !cfg!(target_arch = "x86_64") {
        return None;
    }
    let library = vulkan_apps()?.join("libfaults.so");
    Some(FOLDERS.get_or_init(|| {
        ["above", "below"].map(|name| {
            let folder = scratch(name);
            let description = serde_json::json!({ "file_format_version": "1.1.2", "layer": {
                "name": format!("VK_LAYER_TEST_{name}"), "type": "GLOBAL", "library_path": library,
                "api_version": "1.3.239", "implementation_version": "1", "description": "tests/apps/layers",
                "functions": { "vkNegotiateLoaderLayerInterfaceVersion": format!("{name}_negotiate") },
            }});
            std::fs::write(folder.join("layer.json"), description.to_string()).expect("a file can be written");
            folder.display().to_string()
        })
    }))
}

/// Runs a program with a fault, with a rig or without Cupola. `None` if that is not possible.
fn run((program, extra): Way, rig: Option<&str>, fault: &str) -> Option<Outcome> {
    let [above, below] = layers()?;
    let extra = [extra, &["--shot", "window.ppm"]].concat();
    // Two frames more than the frames whose calls are refused, because frames may be lost until
    // Cupola gives up.
    let frames = if fault.is_empty() { 4 } else { 6 };
    let run = Run { size: (96, 96), frames, extra: &extra, ..Run::new(program) };
    let path = format!("VK_ADD_LAYER_PATH={above}:$VK_ADD_LAYER_PATH:{below} exec \"$@\"");
    let inner = ["sh", "-c", &path, "sh"];
    let mut command = match rig {
        Some(rig) => {
            let mut command = Command::new(env!("CARGO_BIN_EXE_cupola"));
            command.env("CUPOLA_LIBRARY", library()).args(["run", "--rig", rig, "--"]).args(inner);
            command
        }
        None => {
            let mut command = Command::new(inner[0]);
            command.args(&inner[1..]);
            command
        }
    };
    let layers = "VK_LAYER_TEST_above:VK_LAYER_TEST_below:VK_LAYER_KHRONOS_validation";
    command.env("VK_INSTANCE_LAYERS", layers).env("FAULTS", fault).env("FAULTS_REPORT", "calls.txt");
    let place = display::place();
    command.arg(vulkan_apps()?.join(program)).args(run.arguments(&place));
    let finished = Finished::of(command, program, fault)?;
    let number = |text: Option<&str>| text.and_then(|text| text.parse().ok()).unwrap_or(0);
    let line = |line: &str| {
        let mut words = line.split(' ');
        let name = words.next().unwrap_or_default().to_owned();
        (name, (number(words.next()), number(words.next())))
    };
    let calls = if finished.wrote("calls.txt") { finished.text("calls.txt") } else { String::new() };
    Some(Outcome {
        succeeded: finished.succeeded(),
        window: finished.wrote("window.ppm").then(|| finished.picture("window.ppm")),
        calls: calls.lines().map(line).collect(),
        words: finished.words().lines().filter(|line| line.starts_with("cupola: ")).map(str::to_owned).collect(),
        modes: lines_after(&finished, "present mode ").into_iter().collect(),
        barriers: lines_after(&finished, "barrier: "),
        messages: finished.kinds_of_messages(),
    })
}

/// What follows `start` in the lines of a program that begin so.
fn lines_after(finished: &Finished, start: &str) -> Vec<String> {
    finished.words().lines().filter_map(|line| Some(line.strip_prefix(start)?.to_owned())).collect()
}

/// Calls of the program without Cupola, calls of both with Cupola, and the right picture.
fn without_a_fault(way: Way) -> Option<(Outcome, Outcome, Picture)> {
    let (plain, ours) = (run(way, None, "")?, run(way, Some(RIG), "")?);
    let right = plain.window.clone().expect("the program writes its picture");
    assert!(plain.succeeded, "{way:?} without Cupola");
    let faults = ours.faults(&right, 0);
    assert!(faults.is_empty(), "{way:?} without a fault: {faults:?} {:?}", ours.words);
    // Control: the layers are above and below Cupola.
    assert!(ours.calls.values().filter(|(own, _)| *own > 0).count() > 40, "{:?}", ours.calls);
    assert_eq!(ours.calls.get("vkQueuePresentKHR"), Some(&(0, 4)), "{:?}", ours.calls);
    Some((plain, ours, right))
}

fn tries_all() -> bool {
    std::env::var_os("CUPOLA_ALL_FAULTS").is_some()
}

fn ways() -> impl Iterator<Item = Way> {
    WAYS.into_iter().take(if tries_all() { WAYS.len() } else { 1 })
}

/// Tries all faults or a sample of them, and panics with a list of those after which something is
/// wrong. `most` is as in [`Outcome::faults`].
fn expect_the_own_picture(way: Way, faults: &[String], sample: usize, most: usize, right: &Picture) {
    let step = if tries_all() { 1 } else { faults.len().div_ceil(sample) };
    let mut wrong = Vec::new();
    let mut tried = 0;
    for fault in faults.iter().step_by(step.max(1)) {
        let Some(outcome) = run(way, Some(RIG), fault) else { return };
        tried += 1;
        let found = outcome.faults(right, most);
        if !found.is_empty() {
            wrong.push(format!("{fault}: {}; {:?}", found.join("; "), outcome.words));
        }
    }
    note(format_args!("{way:?}: {tried} of {} faults were tried", faults.len()));
    assert!(wrong.is_empty(), "{way:?}: {} of {tried} faults:\n{}", wrong.len(), wrong.join("\n"));
}

/// Error that a function returns if it refuses. `None` if it cannot refuse.
fn refusal(function: &str) -> Option<i32> {
    // The first entry with which the function's name begins is used. The results are
    // VK_ERROR_OUT_OF_HOST_MEMORY, _OUT_OF_DEVICE_MEMORY, _INITIALIZATION_FAILED, _DEVICE_LOST,
    // _MEMORY_MAP_FAILED, _OUT_OF_POOL_MEMORY and _SURFACE_LOST_KHR.
    const REFUSALS: [(&str, i32); 14] = [
        ("vkCreateGraphicsPipelines", -3),
        ("vkCreateShaderModule", -1),
        ("vkCreate", -2),
        ("vkAllocateMemory", -2),
        ("vkAllocateDescriptorSets", -1_000_069_000),
        ("vkAllocate", -1),
        ("vkBind", -2),
        ("vkMapMemory", -5),
        ("vkQueueSubmit", -4),
        ("vkWaitForFences", -4),
        ("vkResetFences", -2),
        ("vkBeginCommandBuffer", -1),
        ("vkEndCommandBuffer", -2),
        ("vkGetSwapchainImagesKHR", -1),
    ];
    if ["vkGetPhysicalDeviceSurfaceCapabilitiesKHR"].contains(&function) {
        return Some(-1_000_000_000);
    }
    REFUSALS.iter().find(|(start, _)| function.starts_with(start)).map(|(_, result)| *result)
}

fn calls_that_are_refused() {
    for way in ways() {
        let Some((_, ours, right)) = without_a_fault(way) else { return };
        let refused = || ours.calls.iter().filter_map(|(name, (own, _))| Some((name, *own, refusal(name)?)));
        let once: Vec<_> = refused()
            .flat_map(|(name, own, result)| (1..=own).map(move |call| format!("call {name} {call} {call} {result}")))
            .collect();
        expect_the_own_picture(way, &once, 16, ONCE, &right);
        let always: Vec<_> = refused()
            .filter(|(_, own, _)| *own > 0)
            .map(|(name, _, result)| format!("call {name} 1 {} {result}", u32::MAX))
            .collect();
        expect_the_own_picture(way, &always, 6, ALWAYS, &right);
    }
}

fn functions_that_are_missing() {
    for way in ways() {
        let Some((plain, ours, right)) = without_a_fault(way) else { return };
        let own = ours.calls.iter().filter(|(name, (own, _))| *own > 0 && !plain.calls.contains_key(*name));
        // The layers cannot tell functions that an instance lacks from those that a device lacks.
        let own = own.filter(|(name, _)| !name.starts_with("vkGetPhysicalDevice"));
        let faults: Vec<_> = own.map(|(name, _)| format!("missing {name}")).collect();
        assert!(faults.len() > 4, "{faults:?}");
        expect_the_own_picture(way, &faults, 4, ONCE, &right);
    }
}

fn answers_that_are_absurd() {
    let mut faults = Vec::new();
    const LIMITS: [&str; 13] = [
        "maxImageDimension2D",
        "maxFramebufferWidth",
        "maxFramebufferHeight",
        "maxBoundDescriptorSets",
        "maxPushConstantsSize",
        "maxUniformBufferRange",
        "maxMemoryAllocationCount",
        "maxDescriptorSetUniformBuffersDynamic",
        "minUniformBufferOffsetAlignment",
        "nonCoherentAtomSize",
        "timestampPeriod",
        "apiVersion",
        "deviceName",
    ];
    for limit in LIMITS {
        faults.extend([0, 1, 64, -1, i64::from(i32::MAX)].map(|value| format!("limit {limit} {value}")));
    }
    for kind in ["memory", "queues", "formats", "surface"] {
        faults.extend([0, 1, 2, 16].map(|flags| format!("{kind} {flags}")));
    }
    faults.push("features 0".to_owned());
    for way in ways() {
        let Some((_, _, right)) = without_a_fault(way) else { return };
        expect_the_own_picture(way, &faults, 12, ALWAYS, &right);
    }
}

/// `VK_SUBOPTIMAL_KHR` and `VK_ERROR_OUT_OF_DATE_KHR` reach the program, which then makes a new
/// swapchain.
fn swapchains_that_are_out_of_date() {
    for way in ways() {
        let Some((_, _, right)) = without_a_fault(way) else { return };
        for result in [1_000_001_003, -1_000_001_004] {
            let fault = format!("program vkQueuePresentKHR 1 2 {result}");
            let Some(outcome) = run(way, Some(RIG), &fault) else { return };
            let found = outcome.faults(&right, 0);
            assert!(found.is_empty(), "{way:?}: {fault}: {found:?} {:?}", outcome.words);
        }
    }
}

/// Negative control: calls that the program itself submits are refused. The test must notice it.
fn a_fault_of_the_program_s_own_calls_is_seen() {
    let Some((_, _, right)) = without_a_fault(WAYS[0]) else { return };
    let Some(refused) = run(WAYS[0], Some(RIG), "program vkQueueSubmit 1 1000 -4") else { return };
    assert!(!refused.faults(&right, ALWAYS).is_empty());
}

/// `VK_PRESENT_MODE_FIFO_KHR`: each picture waits for a refresh of the display.
const FIFO: &str = "2";

/// Runs `vk_cube` with keys of `[window]` in the rig.
fn with_keys(keys: &str, fault: &str) -> Option<Outcome> {
    let preset = cupola::rig::presets().iter().find(|preset| preset.name == RIG).expect("a preset").text;
    let path = scratch("swaps").join("rig.toml");
    std::fs::write(&path, format!("{preset}\n[window]\n{keys}\n")).expect("written");
    run(("vk_cube", &[]), path.to_str(), fault)
}

fn swapchains_have_the_rig_s_swap_interval() {
    let with = |keys: &str| with_keys(keys, "told MODE");
    let waiting = |outcome: Outcome| {
        assert!(outcome.succeeded && outcome.modes.len() == 1, "{:?} {:?}", outcome.modes, outcome.words);
        outcome.modes.contains(FIFO)
    };
    let Some(own) = with("") else { return };
    assert!(waiting(own), "the program's own mode");
    assert!(!waiting(with("swap_interval = 0").expect("a display")));
    assert!(waiting(with("swap_interval = 1").expect("a display")));
}

/// `VK_NV_present_barrier` is enabled and joined if the rig has a swap group, and only then. Where
/// the driver does not let a window join, it says so, and the picture is the same.
fn windows_join_a_present_barrier() {
    let Some((_, _, right)) = without_a_fault(("vk_cube", &[])) else { return };
    let group = "swap_group = 1";
    let cases: [(&str, &str, &[&str], Option<&str>); 5] = [
        ("", "barrier 1", &["swapchain 0"], None),
        (group, "barrier 1", &["device", "swapchain 1"], None),
        (group, "barrier 0", &["device", "swapchain 0"], Some("does not let the window join")),
        (group, "barrier 2", &["device", "swapchain 1", "swapchain 0"], Some("does not let the window join")),
        (group, "told MODE", &[], Some("has no VK_NV_present_barrier")),
    ];
    for (keys, fault, arrived, word) in cases {
        let outcome = with_keys(keys, fault).expect("a display");
        let found = outcome.faults(&right, ONCE);
        assert!(found.is_empty(), "{keys}, {fault}: {found:?} {:?}", outcome.words);
        assert_eq!(outcome.barriers, arrived, "{keys}, {fault}: {:?}", outcome.words);
        match word {
            Some(word) => assert!(outcome.words.iter().any(|line| line.contains(word)), "{fault}: {:?}", outcome.words),
            None => assert!(outcome.words.is_empty(), "{fault}: {:?}", outcome.words),
        }
    }
}
