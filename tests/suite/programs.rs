//! Builds the C programs and runs them, without Cupola and under `cupola run`.

use crate::display::{self, Compositor, Display, Place};
pub use crate::finished::Finished;
use crate::harness::missing;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::OnceLock;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Folder of the built programs. The first call builds them.
pub fn built() -> &'static Path {
    static BUILT: OnceLock<PathBuf> = OnceLock::new();
    BUILT.get_or_init(|| {
        let directory = Path::new(env!("CARGO_TARGET_TMPDIR")).join("apps");
        let output = Command::new("make")
            .args(["-s", "-C", concat!(env!("CARGO_MANIFEST_DIR"), "/tests/apps")])
            .arg(format!("OUT={}", directory.display()))
            .arg(format!("CUPOLA={}", library().with_file_name("").display()))
            .output()
            .expect("make can be started");
        assert!(output.status.success(), "the C programs do not build:\n{}", String::from_utf8_lossy(&output.stderr));
        directory
    })
}

/// Path of a library for `LD_PRELOAD`, built from `tests/apps/preload/NAME.c`.
pub fn preload(name: &str) -> String {
    built().join(format!("{name}.so")).to_str().expect("a UTF-8 path").to_owned()
}

/// Folder of the vendor library "calls" for GLX (`tests/apps/preload/calls.c`), for
/// `LD_LIBRARY_PATH`. Cupola searches the library where the dynamic linker does. `None` if the
/// library does not support the processor.
pub fn vendor() -> Option<&'static str> {
    static FOLDER: OnceLock<String> = OnceLock::new();
    if !cfg!(target_arch = "x86_64") {
        return None;
    }
    Some(FOLDER.get_or_init(|| {
        let folder = scratch("vendor");
        std::os::unix::fs::symlink(preload("calls"), folder.join("libGLX_calls.so.0")).expect("a link can be made");
        folder.display().to_string()
    }))
}

/// `cupola-lab calls` with the program that plays calls.
pub fn player() -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_cupola-lab"));
    command.env("CUPOLA_LIBRARY", library()).arg("calls").arg("--player").arg(built().join("player"));
    command
}

/// Library that was built for these tests. Only `cargo build` puts it beside the command.
pub fn library() -> PathBuf {
    Path::new(env!("CARGO_BIN_EXE_cupola")).with_file_name("deps/libcupola.so")
}

/// A fresh folder for the files of one run.
pub fn scratch(what: &str) -> PathBuf {
    static COUNT: AtomicUsize = AtomicUsize::new(0);
    let index = COUNT.fetch_add(1, Ordering::Relaxed);
    let directory = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("suite-{}/{what}-{index}", std::process::id()));
    std::fs::create_dir_all(&directory).expect("a scratch folder can be made");
    directory
}

/// One run of a test program.
#[derive(Clone, Debug)]
pub struct Run<'a> {
    pub program: &'a str,
    pub size: (usize, usize),
    /// Field of view in height, in degrees.
    pub fov: f64,
    pub yaw: f64,
    pub pitch: f64,
    pub frames: usize,
    /// Cupola captures this frame and ends the program in it. If the program ends itself earlier,
    /// after `frames`, nothing is captured. With 0 the program ends itself, and its last frame is
    /// captured.
    pub cupola_frames: usize,
    /// Further options of the program.
    pub extra: &'a [&'a str],
    /// Options of `cupola run` besides the rig.
    pub cupola: &'a [&'a str],
    /// Further variables of the environment.
    pub environment: &'a [(&'a str, &'a str)],
    /// Folder in which the program runs; a new one by default.
    pub directory: Option<&'a Path>,
}

impl<'a> Run<'a> {
    /// A run with a small window, a usual lens and a turned camera.
    pub fn new(program: &'a str) -> Self {
        let (size, frames) = ((256, 256), 3);
        Self {
            program,
            size,
            fov: 75.0,
            yaw: 20.0,
            pitch: -10.0,
            frames,
            cupola_frames: frames,
            extra: &[],
            cupola: &[],
            environment: &[],
            directory: None,
        }
    }

