//! The keys of a rig file: their names, ranges and defaults. Degrees become radians here.

mod blend;
mod calibration;
mod content;
mod lens;
mod method;
mod output;
mod profile;
mod screen;
mod transfer;
mod viewer;
mod views;

use super::reading::allowed::Allowed;
use super::reading::problems::Problems;
use super::reading::reader::Section;
use super::reading::syntax_hints;
use super::{Content, Defaults, Dome, Rig, WindowSwaps};
use std::path::Path;
use toml::de::DeTable;

const YAW: Allowed = Allowed::closed(-360.0, 360.0, "an angle in degrees, to the right");
const PITCH: Allowed = Allowed::closed(-180.0, 180.0, "an angle in degrees, upwards");
const ROLL: Allowed = Allowed::closed(-360.0, 360.0, "an angle in degrees, clockwise");
const TILT: Allowed = Allowed::closed(-180.0, 180.0, "an angle in degrees, 0 = zenith up, 90 = pole straight ahead");
const OPENING: Allowed = Allowed::above(0.0, 360.0, "a whole opening angle in degrees");
const METRES: Allowed = Allowed::closed(-1e6, 1e6, "[x right, y up, z backward] in metres from the dome's centre");

/// Greatest number of outputs: more than the graphics adapters of one machine can have.
const MOST_OUTPUTS: usize = 64;

pub(in crate::rig) use profile::profile;

/// Parses the table of a file; `None` if it is not TOML.
fn table<'a>(text: &'a str, problems: &mut Problems) -> Option<DeTable<'a>> {
    match DeTable::parse(text) {
        Ok(table) => Some(table.into_inner()),
        Err(error) => {
            let why = match error.message() {
                deep if deep.contains("recursion") => "lists and tables are nested too deeply".to_owned(),
                other => format!("this is not TOML: {}", other.replace('\n', ", ")),
            };
            problems.add_at(error.span(), syntax_hints::with_hint(text, error.span(), why));
            None
        }
    }
}

/// Reads the rig in `text`, with `defaults` for keys of the program that it does not have. `None`
/// if it is not TOML at all. Otherwise the result is usable only if no problem was added.
pub(in crate::rig) fn read(
    text: &str,
    file_name: &str,
    directory: &Path,
    defaults: &Defaults,
    problems: &mut Problems,
) -> Option<Rig> {
    let table = table(text, problems)?;
    let mut root = Section::new(&table, String::new());
    let stem = Path::new(file_name).file_stem().map_or_else(|| file_name.into(), |stem| stem.to_string_lossy());
    let name = root.text("name", "the rig's name", problems).unwrap_or(&stem).to_owned();
    let passthrough = root.boolean("passthrough", false, problems);
    let dome = screen::dome(root.section("dome", problems), problems);
    let surface = screen::screen(root.section("screen", problems), directory, problems);
    let viewer = viewer::viewer(root.section("viewer", problems), problems);
    let camera = viewer::camera(root.section("camera", problems), &defaults.camera, problems);
    let content = root.section("content", problems).and_then(|section| content::content(section, &dome, problems));
    let views = views::views(root.section("views", problems), defaults, problems);
    let overlay = views::overlay(root.section("overlay", problems), defaults.overlay, problems);
    let window = root.section("window", problems).map_or_else(WindowSwaps::default, |section| swaps(section, problems));
    let mut sections = root.sections("output", "[[output]] with double brackets", problems);
    if sections.len() > MOST_OUTPUTS {
        let count = sections.len();
        problems.add(
            &format!("output[{MOST_OUTPUTS}]"),
            format!("is one too many; expected at most {MOST_OUTPUTS} outputs, not {count}"),
        );
        // Each output may name files, so none of them is read.
        sections.clear();
    }
    let outputs = sections
        .into_iter()
        .enumerate()
        .filter_map(|(index, section)| output::output(section, index, &dome, directory, problems))
        .collect();
    root.finish(&[("outputs", "the file as [[output]], one for each output")], problems);
    Some(Rig {
        name,
        passthrough,
        dome,
        screen: surface,
        viewer,
        camera,
        content,
        views,
        overlay,
        window,
        outputs,
        beside: Vec::new(),
    })
}

/// Reads `[window]`.
fn swaps(mut section: Section, problems: &mut Problems) -> WindowSwaps {
    let allowed = Allowed::closed(0.0, 16.0, "a number of refreshes of the display");
    let interval = section.optional_number("swap_interval", &allowed, problems).map(|number| number.round() as u32);
    let allowed = Allowed::closed(1.0, 1024.0, "a number from 1");
    let [group, barrier] = ["swap_group", "swap_barrier"]
        .map(|key| section.optional_number(key, &allowed, problems).map(|number| number.round() as u32));
    if group.is_none() && barrier.is_some() {
        problems.add("window.swap_barrier", "needs swap_group: a group is bound to a barrier, not a window");
    }
    section.finish(&[], problems);
    WindowSwaps { interval, group, barrier }
}

/// Reads a text that has only the table `content`.
pub(in crate::rig) fn content(text: &str, dome: &Dome, problems: &mut Problems) -> Option<Content> {
    let table = match DeTable::parse(text) {
        Ok(table) => table,
        Err(error) => {
            problems.add_at(error.span(), error.message().replace('\n', ", "));
            return None;
        }
    };
    let section = Section::new(table.get_ref(), String::new()).section("content", problems)?;
    content::content(section, dome, problems)
}

/// Reads yaw, pitch and roll into radians.
fn angles(section: &mut Section, problems: &mut Problems) -> [f64; 3] {
    [("yaw", &YAW), ("pitch", &PITCH), ("roll", &ROLL)]
        .map(|(key, allowed)| section.number(key, allowed, 0.0, problems).to_radians())
}
