//! The parts of `docs/` that are generated from the code: help texts of the commands and key tables
//! of the rig file.
//!
//! `CUPOLA_BLESS=1 cargo test --test reference_pages` writes these parts again.

use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::process::Command;

const DOCS: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/docs");

/// Compares a page with what the code generates. With `CUPOLA_BLESS` it writes the page instead.
fn compare(path: &Path, is: &str, should_be: &str) {
    if is == should_be {
        return;
    }
    if std::env::var_os("CUPOLA_BLESS").is_some() {
        std::fs::write(path, should_be).unwrap();
        return;
    }
    let differing = is.lines().zip(should_be.lines()).find(|(is, should_be)| is != should_be);
    let (is, should_be) = differing.unwrap_or(("", "another number of lines"));
    panic!(
        "{} does not agree with the code; CUPOLA_BLESS=1 cargo test --test reference_pages writes it again\n\
         is:        {is}\nshould be: {should_be}",
        path.display()
    );
}

fn pages() -> Vec<PathBuf> {
    let mut pages: Vec<PathBuf> = std::fs::read_dir(DOCS).unwrap().map(|entry| entry.unwrap().path()).collect();
    pages.retain(|path| path.extension().is_some_and(|extension| extension == "md"));
    pages.sort();
    pages
}

/// The help text of `command`, such as `cupola run`.
fn help(command: &str) -> String {
    let mut words = command.split_whitespace();
    let name = words.next().expect("a command");
    let program = Path::new(env!("CARGO_BIN_EXE_cupola")).with_file_name(name);
    let output = Command::new(&program).args(words).arg("-h").env("COLUMNS", "2000").output();
    let output = output.unwrap_or_else(|error| panic!("{}: {error}", program.display()));
    assert!(output.status.success(), "{command} -h: {output:?}");
    String::from_utf8(output.stdout).unwrap()
}

/// Writes a line of a help text in at most 118 columns. Further lines of a description are indented
/// to its beginning.
fn write_wrapped(written: &mut String, line: &str) {
    let start = line.len() - line.trim_start().len();
    let gap = line[start..].find("  ").map_or(start, |gap| start + gap);
    let indent = line[..gap].chars().count() + line[gap..].chars().take_while(|letter| *letter == ' ').count();
    let mut column = 0;
    for (index, word) in line.trim_start().split_inclusive(' ').enumerate() {
        let width = word.trim_end().chars().count();
        if index == 0 {
            write!(written, "{:start$}", "").unwrap();
            column = start;
        } else if column + width > 118 {
            written.truncate(written.trim_end().len());
            write!(written, "\n{:indent$}", "").unwrap();
            column = indent;
        }
        written.push_str(word);
        column += word.chars().count();
    }
    written.push('\n');
}

/// The page with each block after `<!-- help: COMMAND -->` replaced by the command's help.
fn with_help(page: &str) -> String {
    let mut written = String::new();
    let mut lines = page.lines().peekable();
    while let Some(line) = lines.next() {
        writeln!(written, "{line}").unwrap();
        let Some(command) = line.strip_prefix("<!-- help: ").and_then(|rest| rest.strip_suffix(" -->")) else {
            continue;
        };
        if lines.next_if_eq(&"```text").is_some() {
            for _ in lines.by_ref().take_while(|line| *line != "```") {}
        }
        writeln!(written, "```text").unwrap();
        for line in help(command).trim_end().lines() {
            write_wrapped(&mut written, line.trim_end());
        }
        writeln!(written, "```").unwrap();
    }
    written
}

#[test]
fn pages_show_the_options_that_the_commands_have() {
    let mut commands = String::new();
    for path in pages() {
        let page = std::fs::read_to_string(&path).unwrap();
        compare(&path, &page, &with_help(&page));
        commands += &page;
    }
    // Each subcommand has a place on a page.
    for program in ["cupola", "cupola-lab"] {
        let help = help(program);
        let listed = help.lines().skip_while(|line| *line != "Commands:").skip(1).take_while(|line| !line.is_empty());
        for name in listed.filter_map(|line| line.split_whitespace().next()).filter(|name| *name != "help") {
            assert!(commands.contains(&format!("<!-- help: {program} {name} -->")), "{program} {name} is on no page");
        }
    }
}