    pub fn arguments(&self, place: &Place) -> Vec<String> {
        let mut arguments: Vec<String> = [
            ("--size", format!("{}x{}", self.size.0, self.size.1)),
            ("--fov", self.fov.to_string()),
            ("--yaw", self.yaw.to_string()),
            ("--pitch", self.pitch.to_string()),
            ("--frames", self.frames.to_string()),
            ("--at", format!("{},{}", place.corner.0, place.corner.1)),
        ]
        .into_iter()
        .flat_map(|(option, value)| [option.to_owned(), value])
        .collect();
        arguments.extend(self.extra.iter().map(|&option| option.to_owned()));
        arguments
    }

    /// Runs the program without Cupola. `None` if there is no display.
    pub fn plain(&self) -> Option<Finished> {
        let mut command = Command::new(built().join(self.program));
        let place = display::place();
        command.args(self.arguments(&place));
        command.envs(self.environment.iter().copied());
        self.in_a_window(command, "without Cupola")
    }

    /// Runs a command on the shared screen. A window that is larger than a place there would cover
    /// other windows, so it gets a screen of its own.
    fn in_a_window(&self, command: Command, rig: &str) -> Option<Finished> {
        if self.size.0 <= display::PLACE.0 && self.size.1 <= display::PLACE.1 {
            return Finished::of(command, self.program, rig);
        }
        Some(Finished::on(&display::own(24)?, command, self.program, rig))
    }

    /// Runs the program with the preload library instead of `cupola run`. The rig is given in the
    /// environment. `None` if there is no display.
    pub fn preloaded(&self, rig: &str) -> Option<Finished> {
        let library = Path::new(env!("CARGO_BIN_EXE_cupola")).with_file_name("examples/libcupola_preload.so");
        assert!(library.exists(), "{}: build it by cargo build --example cupola_preload", library.display());
        let mut command = Command::new(built().join(self.program));
        let place = display::place();
        command.args(self.arguments(&place)).env("LD_PRELOAD", library).env("CUPOLA_RIG", rig);
        command.env("CUPOLA_FRAMES", self.cupola_frames.to_string());
        command.env("CUPOLA_CAPTURE", "capture.png").env("CUPOLA_STATS", "stats.json");
        command.envs(self.environment.iter().copied());
        Finished::of(command, self.program, &format!("{rig}, preloaded"))
    }

    /// Runs the program under `cupola run`, which captures and writes statistics. Panics if Cupola
    /// says that it will not correct the program. `None` if there is no display.
    pub fn under(&self, rig: &str) -> Option<Finished> {
        let mut command = Command::new(env!("CARGO_BIN_EXE_cupola"));
        command.env("CUPOLA_LIBRARY", library());
        let place = display::place();
        command.args(["run", "--rig", rig]);
        if self.cupola_frames <= self.frames {
            command.args(["--capture", "capture.png", "--stats", "stats.json"]);
        }
        if self.cupola_frames > 0 {
            command.args(["--frames", &self.cupola_frames.to_string()]);
        }
        command.args(self.cupola).arg("--").arg(built().join(self.program)).args(self.arguments(&place));
        command.envs(self.environment.iter().copied());
        self.directory.map(|directory| command.current_dir(directory));
        let finished = self.in_a_window(command, rig)?;
        let corrected = !finished.words().contains("will not be corrected");
        assert!(corrected, "{} ({rig}): {}", self.program, finished.words());
        Some(finished)
    }
}

