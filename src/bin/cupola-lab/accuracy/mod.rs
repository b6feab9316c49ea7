//! `cupola-lab accuracy`: maps that the shaders compute for every screen with every lens, compared
//! with the exact maps.

mod cases;

use crate::failure::Failure;
use crate::meshes::Folder;
use crate::planning::request;
use crate::terminal;
use cases::{Case, Row};
use cupola::backend::gl::driver::headless::{Api, Headless};
use cupola::backend::gl::gpu_map;
use cupola::correct::Source;
use cupola::views::Surveyor;
use cupola::warp::{MapError, WarpMap, compare_each};
use glam::DVec3;
use serde_json::json;
use std::process::ExitCode;

/// Compare the maps that the graphics driver computes with the exact maps, for every screen and
/// every lens.
///
/// Errors are in pixels of a picture 3840 pixels wide, or in texels where texels are larger because
/// of the driver's texture size limit. The exit code is 1 if a bound is exceeded.
#[derive(clap::Args)]
pub struct Arguments {
    /// Size of the compared pictures in pixels
    #[arg(long, value_name = "WxH", value_parser = crate::arguments::size, default_value = "640x360")]
    size: (u32, u32),
    /// Compare only every N-th case
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..))]
    every: u32,
    /// Compare only every N-th pixel of every N-th row with the exact map; all pixels are checked
    /// for NaN and infinity
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..))]
    step: u32,
    /// Print the result as JSON
    #[arg(long)]
    json: bool,
}

/// Width in pixels of the picture in whose pixels errors are given.
const REFERENCE_WIDTH: f64 = 3840.0;
/// Greatest error of a formula with viewer and projector within 0.9 radii of the centre.
const INSIDE: f64 = 0.002;
/// Greatest error of projectors outside, and of tables: 5·10⁻⁷ of the width of a view of twice
/// [`REFERENCE_WIDTH`].
const OUTSIDE: f64 = 0.004;

/// Result for one screen with one lens.
struct Found {
    row: Row,
    cases: u32,
    pixels: u64,
    /// Greatest error of projectors within 0.9 radii, and of those farther out; `None` without such
    /// a case.
    worst: [Option<f64>; 2],
    /// True if a case exceeds its bound.
    exceeded: bool,
    wrong: u64,
    squares: f64,
}

/// Runs the subcommand.
pub fn run(arguments: &Arguments) -> Result<ExitCode, Failure> {
    let context = Headless::new(Api::Core)?;
    let folder = Folder::new()?;
    let rows = cases::rows();
    let bar = terminal::progress(rows.len() as u64, "rows");
    if !arguments.json {
        println!("| screen | lens or picture | cases | up to 0.9 R, px | 2 R … 10⁶ R, px | rms, px | pixels | wrong |");
        println!("|---|---|---|---|---|---|---|---|");
    }
    let mut number = 0u32;
    let mut results = Vec::with_capacity(rows.len());
    for row in rows {
        let mut result = Found { row, cases: 0, pixels: 0, worst: [None; 2], exceeded: false, wrong: 0, squares: 0.0 };
        for case in result.row.cases() {
            number += 1;
            // A projector that does not reach the screen from this position is not a case.
            if let (true, Some(rig)) = (number.is_multiple_of(arguments.every), folder.rig(&case.text).ok()) {
                let (error, by_table) = measured(&context, &rig, arguments)
                    .map_err(|failure| Failure::new(format!("{}\n{}", failure.message, case.text)))?;
                result.add(&case, &error, by_table, REFERENCE_WIDTH / f64::from(arguments.size.0));
            }
        }
        if result.cases > 0 && !arguments.json {
            println!("{}", result.line());
        }
        results.push(result);
        bar.inc(1);
    }
    bar.finish_and_clear();
    if arguments.json {
        let compared: Vec<_> = results.iter().filter(|result| result.cases > 0).map(Found::json).collect();
        println!("{:#}", json!({ "driver": context.driver(), "rows": compared }));
    }
    Ok(if results.iter().all(Found::is_good) { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

/// The error of the driver's map of a rig's only output, and whether the map comes from a table.
fn measured(
    context: &Headless,
    rig: &cupola::rig::Rig,
    &Arguments { size, step, .. }: &Arguments,
) -> Result<(MapError, bool), Failure> {
    let request = request(vec![size], size);
    let plan = cupola::correct::build(rig, &request)?;
    let map = gpu_map(&context.gl, context.is_gles, &plan, 0)?;
    let exact = WarpMap::new(rig, 0, size, None)?;
    let surveyor = Surveyor::new(&plan.views, rig, 0, size)?;
    let scale = REFERENCE_WIDTH / f64::from(size.0);
    let look = |x: u32, y: u32| {
        let pixel = &map[(y * size.0 + x) as usize];
        pixel.view.map(|_| DVec3::from_array(pixel.direction.map(f64::from)))
    };
    let mut greatest = 0.0f64;
    let error = compare_each(&exact, step, look, |found| {
        // The error of a view that is coarser than the output, because of the size limit, counts in
        // texels.
        let coarse = || surveyor.at(found.centre()).and_then(|pixel| pixel.texels_per_pixel).unwrap_or(1.0).min(1.0);
        greatest = greatest.max(found.pixels * if found.pixels * scale > INSIDE { coarse() } else { 1.0 });
    });
    // Compared pixels have been counted above.
    let left_out = |index: &usize| {
        !(index % size.0 as usize).is_multiple_of(step as usize)
            || !(index / size.0 as usize).is_multiple_of(step as usize)
    };
    let no_number =
        |index: &usize| map[*index].view.is_some() && !map[*index].direction.iter().all(|part| part.is_finite());
    let non_finite = error.non_finite + (0..map.len()).filter(left_out).filter(no_number).count() as u64;
    Ok((MapError { max: greatest, non_finite, ..error }, matches!(plan.passes[0].source, Source::Table(_))))
}

impl Found {
    fn add(&mut self, case: &Case, error: &MapError, by_table: bool, scale: f64) {
        self.cases += 1;
        self.pixels += error.compared;
        let worst = &mut self.worst[usize::from(case.outside)];
        *worst = Some(worst.unwrap_or(0.0).max(error.max * scale));
        self.exceeded |= error.max * scale > if case.outside || by_table { OUTSIDE } else { INSIDE };
        self.wrong += error.non_finite + error.ghosts + error.uncovered;
        self.squares += (error.rms * scale).powi(2) * error.compared as f64;
    }

    fn rms(&self) -> f64 {
        (self.squares / self.pixels.max(1) as f64).sqrt()
    }

    fn is_good(&self) -> bool {
        self.wrong == 0 && !self.exceeded
    }

    fn line(&self) -> String {
        let words = |worst: Option<f64>| worst.map_or("–".to_owned(), |worst| format!("{worst:.5}"));
        format!(
            "| {} | {} | {} | {} | {} | {:.5} | {} | {} |",
            self.row.screen,
            self.row.lens,
            self.cases,
            words(self.worst[0]),
            words(self.worst[1]),
            self.rms(),
            self.pixels,
            self.wrong
        )
    }

    fn json(&self) -> serde_json::Value {
        json!({
            "screen": self.row.screen,
            "lens": self.row.lens,
            "cases": self.cases,
            "pixels": self.pixels,
            "inside": self.worst[0],
            "outside": self.worst[1],
            "rms": self.rms(),
            "wrong": self.wrong,
            "good": self.is_good(),
        })
    }
}
