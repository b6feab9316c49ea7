//! Options of `cupola convert` and the file formats that it writes.

use crate::failure::Failure;
use std::path::{Path, PathBuf};

/// Convert a rig or a calibration file to the format of another program.
///
/// The extension of a file name selects the format: .data or .map (Bourke's warp mesh), .pfm, .vwf
/// (VIOSO), .mpcdi, .toml (a rig and its maps). These are only read: .ol (EasyBlend), .csv
/// (domeprojection), .json (SGCT, to a rig), .xml (an MPCDI description without its archive, to a
/// rig).
#[derive(clap::Args)]
pub struct Arguments {
    /// Rig file, name of a preset, or calibration file
    #[arg(value_name = "FROM")]
    pub from: String,
    /// File to write
    #[arg(value_name = "TO")]
    pub to: PathBuf,
    /// Name of the output to convert [default: all outputs, each in a file TO-NAME if the format
    /// holds only one]
    #[arg(long, value_name = "NAME")]
    pub output: Option<String>,
    /// Size of an output in pixels [default: from the rig, or its part of a window of 1920x1200]
    #[arg(long, value_name = "WxH", value_parser = crate::arguments::size)]
    pub size: Option<(u32, u32)>,
    /// Meaning of the values of a map
    #[arg(long, value_enum, default_value_t = Values::Picture)]
    pub values: Values,
    /// Profile of an MPCDI archive [default: 2d for pictures, a3 for points, 3d for directions]
    #[arg(long, value_enum)]
    pub profile: Option<ArchiveProfile>,
    /// Version of an MPCDI archive
    #[arg(long, value_enum, default_value_t = ArchiveVersion::One)]
    pub archive_version: ArchiveVersion,
    /// When writing a rig: write the projectors that an MPCDI archive of profile sl describes,
    /// instead of its maps
    #[arg(long)]
    pub projectors: bool,
    /// Number of columns and rows of a warp mesh
    #[arg(long, value_name = "WxH", value_parser = crate::arguments::size, default_value = "129x129")]
    pub nodes: (u32, u32),
    /// Replace files that exist
    #[arg(long)]
    pub force: bool,
    /// Print the result as JSON
    #[arg(long)]
    pub json: bool,
}

impl Arguments {
    /// The conversion of a calibration to a rig, as `cupola setup --from` asks for it.
    pub fn to_rig(from: &str, to: &Path, force: bool) -> Self {
        Self {
            from: from.to_owned(),
            to: to.to_owned(),
            output: None,
            size: None,
            values: Values::Picture,
            profile: None,
            archive_version: ArchiveVersion::One,
            projectors: false,
            nodes: (129, 129),
            force,
            json: false,
        }
    }

    /// The meaning of the values of maps. The profile of an archive takes precedence over
    /// `--values`.
    pub fn values(&self) -> Values {
        self.profile.map_or(self.values, ArchiveProfile::values)
    }
}

/// Meaning of the values of a map.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum Values {
    /// Positions in a domemaster of the rig's dome, 0…1 from the bottom left
    Picture,
    /// Points on the dome, in metres from its centre: x right, y up, z backward
    Points,
    /// Directions from the viewer: x right, y up, z backward
    Directions,
}

impl Values {
    /// The name of this meaning in messages, JSON and rig files.
    pub fn words(self) -> &'static str {
        match self {
            Self::Picture => "picture",
            Self::Points => "points",
            Self::Directions => "directions",
        }
    }
}

/// Profiles of MPCDI archives.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum ArchiveProfile {
    /// Positions in one picture
    #[value(name = "2d")]
    Flat,
    /// Positions in a perspective picture for each output
    #[value(name = "3d")]
    Perspective,
    /// Points of the screen
    #[value(name = "a3")]
    Screen,
    /// Points of the screen, with the position of each projector
    #[value(name = "sl")]
    ShaderLamps,
}

impl ArchiveProfile {
    /// The meaning of the values of its maps.
    fn values(self) -> Values {
        match self {
            Self::Flat => Values::Picture,
            Self::Perspective => Values::Directions,
            Self::Screen | Self::ShaderLamps => Values::Points,
        }
    }
}

/// Versions of MPCDI archives.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum ArchiveVersion {
    /// 1.0
    #[value(name = "1")]
    One,
    /// 2.0
    #[value(name = "2")]
    Two,
}

/// Formats that can be written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    Bourke,
    Pfm,
    Vwf,
    Mpcdi,
    Rig,
}

impl Format {
    /// The format that the extension of a file name selects.
    pub fn of(path: &Path) -> Result<Self, Failure> {
        match ending(path).as_str() {
            "data" | "map" => Ok(Self::Bourke),
            "pfm" => Ok(Self::Pfm),
            "vwf" => Ok(Self::Vwf),
            "mpcdi" => Ok(Self::Mpcdi),
            "toml" => Ok(Self::Rig),
            other => Err(Failure::usage(format!(
                "{}: the format {other:?} cannot be written; expected a name that ends in .data, .map, .pfm, .vwf, \
                 .mpcdi or .toml",
                path.display()
            ))),
        }
    }
}

/// The extension of a file name in lower case.
pub fn ending(path: &Path) -> String {
    path.extension().unwrap_or_default().to_string_lossy().to_lowercase()
}
