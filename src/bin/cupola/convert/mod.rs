//! `cupola convert`: rigs and calibration files into the formats of other programs.

mod calibration;
mod projector;
mod rig;
mod sgct;
mod source;
mod target;

use crate::Failure;
use serde_json::json;
use std::path::PathBuf;
use std::process::ExitCode;

/// Convert a rig or a calibration file into a format of another program.
///
/// The name's ending says the format: .data or .map (Bourke's warp mesh), .pfm, .vwf (VIOSO), .mpcdi, .toml (a rig and
/// its maps); read only: .ol (EasyBlend), .csv (domeprojection), .json (SGCT, into a rig).
#[derive(clap::Args)]
pub struct Arguments {
    /// A rig file, a preset's name, or a calibration file
    #[arg(value_name = "FROM")]
    from: String,
    /// The file to write
    #[arg(value_name = "TO")]
    to: PathBuf,
    /// The output's name [default: all of them, each in a file TO-NAME where the format holds one]
    #[arg(long, value_name = "NAME")]
    output: Option<String>,
    /// Size of an output in pixels [default: what the rig says, or its place in 1920x1200]
    #[arg(long, value_name = "WxH", value_parser = crate::arguments::size)]
    size: Option<(u32, u32)>,
    /// What the values of a map are
    #[arg(long, value_enum, default_value_t = source::Values::Picture)]
    values: source::Values,
    /// Profile of an MPCDI archive [default: 2d, a3 or 3d, as the values are pictures, points or directions]
    #[arg(long, value_enum)]
    profile: Option<target::ArchiveProfile>,
    /// Version of an MPCDI archive
    #[arg(long, value_enum, default_value_t = target::ArchiveVersion::One)]
    archive_version: target::ArchiveVersion,
    /// Into a rig: projectors as an archive of profile sl describes them, in place of its maps
    #[arg(long)]
    projectors: bool,
    /// Columns and rows of a warp mesh
    #[arg(long, value_name = "WxH", value_parser = crate::arguments::size, default_value = "129x129")]
    nodes: (u32, u32),
    /// Answer in JSON
    #[arg(long)]
    json: bool,
}

/// Runs the subcommand.
pub fn run(arguments: &Arguments) -> Result<ExitCode, Failure> {
    let format = target::Format::of(&arguments.to)?;
    let source = source::open(arguments)?;
    let mut notes = source.notes().to_vec();
    let written = match (&source, format) {
        (source::Source::Sgct { config, .. }, target::Format::Rig) => {
            sgct::rigs(&arguments.to, &arguments.from, config, &mut notes)?
        }
        (source::Source::Sgct { .. }, _) => {
            return Err(Failure::usage("a configuration of SGCT becomes a rig; expected a name that ends in .toml"));
        }
        _ => target::write(arguments, format, &source.channels(arguments)?)?,
    };
    if arguments.json {
        let files: Vec<_> = written.iter().map(target::Written::json).collect();
        println!("{:#}", json!({ "files": files, "notes": notes }));
        return Ok(ExitCode::SUCCESS);
    }
    for note in &notes {
        eprintln!("cupola: {note}");
    }
    for file in &written {
        println!("{}", file.words());
    }
    Ok(ExitCode::SUCCESS)
}
