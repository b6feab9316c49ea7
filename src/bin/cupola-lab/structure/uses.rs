//! Uses between the files of the library: the paths in their code, resolved to files.
//!
//! `tests/architecture.rs` uses this file too.

use super::source::Source;
use std::collections::{BTreeMap, BTreeSet};

/// The uses between files.
pub struct Uses {
    /// Paths of the files, as in [`Source::path`].
    pub files: Vec<String>,
    /// For each file, the indices of the files that it uses.
    pub of: Vec<BTreeSet<usize>>,
}

/// A file with its place in the module tree.
struct Module {
    /// Names of the modules from the crate's root to this one.
    name: Vec<String>,
    /// Exports from elsewhere: a name and its absolute path.
    exports: Vec<(String, Vec<String>)>,
    /// Absolute paths in the code.
    paths: Vec<Vec<String>>,
}

impl Uses {
    /// Finds the uses between the files below `folder` (`src`), which is the root of a crate.
    ///
    /// A path through `pub use` counts for the file to which it leads, so that re-exports of a
    /// folder make no circle.
    pub fn between(sources: &[Source], folder: &str) -> Self {
        let inside: Vec<&Source> = sources.iter().filter(|source| source.path.starts_with(folder)).collect();
        let modules: Vec<Module> = inside.iter().map(|source| read(source, folder)).collect();
        let by_name: BTreeMap<&[String], usize> =
            modules.iter().enumerate().map(|(index, module)| (&module.name[..], index)).collect();
        let of = modules.iter().enumerate().map(|(index, module)| {
            let targets = module.paths.iter().filter_map(|path| resolve(path, &modules, &by_name, 8));
            targets.filter(|target| *target != index).collect()
        });
        Self { of: of.collect(), files: inside.iter().map(|source| source.path.clone()).collect() }
    }

    /// Uses between files of one folder.
    pub fn within(&self, folder: &str) -> Self {
        let kept: Vec<usize> = (0..self.files.len()).filter(|i| self.files[*i].starts_with(folder)).collect();
        let place: BTreeMap<usize, usize> = kept.iter().enumerate().map(|(new, old)| (*old, new)).collect();
        Self {
            files: kept.iter().map(|i| self.files[*i].clone()).collect(),
            of: kept.iter().map(|i| self.of[*i].iter().filter_map(|t| place.get(t).copied()).collect()).collect(),
        }
    }
}

/// File to which a path leads: the deepest module on it, or the target of that module's export.
fn resolve(path: &[String], modules: &[Module], by_name: &BTreeMap<&[String], usize>, depth: u32) -> Option<usize> {
    let (length, index) = (1..=path.len()).rev().find_map(|n| by_name.get(&path[..n]).map(|index| (n, *index)))?;
    let item = path.get(length);
    let exported = item.and_then(|item| modules[index].exports.iter().find(|(name, _)| name == item));
    match exported {
        Some((_, target)) if depth > 0 => {
            let rest = target.iter().chain(&path[length + 1..]).cloned().collect::<Vec<_>>();
            resolve(&rest, modules, by_name, depth - 1)
        }
        _ => Some(index),
    }
}

fn read(source: &Source, folder: &str) -> Module {
    let inner = source.path.trim_start_matches(folder).trim_start_matches('/').trim_end_matches(".rs");
    let mut name: Vec<String> = std::iter::once("crate").chain(inner.split('/')).map(str::to_owned).collect();
    if name.last().is_some_and(|last| last == "mod" || last == "lib") {
        name.pop();
    }
    let code = source.code_without_tests();
    let children = children(&code);
    let mut exports = Vec::new();
    let mut paths = Vec::new();
    let mut end = 0;
    for start in path_starts(&code, &children) {
        if start < end {
            continue;
        }
        let line = code[..start].rfind('\n').map_or(0, |at| at + 1);
        let before = code[line..start].trim();
        let exported = before.starts_with("pub") && before.ends_with("use");
        let mut leaves = Vec::new();
        end = start + tree(&code[start..], &mut Vec::new(), &mut leaves);
        for (leaf, alias) in leaves {
            let Some(path) = absolute(&leaf, &name, &children) else { continue };
            if exported && let Some(last) = alias.or_else(|| path.last().cloned()) {
                exports.push((last, path));
            } else {
                paths.push(path);
            }
        }
    }
    Module { name, exports, paths }
}