#[test]
fn the_map_for_contributors_names_files_that_there_are() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let page = |name: &str| std::fs::read_to_string(root.join(name)).unwrap();
    let contributing = page("CONTRIBUTING.md");
    let folders = contributing.split("## Map of the sources").nth(1).expect("the map");
    let map = [folders, &page("docs/which-file.md")].concat();
    let mut paths = 0;
    for line in map.lines().filter(|line| line.starts_with('|')) {
        for cell in line.split('|') {
            for path in cell.split('`').skip(1).step_by(2).filter(|word| word.chars().all(is_of_a_path)) {
                let there = root.join("src").join(path).exists() || root.join(path).exists();
                // Words of the first column that are no paths (`glClear`) have no slash and no file
                // in `src`.
                assert!(there || !path.contains('/'), "the map: {path} is not there");
                paths += usize::from(there);
            }
        }
    }
    assert!(paths > 50, "{paths} paths");
}

fn is_of_a_path(letter: char) -> bool {
    letter.is_ascii_alphanumeric() || "/_-.".contains(letter)
}

/// Names of the tables of `docs/rig-file.md`, each with rigs in which `@` marks the place of a key.
/// A table has the keys of all its rigs.
const SECTIONS: [(&str, &[&str]); 27] = [
    ("file", &["@\n[[output]]\nkind = \"domemaster\""]),
    ("dome", &["[dome]\n@"]),
    (
        "screen",
        &[
            "[screen]\nshape = \"sphere\"\n@",
            "[screen]\nshape = \"ellipsoid\"\n@",
            "[screen]\nshape = \"cylinder\"\n@",
            "[screen]\nshape = \"cone\"\n@",
            "[screen]\nshape = \"plane\"\n@",
            "[screen]\nshape = \"mesh\"\n@",
        ],
    ),
    ("viewer", &["[viewer]\n@"]),
    ("camera", &["[camera]\n@"]),
    ("content", &["[content]\nkind = \"cubemap\"\n@\n[[output]]\nkind = \"cubemap\""]),
    ("content domemaster", &["[content]\nkind = \"domemaster\"\n@\n[[output]]\nkind = \"cubemap\""]),
    (
        "content others",
        &[
            "[content]\nkind = \"equirectangular\"\n@\n[[output]]\nkind = \"cubemap\"",
            "[content]\nkind = \"cylindrical\"\n@\n[[output]]\nkind = \"cubemap\"",
            "[content]\nkind = \"flat\"\n@\n[[output]]\nkind = \"cubemap\"",
        ],
    ),
    ("views", &["[views]\n@"]),
    ("overlay", &["[overlay]\n@"]),
    ("output", &["[[output]]\nkind = \"cubemap\"\n@"]),
    (
        "output method",
        &[
            "[[output]]\nkind = \"domemaster\"\nmethod = \"table\"\n@",
            "[[output]]\nkind = \"domemaster\"\nmethod = \"mesh\"\n@",
            "[[output]]\nkind = \"domemaster\"\nmethod = \"cube-mesh\"\n@",
        ],
    ),
    (
        "output method primitive",
        &[
            "[[output]]\nkind = \"domemaster\"\nmethod = \"primitive\"\n@",
            "[[output]]\nkind = \"domemaster\"\nmethod = \"primitive-tessellation\"\n@",
        ],
    ),
    ("output domemaster", &["[[output]]\nkind = \"domemaster\"\n@"]),
    (
        "output panorama",
        &[
            "[[output]]\nkind = \"equirectangular\"\n@",
            "[[output]]\nkind = \"cylindrical\"\n@",
            "[[output]]\nkind = \"cubemap\"\n@",
        ],
    ),
    ("output projector", &["[[output]]\nkind = \"projector\"\n@"]),
    ("output angles", &["[[output]]\nkind = \"projector\"\n[output.angles]\n@"]),
    ("output distortion", &["[[output]]\nkind = \"projector\"\nfov = [60, 40]\n[output.distortion]\n@"]),
    ("output fisheye", &["[[output]]\nkind = \"projector\"\n[output.fisheye]\n@"]),
    ("output mirror", &["[[output]]\nkind = \"projector\"\nfov = [60, 40]\n[output.mirror]\n@"]),
    (
        "output perspective",
        &["[[output]]\nkind = \"perspective\"\n@", "[[output]]\nkind = \"perspective\"\nlens = \"x\"\n@"],
    ),
    (
        "output mesh",
        &[
            "[[output]]\nkind = \"mesh\"\nfile = \"x\"\n@",
            "[[output]]\nkind = \"mesh\"\nfile = \"x\"\nvalues = \"picture\"\npicture = \"perspective\"\nfov = [60, 40]\n@",
        ],
    ),
    ("output blend", &["[[output]]\nkind = \"projector\"\nfov = [60, 40]\n[output.blend]\n@"]),
    ("output transfer", &["[[output]]\nkind = \"projector\"\nfov = [60, 40]\n[output.blend.transfer]\n@"]),
    (
        "output ramps",
        &[
            "[[output]]\nkind = \"projector\"\nfov = [60, 40]\n[[output.blend.ramps]]\nangle = \"polar\"\n@",
            "[[output]]\nkind = \"projector\"\nfov = [60, 40]\n[[output.blend.ramps]]\nangle = \"azimuth\"\n@",
        ],
    ),
    ("output mask", &["[[output]]\nkind = \"projector\"\nfov = [60, 40]\n[output.mask]\n@"]),
    ("output black", &["[[output]]\nkind = \"projector\"\nfov = [60, 40]\n[output.black]\n@"]),
];

