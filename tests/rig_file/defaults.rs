//! What the reader takes for a missing key.

use super::accepts::{messages, number, problems};
use cupola::rig::{DefaultValue, keys};
use std::path::Path;

/// A default that depends on other keys, in words of the page.
struct Depending {
    section: &'static str,
    key: &'static str,
    text: &'static str,
    /// Rigs in which `@` marks the place of the key, with its default.
    cases: &'static [(&'static str, &'static str)],
}

/// A dome that is not the usual one.
const DOME: &str = "dome = { coverage = 90, tilt = 45 }\n";

const DEPENDING: [Depending; 9] = [
    Depending {
        section: "output",
        key: "shown",
        text: "true if no own window",
        cases: &[
            ("[[output]]\nkind = \"cubemap\"\n@", "true"),
            ("[[output]]\nkind = \"cubemap\"\nsize = [6, 1]\nfullscreen = true\n@", "false"),
        ],
    },
    Depending {
        section: "output",
        key: "publish",
        text: "false if `shown`",
        cases: &[
            ("[[output]]\nkind = \"cubemap\"\n@", "false"),
            ("[[output]]\nkind = \"cubemap\"\nsize = [6, 1]\nshown = false\n@", "true"),
        ],
    },
    Depending {
        section: "output blend",
        key: "overlap",
        text: "true for projectors",
        cases: &[
            ("[[output]]\nkind = \"projector\"\nfov = [60, 40]\n[output.blend]\n@", "true"),
            ("[[output]]\nkind = \"domemaster\"\n[output.blend]\n@", "false"),
        ],
    },
    Depending {
        section: "content domemaster",
        key: "aperture",
        text: "`dome.coverage`",
        cases: &[
            ("[content]\nkind = \"domemaster\"\n@", "180"),
            ("dome = { coverage = 90 }\n[content]\nkind = \"domemaster\"\n@", "90"),
        ],
    },
    Depending {
        section: "content domemaster",
        key: "tilt",
        text: "`dome.tilt`",
        cases: &[
            ("[content]\nkind = \"domemaster\"\n@", "0"),
            ("dome = { tilt = 45 }\n[content]\nkind = \"domemaster\"\n@", "45"),
        ],
    },
    Depending {
        section: "output domemaster",
        key: "aperture",
        text: "`dome.coverage`",
        cases: &[
            ("[[output]]\nkind = \"domemaster\"\n@", "180"),
            ("dome = { coverage = 90 }\n[[output]]\nkind = \"domemaster\"\n@", "90"),
        ],
    },
    Depending {
        section: "output domemaster",
        key: "tilt",
        text: "`dome.tilt`",
        cases: &[
            ("[[output]]\nkind = \"domemaster\"\n@", "0"),
            ("dome = { tilt = 45 }\n[[output]]\nkind = \"domemaster\"\n@", "45"),
        ],
    },
    Depending {
        section: "output mesh",
        key: "aperture",
        text: "`dome.coverage`",
        cases: &[
            ("[[output]]\nkind = \"mesh\"\nfile = \"x\"\n@", "180"),
            ("dome = { coverage = 90 }\n[[output]]\nkind = \"mesh\"\nfile = \"x\"\n@", "90"),
        ],
    },
    Depending {
        section: "output mesh",
        key: "tilt",
        text: "`dome.tilt`",
        cases: &[
            ("[[output]]\nkind = \"mesh\"\nfile = \"x\"\n@", "0"),
            ("dome = { tilt = 45 }\n[[output]]\nkind = \"mesh\"\nfile = \"x\"\n@", "45"),
        ],
    },
];

/// Path of `key` at the mark of `rig`.
fn path(rig: &str, key: &str) -> String {
    let messages = messages(rig, "qqq", "1");
    let unknown = messages.iter().find_map(|line| line.split_once("qqq: unknown key")?.0.split_once(' '));
    let (_, table) = unknown.unwrap_or_else(|| panic!("{rig}: {messages:?}"));
    format!("{table}{key}")
}

/// What the page says of `key` at the mark of `rig`: "required", or the default that the reader has
/// recorded. `None` if the key may be missing and nothing replaces it.
fn absent(rig: &str, key: &str) -> Option<String> {
    let path = path(rig, key);
    let lines: Vec<&str> = rig.lines().filter(|line| line.split(" =").next() != Some(key)).collect();
    let text = lines.join("\n").replace('@', "");
    let missing = format!(" {path}: is missing");
    let refused = cupola::rig::parse(&text, "x", Path::new("")).err();
    if refused.is_some_and(|error| problems(&error.message).iter().any(|line| line.contains(&missing))) {
        return Some("required".to_owned());
    }
    let found = keys(&text, "x", Path::new("")).into_iter().find(|found| found.path == path)?;
    assert!(!found.given, "{path} of {rig}");
    Some(match found.default? {
        DefaultValue::Number(default) => number(&default.to_string()),
        DefaultValue::Truth(default) => default.to_string(),
        default => format!("`{default}`"),
    })
}

/// Defaults of `key` in the table `section`, whose rigs are `rigs`, each in the words of the page.
pub fn of(section: &str, rigs: &[&str], key: &str) -> Vec<String> {
    if let Some(depending) = DEPENDING.iter().find(|one| (one.section, one.key) == (section, key)) {
        let found: Vec<_> = depending.cases.iter().map(|(rig, _)| absent(rig, key)).collect();
        let expected: Vec<_> = depending.cases.iter().map(|(_, default)| Some((*default).to_owned())).collect();
        assert_eq!(found, expected, "{section}: `{key}` is no longer {:?}", depending.text);
        assert_ne!(found[0], found[1], "{section}: `{key}` is the same in all cases");
        return vec![depending.text.to_owned()];
    }
    let possible = rigs.iter().filter(|rig| super::possible_keys(rig).iter().any(|possible| possible == key));
    let mut found = Vec::new();
    for rig in possible {
        let default = absent(rig, key);
        if !rig.contains("[dome]") {
            assert_eq!(default, absent(&format!("{DOME}{rig}"), key), "{section}: `{key}` depends on the dome");
        }
        found.extend(default);
    }
    found
}

/// The cell of a row whose keys have these defaults. A cell is kept if it adds to each of them,
/// after a comma. Without a default, it may be any text that is no value.
pub fn cell(is: &str, defaults: &[String], row: &str) -> String {
    if defaults.is_empty() {
        assert!(!is_value(is), "rig-file.md: {row} has no default, and the page says {is:?}");
        return is.to_owned();
    }
    let parts: Vec<&str> = is.split("; ").collect();
    let agrees = |(part, default): (&&str, &String)| {
        part.strip_prefix(default.as_str()).is_some_and(|rest| rest.is_empty() || rest.starts_with(", "))
    };
    let all = parts.len() == defaults.len() && parts.iter().zip(defaults).all(agrees);
    if all { is.to_owned() } else { defaults.join("; ") }
}

/// True if a text is, or begins with, a value or "required".
pub fn is_value(text: &str) -> bool {
    let word = text.split(|c: char| !c.is_alphanumeric()).next().unwrap_or_default();
    ["true", "false", "required"].contains(&word)
        || text.starts_with(|c: char| c.is_ascii_digit() || "−±".contains(c))
        || ["`\"", "`["].iter().any(|start| text.starts_with(start))
}
