//! `cupola-lab structure`: numbers about the source: lines, files, hooks, subcommands, rooms,
//! circles of uses, uses against the order of the rooms, long functions; the size of a library.

mod circles;
mod counts;
mod rules;
mod source;
mod uses;

use crate::failure::Failure;
use circles::circles;
use source::{Source, sources};
use std::collections::BTreeSet;
use std::path::PathBuf;
use std::process::ExitCode;
use uses::Uses;

/// Greatest number of lines of a function that is not listed.
const LONG_FUNCTION: usize = 60;

/// Measure the structure of the source
#[derive(clap::Args)]
pub struct Arguments {
    /// Folder of the project, also of another version
    #[arg(default_value = ".", value_name = "DIR")]
    root: PathBuf,
    /// Also list circles, uses against the order and long functions
    #[arg(long)]
    list: bool,
    /// Also print the size of a library
    #[arg(long, value_name = "FILE")]
    library: Option<PathBuf>,
}

/// Runs the command.
///
/// # Errors
///
/// A folder without sources, or a file or library that cannot be read.
pub fn run(arguments: &Arguments) -> Result<ExitCode, Failure> {
    let sources = sources(&arguments.root, &["src"], &["rs"]).map_err(Failure::usage)?;
    if sources.is_empty() {
        return Err(Failure::usage(format!("{}: no Rust files in src", arguments.root.display())));
    }
    let uses = Uses::between(&sources, "src");
    print_size(&sources);
    if let Some(library) = &arguments.library {
        let unreadable = |error| Failure::usage(format!("{}: {error}", library.display()));
        println!("Bytes of {}: {}", library.display(), std::fs::metadata(library).map_err(unreadable)?.len());
    }
    println!("\nAfter a slash: the number that the architecture test allows.");
    println!(
        "{:<18} {:>6} {:>7} {:>6} {:>6} {:>7} {:>15} {:>10}",
        "folder", "files", "lines", "rooms", "uses", "against", "largest circle", "its lines"
    );
    for order in &rules::ORDERS {
        let own = uses.within(order.folder);
        let all = circles(&own);
        let against = rules::against_the_order(&own, order);
        let known = rules::unlisted(&own, order).is_empty();
        let largest = all.first().map_or(&[][..], |circle| circle);
        println!(
            "{:<18} {:>6} {:>7} {:>6} {:>6} {:>7} {:>15} {:>10}",
            order.folder.trim_start_matches("src/"),
            own.files.len(),
            lines(&sources, |path| path.starts_with(order.folder)),
            rooms(own.files.iter().map(String::as_str)),
            own.of.iter().map(BTreeSet::len).sum::<usize>(),
            if known { format!("{}/{}", against.len(), order.most_against) } else { "-".into() },
            format!("{}/{}", largest.len(), order.largest_circle),
            lines(&sources, |path| largest.contains(&path)),
        );
        if arguments.list {
            all.iter().for_each(|circle| println!("    circle: {}", circle.join(", ")));
            against.iter().filter(|_| known).for_each(|line| println!("    against: {line}"));
        }
    }
    let long = long_functions(&sources);
    println!("\nFunctions of more than {LONG_FUNCTION} lines: {}", long.len());
    if arguments.list {
        long.iter().for_each(|line| println!("    {line}"));
    }
    Ok(ExitCode::SUCCESS)
}

fn print_size(sources: &[Source]) {
    let library = |path: &str| !path.starts_with("src/bin/");
    let tests = |path: &str| path.contains("/tests/") || path.ends_with("/tests.rs");
    println!("Lines of the library: {}", lines(sources, |path| library(path) && !tests(path)));
    println!("Lines of its unit tests in files of their own: {}", lines(sources, |path| library(path) && tests(path)));
    println!("Lines of the commands: {}", lines(sources, |path| !library(path)));
    println!("Files: {}, folders: {}", sources.len(), rooms(sources.iter().map(|source| source.path.as_str())));
    if let Some(longest) = sources.iter().max_by_key(|source| source.text.lines().count()) {
        println!("Longest file: {}, {} lines", longest.path, longest.text.lines().count());
    }
    let number = |count: Option<usize>| count.map_or_else(|| "not known".to_owned(), |count| count.to_string());
    let [opengl, vulkan] = ["OpenGL", "Vulkan"].map(|api| number(counts::hooked(sources, api)));
    println!("Hooked functions of OpenGL: {opengl}, of Vulkan: {vulkan}");
    println!("Subcommands of cupola: {}", number(counts::subcommands(sources)));
}

fn lines(sources: &[Source], wanted: impl Fn(&str) -> bool) -> usize {
    sources.iter().filter(|source| wanted(&source.path)).map(|source| source.text.lines().count()).sum()
}

/// Number of folders that contain files.
fn rooms<'a>(paths: impl Iterator<Item = &'a str>) -> usize {
    paths.filter_map(|path| path.rsplit_once('/')).map(|(folder, _)| folder).collect::<BTreeSet<_>>().len()
}

/// Functions with more than [`LONG_FUNCTION`] lines, without unit tests, the longest first.
fn long_functions(sources: &[Source]) -> Vec<String> {
    let mut found = Vec::new();
    for source in sources {
        let code = source.code_without_tests();
        let lines: Vec<&str> = code.lines().collect();
        for (start, line) in lines.iter().enumerate() {
            let Some(name) = function_name(line) else { continue };
            let length = body_lines(&lines[start..]);
            if length > LONG_FUNCTION {
                found.push((length, format!("{length} lines: {}:{}, {name}", source.path, start + 1)));
            }
        }
    }
    found.sort_by_key(|(length, _)| std::cmp::Reverse(*length));
    found.into_iter().map(|(_, line)| line).collect()
}

/// Name of the function that a line defines.
fn function_name(line: &str) -> Option<&str> {
    let (before, after) = line.split_once("fn ")?;
    let qualifier = |word: &str| {
        ["const", "async", "unsafe", "extern", "system", "C"].contains(&word) || word.starts_with("pub") || word == "in"
    };
    let words = before.split(|c: char| !c.is_alphanumeric() && c != '_').filter(|word| !word.is_empty());
    let defines = before.contains("pub(") || words.clone().all(qualifier);
    defines.then(|| after.split(['(', '<']).next().unwrap_or_default())
}

/// Number of lines from the first one to the end of the block that opens first.
fn body_lines(lines: &[&str]) -> usize {
    let mut depth = 0usize;
    for (number, line) in lines.iter().enumerate() {
        for c in line.chars() {
            match c {
                '{' => depth += 1,
                '}' if depth == 1 => return number + 1,
                '}' => depth = depth.saturating_sub(1),
                ';' if depth == 0 => return number + 1,
                _ => {}
            }
        }
    }
    0
}
