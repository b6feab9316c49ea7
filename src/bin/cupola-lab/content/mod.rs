//! `cupola-lab content`: compares captured pictures of content with the exact map.
//!
//! `prediction` computes what each pixel has to show, `pixels` compares the outputs, `seams` what
//! the audience sees where projectors overlap.

mod pixels;
mod prediction;
mod seams;

use crate::failure::Failure;
use cupola::rig::ContentKind;
use pixels::Difference;
use prediction::Prediction;
use seams::Seams;
use serde_json::json;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Compare captured pictures of a program with `--content domemaster` with what the exact map says
/// that they must show.
#[derive(clap::Args)]
pub struct Arguments {
    /// Rig file or name of a preset
    #[arg(value_name = "FILE|PRESET")]
    rig: String,
    /// The content, as for `cupola run`; a fisheye picture
    #[arg(long, value_name = "KIND[,KEY=VALUE,…]", default_value = "domemaster")]
    content: String,
    /// The program's own picture, captured with the rig `identity`
    #[arg(long, value_name = "FILE.png")]
    plain: PathBuf,
    /// Captured pictures, as given to `cupola run --capture`
    #[arg(long, value_name = "FILE.png")]
    captures: PathBuf,
    /// Width and height of the picture in which borders of overlaps are examined
    #[arg(long, value_name = "N", default_value_t = 1024, value_parser = clap::value_parser!(u32).range(16..=8192))]
    size: u32,
    /// Print the result as JSON
    #[arg(long)]
    json: bool,
}

/// Runs the subcommand.
pub fn run(arguments: &Arguments) -> Result<ExitCode, Failure> {
    let rig = cupola::rig::load(&arguments.rig)?.with_content_override(&arguments.content)?;
    let kind = rig.content.as_ref().map(|content| &content.kind);
    let is_fisheye = |kind: &ContentKind| matches!(kind, ContentKind::Directions(panorama) if panorama.is_circular());
    if !kind.is_some_and(is_fisheye) {
        return Err(Failure::usage(format!("{:?} is no fisheye picture; expected domemaster", arguments.content)));
    }
    let plain = prediction::read(&arguments.plain)?;
    let names: Vec<&str> = rig.outputs.iter().map(|output| output.name.as_str()).collect();
    let files = names.iter().map(|name| file_of(&arguments.captures, name, names.len()));
    let captures = files.map(|file| prediction::read(&file)).collect::<Result<Vec<_>, _>>()?;
    let sizes: Vec<(u32, u32)> = captures.iter().map(|picture| (picture.width, picture.height)).collect();
    let around = rig.around_content();
    let prediction = Prediction::new(&around, &plain, &sizes)?;
    let differences = captures.iter().enumerate().map(|(index, shown)| Difference::of(&prediction, index, shown));
    let differences: Vec<Difference> = differences.collect();
    let seams = Seams::of(&rig, &prediction, &captures, arguments.size)?;
    if arguments.json {
        let outputs: Vec<_> = names.iter().zip(&differences).map(|(name, found)| found.json(name)).collect();
        println!("{:#}", json!({ "rig": rig.name, "outputs": outputs, "audience": seams.json(&names) }));
    } else {
        println!("{}", Difference::head());
        names.iter().zip(&differences).for_each(|(name, found)| println!("{}", found.line(name)));
        print!("{}", seams.lines(&names));
    }
    let good = differences.iter().all(Difference::is_good) && seams.is_good();
    Ok(if good { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

/// The file that `cupola run --capture file` writes for an output.
fn file_of(file: &Path, name: &str, outputs: usize) -> PathBuf {
    let stem = file.file_stem().unwrap_or_default().to_string_lossy();
    if outputs == 1 { file.to_owned() } else { file.with_file_name(format!("{stem}-{name}.png")) }
}