/// Messages about `rig` with `key = value` at its mark. A line of the rig with the same key is left
/// out.
fn messages(rig: &str, key: &str, value: &str) -> Vec<String> {
    let others: Vec<&str> = rig.lines().filter(|line| line.split(" =").next() != Some(key)).collect();
    let text = others.join("\n").replace('@', &format!("{key} = {value}"));
    let rig = cupola::rig::parse(&text, "x", Path::new(""));
    rig.err().map_or_else(Vec::new, |error| error.message.lines().map(str::to_owned).collect())
}

/// The keys that are possible at the mark of `rig`.
fn possible_keys(rig: &str) -> Vec<String> {
    let messages = messages(rig, "qqq", "1");
    let list = messages.iter().find_map(|line| line.split(".qqq: unknown key; possible here: ").nth(1));
    let list =
        list.or_else(|| messages.iter().find_map(|line| line.split(" qqq: unknown key; possible here: ").nth(1)));
    list.unwrap_or_else(|| panic!("{rig}: {messages:?}")).split(", ").map(str::to_owned).collect()
}

/// Writes `1000000` as `10⁶`.
fn number(text: &str) -> String {
    match text.trim_start_matches('-') {
        "1000000" => text.replace("1000000", "10⁶"),
        "1000000000" => text.replace("1000000000", "10⁹"),
        _ => text.replace('-', "−"),
    }
    .replace('-', "−")
}

/// Range at the end of a message: "…, at least −180 and at most 180" gives "−180…180".
fn range(message: &str) -> Option<String> {
    let ends = [("at least ", "≥ "), ("greater than ", "> ")];
    let (at, (word, sign)) = ends.iter().find_map(|end| Some((message.rfind(end.0)?, end)))?;
    let (low, high) = message[at + word.len()..].split_once(" and ")?;
    let (high, below) = match (high.strip_prefix("at most "), high.strip_prefix("less than ")) {
        (Some(high), _) => (high, "≤ "),
        (_, Some(high)) => (high, "< "),
        _ => return None,
    };
    let (low, high) = (number(low), number(high));
    Some(match (*sign, below) {
        ("≥ ", "≤ ") if low.strip_prefix('−') == Some(&high) => format!("±{high}"),
        ("≥ ", "≤ ") => format!("{low}…{high}"),
        ("> ", _) if low == "0" => format!("> 0, {below}{high}"),
        _ => format!("{sign}{low}, {below}{high}"),
    })
}

