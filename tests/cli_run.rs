//! `cupola run` and `play`: what the program gets, what remains afterwards, and how it ends.

#![deny(dead_code)]

mod harness;

use harness::tests;
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::time::{Duration, Instant};

tests! {
    the_exit_code_is_the_programs,
    programs_that_cannot_be_started,
    wrong_options_start_nothing,
    the_program_gets_the_settings,
    a_profile_is_chosen_by_the_programs_name,
    films_are_played_as_what_they_are,
    libglvnd_is_led_to_the_library,
    each_egl_vendor_gets_a_library_of_its_own,
    a_broken_library_leaves_the_program_alone,
    the_kill_switch_runs_the_program_plainly,
    the_environment_is_printed_for_a_shell,
    headless_programs_have_a_display_of_their_own,
    the_library_is_between_program_and_driver,
    signals_reach_the_program_and_everything_is_tidied_up,
    the_display_does_not_outlive_a_killed_cupola,
    a_missing_xvfb_is_named_with_its_package,
}

/// A subcommand with a clean environment and a folder of its own for temporary files.
fn command(subcommand: &str, folder: &Path) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_cupola"));
    for (name, _) in std::env::vars_os().filter(|(name, _)| {
        let name = name.to_string_lossy();
        name.starts_with("CUPOLA")
            || name.starts_with("__GLX")
            || name.starts_with("__EGL")
            || name == "LD_LIBRARY_PATH"
    }) {
        command.env_remove(name);
    }
    command.env("CUPOLA_LIBRARY", library()).env("TMPDIR", folder).arg(subcommand).stdin(Stdio::null());
    command
}

/// `cupola run` with a clean environment and a folder of its own for temporary files.
fn cupola(folder: &Path) -> Command {
    command("run", folder)
}

/// Library of this build. `cargo test` puts it beside the tests and not beside the command.
fn library() -> PathBuf {
    let command = Path::new(env!("CARGO_BIN_EXE_cupola"));
    let built = command.with_file_name("deps").join("libcupola.so");
    if built.exists() { built } else { command.with_file_name("libcupola.so") }
}

/// An empty folder for one test.
fn folder(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("cli_run").join(name);
    let _ = std::fs::remove_dir_all(&folder);
    std::fs::create_dir_all(&folder).unwrap();
    folder
}

fn is_empty(folder: &Path) -> bool {
    std::fs::read_dir(folder).unwrap().next().is_none()
}

