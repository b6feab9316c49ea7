//! The tables of keys in `docs/rig-file.md`.

mod accepts;
mod defaults;
mod sections;

use accepts::{accepted, possible_keys};
use sections::SECTIONS;
use std::fmt::Write;
use std::path::Path;

/// Fills the columns "accepts" and "default" of each table after `<!-- keys: SECTION -->`. Returns
/// the page and the keys of each table.
fn with_columns(page: &str) -> (String, Vec<(&'static str, Vec<String>)>) {
    let mut written = String::new();
    let mut section = None;
    let mut found: Vec<(&'static str, Vec<String>)> = Vec::new();
    for line in page.lines() {
        if let Some(name) = line.strip_prefix("<!-- keys: ").and_then(|rest| rest.strip_suffix(" -->")) {
            let known = SECTIONS.iter().find(|(known, _)| *known == name);
            section = Some(known.unwrap_or_else(|| panic!("rig-file.md: there is no section {name}")));
            found.push((section.map_or("", |(name, _)| name), Vec::new()));
        } else if !line.starts_with('|') {
            section = None;
        }
        let cells: Vec<&str> = line.trim_matches('|').split('|').map(str::trim).collect();
        let (Some((name, rigs)), Some(first)) = (section, cells.first().filter(|cell| cell.starts_with('`'))) else {
            writeln!(written, "{line}").unwrap();
            continue;
        };
        let (mut accepts, mut defaults): (Vec<String>, Vec<String>) = Default::default();
        for key in first.split('`').skip(1).step_by(2) {
            found.last_mut().expect("a table").1.push(key.to_owned());
            for rig in rigs.iter().filter(|rig| possible_keys(rig).iter().any(|possible| possible == key)) {
                let accepted = accepted(rig, key);
                if !accepts.contains(&accepted) {
                    accepts.push(accepted);
                }
            }
            for default in defaults::of(name, rigs, key) {
                if !defaults.contains(&default) {
                    defaults.push(default);
                }
            }
        }
        let mut cells: Vec<String> = cells.iter().map(|cell| (*cell).to_owned()).collect();
        cells[2] = accepts.join("; ");
        if let Some(cell) = cells.get_mut(3) {
            *cell = defaults::cell(cell, &defaults, &format!("{name}: {first}"));
        }
        let row = cells.iter().map(|cell| format!(" {cell} ").replace("  ", " ")).collect::<Vec<_>>().join("|");
        writeln!(written, "|{row}|").unwrap();
    }
    (written, found)
}

#[test]
fn the_rig_files_page_has_each_key_with_what_it_accepts() {
    let path = Path::new(super::DOCS).join("rig-file.md");
    let page = std::fs::read_to_string(&path).unwrap();
    let (written, found) = with_columns(&page);
    super::compare(&path, &page, &written);
    let keys_of = |name: &str| -> Vec<String> {
        found.iter().filter(|(section, _)| *section == name).flat_map(|(_, keys)| keys.clone()).collect()
    };
    let (common, content) = (keys_of("output"), keys_of("content"));
    for (name, rigs) in SECTIONS {
        let described = keys_of(name);
        assert!(!described.is_empty(), "rig-file.md has no table of {name}");
        let mut possible: Vec<String> = rigs.iter().flat_map(|rig| possible_keys(rig)).collect();
        // Keys that all outputs have are in their own table. Tables within the file have their own
        // sections.
        let output_kind = name.starts_with("output ")
            && rigs.iter().all(|rig| !rig.contains("[output.") && !rig.contains("[[output."));
        possible.retain(|key| !(output_kind && common.contains(key)));
        possible.retain(|key| !(name.starts_with("content ") && content.contains(key)));
        match name {
            "file" => possible.retain(|key| key != "output" && !SECTIONS.iter().any(|(section, _)| section == key)),
            "output" => possible.retain(|key| !["yaw", "pitch", "roll"].contains(&key.as_str())),
            "output method" | "output method primitive" => {
                possible.retain(|key| ["max_error", "density"].contains(&key.as_str()));
            }
            _ => {}
        }
        for key in &possible {
            assert!(described.contains(key), "rig-file.md: the table of {name} lacks `{key}`");
        }
        for key in &described {
            assert!(possible.contains(key), "rig-file.md: `{key}` is no key of {name}");
        }
    }
}

/// Control: a default that is not the reader's is replaced, and a value is no text for a key without
/// a default.
#[test]
fn a_wrong_default_in_the_page_is_found() {
    let page = std::fs::read_to_string(Path::new(super::DOCS).join("rig-file.md")).unwrap();
    for (row, is, wrong) in [
        ("`gamma`", " 2.2 |", " 2.4 |"),
        ("`shape` | how the ramp rises", "`\"smoothstep\"` |", "`\"cosine\"` |"),
        ("`radial`", "`[0, 0, 0]` |", "`[0, 0, 1]` |"),
        ("`passthrough`", " false |", " true |"),
        ("`aperture` | angle from rim to rim", "`dome.coverage` |", " 180 |"),
        ("`fov` | opening `[horizontal", " required, or `angles` |", " |"),
    ] {
        let line = page.lines().find(|line| line.starts_with(&format!("| {row}"))).expect(row);
        assert!(line.ends_with(is), "{line}");
        let written = page.replacen(line, &line.replace(is, wrong), 1);
        assert_ne!(with_columns(&written).0, written, "{row}");
    }
    assert!(defaults::is_value("5") && defaults::is_value("`[0, 0]`") && defaults::is_value("true for projectors"));
    assert!(!defaults::is_value("none") && !defaults::is_value("all around") && !defaults::is_value("`output-1` …"));
}