/// Modules that a file declares.
fn children(code: &str) -> BTreeSet<&str> {
    let declared = code.lines().filter_map(|line| line.trim().strip_suffix(';')?.rsplit_once("mod "));
    declared.filter(|(before, _)| before.is_empty() || before.starts_with("pub")).map(|(_, name)| name).collect()
}

/// Positions at which paths begin: at `crate`, `super`, `self` or the name of a child, each before
/// `::`.
fn path_starts(code: &str, children: &BTreeSet<&str>) -> Vec<usize> {
    let part = |c: char| c.is_alphanumeric() || c == '_';
    let mut starts = Vec::new();
    let mut at = 0;
    while let Some(found) = code[at..].find("::") {
        let end = at + found;
        let start = code[..end].char_indices().rev().take_while(|(_, c)| part(*c)).last().map_or(end, |(i, _)| i);
        let word = &code[start..end];
        let free = !code[..start].ends_with("::") && !code[..start].ends_with("pub(in ");
        if free && (["crate", "super", "self"].contains(&word) || children.contains(word)) {
            starts.push(start);
        }
        at = end + 2;
    }
    starts
}

type Leaf = (Vec<String>, Option<String>);

/// Reads a path or a tree of paths; returns its length. A leaf is a path and the name that it gets.
fn tree(code: &str, prefix: &mut Vec<String>, leaves: &mut Vec<Leaf>) -> usize {
    let part = |c: char| c.is_alphanumeric() || c == '_';
    let mut at = 0;
    let depth = prefix.len();
    loop {
        at += code[at..].len() - code[at..].trim_start().len();
        if code[at..].starts_with('{') {
            at += 1;
            loop {
                at += code[at..].find(|c: char| !c.is_whitespace() && c != ',').unwrap_or(code.len() - at);
                if at >= code.len() || code[at..].starts_with('}') {
                    break;
                }
                let read = tree(&code[at..], prefix, leaves);
                if read == 0 {
                    break;
                }
                at += read;
            }
            prefix.truncate(depth);
            return (at + 1).min(code.len());
        }
        let word: String = code[at..].chars().take_while(|c| part(*c)).collect();
        at += word.len();
        if !word.is_empty() {
            prefix.push(word.clone());
        }
        if !word.is_empty() && code[at..].starts_with("::") {
            at += 2;
            continue;
        }
        let alias =
            code[at..].strip_prefix(" as ").map(|rest| rest.chars().take_while(|c| part(*c)).collect::<String>());
        at += alias.as_ref().map_or(0, |alias| alias.len() + 4) + usize::from(word.is_empty());
        leaves.push((prefix.clone(), alias));
        prefix.truncate(depth);
        return at.min(code.len());
    }
}

/// The path from the crate's root.
fn absolute(path: &[String], module: &[String], children: &BTreeSet<&str>) -> Option<Vec<String>> {
    let first = path.first()?.as_str();
    let mut whole = match first {
        "crate" => path.to_vec(),
        "self" => module.iter().chain(&path[1..]).cloned().collect(),
        "super" => {
            let up = path.iter().take_while(|word| *word == "super").count();
            let base = module.get(..module.len().checked_sub(up)?)?;
            base.iter().chain(&path[up..]).cloned().collect()
        }
        child if children.contains(child) => module.iter().chain(path).cloned().collect(),
        _ => return None,
    };
    whole.retain(|word| word != "self");
    Some(whole)
}
