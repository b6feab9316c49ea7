//! Options of `cupola setup`.

use super::places::Place;
use crate::failure::Failure;
use std::path::PathBuf;

/// Write a first rig: from monitors, measures and places of projectors, or from the calibration of
/// another program.
///
/// On a terminal, the command asks for what the options leave open.
#[derive(clap::Args)]
#[command(after_help = "\
A PLACE is a list of KEY=VALUE, separated by commas. azimuth: where the projector stands, seen from the dome's centre
(0 = front, 90 = right, 180 = back); distance: horizontal, from the centre, metres; height: of the lens above the centre,
metres; throw: distance of a flat picture over its width, or fov: its horizontal field of view, degrees;
aim=AZIMUTH:POLAR: the place on the dome where the middle of the picture is (POLAR: degrees from the pole); name; size:
WIDTHxHEIGHT.")]
pub struct Arguments {
    /// Rig file to write
    #[arg(value_name = "FILE.toml")]
    pub file: PathBuf,
    /// Start from a calibration: SGCT (.json), MPCDI, VIOSO (.vwf) or another one that `convert`
    /// reads
    #[arg(long, value_name = "FILE", conflicts_with_all = ["diameter", "tilt", "coverage", "seat", "fisheye", "projectors", "places"])]
    pub from: Option<String>,
    /// Diameter of the dome, metres
    #[arg(long, value_name = "METRES", value_parser = crate::decimal::number)]
    pub diameter: Option<f64>,
    /// Angle from the zenith to the dome's pole, towards the front, degrees [default: 0]
    #[arg(long, value_name = "DEGREES", allow_hyphen_values = true, value_parser = crate::decimal::number)]
    pub tilt: Option<f64>,
    /// Opening angle of the dome, degrees [default: 180, a hemisphere]
    #[arg(long, value_name = "DEGREES", value_parser = crate::decimal::number)]
    pub coverage: Option<f64>,
    /// Position of the audience's heads, metres from the dome's centre: x right, y up, z backward
    /// [default: 0,0,0]
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true, value_parser = seat)]
    pub seat: Option<[f64; 3]>,
    /// One projector with a fisheye lens in the dome's centre
    #[arg(long, conflicts_with_all = ["projectors", "places"])]
    pub fisheye: bool,
    /// Number of projectors; those without a PLACE stand at equal distances around the dome
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u8).range(1..=64))]
    pub projectors: Option<u8>,
    /// Place of a projector; may be given several times, in the order of the monitors
    #[arg(long = "projector", value_name = "PLACE", value_parser = super::places::place)]
    pub places: Vec<Place>,
    /// Names of the projectors' monitors, in their order [default: all]
    #[arg(long, value_name = "NAME,…", value_delimiter = ',')]
    pub monitors: Vec<String>,
    /// Read the monitors from a file with the output of `xrandr --query`
    #[arg(long, value_name = "FILE")]
    pub xrandr: Option<PathBuf>,
    /// Folder for numbered test patterns, one picture for each output
    #[arg(long, value_name = "DIR")]
    pub patterns: Option<PathBuf>,
    /// Show the numbered test patterns on the projectors until a key is pressed
    #[arg(long)]
    pub show: bool,
    /// Replace the file if it exists
    #[arg(long)]
    pub force: bool,
    /// Print the result as JSON
    #[arg(long, conflicts_with_all = ["patterns", "show"])]
    pub json: bool,
}

impl Arguments {
    /// Fails for values that no rig can have, before the command asks or writes anything.
    pub fn check(&self) -> Result<(), Failure> {
        if self.file.extension().is_none_or(|ending| ending != "toml") {
            return Err(Failure::usage(format!(
                "{}: expected a file name that ends in .toml, for example dome.toml",
                self.file.display()
            )));
        }
        let ranges = [
            ("--diameter", self.diameter, 0.2..=200.0, "0.2 to 200 metres"),
            ("--tilt", self.tilt, -180.0..=180.0, "-180 to 180 degrees"),
            ("--coverage", self.coverage, 1.0..=360.0, "1 to 360 degrees"),
        ];
        for (name, value, range, expected) in ranges {
            if let Some(value) = value.filter(|value| !range.contains(value)) {
                return Err(Failure::usage(format!("{name} {value}: expected {expected}")));
            }
        }
        match self.projectors {
            Some(count) if self.places.len() > usize::from(count) => Err(Failure::usage(format!(
                "--projectors {count}: {} places are given with --projector; leave --projectors out",
                self.places.len()
            ))),
            _ if self.places.len() > 64 => Err(Failure::usage("--projector: a rig has 64 outputs at most")),
            _ => Ok(()),
        }
    }
}

fn seat(text: &str) -> Result<[f64; 3], String> {
    let numbers: Option<Vec<f64>> =
        text.split(',').map(|part| part.trim().parse().ok().filter(|number: &f64| number.is_finite())).collect();
    numbers
        .and_then(|numbers| numbers.try_into().ok())
        .ok_or_else(|| "expected three numbers in metres, for example 0,-0.5,1".to_owned())
}
