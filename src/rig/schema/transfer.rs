//! `transfer` of `[output.blend]`: the display's response.

use crate::formats::read_at_most;
use crate::rig::reading::allowed::Allowed;
use crate::rig::reading::problems::Problems;
use crate::rig::reading::reader::Section;
use crate::rig::{Response, Transfer};
use std::path::Path;
use std::sync::Arc;

const GAMMA: Allowed = Allowed::closed(1.0, 4.0, "the exponent of the channel's response");
const POINT: Allowed = Allowed::closed(0.0, 1e9, "a value from 0 up, or the light that was measured for it");
const CHANNELS: [&str; 3] = ["red", "green", "blue"];
const EXPECTED: &str =
    "expected two points or more, [[value, light], …], both growing, the first with the value 0, the last white";
/// Forms of the key `transfer`.
const FORMS: &str = "\"power\", \"srgb\", { red = …, green = …, blue = … }, { measured = [[value, light], …] } or \
                     { file = \"response.csv\" }";
/// Greatest length of a file of measurements, bytes.
const LONGEST_FILE: u64 = 1 << 20;

/// Response of one channel, as its key gives it.
enum Channel {
    Power(f64),
    Measured(Box<Response>),
}

/// Reads the response from `transfer` and, for a plain power, `gamma`.
pub(super) fn transfer(section: &mut Section, directory: &Path, problems: &mut Problems) -> Transfer {
    section.note_value("transfer", &["power", "srgb"], FORMS, problems);
    let transfer = if section.is_table("transfer") {
        let table = section.section("transfer", problems);
        table.map_or(Transfer::Power, |table| described(table, directory, problems))
    } else {
        let words = [("power", Transfer::Power), ("srgb", Transfer::Srgb)];
        section.choice_or("transfer", &words, Transfer::default(), problems)
    };
    if !transfer.is_plain() && section.has("gamma") {
        let why = "needs transfer = \"power\"; any other response has exponents of its own, or none";
        problems.add(&section.path("gamma"), why);
    }
    transfer
}

/// Reads a table: `red`, `green` and `blue`, or `measured` or `file` for all of them.
fn described(mut section: Section, directory: &Path, problems: &mut Problems) -> Transfer {
    let path = section.path("file");
    let all = section.number_pairs("measured", &POINT, problems);
    let file = section.text("file", "the name of a file of measurements", problems);
    let by_channel = CHANNELS.iter().any(|key| section.has(key));
    let ways = ["measured", "file"].into_iter().filter(|key| section.has(key)).count() + usize::from(by_channel);
    if ways != 1 {
        let expected = "expected one of: red, green and blue; measured = [[value, light], …]; file = \"response.csv\"";
        problems.add(&section.path("measured"), format!("{ways} ways to give the response; {expected}"));
    }
    let missing: Vec<String> =
        CHANNELS.iter().filter(|key| by_channel && !section.has(key)).map(|key| section.path(key)).collect();
    for key in CHANNELS {
        section.note_value(key, &[], "an exponent, or points [[value, light], …]", problems);
    }
    let channels = CHANNELS.map(|key| channel(&mut section, key, problems));
    // A misspelt channel is reported before the one that is missing because of it.
    section.finish(&[("gamma", "[output.blend]")], problems);
    for path in missing {
        problems.add(&path, "is missing; expected red, green and blue, each an exponent or points");
    }
    if let Some(points) = all {
        return same(response(&points, &section_path(&path, "measured"), problems));
    }
    if let Some(file) = file {
        return match responses(&directory.join(file)) {
            Ok(responses) => Transfer::Measured(Arc::new(responses)),
            Err(why) => {
                problems.add(&path, why);
                Transfer::Power
            }
        };
    }
    match channels {
        [Some(Channel::Power(red)), Some(Channel::Power(green)), Some(Channel::Power(blue))] => {
            Transfer::Powers([red, green, blue])
        }
        [Some(red), Some(green), Some(blue)] => {
            Transfer::Measured(Arc::new([red, green, blue].map(|channel| match channel {
                Channel::Power(gamma) => Response::power(gamma),
                Channel::Measured(response) => *response,
            })))
        }
        _ => Transfer::Power,
    }
}

/// Path of a key beside another one.
fn section_path(path: &str, key: &str) -> String {
    path.rsplit_once('.').map_or_else(|| key.to_owned(), |(parent, _)| format!("{parent}.{key}"))
}

/// Makes a measured response for all three channels.
fn same(response: Option<Response>) -> Transfer {
    response.map_or(Transfer::Power, |r| Transfer::Measured(Arc::new([r.clone(), r.clone(), r])))
}

/// Reads a channel: an exponent or points.
fn channel(section: &mut Section, key: &'static str, problems: &mut Problems) -> Option<Channel> {
    if !section.has(key) {
        // Reads the key, so that its name is known.
        section.optional_number(key, &GAMMA, problems);
        return None;
    }
    if !section.is_list(key) {
        return section.optional_number(key, &GAMMA, problems).map(Channel::Power);
    }
    let points = section.number_pairs(key, &POINT, problems)?;
    response(&points, &section.path(key), problems).map(|response| Channel::Measured(Box::new(response)))
}

fn response(points: &[[f64; 2]], path: &str, problems: &mut Problems) -> Option<Response> {
    let response = Response::measured(points);
    if response.is_none() {
        problems.add(path, format!("is no response; {EXPECTED}"));
    }
    response
}

/// Reads a file of measurements: lines of a value and its light, or of a value and the light of
/// red, green and blue, separated by commas, semicolons or blanks. Lines that begin with `#` and a
/// first line of words are left out.
fn responses(path: &Path) -> Result<[Response; 3], String> {
    let refused = |why: String| format!("{}: {why}", path.display());
    let bytes = read_at_most(path, LONGEST_FILE).map_err(|error| error.message)?;
    let text = String::from_utf8(bytes).map_err(|error| refused(error.to_string()))?;
    let mut channels: [Vec<[f64; 2]>; 3] = Default::default();
    let lines = text.lines().enumerate().map(|(index, line)| (index + 1, line.trim()));
    for (number, line) in lines.filter(|(_, line)| !line.is_empty() && !line.starts_with('#')) {
        let words = line.split([',', ';', ' ', '\t']).filter(|word| !word.is_empty());
        let numbers: Option<Vec<f64>> = words.map(|word| word.parse().ok()).collect();
        match numbers.as_deref() {
            None if number == 1 => {}
            Some(&[code, light]) => channels.iter_mut().for_each(|channel| channel.push([code, light])),
            Some(&[code, red, green, blue]) => {
                channels.iter_mut().zip([red, green, blue]).for_each(|(channel, light)| channel.push([code, light]));
            }
            _ => return Err(refused(format!("line {number} does not have two or four numbers: value, light"))),
        }
    }
    let [red, green, blue] = channels.map(|points| Response::measured(&points));
    match (red, green, blue) {
        (Some(red), Some(green), Some(blue)) => Ok([red, green, blue]),
        _ => Err(refused(format!("is no response; {EXPECTED}"))),
    }
}
