//! `cupola simulate`: sum of the captured frames of all outputs on the dome.

use crate::failure::Failure;
use crate::terminal;
use cupola::blend::{Picture, Simulation, code_of, simulate};
use cupola::rig::Rig;
use glam::DVec2;
use serde_json::json;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Add up the captured pictures of all outputs on the dome and report the uniformity of the light.
#[derive(clap::Args)]
pub struct Arguments {
    /// Rig file or name of a preset
    #[arg(value_name = "FILE|PRESET")]
    rig: String,
    /// Folder with a picture for each output: NAME.png, or any-NAME.png as `run --capture any.png`
    /// writes them
    #[arg(long, value_name = "DIR", required_unless_present = "white")]
    captures: Option<PathBuf>,
    /// Use white pictures, dimmed by the blend weights and masks of each output, instead of
    /// captures
    #[arg(long, conflicts_with = "captures")]
    white: bool,
    /// Picture to write: a fisheye of the dome as the viewer sees it
    #[arg(short = 'o', long = "out", value_name = "DOME.png")]
    file: PathBuf,
    /// Width and height of the picture in pixels
    #[arg(long, value_name = "N", default_value_t = 1024, value_parser = clap::value_parser!(u32).range(1..=8192))]
    size: u32,
    /// Print the result as JSON
    #[arg(long)]
    json: bool,
}

/// Runs the subcommand.
pub fn run(arguments: &Arguments) -> Result<ExitCode, Failure> {
    let rig = cupola::rig::load(&arguments.rig)?.with_all_outputs().into_owned();
    if rig.outputs.is_empty() {
        return Err(Failure::usage(format!("the rig {} has no outputs", rig.name)));
    }
    let spinner = terminal::spinner("adding up the light");
    let pictures = match &arguments.captures {
        Some(folder) => captures(&rig, folder)?,
        None => white(&rig)?,
    };
    let simulation = simulate(&rig, &pictures, arguments.size)?;
    write(&arguments.file, &simulation)?;
    spinner.finish_and_clear();
    let shares = shares(&simulation);
    let even = &simulation.uniformity;
    if arguments.json {
        let answer = json!({
            "rig": rig.name,
            "size": simulation.size,
            "uniformity": { "max": even.max, "rms": even.rms, "mean": even.mean, "pixels": even.covered_pixels },
            "lit_by": shares,
        });
        println!("{answer:#}");
        return Ok(ExitCode::SUCCESS);
    }
    println!("{}: {} × {} pixels of the dome", arguments.file.display(), simulation.size, simulation.size);
    for (count, share) in shares.iter().enumerate() {
        let outputs = if count == 1 { "output" } else { "outputs" };
        println!("{:6.2} % of the circle lit by {count} {outputs}", share * 100.0);
    }
    let about = if arguments.white { "" } else { " (meaningful only if all pictures are white)" };
    println!(
        "light against even white{about}: mean {:.5}, greatest deviation {:.5}, root mean square {:.5}",
        even.mean, even.max, even.rms
    );
    Ok(ExitCode::SUCCESS)
}

/// The captured picture of each output, in the order of the rig.
fn captures(rig: &Rig, folder: &Path) -> Result<Vec<Picture>, Failure> {
    let unreadable = |error: std::io::Error| Failure::usage(format!("{} cannot be read: {error}", folder.display()));
    let entries = std::fs::read_dir(folder).map_err(unreadable)?.flatten().map(|entry| entry.path());
    let mut files: Vec<PathBuf> = entries.filter(|path| path.extension().is_some_and(|kind| kind == "png")).collect();
    files.sort();
    let names: Vec<&str> = rig.outputs.iter().map(|output| output.name.as_str()).collect();
    names.iter().map(|name| find(name, &names, &files, folder).and_then(|file| read(&file))).collect()
}

/// The file in `files` that shows the output `name`.
fn find(name: &str, names: &[&str], files: &[PathBuf], folder: &Path) -> Result<PathBuf, Failure> {
    let stem = |file: &PathBuf| file.file_stem().map(|stem| stem.to_string_lossy().into_owned()).unwrap_or_default();
    // `a-back-left` belongs to `back-left` and not to `left`: the longest matching name counts.
    let owner = |stem: &str| {
        let fits = |name: &&&str| stem == **name || stem.ends_with(&format!("-{name}"));
        names.iter().filter(fits).max_by_key(|name| name.len()).copied()
    };
    let mut found: Vec<&PathBuf> = files.iter().filter(|file| owner(&stem(file)) == Some(name)).collect();
    if let ([_], [only]) = (names, files) {
        found = vec![only];
    }
    match found[..] {
        [file] => Ok(file.clone()),
        [] => Err(Failure::usage(format!(
            "{} has no picture of {name}; expected {name}.png or any-{name}.png",
            folder.display()
        ))),
        _ => {
            let listed: Vec<String> = found.iter().map(|file| file.display().to_string()).collect();
            Err(Failure::usage(format!("several pictures fit the output {name}: {}", listed.join(", "))))
        }
    }
}