impl Run<'_> {
    /// Runs a Vulkan test program without Cupola. `None` if it cannot be built or if there is no
    /// display.
    pub fn vulkan_plain(&self) -> Option<Finished> {
        let mut command = Command::new(vulkan_apps()?.join(self.program));
        let place = display::place();
        command.args(self.arguments(&place));
        Finished::of(command, self.program, "without Cupola")
    }

    /// Runs a Vulkan test program that uses the C interface, under the validation layer. Panics if
    /// the layer writes a message. `None` as above.
    pub fn vulkan_embedding(&self) -> Option<Finished> {
        self.embedding_in(vulkan_apps()?)
    }

    /// As [`Self::vulkan_embedding`], for a program that was compiled with the headers of the first
    /// published version.
    pub fn vulkan_embedding_of_first_version(&self) -> Option<Finished> {
        static BUILT: OnceLock<Result<PathBuf, &str>> = OnceLock::new();
        let build = || build_vulkan("tests/apps/vulkan", "apps-vulkan-0.1", "first_version", &[FIRST_HEADERS]);
        self.embedding_in(available(BUILT.get_or_init(build))?)
    }

    fn embedding_in(&self, folder: &Path) -> Option<Finished> {
        let mut command = Command::new(folder.join(self.program));
        let place = display::place();
        command.args(self.arguments(&place));
        validating(&mut command);
        Some(Finished::of(command, self.program, "embedding")?.expect_success().expect_no_validation_messages())
    }

    /// Runs a Vulkan test program under `cupola run`, with the validation layer between Cupola and
    /// the driver. Panics unless the program succeeds and the layer accepts the calls that Cupola
    /// makes.
    pub fn vulkan_under(&self, rig: &str) -> Option<Finished> {
        let program = vulkan_apps()?.join(self.program);
        let mut command = Command::new(env!("CARGO_BIN_EXE_cupola"));
        command.env("CUPOLA_LIBRARY", library()).env("VK_LOADER_DEBUG", "layer");
        command.envs(self.environment.iter().copied());
        self.directory.map(|directory| command.current_dir(directory));
        let place = display::place();
        command.args(["run", "--rig", rig, "--capture", "capture.png", "--stats", "stats.json"]).args(self.cupola);
        command.args(["--", "env", "VK_INSTANCE_LAYERS=VK_LAYER_CUPOLA_dome:VK_LAYER_KHRONOS_validation"]);
        command.arg(format!("{}={}", SYNCHRONISATION.0, SYNCHRONISATION.1)).arg(program).args(self.arguments(&place));
        let finished = Finished::of(command, self.program, rig)?.expect_success().expect_no_validation_messages();
        assert!(finished.words().contains("VK_LAYER_CUPOLA_dome"), "Cupola is not loaded:\n{}", finished.words());
        Some(finished)
    }
}

/// Runs an installed program under `cupola run`. `None` if the program is not installed or if there
/// is no display.
pub fn installed(program: &str, arguments: &[&str], rig: &str, cupola: &[&str]) -> Option<Finished> {
    installed_on(display::for_installed_programs()?, program, arguments, rig, cupola)
}

/// As [`installed`], on another display.
pub fn installed_on(
    display: &Display,
    program: &str,
    arguments: &[&str],
    rig: &str,
    cupola: &[&str],
) -> Option<Finished> {
    Some(Finished::on(display, command_of_installed(program, arguments, rig, cupola)?, program, rig))
}

/// As [`installed`], in a Wayland compositor, without an X server.
pub fn installed_in(
    compositor: &Compositor,
    program: &str,
    arguments: &[&str],
    rig: &str,
    cupola: &[&str],
) -> Option<Finished> {
    let mut command = command_of_installed(program, arguments, rig, cupola)?;
    command.env_remove("DISPLAY").envs(compositor.environment());
    Some(Finished::run(command, program, rig))
}

fn command_of_installed(program: &str, arguments: &[&str], rig: &str, cupola: &[&str]) -> Option<Command> {
    if !is_installed(program) {
        return None;
    }
    let mut command = Command::new(env!("CARGO_BIN_EXE_cupola"));
    command.env("CUPOLA_LIBRARY", library()).args(["run", "--rig", rig]).args(cupola);
    command.arg("--").arg(program).args(arguments);
    Some(command)
}