/// Values that a key accepts, taken from the messages about wrong values.
fn accepted(rig: &str, key: &str) -> String {
    let about = |value: &str| -> Option<String> {
        let path = format!("{key}: ");
        let element = format!("{key}[");
        let mut messages = messages(rig, key, value).into_iter();
        messages.find(|line| {
            let about = line.split_once(' ').map_or("", |(_, rest)| rest);
            let name = about.split(": ").next().unwrap_or_default();
            let last = name.rsplit_once('.').map_or(name, |(_, last)| last);
            !about.contains(": unknown key") && (format!("{last}: ") == path || last.starts_with(&element))
        })
    };
    let text = about("\"?\"").filter(|message| message.contains("\"?\"")).unwrap_or_default();
    if let Some((_, words)) = text.split_once("is not one of ") {
        return words.split("; ").next().unwrap_or(words).replace('"', "");
    }
    if text.contains("is neither true nor false") {
        return "true, false".to_owned();
    }
    if text.contains("is not a list of tables") {
        return "list of tables".to_owned();
    }
    if text.contains("is not a table") {
        return "table".to_owned();
    }
    if text.contains("expected [[…, …], …]") {
        return "list of pairs".to_owned();
    }
    if let Some((_, rest)) = text.split_once("expected 1 to ").filter(|_| text.contains(" of [x, y, z]")) {
        let most = rest.split(' ').next().unwrap_or_default();
        let range = about("[[nan, nan, nan]]").and_then(|message| range(&message)).unwrap_or_default();
        return format!("1 to {most} of 3 numbers, {range}");
    }
    if let Some((_, rest)) = text.split_once("does not fit; expected ") {
        let count: usize = rest.split(' ').next().and_then(|count| count.parse().ok()).unwrap_or_default();
        let whole = about(&format!("[{}]", vec!["-1"; count].join(", ")));
        let ranges: Vec<String> = (0..count)
            .filter_map(|index| {
                let wrong: Vec<&str> = (0..count).map(|other| if other == index { "-1" } else { "1" }).collect();
                let message = about(&format!("[{}]", wrong.join(", ")))?;
                let (least, greatest) = message.split_once("this one from ")?.1.split_once(" to ")?;
                Some(format!("{least}…{greatest}"))
            })
            .collect();
        if whole.is_some() && ranges.len() == count {
            let mut different = ranges;
            different.dedup();
            return format!("{count} whole numbers, {}", different.join(", "));
        }
        let range = about(&format!("[{}]", vec!["nan"; count].join(", "))).and_then(|message| range(&message));
        return format!("{count} numbers, {}", range.unwrap_or_default());
    }
    if let Some(range) = range(&text) {
        return range;
    }
    if about("true").is_some_and(|message| message.contains("is neither a whole number nor text")) {
        return "whole number, text".to_owned();
    }
    let number = about("1").unwrap_or_default();
    assert!(number.contains("is not text"), "{key} of {rig}: {text:?}, {number:?}");
    "text".to_owned()
}

/// Fills the column "accepts" of each table after `<!-- keys: SECTION -->`. Returns the page and
/// the keys of each table.
fn with_ranges(page: &str) -> (String, Vec<(&'static str, Vec<String>)>) {
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
        let (Some((_, rigs)), Some(first)) = (section, cells.first().filter(|cell| cell.starts_with('`'))) else {
            writeln!(written, "{line}").unwrap();
            continue;
        };
        let mut accepts: Vec<String> = Vec::new();
        for key in first.split('`').skip(1).step_by(2) {
            found.last_mut().expect("a table").1.push(key.to_owned());
            for rig in rigs.iter().filter(|rig| possible_keys(rig).iter().any(|possible| possible == key)) {
                let accepted = accepted(rig, key);
                if !accepts.contains(&accepted) {
                    accepts.push(accepted);
                }
            }
        }
        let mut cells: Vec<String> = cells.iter().map(|cell| (*cell).to_owned()).collect();
        cells[2] = accepts.join("; ");
        let row = cells.iter().map(|cell| format!(" {cell} ").replace("  ", " ")).collect::<Vec<_>>().join("|");
        writeln!(written, "|{row}|").unwrap();
    }
    (written, found)
}

#[test]
fn the_rig_files_page_has_each_key_with_what_it_accepts() {
    let path = Path::new(DOCS).join("rig-file.md");
    let page = std::fs::read_to_string(&path).unwrap();
    let (written, found) = with_ranges(&page);
    compare(&path, &page, &written);
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
