//! Owners of the parts of a context or device: only the rooms that own a part name its fields. Other
//! rooms call the part's methods, which are named for what happens.

use crate::source::Source;

/// A part, and the rooms that may name its fields.
pub struct Part {
    /// Name of the field that holds the part, and of parameters that are this part.
    pub name: &'static str,
    /// Rooms that own it.
    pub owners: &'static [&'static str],
    /// Fields that any room may name: facts that never change, and parts with private fields.
    pub open: &'static [&'static str],
}

const fn part(name: &'static str, owners: &'static [&'static str], open: &'static [&'static str]) -> Part {
    Part { name, owners, open }
}

/// Folders with such parts. The room `state` of each folder holds the parts.
pub const FOLDERS: [(&str, &[Part]); 2] = [
    (
        "src/intercept/gl",
        &[
            part("driver", &[], &["gl", "id", "profile", "known_state", "endless_anisotropy"]),
            part("app", &[], &[]),
            part("drawable", &[], &[]),
            part("frame", &[], &[]),
            part("draw", &[], &[]),
            part("shaders", &[], &[]),
            part("vertex_input", &["vertex_input"], &[]),
            part("queries", &["queries"], &[]),
            part("view_copies", &["offscreen"], &[]),
            part("compat", &["compat"], &["projection"]),
            part("lists", &["compat", "context"], &[]),
            part("projected", &[], &[]),
        ],
    ),
    (
        "src/intercept/vk",
        &[
            part("flatness", &[], &[]),
            part("recordings", &["commands"], &[]),
            part("framebuffers", &["commands"], &[]),
            part("images", &["offscreen"], &[]),
            part("scene_graph", &["offscreen"], &[]),
            part("layouts", &["pipelines"], &[]),
            part("pipelines", &["pipelines"], &["divided"]),
            part("descriptors", &["descriptors"], &[]),
            part("host_memory", &["submit"], &[]),
            part("view_constants", &["submit"], &[]),
            part("frame", &["submit"], &[]),
            part("queries", &["queries"], &[]),
            part("swapchains", &["swapchain"], &[]),
            part("presented", &["swapchain"], &[]),
        ],
    ),
];

/// The fields of `part` that the code names, each with true if the code assigns to it. Calls of
/// methods are no fields.
fn named_fields<'a>(code: &'a str, part: &str) -> Vec<(&'a str, bool)> {
    let is_word = |c: char| c.is_alphanumeric() || c == '_';
    let mut fields = Vec::new();
    for (start, _) in code.match_indices(part) {
        let before = code[..start].chars().next_back();
        let Some(rest) = code[start + part.len()..].trim_start().strip_prefix('.') else { continue };
        if before.is_some_and(|c| is_word(c) || c == ':') {
            continue;
        }
        let end = rest.find(|c| !is_word(c)).unwrap_or(rest.len());
        let (field, next) = (&rest[..end], rest[end..].trim_start());
        if !field.starts_with(|c: char| c.is_ascii_lowercase()) || next.starts_with('(') || next.starts_with("::") {
            continue;
        }
        let operator = next.trim_start_matches(['+', '-', '*', '|', '&', '^']);
        let assigns = operator.starts_with('=') && !operator.starts_with("==") && !operator.starts_with("=>");
        fields.push((field, assigns));
    }
    fields
}

/// Uses of fields by rooms of `folder` that do not own the part.
pub fn foreign_uses(sources: &[Source], folder: &str, parts: &[Part]) -> Vec<String> {
    let mut findings = Vec::new();
    for source in sources {
        let Some(inner) = source.path.strip_prefix(folder).map(|rest| rest.trim_start_matches('/')) else { continue };
        let room = inner.split('/').next().unwrap_or_default();
        if room == "state" {
            continue;
        }
        let code = source.code_without_tests();
        for part in parts.iter().filter(|part| !part.owners.contains(&room)) {
            for (field, assigns) in named_fields(&code, part.name) {
                let Part { name, open, .. } = part;
                if assigns {
                    findings.push(format!("{}: sets {name}.{field}: call a method of the part", source.path));
                } else if !open.contains(&field) {
                    findings.push(format!("{}: names {name}.{field}: call a method of the part", source.path));
                }
            }
        }
    }
    findings
}

/// Fields that are open but are not named any more.
pub fn unused(sources: &[Source], folder: &str, parts: &[Part]) -> Vec<String> {
    let all: String = sources
        .iter()
        .filter(|source| source.path.starts_with(folder))
        .map(Source::code_without_tests)
        .collect::<Vec<_>>()
        .join("\n");
    let mut findings = Vec::new();
    for part in parts {
        let fields = named_fields(&all, part.name);
        for open in part.open.iter().filter(|open| fields.iter().all(|(field, _)| field != *open)) {
            findings.push(format!("{folder}: no room names {}.{open}: remove it from the list", part.name));
        }
    }
    findings
}