fn words(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

fn shell(folder: &Path, options: &[&str], script: &str) -> Output {
    cupola(folder).args(options).args(["--", "sh", "-c", script]).output().unwrap()
}

fn has_xvfb() -> bool {
    let there = Command::new("Xvfb").arg("-help").output().is_ok();
    if !there {
        harness::missing("Xvfb is not installed");
    }
    there
}

/// Waits until `done` returns true, for at most ten seconds.
#[track_caller]
fn wait_until(what: &str, mut done: impl FnMut() -> bool) {
    let start = Instant::now();
    while !done() {
        assert!(start.elapsed() < Duration::from_secs(10), "{what}: not within ten seconds");
        std::thread::sleep(Duration::from_millis(10));
    }
}

fn the_exit_code_is_the_programs() {
    let folder = folder("exit_code");
    // Options after the program's name belong to the program, also without the separator `--`.
    let output = cupola(&folder).args(["sh", "-c", "exit 9", "--frames"]).output().unwrap();
    assert_eq!(output.status.code(), Some(9));
    for (script, code) in [("exit 0", 0), ("exit 7", 7), ("kill -9 $$", 137), ("kill -15 $$", 143)] {
        assert_eq!(shell(&folder, &[], script).status.code(), Some(code), "{script}");
    }
    assert!(is_empty(&folder), "temporary files are left");
}

fn programs_that_cannot_be_started() {
    let folder = folder("no_program");
    let output = cupola(&folder).args(["--", "no-such-program-here"]).output().unwrap();
    assert_eq!(output.status.code(), Some(127));
    assert!(words(&output.stderr).contains("no-such-program-here: command not found"));
    assert!(is_empty(&folder));
    let text = folder.join("text");
    std::fs::write(&text, "not a program").unwrap();
    std::fs::set_permissions(&text, std::fs::Permissions::from_mode(0o644)).unwrap();
    let output = cupola(&folder).arg(&text).output().unwrap();
    assert_eq!(output.status.code(), Some(126));
    assert!(words(&output.stderr).contains("cannot be started"));
}

fn wrong_options_start_nothing() {
    let folder = folder("wrong_options");
    let started = folder.join("started");
    let rig = folder.join("rig.toml");
    std::fs::write(&rig, "[[output]]\nkind = \"domemaster\"\naperture = 400\n").unwrap();
    let rig = rig.to_str().unwrap();
    for (options, expected) in [
        (&["--rig", rig][..], "rig.toml:3: output[0].aperture (output-1): 400 is out of range"),
        (&["--rig", "fishey"], "did you mean the preset `fisheye`?"),
        (&["--camera", "zom=2"], "did you mean `zoom`?"),
        (&["--capture", "no/such/folder/a.png"], "the folder of this file does not exist"),
        (&["--size", "0x100"], "WIDTHxHEIGHT"),
        (&["--capture", "a.jpg"], "expected a name that ends in .png"),
        (&["--stats", "."], ". is a folder; expected the name of a file"),
        (&["--log", "."], ". is a folder"),
        (&["--publish=."], ". is a folder"),
        (&["--frames", "0"], "expected a whole number above 0, for example 60"),
        (&["--bogus"], "--bogus"),
    ] {
        let output = shell(&folder, options, &format!("touch {}", started.display()));
        assert_eq!(output.status.code(), Some(2), "{options:?}");
        assert!(words(&output.stderr).contains(expected), "{options:?}: {}", words(&output.stderr));
        assert!(!started.exists(), "{options:?} started the program");
    }
    // Control: the same program runs if the options are correct.
    assert!(shell(&folder, &[], &format!("touch {}", started.display())).status.success());
    assert!(started.exists());
}

fn the_program_gets_the_settings() {
    let folder = folder("settings");
    let options = [
        "--rig",
        "fisheye-210",
        "--size",
        "640x480",
        "--frames",
        "5",
        "--capture",
        "cap.png",
        "--capture-views",
        "views",
        "--stats",
        "stats.json",
        "--camera",
        "zoom=4,move=0,0,-20",
        "--viewer",
        "position=0,-0.5,1",
        "--offscreen",
        "--log",
        "log.txt",
    ];
    let output = cupola(&folder).current_dir(&folder).args(options).args(["--", "env"]).output().unwrap();
    let environment = words(&output.stdout);
    let here = folder.display();
    for expected in [
        "CUPOLA_RIG=fisheye-210",
        "CUPOLA_SIZE=640x480",
        "CUPOLA_FRAMES=5",
        "CUPOLA_CAMERA=zoom=4,move=0,0,-20",
        "CUPOLA_VIEWER=position=0,-0.5,1",
        "CUPOLA_OFFSCREEN=1",
        &format!("CUPOLA_CAPTURE={here}/cap.png"),
        &format!("CUPOLA_CAPTURE_VIEWS={here}/views"),
        &format!("CUPOLA_STATS={here}/stats.json"),
        &format!("CUPOLA_LOG={here}/log.txt"),
    ] {
        assert!(environment.lines().any(|line| line == expected), "{expected} is not in\n{environment}");
    }
    // A rig file is found even if the program changes its folder.
    std::fs::write(folder.join("my.toml"), "[[output]]\nkind = \"domemaster\"\n").unwrap();
    let output = cupola(&folder).current_dir(&folder).args(["--rig", "my.toml", "--", "env"]).output().unwrap();
    assert!(words(&output.stdout).contains(&format!("CUPOLA_RIG={here}/my.toml\n")));
}

fn a_profile_is_chosen_by_the_programs_name() {
    let folder = folder("profiles");
    let profiles = folder.join("config/cupola/profiles");
    std::fs::create_dir_all(&profiles).unwrap();
    let profile = "executables = [\"game\"]\nhint = \"be wide\"\n[environment]\nGAME_A = \"1\"\nGAME_B = \"2\"\n";
    let (own, wrong) = (profiles.join("mine.toml"), profiles.join("wrong.toml"));
    std::fs::write(&own, profile).unwrap();
    std::fs::write(&wrong, "executables = [\"sh\"]\n[camera]\nzoom = 0\n").unwrap();
    let game = folder.join("game");
    std::fs::write(&game, "#!/bin/sh\nenv\n").unwrap();
    std::fs::set_permissions(&game, std::fs::Permissions::from_mode(0o755)).unwrap();
    let run = |options: &[&str], program: &Path| {
        let mut command = cupola(&folder);
        command.env("XDG_CONFIG_HOME", folder.join("config")).env("GAME_B", "own").args(options).arg("--").arg(program);
        let output = command.output().unwrap();
        (words(&output.stdout), words(&output.stderr), output.status.code())
    };
    let (environment, said, _) = run(&[], &game);
    let line = format!("cupola: profile mine ({}, for game): be wide\n", own.display());
    assert!(said.contains(&line), "{said}");
    assert!(
        said.contains("a profile is left out: ") && said.contains("wrong.toml:3: camera.zoom: 0 is out of"),
        "{said}"
    );
    for expected in [&format!("CUPOLA_PROFILE={}", own.display()), "GAME_A=1", "GAME_B=own"] {
        assert!(environment.lines().any(|line| line == expected), "{expected} is not in\n{environment}");
    }
    // A built-in profile is used whatever the program's name is. `none` uses no profile.
    let (environment, said, _) = run(&["--profile", "minetest"], &game);
    assert!(said.contains("cupola: profile minetest (built in): "), "{said}");
    assert!(environment.contains("CUPOLA_PROFILE=minetest\n") && !environment.contains("GAME_A"), "{environment}");
    let (environment, said, _) = run(&["--profile", "none"], &game);
    assert!(environment.contains("CUPOLA_PROFILE=none\n") && !said.contains("profile"), "{said}{environment}");
    // The option has priority over the variable, and the variable over the program's name.
    for (options, expected) in [(&["--profile", "minetest"][..], "minetest"), (&[], "vtk")] {
        let mut command = cupola(&folder);
        command.env("XDG_CONFIG_HOME", folder.join("config")).env("CUPOLA_PROFILE", "vtk").args(options);
        let environment = words(&command.arg("--").arg(&game).output().unwrap().stdout);
        assert!(environment.contains(&format!("CUPOLA_PROFILE={expected}\n")), "{options:?} {environment}");
    }
    // `cupola run` chooses no profile for other programs. The library chooses one by the libraries
    // that the program loads.
    let (environment, _, _) = run(&[], Path::new("env"));
    assert!(!environment.contains("CUPOLA_PROFILE"), "{environment}");
    for (name, expected) in [("wrong", "wrong.toml:3: camera.zoom"), ("min", "did you mean `mine`?")] {
        let (environment, said, code) = run(&["--profile", name], &game);
        assert!(said.contains(expected) && environment.is_empty() && code == Some(2), "{code:?} {said}{environment}");
    }
}

/// The player is a script. Asked for the size of a film, it prints one. When it is to play the
/// film, it prints its arguments.
fn films_are_played_as_what_they_are() {
    let folder = folder("play");
    let script = "#!/bin/sh\ncase \"$*\" in\n*--vo=null*) echo \"cupola ${SIZE}\" ;;\n\
        *) printf '%s\\n' \"content=$CUPOLA_CONTENT\" \"$@\" ;;\nesac\n";
    let player = folder.join("mpv");
    std::fs::write(&player, script).unwrap();
    std::fs::set_permissions(&player, std::fs::Permissions::from_mode(0o755)).unwrap();
    let film = folder.join("a film,%1.mp4");
    std::fs::write(&film, "").unwrap();
    let path = format!("{}:{}", folder.display(), std::env::var("PATH").unwrap());
    let play = |size: &str, options: &[&str], file: &Path| {
        let mut play = command("play", &folder);
        play.env("PATH", &path).env("SIZE", size).args(options).arg(file).arg("--volume=50").output().unwrap()
    };
    let dome = play("4096 4096", &["--size", "640x480"], &film);
    let told = words(&dome.stdout);
    for expected in ["content=domemaster", "--geometry=640x480", "--loop-playlist=inf", "--volume=50"] {
        assert!(told.lines().any(|line| line == expected), "{expected} is not in\n{told}{}", words(&dome.stderr));
    }
    assert_eq!(told.lines().last(), film.to_str());
    assert!(words(&dome.stderr).contains("4096 × 4096 pixels and is shown as domemaster"));
    let given = play("4096 4096", &["--content", "equirectangular,width=180", "--once"], &film);
    let told = words(&given.stdout);
    assert!(told.contains("content=equirectangular,width=180\n") && told.contains("--loop-playlist=no\n"), "{told}");
    assert!(told.contains("--fullscreen\n"), "{told}");
    // The rig's own `[content]` has priority over the size of the film.
    let rig = folder.join("rig.toml");
    std::fs::write(&rig, "[content]\nkind = \"cubemap\"\n[[output]]\nkind = \"domemaster\"\n").unwrap();
    let by_rig = play("4096 4096", &["--rig", rig.to_str().unwrap()], &film);
    assert!(words(&by_rig.stdout).contains("content=\n"), "{}", words(&by_rig.stdout));
    for (size, file, why) in
        [("", &film, "finds no picture"), ("1 1", &folder.join("none.mp4"), "none.mp4: No such file")]
    {
        let refused = play(size, &[], file);
        assert_eq!(refused.status.code(), Some(2), "{}", words(&refused.stderr));
        assert!(words(&refused.stderr).contains(why), "{}", words(&refused.stderr));
    }
    // If the player is missing, the message names it.
    std::fs::remove_file(&player).unwrap();
    let empty = folder.join("empty");
    std::fs::create_dir(&empty).unwrap();
    let missing = command("play", &folder).env("PATH", &empty).arg(&film).output().unwrap();
    assert_eq!(missing.status.code(), Some(1));
    assert!(words(&missing.stderr).contains("apt install mpv"), "{}", words(&missing.stderr));
}

fn libglvnd_is_led_to_the_library() {
    let folder = folder("libglvnd");
    let script = "echo glx=$__GLX_VENDOR_LIBRARY_NAME real=$CUPOLA_GLX_REAL; readlink ${LD_LIBRARY_PATH%%:*}/libGLX_cupola.so.0; \
                  echo path=$LD_LIBRARY_PATH; stat -c %a $(dirname ${LD_LIBRARY_PATH%%:*})";
    let output = cupola(&folder)
        .env("__GLX_VENDOR_LIBRARY_NAME", "nvidia")
        .env("LD_LIBRARY_PATH", "/some/where:/else")
        .args(["--", "sh", "-c", script])
        .output()
        .unwrap();
    let text = words(&output.stdout);
    assert!(text.contains("glx=cupola real=nvidia\n"), "{text}{}", words(&output.stderr));
    assert!(text.contains("/libcupola.so\n"), "{text}");
    assert!(text.contains(":/some/where:/else\n"), "{text}");
    assert!(text.ends_with("700\n"), "the folder is open to others: {text}");
    assert!(is_empty(&folder), "temporary files are left");
}

fn each_egl_vendor_gets_a_library_of_its_own() {
    let folder = folder("egl");
    let vendors = folder.join("vendors");
    std::fs::create_dir(&vendors).unwrap();
    let json = |path: &str| format!(r#"{{"file_format_version": "1.0.0", "ICD": {{"library_path": "{path}"}}}}"#);
    std::fs::write(vendors.join("20_b.json"), json("sub/libEGL_b.so.0")).unwrap();
    std::fs::write(vendors.join("10_a.json"), json("libEGL_a.so.0")).unwrap();
    std::fs::write(vendors.join("30_broken.json"), "{").unwrap();
    std::fs::write(vendors.join("readme.txt"), json("libEGL_c.so.0")).unwrap();
    let script = "echo real=$CUPOLA_EGL_REAL; echo files=$__EGL_VENDOR_LIBRARY_FILENAMES; \
                  for file in $(echo $__EGL_VENDOR_LIBRARY_FILENAMES | tr : ' '); do \
                  stat -Lc %i $(sed 's/.*library_path\":\"\\([^\"]*\\).*/\\1/' $file); done";
    let output =
        cupola(&folder).env("__EGL_VENDOR_LIBRARY_DIRS", &vendors).args(["--", "sh", "-c", script]).output().unwrap();
    let text = words(&output.stdout);
    let real = format!("real=libEGL_a.so.0:{}/sub/libEGL_b.so.0\n", vendors.display());
    assert!(text.starts_with(&real), "{text}{}", words(&output.stderr));
    let inodes: Vec<&str> = text.lines().skip(2).collect();
    assert!(inodes.len() == 2 && inodes[0] != inodes[1], "libEGL would load these as one library: {text}");
    // If the list of EGL vendors is empty, EGL stays unchanged.
    std::fs::create_dir(folder.join("none")).unwrap();
    let output = cupola(&folder)
        .env("__EGL_VENDOR_LIBRARY_DIRS", folder.join("none"))
        .args(["--", "sh", "-c", "echo files=$__EGL_VENDOR_LIBRARY_FILENAMES"])
        .output()
        .unwrap();
    assert_eq!(words(&output.stdout), "files=\n");
    assert!(words(&output.stderr).contains("lists no EGL vendor"));
}

fn a_broken_library_leaves_the_program_alone() {
    let folder = folder("broken_library");
    let script = "echo egl=$__EGL_VENDOR_LIBRARY_FILENAMES glx=$__GLX_VENDOR_LIBRARY_NAME";
    // A file that is no library, and a file that contains the names of the entry points but cannot
    // be loaded.
    for content in [&b"nothing"[..], b"\0__egl_Main\0__glx_Main\0"] {
        let library = folder.join("libbroken.so");
        std::fs::write(&library, content).unwrap();
        let output = cupola(&folder).env("CUPOLA_LIBRARY", &library).args(["--", "sh", "-c", script]).output().unwrap();
        assert_eq!(words(&output.stdout), "egl= glx=\n");
        assert!(output.status.success());
        let said = words(&output.stderr);
        assert!(said.contains("EGL will not be corrected") && said.contains("GLX will not be corrected"), "{said}");
    }
    // Control: the same checks accept the real library.
    let hooked = words(&shell(&folder, &[], script).stdout);
    assert!(hooked.contains("_cupola.json") && hooked.ends_with("glx=cupola\n"), "{hooked}");
    let missing = cupola(&folder).env("CUPOLA_LIBRARY", folder.join("none.so")).args(["--", "true"]).output().unwrap();
    assert_eq!(missing.status.code(), Some(1));
    assert!(words(&missing.stderr).contains("none.so"));
}

fn the_kill_switch_runs_the_program_plainly() {
    let folder = folder("kill_switch");
    let output = cupola(&folder).env("CUPOLA", "0").args(["--frames", "3", "--", "env"]).output().unwrap();
    let environment = words(&output.stdout);
    assert!(environment.contains("CUPOLA=0\n"));
    let settings = environment.replace("CUPOLA_LIBRARY", "");
    assert!(!settings.contains("CUPOLA_") && !environment.contains("VENDOR_LIBRARY"), "{environment}");
}

fn the_environment_is_printed_for_a_shell() {
    let folder = folder("print_environment");
    let cache = folder.join("it's here");
    let printed = || {
        let output =
            cupola(&folder).env("XDG_CACHE_HOME", &cache).args(["--camera", "zoom=2", "--print-environment"]).output();
        words(&output.unwrap().stdout)
    };
    printed();
    // The second call finds the files of the first.
    let script =
        format!("{}\nls \"${{LD_LIBRARY_PATH%%:*}}/libGLX_cupola.so.0\"; echo $CUPOLA_CAMERA $CUPOLA_RIG", printed());
    let output = Command::new("sh").arg("-c").arg(script).env_remove("LD_LIBRARY_PATH").output().unwrap();
    let text = words(&output.stdout);
    assert!(text.contains("it's here/cupola/lib/libGLX_cupola.so.0\n"), "{text}{}", words(&output.stderr));
    assert!(text.ends_with("zoom=2 fisheye\n"), "{text}");
}

fn headless_programs_have_a_display_of_their_own() {
    if !has_xvfb() {
        return;
    }
    let folder = folder("headless");
    let script = "echo $DISPLAY; test -S /tmp/.X11-unix/X${DISPLAY#:} && echo served; echo wayland=$WAYLAND_DISPLAY";
    let output =
        cupola(&folder).env("WAYLAND_DISPLAY", "wayland-0").args(["--headless", "--", "sh", "-c", script]).output();
    let text = words(&output.unwrap().stdout);
    assert!(text.starts_with(':') && text.ends_with("served\nwayland=\n"), "{text}");
    let socket = PathBuf::from(format!("/tmp/.X11-unix/X{}", text.lines().next().unwrap().trim_start_matches(':')));
    wait_until("the display is gone", || !socket.exists());
    assert!(is_empty(&folder), "temporary files are left");
}

fn the_library_is_between_program_and_driver() {
    if !has_xvfb() {
        return;
    }
    let folder = folder("between");
    let ask = [env!("CARGO_BIN_EXE_cupola"), "probe", "glx"];
    let loaded = |switch: &str| {
        let output = cupola(&folder).env("CUPOLA", switch).args(["--headless", "--"]).args(ask).output().unwrap();
        assert!(output.status.success(), "{}", words(&output.stderr));
        words(&output.stdout)
    };
    assert!(loaded("1").contains("libcupola.so"));
    assert!(!loaded("0").contains("libcupola.so"));
}

fn signals_reach_the_program_and_everything_is_tidied_up() {
    if !has_xvfb() {
        return;
    }
    let folder = folder("signals");
    let note = folder.join("note");
    let script = format!(
        "trap 'echo caught >> {0}; exit 5' TERM; echo $DISPLAY > {0}; while :; do sleep 0.05; done",
        note.display()
    );
    let mut child = cupola(&folder).args(["--headless", "--", "sh", "-c", &script]).spawn().unwrap();
    let display = || std::fs::read_to_string(&note).unwrap_or_default().lines().next().unwrap_or_default().to_owned();
    wait_until("the program runs", || display().starts_with(':'));
    // `kill` is built into the shell. A minimal Debian has no such program.
    assert!(Command::new("sh").args(["-c", &format!("kill {}", child.id())]).status().unwrap().success());
    assert_eq!(child.wait().unwrap().code(), Some(5));
    assert!(std::fs::read_to_string(&note).unwrap().contains("caught"));
    std::fs::remove_file(&note).unwrap();
    assert!(is_empty(&folder), "temporary files are left");
}

fn the_display_does_not_outlive_a_killed_cupola() {
    if !has_xvfb() {
        return;
    }
    let folder = folder("killed");
    let note = folder.join("note");
    let script = format!("echo $DISPLAY > {}; sleep 3", note.display());
    let mut child = cupola(&folder).args(["--headless", "--", "sh", "-c", &script]).spawn().unwrap();
    let display = || std::fs::read_to_string(&note).unwrap_or_default().trim().to_owned();
    wait_until("the program runs", || display().starts_with(':'));
    let socket = PathBuf::from(format!("/tmp/.X11-unix/X{}", display().trim_start_matches(':')));
    assert!(socket.exists());
    child.kill().unwrap();
    child.wait().unwrap();
    wait_until("the display is gone", || !socket.exists());
}

fn a_missing_xvfb_is_named_with_its_package() {
    let folder = folder("no_xvfb");
    let output = cupola(&folder).env("PATH", &folder).args(["--headless", "--", "/bin/true"]).output().unwrap();
    assert_eq!(output.status.code(), Some(1));
    assert!(words(&output.stderr).contains("package xvfb"), "{}", words(&output.stderr));
    // If Xvfb does not start, the message contains its own words.
    let fake = folder.join("Xvfb");
    std::fs::write(&fake, "#!/bin/sh\necho no room for a screen >&2\n").unwrap();
    std::fs::set_permissions(&fake, std::fs::Permissions::from_mode(0o755)).unwrap();
    let output = cupola(&folder).env("PATH", &folder).args(["--headless", "--", "/bin/true"]).output().unwrap();
    assert!(words(&output.stderr).contains("no room for a screen"), "{}", words(&output.stderr));
}

fn main() -> std::process::ExitCode {
    harness::run(tests())
}
