//! The pages of documentation: links lead to files and headings, lines and pages are short, goals
//! and crates are described.

use std::path::{Path, PathBuf};

const ROOT: &str = env!("CARGO_MANIFEST_DIR");
const LONGEST_LINE: usize = 120;
const MOST_WORDS: usize = 2000;
/// Pages for looking up, which may be longer.
const REFERENCES: [&str; 2] = ["rig-file.md", "command-line.md"];

fn files_below(folder: &Path, extension: &str, found: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()) {
        if entry.is_dir() {
            files_below(&entry, extension, found);
        } else if entry.extension().is_some_and(|is| is == extension) {
            found.push(entry);
        }
    }
}

/// All pages with their texts.
fn pages() -> Vec<(PathBuf, String)> {
    let mut paths = ["README.md", "CONTRIBUTING.md", "CHANGELOG.md"].map(|name| Path::new(ROOT).join(name)).to_vec();
    files_below(&Path::new(ROOT).join("docs"), "md", &mut paths);
    paths.into_iter().map(|path| (path.clone(), std::fs::read_to_string(path).unwrap())).collect()
}

/// The lines of a page outside blocks of code.
fn prose(text: &str) -> Vec<&str> {
    let mut code = false;
    let mut lines = Vec::new();
    for line in text.lines() {
        if line.trim_start().starts_with("```") {
            code = !code;
        } else if !code {
            lines.push(line);
        }
    }
    lines
}

/// The anchor that a heading has on GitHub.
fn anchor(heading: &str) -> String {
    let mut plain = heading.trim_start_matches('#').trim().to_lowercase();
    // GitHub uses only the words of a link in a heading.
    while let (Some(open), Some(middle)) = (plain.find('['), plain.find("](")) {
        let close = plain[middle..].find(')').map_or(plain.len(), |close| middle + close + 1);
        plain = format!("{}{}{}", &plain[..open], &plain[open + 1..middle], &plain[close..]);
    }
    plain.retain(|letter| letter.is_alphanumeric() || "-_ ".contains(letter));
    plain.replace(' ', "-")
}

/// The targets of links in a page.
fn links(text: &str) -> Vec<String> {
    let text = prose(text).join("\n");
    let targets = text.split("](").skip(1).filter_map(|rest| rest.split(')').next());
    let named = text.lines().filter(|line| line.starts_with('[')).filter_map(|line| line.split("]: ").nth(1));
    targets.chain(named).map(str::to_owned).collect()
}

#[test]
fn links_lead_to_files_and_headings() {
    let mut count = 0;
    for (page, text) in pages() {
        for link in links(&text).into_iter().filter(|link| !link.starts_with("http")) {
            let (file, heading) = link.split_once('#').map_or((link.as_str(), None), |(file, name)| (file, Some(name)));
            let target = if file.is_empty() { page.clone() } else { page.parent().unwrap().join(file) };
            assert!(target.exists(), "{}: {link} leads nowhere", page.display());
            if let Some(heading) = heading {
                let text = std::fs::read_to_string(&target).unwrap();
                let found = prose(&text).iter().any(|line| line.starts_with('#') && anchor(line) == heading);
                assert!(found, "{}: there is no heading for {link}", page.display());
            }
            count += 1;
        }
    }
    assert!(count > 150, "{count} links");
}

#[test]
fn files_that_pages_name_are_there() {
    let mut count = 0;
    for (page, text) in pages() {
        for word in prose(&text).iter().flat_map(|line| line.split('`').skip(1).step_by(2)) {
            let named = ["src/", "tests/", "examples/", "benches/", "scripts/", "include/"];
            let is_path = word.chars().all(|letter| letter.is_ascii_alphanumeric() || "/_-.".contains(letter));
            if is_path && named.iter().any(|folder| word.starts_with(folder)) {
                assert!(Path::new(ROOT).join(word).exists(), "{}: there is no {word}", page.display());
                count += 1;
            }
        }
    }
    assert!(count > 50, "{count} files");
}

#[test]
fn pages_and_lines_are_short() {
    for (page, text) in pages() {
        for (index, line) in text.lines().enumerate() {
            let length = line.chars().count();
            // The pictures in the README's table are links that cannot be wrapped.
            assert!(
                length <= LONGEST_LINE || line.contains("!["),
                "{}:{}: {length} columns",
                page.display(),
                index + 1
            );
        }
        let words = text.split_whitespace().count();
        let reference = page.file_name().is_some_and(|name| REFERENCES.iter().any(|page| name == *page));
        assert!(words <= MOST_WORDS || reference, "{} has {words} words, more than {MOST_WORDS}", page.display());
    }
}

