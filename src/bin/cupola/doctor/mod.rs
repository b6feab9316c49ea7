//! `cupola doctor`: reports which kinds of programs can be corrected on this machine, and why
//! others cannot.

mod screens;

use crate::display;
use crate::failure::Failure;
use crate::launch::probe::{self, Answer, Way};
use crate::launch::{Environment, library, loader};
use cupola::backend::vk;
use serde_json::{Map, Value, json};
use std::path::Path;
use std::process::ExitCode;

/// Environment variables that change the behaviour of `cupola run`.
const TELLING: [&str; 16] = [
    "CUPOLA",
    "CUPOLA_RIG",
    "CUPOLA_CAMERA",
    "CUPOLA_VIEWER",
    "CUPOLA_DUPLICATE",
    "CUPOLA_CONTENT",
    "CUPOLA_METHOD",
    "CUPOLA_LIBRARY",
    "CUPOLA_GLX_REAL",
    "CUPOLA_EGL_REAL",
    "__GLX_VENDOR_LIBRARY_NAME",
    "__EGL_VENDOR_LIBRARY_FILENAMES",
    "__EGL_VENDOR_LIBRARY_DIRS",
    "LD_PRELOAD",
    "LD_LIBRARY_PATH",
    "LIBGL_ALWAYS_INDIRECT",
];

/// Report which kinds of programs Cupola can correct on this machine, and why others cannot be
/// corrected.
#[derive(clap::Args)]
pub struct Arguments {
    /// Print the result as JSON
    #[arg(long)]
    json: bool,
}

/// One finding.
struct Finding {
    /// Name of the subject, also used in JSON.
    key: &'static str,
    /// True if this is as it should be; `None` for mere information.
    good: Option<bool>,
    /// The finding, and the remedy if there is one.
    words: String,
}

impl Finding {
    fn print(&self) {
        let mark = match self.good {
            Some(true) => "good",
            Some(false) => "BAD ",
            None => "    ",
        };
        println!("{mark} {:12} {}", self.key, self.words);
    }
}

