//! Parts of a configuration that Cupola does not take over.

use serde_json::Value;
use std::collections::BTreeSet;

/// Keys that are read, or that do not concern the picture. Keys below them are ignored.
const KNOWN: &[&str] = &[
    "$schema",
    "author",
    "description",
    "generator",
    "license",
    "masteraddress",
    "meta",
    "name",
    "title",
    "version",
    "nodes.address",
    "nodes.port",
    "nodes.windows.id",
    "nodes.windows.name",
    "nodes.windows.tags",
    "nodes.windows.mirrorx",
    "nodes.windows.mirrory",
    "nodes.windows.pos",
    "nodes.windows.size",
    "nodes.windows.viewports.pos",
    "nodes.windows.viewports.size",
    "nodes.windows.viewports.mesh",
    "nodes.windows.viewports.blendmask",
    "nodes.windows.viewports.eye",
    "nodes.windows.viewports.projection.type",
    "nodes.windows.viewports.projection.fov",
    "nodes.windows.viewports.projection.tilt",
    "nodes.windows.viewports.projection.orientation",
    "nodes.windows.viewports.projection.offset",
    "nodes.windows.viewports.projection.distance",
    "nodes.windows.viewports.projection.lowerleft",
    "nodes.windows.viewports.projection.upperleft",
    "nodes.windows.viewports.projection.upperright",
    "nodes.windows.viewports.projection.mesh",
    "nodes.windows.viewports.projection.rotation",
    "nodes.windows.viewports.projection.heightoffset",
    "users.pos",
];

/// Greatest number of keys that are named.
const MOST_NAMED: usize = 24;

/// Lists the other keys, each once, in one line for the user; `None` if there are none.
pub(super) fn line(root: &Value) -> Option<String> {
    let mut found = BTreeSet::new();
    collect(root, String::new(), &mut found);
    let named: Vec<String> = found.iter().take(MOST_NAMED).map(|key| shown(key)).collect();
    let more = if found.len() > MOST_NAMED { format!(" and {} more", found.len() - MOST_NAMED) } else { String::new() };
    (!named.is_empty()).then(|| format!("not taken over: {}{more}", named.join(", ")))
}

/// Adds the keys at and below a value to `found`.
fn collect(value: &Value, path: String, found: &mut BTreeSet<String>) {
    let on_the_way = |path: &str| path.is_empty() || KNOWN.iter().any(|known| known.starts_with(&format!("{path}.")));
    if KNOWN.contains(&path.as_str()) {
        return;
    }
    match value {
        _ if !on_the_way(&path) => drop(found.insert(path)),
        Value::Object(keys) => {
            for (key, value) in keys {
                let path = if path.is_empty() { key.clone() } else { format!("{path}.{key}") };
                collect(value, path, found);
            }
        }
        Value::Array(items) => items.iter().for_each(|item| collect(item, path.clone(), found)),
        _ => {}
    }
}

/// Shows a key in a message: short, and without control characters.
fn shown(key: &str) -> String {
    key.chars().filter(|c| !c.is_control()).take(80).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_that_are_not_read_are_named_once() {
        let window = r#"{ "msaa": 4, "pos": {}, "viewports": [{ "projection": { "type": "x", "background": {} } }] }"#;
        let text = format!(
            r#"{{ "version": 1, "scene": {{ "scale": 2 }}, "nodes": [{{ "windows": [{window}, {window}] }}] }}"#
        );
        let expected = "not taken over: nodes.windows.msaa, nodes.windows.viewports.projection.background, scene";
        assert_eq!(line(&serde_json::from_str(&text).unwrap()).as_deref(), Some(expected));
        assert_eq!(line(&serde_json::from_str(r#"{ "users": [{ "pos": 1 }] }"#).unwrap()), None);
    }
}
