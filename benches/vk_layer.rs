//! Cost of the Vulkan layer for a third-party program: `vkcube` without and with it.
//!
//! `cargo bench --bench vk_layer [-- SIZE FRAMES ROUNDS]`, with a display and `vkcube` (Debian:
//! vulkan-tools). The programs run in turn, round by round, and each round begins with another one.
//! The medians of the ratios are printed. If the environment variable `VKBASALT` names vkBasalt's
//! library, that layer runs, too, with its sharpening effect.

use std::path::Path;
use std::process::{Command, Stdio};
use std::time::Instant;

type Failure = Box<dyn std::error::Error>;

/// One way to start the program.
struct Contestant {
    name: &'static str,
    environment: Vec<(&'static str, String)>,
    /// Elapsed time, and processor time of all threads.
    seconds: Vec<(f64, f64)>,
}

fn main() -> Result<(), Failure> {
    let numbers: Vec<u32> = std::env::args().skip(1).filter_map(|a| a.parse().ok()).collect();
    let number = |index: usize, default: u32| numbers.get(index).copied().unwrap_or(default);
    let (size, frames, rounds) = (number(0, 500), number(1, 1000), number(2, 7) as usize);
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("vk_layer");
    std::fs::create_dir_all(&folder)?;
    let mut contestants = contestants(&folder)?;
    println!("vkcube, {size}×{size}, {frames} frames, {rounds} rounds");
    for round in 0..=rounds {
        // Each round begins with another one.
        contestants.rotate_left(1);
        for contestant in &mut contestants {
            let measured = run(contestant, size, frames)?;
            // The first round warms up.
            if round > 0 {
                contestant.seconds.push(measured);
            }
        }
    }
    report(&contestants);
    Ok(())
}

fn contestants(folder: &Path) -> Result<Vec<Contestant>, Failure> {
    let library = std::env::current_exe()?.with_file_name("libcupola.so");
    if !library.exists() {
        return Err(format!("{} is missing: cargo bench builds it", library.display()).into());
    }
    let layer = |name: &str, library: &Path| -> Result<Vec<(&'static str, String)>, Failure> {
        let place = folder.join(name);
        std::fs::create_dir_all(&place)?;
        std::fs::write(
            place.join("layer.json"),
            format!(
                "{{\"file_format_version\": \"1.0.0\", \"layer\": {{\"name\": \"{name}\", \"type\": \"GLOBAL\", \
                 \"library_path\": \"{}\", \"api_version\": \"1.3.280\", \"implementation_version\": \"1\", \
                 \"description\": \"measured\"}}}}",
                library.display()
            ),
        )?;
        Ok(vec![("VK_ADD_LAYER_PATH", place.display().to_string()), ("VK_INSTANCE_LAYERS", name.to_owned())])
    };
    let mut all = vec![Contestant { name: "plain", environment: Vec::new(), seconds: Vec::new() }];
    for rig in ["identity", "identity-captured", "fisheye"] {
        let mut environment = layer("VK_LAYER_CUPOLA_dome", &library)?;
        environment.push(("CUPOLA_RIG", rig.to_owned()));
        all.push(Contestant { name: rig, environment, seconds: Vec::new() });
    }
    if let Some(other) = std::env::var_os("VKBASALT") {
        let (config, other) = (folder.join("vkBasalt.conf"), Path::new(&other).canonicalize()?);
        std::fs::write(&config, "effects = cas\ncasSharpness = 0.4\n")?;
        let mut environment = layer("VK_LAYER_VKBASALT_post_processing", &other)?;
        environment
            .extend([("ENABLE_VKBASALT", "1".to_owned()), ("VKBASALT_CONFIG_FILE", config.display().to_string())]);
        all.push(Contestant { name: "vkBasalt, cas", environment, seconds: Vec::new() });
    }
    Ok(all)
}

/// Runs the program. Returns elapsed and processor seconds.
fn run(contestant: &Contestant, size: u32, frames: u32) -> Result<(f64, f64), Failure> {
    let (started, used) = (Instant::now(), children_seconds());
    let status = Command::new("vkcube")
        .args(["--c", &frames.to_string(), "--width", &size.to_string(), "--height", &size.to_string()])
        // Immediately: not at the display's rate.
        .args(["--present_mode", "0"])
        .envs(contestant.environment.iter().map(|(name, value)| (name, value)))
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .status()
        .map_err(|error| format!("vkcube cannot be started (Debian: vulkan-tools): {error}"))?;
    if !status.success() {
        return Err(format!("vkcube fails ({}): {status}", contestant.name).into());
    }
    Ok((started.elapsed().as_secs_f64(), children_seconds() - used))
}

/// Processor time of all children that have ended.
fn children_seconds() -> f64 {
    // SAFETY: all zeros are a value of this structure.
    let mut usage: libc::rusage = unsafe { std::mem::zeroed() };
    // SAFETY: the pointer is to the local structure above.
    unsafe { libc::getrusage(libc::RUSAGE_CHILDREN, &mut usage) };
    let seconds = |time: libc::timeval| time.tv_sec as f64 + time.tv_usec as f64 * 1e-6;
    seconds(usage.ru_utime) + seconds(usage.ru_stime)
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(f64::NAN)
}

fn report(contestants: &[Contestant]) {
    let Some(plain) = contestants.iter().find(|contestant| contestant.environment.is_empty()) else { return };
    println!("{:20} {:>12} {:>14} {:>8} {:>17}", "", "elapsed s", "processor s", "ratio", "processor's ratio");
    for contestant in contestants {
        let of = |pick: fn(&(f64, f64)) -> f64| median(contestant.seconds.iter().map(pick).collect());
        let ratio = |pick: fn(&(f64, f64)) -> f64| {
            median(contestant.seconds.iter().zip(&plain.seconds).map(|(a, b)| pick(a) / pick(b)).collect())
        };
        println!(
            "{:20} {:12.2} {:14.2} {:8.2} {:17.2}",
            contestant.name,
            of(|seconds| seconds.0),
            of(|seconds| seconds.1),
            ratio(|seconds| seconds.0),
            ratio(|seconds| seconds.1)
        );
    }
}
