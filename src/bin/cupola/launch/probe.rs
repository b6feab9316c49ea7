//! A separate process that loads a driver and reports its name. Drivers can crash the process that
//! loads them, and only a new process uses a changed environment.

use super::{Environment, apply};
use crate::failure::Failure;
use cupola::backend::gl::driver::{glx, headless};
use cupola::backend::vk;
use serde_json::{Value, json};
use std::process::{Command, ExitCode, Stdio};
use std::time::{Duration, Instant};

/// Time limit for the start of a driver.
const PATIENCE: Duration = Duration::from_secs(60);

/// The API through which a program reaches the driver.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum Way {
    /// GLX on the display in `DISPLAY`
    Glx,
    /// EGL without a surface
    Egl,
    /// Vulkan without a surface
    Vulkan,
}

/// Report the driver (used by `cupola run` and `cupola doctor`).
#[derive(clap::Args)]
pub struct Arguments {
    /// API through which the driver is loaded
    way: Way,
}

/// Answer of the process.
#[derive(Clone, Debug)]
pub struct Answer {
    /// Name of the driver.
    pub driver: String,
    /// True if the driver draws in the program's process.
    pub direct: bool,
    /// File names of the loaded libraries of OpenGL and of Cupola.
    pub libraries: Vec<String>,
    /// Extensions of GLX.
    pub extensions: Vec<String>,
}

impl Answer {
    /// Name of the GLX vendor behind libglvnd, as in `__GLX_VENDOR_LIBRARY_NAME`.
    pub fn glx_vendor(&self) -> Option<&str> {
        let names =
            self.libraries.iter().filter_map(|name| name.strip_prefix("libGLX_")?.split_once(".so").map(|n| n.0));
        names.into_iter().find(|name| *name != "cupola")
    }

    /// True if Cupola's library was loaded.
    pub fn has_cupola(&self) -> bool {
        self.libraries.iter().any(|name| name.contains("cupola"))
    }

    /// True if libglvnd was loaded.
    pub fn has_libglvnd(&self) -> bool {
        self.libraries.iter().any(|name| name.starts_with("libGLdispatch."))
    }
}

/// Runs the subcommand: prints the JSON that [`ask`] reads.
pub fn run(arguments: &Arguments) -> Result<ExitCode, Failure> {
    let (driver, direct, libraries);
    let mut extensions = String::new();
    match arguments.way {
        Way::Glx => {
            let found = glx::driver()?;
            driver = format!("{}, {}, {}", found.vendor, found.renderer, found.version);
            direct = found.direct;
            extensions = found.extensions;
            libraries = loaded();
        }
        Way::Egl => {
            let context = headless::Headless::new(headless::Api::Compatibility)
                .or_else(|_| headless::Headless::new(headless::Api::Core))
                .or_else(|_| headless::Headless::new(headless::Api::Es3))?;
            driver = context.driver();
            direct = true;
            libraries = loaded();
        }
        Way::Vulkan => {
            let device = vk::driver::headless::Headless::new(&[])?;
            driver = device.driver.clone();
            direct = true;
            libraries = loaded();
        }
    }
    let extensions: Vec<&str> = extensions.split_whitespace().collect();
    let answer = json!({ "driver": driver, "direct": direct, "libraries": libraries, "extensions": extensions });
    println!("{answer}");
    Ok(ExitCode::SUCCESS)
}

/// File names of the OpenGL libraries in this process.
fn loaded() -> Vec<String> {
    let maps = std::fs::read_to_string("/proc/self/maps").unwrap_or_default();
    let files = maps.lines().filter_map(|line| line.split_once('/')).filter_map(|(_, path)| path.rsplit('/').next());
    let mut names: Vec<String> = files
        .filter(|name| ["libGL", "libEGL", "libOpenGL", "libcupola"].iter().any(|start| name.starts_with(start)))
        .map(str::to_owned)
        .collect();
    names.sort();
    names.dedup();
    names
}

/// Loads the driver in a new process with `environment`.
///
/// # Errors
/// The message of the process if there is no driver.
pub fn ask(way: Way, environment: &Environment) -> Result<Answer, String> {
    let name = match way {
        Way::Glx => "glx",
        Way::Egl => "egl",
        Way::Vulkan => "vulkan",
    };
    let executable = std::env::current_exe().map_err(|error| error.to_string())?;
    let mut command = Command::new(executable);
    apply(&mut command, environment);
    command.args(["probe", name]).stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
    let mut child = command.spawn().map_err(|error| error.to_string())?;
    let start = Instant::now();
    while child.try_wait().map_err(|error| error.to_string())?.is_none() {
        if start.elapsed() > PATIENCE {
            // The process may have ended by itself.
            let _ = child.kill();
            let _ = child.wait();
            return Err(format!("the driver does not answer within {} s", PATIENCE.as_secs()));
        }
        std::thread::sleep(Duration::from_millis(5));
    }
    let output = child.wait_with_output().map_err(|error| error.to_string())?;
    let words = String::from_utf8_lossy(&output.stderr).trim().trim_start_matches("cupola: ").to_owned();
    if !output.status.success() {
        return Err(if words.is_empty() {
            format!("the process that asked ended with {}", output.status)
        } else {
            words
        });
    }
    let answer: Value = serde_json::from_slice(&output.stdout).map_err(|error| error.to_string())?;
    let texts = |key: &str| {
        let texts = answer[key].as_array().into_iter().flatten();
        texts.filter_map(|text| text.as_str().map(str::to_owned)).collect()
    };
    Ok(Answer {
        driver: answer["driver"].as_str().unwrap_or_default().to_owned(),
        direct: answer["direct"].as_bool().unwrap_or_default(),
        libraries: texts("libraries"),
        extensions: texts("extensions"),
    })
}