#[test]
fn goals_that_sources_name_are_in_the_results() {
    let results = std::fs::read_to_string(Path::new(ROOT).join("docs/results.md")).unwrap();
    let mut sources = Vec::new();
    files_below(&Path::new(ROOT).join("src"), "rs", &mut sources);
    let mut found = 0;
    for path in sources {
        let text = std::fs::read_to_string(&path).unwrap();
        for rest in text.split("oal G").skip(1).chain(text.split("oals G").skip(1)) {
            let number: String = rest.chars().take_while(char::is_ascii_digit).collect();
            assert!(results.contains(&format!("\n| G{number} |")), "{}: there is no goal G{number}", path.display());
            found += 1;
        }
    }
    assert!(found > 0, "no source names a goal");
}

/// Name, greatest difference and, if it has one, edge of each tolerance of the direction test.
fn tolerances(text: &str) -> Vec<(String, String, Option<String>)> {
    let number = |text: &str, before: &str| -> Option<String> {
        let rest = text.split(before).nth(1)?.trim_start();
        let digits: String = rest.chars().take_while(|letter| letter.is_ascii_digit() || *letter == '.').collect();
        (!digits.is_empty()).then_some(digits)
    };
    let constants = text.lines().filter_map(|line| line.trim_start().strip_prefix("pub const "));
    let parts = constants.map(|constant| {
        let (name, value) = constant.split_once(':').expect("a type");
        let own = number(value, "tolerance:").or_else(|| number(value, "= "));
        (name.to_owned(), own, number(value, "edge:"), value.contains("..Self::USUAL"))
    });
    let parts: Vec<_> = parts.collect();
    let (_, usual, edge, _) = parts.iter().find(|(name, ..)| name == "USUAL").expect("the usual tolerances").clone();
    let or = |own: Option<String>, other: &Option<String>, takes: bool| own.or(other.clone().filter(|_| takes));
    let whole = parts.into_iter().map(|(name, own, own_edge, takes)| {
        let most = or(own, &usual, takes).unwrap_or_else(|| panic!("{name} has no number"));
        (name, most, or(own_edge, &edge, takes))
    });
    whole.collect()
}

#[test]
fn the_page_lists_the_tolerances_of_the_direction_test() {
    let read = |path: &str| std::fs::read_to_string(Path::new(ROOT).join(path)).unwrap();
    let (source, page) = (read("tests/suite/compare.rs"), read("docs/testing.md"));
    let found = tolerances(&source);
    assert!(found.len() > 8, "{found:?}");
    let rows = page.lines().filter(|line| line.starts_with("| `") && line.split(" | ").count() == 5);
    assert_eq!(rows.count(), found.len(), "rows of docs/testing.md");
    for (name, most, edge) in found {
        let start = match edge {
            Some(edge) => format!("\n| `{name}` | {most} | {edge} |"),
            None => format!("\n| `{name}` | {most} |"),
        };
        assert!(page.contains(&start), "docs/testing.md has no row {start}");
    }
    // Control: a constant in each form is understood.
    let text = "pub const USUAL: Self = Self { tolerance: 2.0, edge: 1.5 };\npub const A: Self = Self { edge: 3.0, \
                ..Self::USUAL };\npub const B: u8 = 9;\n";
    let named =
        |name: &str, most: &str, edge: Option<&str>| (name.to_owned(), most.to_owned(), edge.map(str::to_owned));
    let expected = [("USUAL", "2.0", Some("1.5")), ("A", "2.0", Some("3.0")), ("B", "9", None)];
    assert_eq!(tolerances(text), expected.map(|(name, most, edge)| named(name, most, edge)));
}

/// The fields of the tolerances are private, so a comparison takes one of the constants.
#[test]
fn there_are_no_tolerances_beside_the_constants() {
    let source = std::fs::read_to_string(Path::new(ROOT).join("tests/suite/compare.rs")).unwrap();
    let (_, rest) = source.split_once("pub struct Limits {").expect("a struct");
    let (fields, _) = rest.split_once("\n}").expect("its end");
    assert!(!fields.contains("pub ") && fields.contains("    tolerance: f64,"), "{fields}");
    assert!(!source.contains("for Limits {"), "no other type becomes Limits");
}

#[test]
fn each_crate_is_described() {
    let manifest = std::fs::read_to_string(Path::new(ROOT).join("Cargo.toml")).unwrap();
    let page = std::fs::read_to_string(Path::new(ROOT).join("docs/dependencies.md")).unwrap();
    let mut in_dependencies = false;
    for line in manifest.lines() {
        if line.starts_with('[') {
            in_dependencies = line.ends_with("dependencies]");
        } else if let Some((name, _)) =
            line.split_once(" = ").filter(|_| in_dependencies && !line.starts_with([' ', '#']))
        {
            assert!(page.contains(&format!("`{name}`")), "docs/dependencies.md does not describe {name}");
        }
    }
}

/// Headings with punctuation, code and links have the anchors that GitHub gives them.
#[test]
fn anchors_are_those_of_github() {
    assert_eq!(anchor("## `[output.blend]`: weights"), "outputblend-weights");
    assert_eq!(anchor("### `kind = \"mesh\"`"), "kind--mesh");
    assert_eq!(anchor("# See [the page](page.md), please"), "see-the-page-please");
}
