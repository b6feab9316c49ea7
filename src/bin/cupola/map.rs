//! `cupola map`: writes the direction of each pixel of an output to a file for other programs.

use crate::failure::Failure;
use crate::planning::request;
use crate::terminal;
use cupola::backend::{gl, vk};
use cupola::correct::shaders::map::MapPixel;
use cupola::rig::Rig;
use cupola::warp::{MapError, WarpMap, camera_direction, compare};
use glam::{DVec2, DVec3};
use serde_json::json;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Write the direction of each pixel of an output to a PFM file.
///
/// The file has three floats for each pixel: a unit vector in the axes of the program's camera (x
/// right, y up, z backward), or three NaN where the output shows nothing. Rows go from bottom to
/// top.
#[derive(clap::Args)]
pub struct Arguments {
    /// Rig file or name of a preset
    #[arg(value_name = "FILE|PRESET")]
    rig: String,
    /// Name of the output [default: the only output]
    #[arg(long, value_name = "NAME")]
    output: Option<String>,
    /// File to write
    #[arg(short = 'o', long = "out", value_name = "FILE.pfm")]
    file: PathBuf,
    /// Compute the exact map with one ray per pixel in double precision (default)
    #[arg(long, conflicts_with = "gpu")]
    exact: bool,
    /// Compute the map on the graphics driver and print its error against the exact map
    #[arg(long)]
    gpu: bool,
    /// Graphics API for --gpu
    #[arg(long, value_enum, default_value_t = Backend::Gl, requires = "gpu")]
    backend: Backend,
    /// Size of the output in pixels [default: from the rig, or its part of a window of 1920x1200]
    #[arg(long, value_name = "WxH", value_parser = crate::arguments::size)]
    size: Option<(u32, u32)>,
    /// Print the result as JSON
    #[arg(long)]
    json: bool,
}

/// A graphics API.
#[derive(Clone, Copy, clap::ValueEnum)]
enum Backend {
    /// OpenGL
    Gl,
    /// Vulkan
    Vk,
}

/// Runs the subcommand.
pub fn run(arguments: &Arguments) -> Result<ExitCode, Failure> {
    // Directions of pixels do not depend on the content.
    let rig = Rig { content: None, ..cupola::rig::load(&arguments.rig)?.with_all_outputs().into_owned() };
    let output = find_output(&rig, arguments.output.as_deref())?;
    let size = arguments.size.unwrap_or_else(|| native_size(&rig, output));
    let exact = WarpMap::new(&rig, output, size, None)?;
    let (directions, driver, error) = if arguments.gpu {
        let (directions, driver) = computed(&rig, output, size, arguments.backend)?;
        let look = |x: u32, y: u32| directions[(y * size.0 + x) as usize];
        let error = compare(&exact, 1, look);
        (directions, Some(driver), Some(error))
    } else {
        (traced(&exact), None, None)
    };
    let shown = directions.iter().flatten().count();
    let camera = directions.iter().map(|direction| direction.map(|direction| camera_direction(&rig, direction)));
    write_pfm(&arguments.file, size, camera.collect())?;
    if arguments.json {
        println!("{:#}", summary(&rig, output, size, shown, driver.as_deref(), error.as_ref()));
    } else {
        let name = &rig.outputs[output].name;
        println!("{name}: {} × {} pixels, {shown} of them show something", size.0, size.1);
        if let (Some(driver), Some(error)) = (driver, error) {
            println!("computed by {driver}");
            println!(
                "greatest error {:.6} pixels at column {}, row {}; root mean square {:.6}",
                error.max, error.worst.0, error.worst.1, error.rms
            );
            println!("{} pixels missing, {} false, {} not finite", error.uncovered, error.ghosts, error.non_finite);
        }
    }
    Ok(ExitCode::SUCCESS)
}

/// Index of the output called `name`. Without a name, index of the only output.
fn find_output(rig: &Rig, name: Option<&str>) -> Result<usize, Failure> {
    let names: Vec<&str> = rig.outputs.iter().map(|output| output.name.as_str()).collect();
    let found = match (name, names.len()) {
        (_, 0) => return Err(Failure::usage(format!("the rig {} has no outputs", rig.name))),
        (None, 1) => Some(0),
        (None, _) => None,
        (Some(name), _) => names.iter().position(|known| *known == name),
    };
    found.ok_or_else(|| match name {
        Some(name) => {
            Failure::usage(format!("the rig {} has no output {name:?}; it has {}", rig.name, names.join(", ")))
        }
        None => Failure::usage(format!("the rig has several outputs; --output takes one of {}", names.join(", "))),
    })
}

