//! The parts of `docs/` that are generated from the code: help texts of the commands and key tables
//! of the rig file.
//!
//! `CUPOLA_BLESS=1 cargo test --test reference_pages` writes these parts again.

mod rig_file;

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