fn read(file: &Path) -> Result<Picture, Failure> {
    let unreadable = |error: String| Failure::usage(format!("{} cannot be read: {error}", file.display()));
    let reader = image::ImageReader::open(file).map_err(|error| unreadable(error.to_string()))?;
    let image = reader.decode().map_err(|error| unreadable(error.to_string()))?.into_rgb32f();
    Ok(Picture { width: image.width(), height: image.height(), rgb: image.into_raw() })
}

/// White pictures, dimmed by the blend weights and masks of the outputs.
fn white(rig: &Rig) -> Result<Vec<Picture>, Failure> {
    let sizes: Vec<(u32, u32)> = (0..rig.outputs.len()).map(|output| crate::map::native_size(rig, output)).collect();
    let weights = cupola::blend::Weights::new(rig, &sizes)?;
    let picture = |(output, &(width, height)): (usize, &(u32, u32))| -> Result<Picture, Failure> {
        let described = &rig.outputs[output];
        let blend = &described.blend;
        let mask = described.mask.as_deref().map(cupola::rig::read_mask).transpose()?;
        let value = |index: u32| {
            let pixel = DVec2::new(f64::from(index % width) + 0.5, f64::from(index / width) + 0.5);
            // A mask is mirrored with its picture.
            let place = described.flip.pixel(pixel, (width, height)) / DVec2::new(f64::from(width), f64::from(height));
            let masked = mask.as_ref().map_or(1.0, |(size, values)| mask_at(values, *size, place));
            let light = weights.weight(output, pixel).unwrap_or(0.0) * masked;
            [0, 1, 2].map(|channel| code_of(light, blend, channel) as f32)
        };
        Ok(Picture { width, height, rgb: (0..width * height).flat_map(value).collect() })
    };
    sizes.iter().enumerate().map(picture).collect()
}

/// Weight of a mask at a place, in parts of width and height from the top left, interpolated
/// between the four nearest pixels.
fn mask_at(values: &[u16], (width, height): (u32, u32), place: DVec2) -> f64 {
    let at = (place * DVec2::new(f64::from(width), f64::from(height)) - 0.5).max(DVec2::ZERO);
    let last = |size: u32| size.saturating_sub(1);
    let (x, y) = ((at.x as u32).min(last(width)), (at.y as u32).min(last(height)));
    let (right, down) = ((x + 1).min(last(width)), (y + 1).min(last(height)));
    let part = (at - DVec2::new(f64::from(x), f64::from(y))).clamp(DVec2::ZERO, DVec2::ONE);
    let value = |x: u32, y: u32| f64::from(values[y as usize * width as usize + x as usize]) / f64::from(u16::MAX);
    let row = |y: u32| value(x, y) * (1.0 - part.x) + value(right, y) * part.x;
    row(y) * (1.0 - part.y) + row(down) * part.y
}

/// Share of the circle that is lit by 0, 1, 2 … outputs.
fn shares(simulation: &Simulation) -> Vec<f64> {
    let size = simulation.size as usize;
    let middle = (size as f64 - 1.0) / 2.0;
    let inside = |index: &usize| {
        let (x, y) = ((index % size) as f64 - middle, (index / size) as f64 - middle);
        4.0 * (x * x + y * y) <= (size * size) as f64
    };
    let mut counts = Vec::new();
    for index in (0..simulation.coverage.len()).filter(inside) {
        let count = usize::from(simulation.coverage[index]);
        counts.resize(counts.len().max(count + 1), 0_u64);
        counts[count] += 1;
    }
    let total: u64 = counts.iter().sum();
    counts.iter().map(|count| *count as f64 / total.max(1) as f64).collect()
}

/// Writes the picture with 8 bits per channel. Light above white is clamped.
fn write(file: &Path, simulation: &Simulation) -> Result<(), Failure> {
    let bytes: Vec<u8> = simulation.rgb.iter().map(|value| (value.clamp(0.0, 1.0) * 255.0).round() as u8).collect();
    let kind = image::ExtendedColorType::Rgb8;
    image::save_buffer_with_format(file, &bytes, simulation.size, simulation.size, kind, image::ImageFormat::Png)
        .map_err(|error| Failure::new(format!("{} cannot be written: {error}", file.display())))
}