/// Runs an installed Vulkan program under the validation layer, without Cupola or with a rig. The
/// window is 321 × 243 pixels and gets `sizes` other sizes. The file `memory.txt` has the resident
/// memory at each size. `None` if something is not installed or if there is no display.
pub fn resized(rig: Option<&str>, sizes: &str, program: &[&str]) -> Option<Finished> {
    let name = program.first()?;
    if !is_installed(name) {
        return None;
    }
    let resizer = vulkan_apps()?.join("vk_resizer");
    let mut command = Command::new(if rig.is_some() { env!("CARGO_BIN_EXE_cupola") } else { "env" });
    let layers = match rig {
        Some(rig) => {
            command.env("CUPOLA_LIBRARY", library()).args(["run", "--rig", rig, "--", "env"]);
            "VK_LAYER_CUPOLA_dome:VK_LAYER_KHRONOS_validation"
        }
        None => "VK_LAYER_KHRONOS_validation",
    };
    command.arg(format!("VK_INSTANCE_LAYERS={layers}")).arg("VK_LOADER_DEBUG=layer");
    command.arg(resizer).args(["321x243", sizes, "10", "memory.txt"]).args(program);
    let finished = Finished::on(&display::own(24)?, command, name, rig.unwrap_or("without Cupola")).expect_success();
    let loaded = |layer: &str| finished.words().contains(layer);
    assert!(layers.split(':').all(loaded), "a layer is not loaded:\n{}", finished.words());
    Some(finished)
}

/// Whether a program is installed.
pub fn is_installed(program: &str) -> bool {
    let folders = std::env::var_os("PATH").unwrap_or_default();
    let installed = std::env::split_paths(&folders).any(|folder| folder.join(program).is_file());
    if !installed {
        missing(format_args!("{program} is not installed"));
    }
    installed
}

/// Runs a program that uses the C interface. `None` if there is no display.
pub fn embedding(program: &str, arguments: &[&str], environment: &[(&str, &str)]) -> Option<Finished> {
    let mut command = Command::new(built().join(program));
    command.args(arguments).env("LD_LIBRARY_PATH", library().with_file_name(""));
    command.envs(environment.iter().copied());
    Finished::of(command, program, "embedding")
}

/// Setting for make: folder of the headers of the first published version.
const FIRST_HEADERS: &str = concat!("INCLUDE=", env!("CARGO_MANIFEST_DIR"), "/tests/abi/0.1");

/// As [`embedding`], for a program that was compiled with the headers of the first published
/// version.
pub fn embedding_of_first_version(program: &str, arguments: &[&str]) -> Option<Finished> {
    static BUILT: OnceLock<PathBuf> = OnceLock::new();
    let folder = BUILT.get_or_init(|| {
        let directory = Path::new(env!("CARGO_TARGET_TMPDIR")).join("apps-0.1");
        let output = Command::new("make")
            .args(["-s", "-C", concat!(env!("CARGO_MANIFEST_DIR"), "/tests/apps"), "first_version", FIRST_HEADERS])
            .arg(format!("OUT={}", directory.display()))
            .arg(format!("CUPOLA={}", library().with_file_name("").display()))
            .output()
            .expect("make can be started");
        assert!(output.status.success(), "programs do not build:\n{}", String::from_utf8_lossy(&output.stderr));
        directory
    });
    let mut command = Command::new(folder.join(program));
    command.args(arguments).env("LD_LIBRARY_PATH", library().with_file_name(""));
    Finished::of(command, program, "embedding, 0.1")
}