/// Runs the subcommand. The exit code is 0 if programs that use GLX or EGL can be corrected.
pub fn run(arguments: &Arguments) -> Result<ExitCode, Failure> {
    let mut findings = Vec::new();
    let mut tell = |key, good, words: String| findings.push(Finding { key, good, words });
    tell("version", None, format!("cupola {} for {}", env!("CARGO_PKG_VERSION"), std::env::consts::ARCH));
    for name in TELLING {
        if let Some(value) = std::env::var_os(name) {
            tell("environment", None, format!("{name}={}", value.to_string_lossy()));
        }
    }
    let on = std::env::var_os("CUPOLA").is_none_or(|value| value != "0");
    if !on {
        tell("switch", Some(false), "CUPOLA=0 switches Cupola off; unset it".to_owned());
    }
    let xvfb = find_command("Xvfb");
    let xvfb_words = match &xvfb {
        Some(path) => format!("{path}, for `run --headless`"),
        None => "Xvfb is not installed; `run --headless` needs it (Debian and Ubuntu: package xvfb)".to_owned(),
    };
    tell("xvfb", Some(xvfb.is_some()), xvfb_words);

    let scratch = loader::Scratch::new()?;
    let own_display = std::env::var_os("DISPLAY").is_none() && xvfb.is_some();
    let server = if own_display { display::Server::start((640, 480), scratch.path()).ok() } else { None };
    let display = server.as_ref().map_or_else(Vec::new, display::Server::environment);
    let place = match (&server, std::env::var("DISPLAY")) {
        (Some(_), _) => "there is no X display; the following results are those of a private Xvfb".to_owned(),
        (None, Ok(name)) => format!("the X display is {name}"),
        (None, Err(_)) => "there is no X display, and Xvfb could not be started".to_owned(),
    };
    tell("display", None, place);
    let shown_on = display.iter().find(|(name, _)| *name == "DISPLAY").and_then(|(_, value)| value.clone());
    for words in screens::screens(shown_on.as_deref().and_then(std::ffi::OsStr::to_str)) {
        tell("screen", None, words);
    }
    if let Some(words) = screens::compositor() {
        tell("screen", None, words);
    }
    for words in screens::cards(Path::new("/sys/class/drm")) {
        tell("card", None, words);
    }

    let hooked = hooked(&scratch, &display, &mut tell);
    let works = [("glx", Way::Glx), ("egl", Way::Egl)].map(|(key, way)| {
        let (good, words) = route(way, &display, hooked.as_ref());
        tell(key, Some(good), words);
        good
    });
    let (good, words) = vulkan(&display, hooked.as_ref());
    tell("vulkan", good, words);
    tell_devices(&display, &mut tell);
    let usable = on && works.contains(&true);
    if arguments.json {
        println!("{:#}", as_json(usable, &findings));
    } else {
        findings.iter().for_each(Finding::print);
        println!("{}", if usable { "Programs can be corrected here." } else { "Programs cannot be corrected here." });
    }
    Ok(if usable { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

/// Reports the Vulkan device, and the means to synchronise displays.
fn tell_devices(display: &Environment, tell: &mut impl FnMut(&'static str, Option<bool>, String)) {
    let device = vk::driver::headless::Headless::new(&[]);
    let (good, words) = vulkan_device(device.as_ref().map_err(|error| error.message.clone()));
    tell("vulkan device", good, words);
    if let Ok(device) = &device {
        tell("vulkan flat", None, vulkan_flat(device));
    }
    tell("swap groups", None, screens::swap_groups(display, device.as_ref().ok()));
}

/// Reports the library. Returns the environment of a program that it corrects.
fn hooked(
    scratch: &loader::Scratch,
    display: &Environment,
    mut tell: impl FnMut(&'static str, Option<bool>, String),
) -> Option<Environment> {
    let found = library::find().and_then(|library| {
        let loader = loader::Loader::temporary(scratch.path())?;
        Ok((library, loader.environment(display)?))
    });
    let (library, mut environment) = match found {
        Ok(found) => found,
        Err(failure) => {
            tell("library", Some(false), failure.message);
            return None;
        }
    };
    let refusals: Vec<String> =
        ["__glx_Main", "__egl_Main"].iter().filter_map(|entry| library::refusal(&library, entry)).collect();
    let words = match refusals.first() {
        None => library.display().to_string(),
        Some(why) => format!("{} cannot be used: {why}", library.display()),
    };
    tell("library", Some(refusals.is_empty()), words);
    environment.extend(display.clone());
    Some(environment)
}

/// Reports whether Vulkan programs can be corrected, and a description; `None` if there is no
/// Vulkan driver, which OpenGL programs do not need.
fn vulkan(plain: &Environment, hooked: Option<&Environment>) -> (Option<bool>, String) {
    let driver = match probe::ask(Way::Vulkan, plain) {
        Ok(answer) => answer.driver,
        Err(why) => return (None, why),
    };
    let Some(hooked) = hooked else { return (Some(false), format!("{driver}: the library is missing")) };
    match probe::ask(Way::Vulkan, hooked) {
        Ok(answer) if answer.has_cupola() => {
            let words = "the layer is loaded and programs can be corrected; the log says why a program is shown flat";
            (Some(true), format!("{driver}; {words}"))
        }
        Ok(_) => {
            let words =
                "the Vulkan loader does not load Cupola's layer; version 1.3.234 or later of the loader is needed";
            (Some(false), format!("{driver}: {words}"))
        }
        Err(why) => (Some(false), format!("{driver}, but with Cupola's layer: {why}")),
    }
}

/// Capabilities of the Vulkan device for programs that embed Cupola, through the crate or
/// `cupola_vk.h`.
fn vulkan_device(device: Result<&vk::driver::headless::Headless, String>) -> (Option<bool>, String) {
    let device = match device {
        Ok(device) => device,
        Err(why) => return (None, why),
    };
    let formats = cupola::backend::vk::driver::formats::usable_formats(&device.api);
    if formats.is_empty() {
        return (Some(false), format!("{}: no usual image format can be both filtered and drawn to", device.driver));
    }
    let timed = if device.api.has_timestamps(device.queue_family()) {
        "measures their times"
    } else {
        "cannot measure their times"
    };
    let words = format!(
        "{}; corrects pictures of up to {2} × {2} in {1}, and {timed}",
        device.driver,
        formats.join(", "),
        device.api.largest_image()
    );
    (Some(true), words)
}

/// Describes the programs that the layer shows flat on this device.
fn vulkan_flat(device: &vk::driver::headless::Headless) -> String {
    format!(
        "few programs appear flat, and the log says why: those that draw to layers of an image or to several \
         viewports, use shader objects or descriptor buffers, store places of the scene in buffers by compute shaders, \
         or use all {} descriptor sets of this device",
        device.api.descriptor_sets()
    )
}

/// Reports whether programs that use this API can be corrected, and the reason.
fn route(way: Way, plain: &Environment, hooked: Option<&Environment>) -> (bool, String) {
    let without = match probe::ask(way, plain) {
        Ok(answer) => answer,
        Err(why) => return (false, format!("no driver: {why}")),
    };
    let driver = &without.driver;
    if !without.has_libglvnd() {
        let words =
            "programs do not reach the driver through libglvnd; start them with libcupola_preload.so in LD_PRELOAD";
        return (false, format!("{driver}: {words}"));
    }
    if !without.direct {
        return (
            false,
            format!("{driver}: the context is indirect, the X server draws; there are no calls to intercept"),
        );
    }
    let vendor =
        without.glx_vendor().filter(|_| way == Way::Glx).map_or(String::new(), |name| format!(" (vendor {name})"));
    let Some(hooked) = hooked else { return (false, format!("{driver}{vendor}: the library is missing")) };
    match probe::ask(way, hooked) {
        Ok(Answer { driver: same, .. }) if same != *driver => {
            (false, format!("{driver}{vendor}, but with Cupola {same}: set CUPOLA_GLX_REAL to the vendor's name"))
        }
        Ok(answer) if answer.has_cupola() => (true, format!("{driver}{vendor}; programs can be corrected")),
        Ok(_) => (false, format!("{driver}{vendor}: libglvnd did not load Cupola's library")),
        Err(why) => (false, format!("{driver}{vendor}, but with Cupola there is no driver: {why}")),
    }
}

/// The first executable of this name in `PATH`.
fn find_command(name: &str) -> Option<String> {
    let folders = std::env::var_os("PATH")?;
    let paths = std::env::split_paths(&folders).map(|folder| folder.join(name));
    paths.into_iter().find(|path| Path::is_file(path)).map(|path| path.display().to_string())
}

fn as_json(usable: bool, findings: &[Finding]) -> Value {
    let list: Vec<Value> = findings
        .iter()
        .map(|finding| {
            let mut entry = Map::new();
            entry.insert("key".to_owned(), json!(finding.key));
            if let Some(good) = finding.good {
                entry.insert("good".to_owned(), json!(good));
            }
            entry.insert("words".to_owned(), json!(finding.words));
            Value::Object(entry)
        })
        .collect();
    json!({ "usable": usable, "findings": list })
}