/// The resolution of an output: its own, or that of its part of the window.
pub fn native_size(rig: &Rig, output: usize) -> (u32, u32) {
    let place = |window| {
        let (width, height) = rig.layout(window)[output].size();
        (width.max(1), height.max(1))
    };
    rig.outputs[output].size.unwrap_or_else(|| place(rig.extent().unwrap_or((1920, 1200))))
}

/// The exact direction of every pixel centre, row by row from the top, computed on all processors.
fn traced(map: &WarpMap) -> Vec<Option<DVec3>> {
    let (width, height) = (map.size().0 as usize, map.size().1 as usize);
    let mut directions = vec![None; width * height];
    let bar = terminal::progress(height as u64, "rows");
    let workers = std::thread::available_parallelism().map_or(1, usize::from);
    let rows = height.div_ceil(workers);
    std::thread::scope(|scope| {
        for (part, band) in directions.chunks_mut(rows * width).enumerate() {
            let bar = &bar;
            scope.spawn(move || {
                for (row, line) in band.chunks_mut(width).enumerate() {
                    let y = (part * rows + row) as f64 + 0.5;
                    for (column, direction) in line.iter_mut().enumerate() {
                        *direction = map.direction(DVec2::new(column as f64 + 0.5, y));
                    }
                    bar.inc(1);
                }
            });
        }
    });
    bar.finish_and_clear();
    directions
}

/// The directions that the shaders compute, and the name of the driver.
fn computed(
    rig: &Rig,
    output: usize,
    size: (u32, u32),
    backend: Backend,
) -> Result<(Vec<Option<DVec3>>, String), Failure> {
    let spinner = terminal::spinner("computing the map on the graphics driver");
    let mut output_sizes: Vec<(u32, u32)> = (0..rig.outputs.len()).map(|index| native_size(rig, index)).collect();
    output_sizes[output] = size;
    let request = request(output_sizes, (1920, 1200));
    let plan = cupola::correct::build(rig, &request)?;
    let (pixels, driver) = match backend {
        Backend::Gl => {
            let context = gl::driver::headless::Headless::new(gl::driver::headless::Api::Core)?;
            (gl::gpu_map(&context.gl, context.is_gles, &plan, output)?, context.driver())
        }
        Backend::Vk => {
            let device = vk::driver::headless::Headless::new(&[])?;
            (vk::gpu_map(&device, &plan, output)?, device.driver.clone())
        }
    };
    spinner.finish_and_clear();
    let direction = |pixel: &MapPixel| pixel.view.map(|_| DVec3::from_array(pixel.direction.map(f64::from)));
    Ok((pixels.iter().map(direction).collect(), driver))
}

/// Writes a colour PFM: a header in text, then little-endian floats from the bottom row to the top
/// one.
fn write_pfm(path: &Path, size: (u32, u32), directions: Vec<Option<DVec3>>) -> Result<(), Failure> {
    let mut bytes = format!("PF\n{} {}\n-1.0\n", size.0, size.1).into_bytes();
    bytes.reserve(directions.len() * 12);
    for row in directions.chunks(size.0 as usize).rev() {
        for direction in row {
            let values = direction.unwrap_or(DVec3::NAN).as_vec3().to_array();
            bytes.extend(values.iter().flat_map(|value| value.to_le_bytes()));
        }
    }
    let written = cupola::system::create(path).and_then(|mut file| file.write_all(&bytes));
    written.map_err(|error| Failure::new(format!("{} cannot be written: {error}", path.display())))
}

fn summary(
    rig: &Rig,
    output: usize,
    size: (u32, u32),
    shown: usize,
    driver: Option<&str>,
    error: Option<&MapError>,
) -> serde_json::Value {
    let error = error.map(|error| {
        json!({
            "max": error.max,
            "rms": error.rms,
            "worst": [error.worst.0, error.worst.1],
            "compared": error.compared,
            "edge": error.edge,
            "uncovered": error.uncovered,
            "ghosts": error.ghosts,
            "non_finite": error.non_finite,
        })
    });
    json!({
        "rig": rig.name,
        "output": rig.outputs[output].name,
        "size": [size.0, size.1],
        "shown": shown,
        "driver": driver,
        "error_pixels": error,
    })
}