/// Builds the Vulkan programs of `sources` that `target` names into `folder`. Returns the name of a missing part if
/// they cannot be built or validated.
fn build_vulkan(sources: &str, folder: &str, target: &str, settings: &[&str]) -> Result<PathBuf, &'static str> {
    let directory = Path::new(env!("CARGO_TARGET_TMPDIR")).join(folder);
    let layers = Path::new("/usr/share/vulkan/explicit_layer.d/VkLayer_khronos_validation.json");
    let needed = [
        (!layers.exists(), "the validation layer (Debian: vulkan-validationlayers)"),
        (Command::new("glslangValidator").arg("-v").output().is_err(), "glslangValidator (glslang-tools)"),
        (!Path::new("/usr/include/vulkan/vulkan.h").exists(), "Vulkan's headers (libvulkan-dev)"),
        (!Path::new("/usr/include/X11/extensions/Xdamage.h").exists(), "X's headers for damages (libxdamage-dev)"),
    ];
    if let Some((_, what)) = needed.iter().find(|(missing, _)| *missing) {
        return Err(what);
    }
    let output = Command::new("make")
        .args(["-s", "-C", &format!("{}/{sources}", env!("CARGO_MANIFEST_DIR")), target])
        .args(settings)
        .arg(format!("OUT={}", directory.display()))
        .arg(format!("CUPOLA={}", library().with_file_name("").display()))
        .output()
        .expect("make can be started");
    let words = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "the Vulkan programs of {sources} do not build:\n{words}");
    Ok(directory)
}

/// The folder if the programs were built.
fn available(built: &'static Result<PathBuf, &str>) -> Option<&'static Path> {
    let refused = |what: &&&str| missing(format_args!("no {what}"));
    built.as_deref().inspect_err(refused).ok()
}

/// Folder of the built Vulkan examples.
fn vulkan_examples() -> Option<&'static Path> {
    static BUILT: OnceLock<Result<PathBuf, &str>> = OnceLock::new();
    available(BUILT.get_or_init(|| build_vulkan("examples/c", "c-examples", "vulkan", &[])))
}

/// Folder of the built Vulkan test programs.
pub fn vulkan_apps() -> Option<&'static Path> {
    static BUILT: OnceLock<Result<PathBuf, &str>> = OnceLock::new();
    available(BUILT.get_or_init(|| build_vulkan("tests/apps/vulkan", "apps-vulkan", "vulkan", &[])))
}

/// Variable that makes the validation layer check synchronisation, too.
const SYNCHRONISATION: (&str, &str) =
    ("VK_LAYER_ENABLES", "VK_VALIDATION_FEATURE_ENABLE_SYNCHRONIZATION_VALIDATION_EXT");

/// Adds the validation layer and the path of the library to a program's environment.
fn validating(command: &mut Command) {
    command.env("LD_LIBRARY_PATH", library().with_file_name(""));
    command.env("VK_INSTANCE_LAYERS", "VK_LAYER_KHRONOS_validation").env("VK_LOADER_DEBUG", "layer");
    command.env(SYNCHRONISATION.0, SYNCHRONISATION.1);
}

/// Runs a Vulkan example under the validation layer, which also checks synchronisation. `None` if
/// that is not possible.
pub fn watched(program: &str, arguments: &[&str]) -> Option<Finished> {
    watched_in(vulkan_examples()?, program, arguments)
}

fn watched_in(folder: &Path, program: &str, arguments: &[&str]) -> Option<Finished> {
    let mut command = Command::new(folder.join(program));
    command.args(arguments);
    validating(&mut command);
    let finished = Finished::of(command, program, "watched")?;
    assert!(finished.words().contains("VK_LAYER_KHRONOS_validation"), "the layer is not loaded:\n{}", finished.words());
    Some(finished)
}

/// As [`watched`]. Panics unless the program succeeds and the layer writes no message.
pub fn validated(program: &str, arguments: &[&str]) -> Option<Finished> {
    Some(watched(program, arguments)?.expect_success().expect_no_validation_messages())
}

/// As [`validated`], for an example that was compiled with the headers of the first published
/// version.
pub fn validated_of_first_version(program: &str, arguments: &[&str]) -> Option<Finished> {
    static BUILT: OnceLock<Result<PathBuf, &str>> = OnceLock::new();
    let build = || build_vulkan("examples/c", "c-examples-0.1", "vulkan", &[FIRST_HEADERS]);
    let folder = available(BUILT.get_or_init(build))?;
    Some(watched_in(folder, program, arguments)?.expect_success().expect_no_validation_messages())
}
