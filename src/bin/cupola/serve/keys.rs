//! Keys of a rig as the page shows them: those that the file has, and all others that it may have.

use super::working::Working;
use crate::tune;
use cupola::rig::{self, Accepts, Key};
use serde_json::Value as Json;
use std::path::Path;
use toml_edit::{DocumentMut, Item, Table, Value};

/// Tables that hide keys which the rig may have without them.
const ALONE: [&str; 1] = ["fisheye"];
/// Name of a file that does not exist.
const NO_FILE: &str = "/dev/null/none";

/// Keys of a rig as `set` takes them, with their values.
pub fn keys(working: &Working) -> Vec<Json> {
    let document: DocumentMut = working.text().parse().unwrap_or_default();
    possible(&document, working.name()).into_iter().filter_map(|key| described(&key, &document)).collect()
}

/// A key with its value; `None` for elements of lists, which have no path of their own.
fn described(key: &Key, document: &DocumentMut) -> Option<Json> {
    let mut described = serde_json::to_value(key).ok()?;
    let path = match key.path.strip_prefix("output[") {
        Some(rest) => {
            let (index, rest) = rest.split_once("].")?;
            let index = index.parse().ok()?;
            let output = tune::name_of_output(document.get("output")?.get(index)?, index);
            let path = format!("output.{output}.{rest}");
            described["output"] = output.into();
            path
        }
        None => key.path.clone(),
    };
    let item = item_at(document.as_item(), &key.path);
    described["value"] = item.and_then(Item::as_value).and_then(json_of).unwrap_or(Json::Null);
    if matches!(key.accepts, Accepts::Value { .. }) {
        described["toml"] = item.and_then(text_of).map_or(Json::Null, Json::from);
    }
    described["key"] = path.into();
    described.as_object_mut()?.remove("path");
    (!key.path.trim_start_matches("output[").contains('[')).then_some(described)
}

/// Keys that the rig in `document` may have, including those of tables that it lacks.
fn possible(document: &DocumentMut, name: &str) -> Vec<Key> {
    let mut document = document.clone();
    name_no_files(document.as_item_mut());
    let noted = |document: &DocumentMut| rig::keys(&document.to_string(), name, Path::new(""));
    let mut keys = noted(&document);
    let lacking = |key: &&Key| key.accepts == Accepts::Table && !key.given;
    let tables: Vec<String> = keys.iter().filter(lacking).map(|key| key.path.clone()).collect();
    let is_alone = |path: &&String| ALONE.contains(&last(path));
    let usual = with_tables(&document, tables.iter().filter(|path| !is_alone(path)));
    keys = noted(&usual);
    for alone in ALONE {
        let paths: Vec<&String> = tables.iter().filter(|path| last(path) == alone).collect();
        if !paths.is_empty() {
            let inside = |key: &Key| paths.iter().any(|path| key.path.starts_with(&format!("{path}.")));
            let with = with_tables(&document, paths.iter().copied());
            keys.extend(noted(&with).into_iter().filter(inside));
        }
    }
    keys.retain(|key| key.accepts != Accepts::Table);
    keys
}

/// Last part of a path.
fn last(path: &str) -> &str {
    path.rsplit_once('.').map_or(path, |(_, last)| last)
}

/// The document with empty tables at these paths.
fn with_tables<'a>(document: &DocumentMut, paths: impl Iterator<Item = &'a String>) -> DocumentMut {
    let mut document = document.clone();
    for path in paths {
        let (parent, name) = path.rsplit_once('.').unwrap_or(("", path));
        let parent = item_at_mut(document.as_item_mut(), parent);
        if let Some(table) = parent.and_then(Item::as_table_like_mut) {
            table.entry(name).or_insert_with(|| Item::Table(Table::new()));
        }
    }
    document
}

/// Replaces the names of all files: only the names of the keys matter, and reading files takes time.
fn name_no_files(item: &mut Item) {
    if let Some(tables) = item.as_array_of_tables_mut() {
        for table in tables.iter_mut() {
            table.iter_mut().for_each(|(key, item)| name_no_file(key.get(), item));
        }
    } else if let Some(table) = item.as_table_like_mut() {
        table.iter_mut().for_each(|(key, item)| name_no_file(key.get(), item));
    }
}

fn name_no_file(key: &str, item: &mut Item) {
    match item.as_value_mut() {
        Some(value) if value.is_str() && tune::FILES.contains(&key) => *value = NO_FILE.into(),
        _ => name_no_files(item),
    }
}

/// Names and indices of a path such as `output[0].blend.ramp`.
fn parts(path: &str) -> impl Iterator<Item = (&str, Option<usize>)> {
    path.split('.').filter(|part| !part.is_empty()).map(|part| {
        let indexed = part.strip_suffix(']').and_then(|part| part.split_once('['));
        indexed.map_or((part, None), |(name, index)| (name, index.parse().ok()))
    })
}

fn item_at<'a>(item: &'a Item, path: &str) -> Option<&'a Item> {
    parts(path).try_fold(item, |item, (name, index)| {
        let item = item.get(name)?;
        index.map_or(Some(item), |index| item.get(index))
    })
}

fn item_at_mut<'a>(item: &'a mut Item, path: &str) -> Option<&'a mut Item> {
    parts(path).try_fold(item, |item, (name, index)| {
        let item = item.get_mut(name)?;
        match index {
            Some(index) => item.get_mut(index),
            None => Some(item),
        }
    })
}

/// Text of a value as the file has it, or of a table as it would stand in braces.
fn text_of(item: &Item) -> Option<String> {
    let mut value = item.clone().into_value().ok()?;
    value.decor_mut().clear();
    Some(value.to_string())
}

fn json_of(value: &Value) -> Option<Json> {
    if let Some(list) = value.as_array() {
        return Some(Json::Array(list.iter().filter_map(json_of).collect()));
    }
    let float = value.as_float().map(Json::from);
    let whole = value.as_integer().map(Json::from);
    float.or(whole).or(value.as_bool().map(Json::from)).or(value.as_str().map(Json::from))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::launch::loader::Scratch;

    const RIG: &str = "[dome]\nradius = 4.0 # wide\n\n[[output]]\nname = \"a.b\"\nkind = \"projector\"\n\
                       fov = [60, 40]\n\n[[output.blend.ramps]]\nangle = \"polar\"\nzero = 90\nfull = 80\n\n\
                       [[output]]\nkind = \"domemaster\"\n";

    fn opened(text: &str) -> Working {
        let scratch = Scratch::new().expect("a folder");
        let file = scratch.path().join("dome.toml");
        std::fs::write(&file, text).expect("written");
        Working::open(file.to_str().expect("a path"), &scratch.path().join("working.toml")).expect("a rig")
    }

    fn names(keys: &[Json]) -> Vec<&str> {
        keys.iter().filter_map(|key| key["key"].as_str()).collect()
    }

    fn find<'a>(keys: &'a [Json], name: &str) -> &'a Json {
        keys.iter().find(|key| key["key"] == name).unwrap_or_else(|| panic!("{name}: {:?}", names(keys)))
    }

    #[test]
    fn keys_have_values_ranges_and_defaults() {
        let keys = keys(&opened(RIG));
        let radius = find(&keys, "dome.radius");
        assert_eq!((&radius["least"], &radius["greatest"]), (&0.0.into(), &1e6.into()));
        assert_eq!(radius["value"], 4.0);
        let ramp = find(&keys, "output.a.b.blend.ramp");
        assert_eq!((&ramp["default"], &ramp["given"], &ramp["output"]), (&0.25.into(), &false.into(), &"a.b".into()));
        assert_eq!(find(&keys, "output.output-2.aperture")["output"], "output-2");
        // Each key has one control.
        let mut once = names(&keys);
        once.sort_unstable();
        once.dedup();
        assert_eq!(once.len(), keys.len());
    }

    #[test]
    fn text_and_lists_are_keys() {
        let keys = keys(&opened(RIG));
        for key in ["name", "output.a.b.name", "output.a.b.display", "output.a.b.mask.image"] {
            assert_eq!(find(&keys, key)["type"], "text", "{key}");
        }
        for key in ["output.a.b.keystone", "output.a.b.node", "output.a.b.blend.transfer", "views.cells"] {
            let found = find(&keys, key);
            assert_eq!((&found["type"], &found["toml"]), (&"value".into(), &Json::Null), "{key}");
        }
        assert_eq!(find(&keys, "output.a.b.blend.transfer")["words"][1], "srgb");
        let ramps = find(&keys, "output.a.b.blend.ramps");
        assert_eq!(ramps["toml"], "[{ angle = \"polar\", zero = 90, full = 80 }]");
        let table = keys_of_transfer("{ red = 2.15, green = [[0, 0], [255, 9]], blue = 2 }");
        assert_eq!(find(&table, "output.all.blend.transfer.green")["toml"], "[[0, 0], [255, 9]]");
    }

    fn keys_of_transfer(value: &str) -> Vec<Json> {
        let text = format!("[[output]]\nname = \"all\"\nkind = \"domemaster\"\nblend = {{ transfer = {value} }}\n");
        keys(&opened(&text))
    }

    #[test]
    fn keys_of_tables_that_the_file_lacks_are_offered_where_they_are_possible() {
        let found = keys(&opened(RIG));
        let names = names(&found);
        for key in ["content.kind", "screen.shape", "window.swap_interval", "overlay.width", "views.quality"] {
            assert!(names.contains(&key), "{key}");
        }
        for key in ["distortion.radial", "fisheye.aperture", "mirror.radius", "mask.image", "black.values"] {
            assert!(names.contains(&format!("output.a.b.{key}").as_str()), "{key}");
        }
        for key in ["distortion.radial", "fisheye.aperture", "mirror.radius", "fov"] {
            assert!(!names.contains(&format!("output.output-2.{key}").as_str()), "{key}");
        }
        // A pinhole's keys are not those of a fisheye, which hides nothing before it is there.
        let text = "[[output]]\nname = \"all\"\nkind = \"projector\"\nfisheye = { aperture = 170 }\n";
        let fisheye = keys(&opened(text));
        assert!(
            fisheye
                .iter()
                .all(|key| !["output.all.shift", "output.all.keystone"].contains(&key["key"].as_str().unwrap_or("")))
        );
        find(&fisheye, "output.all.fisheye.aperture");
    }

    #[test]
    fn no_table_is_written_by_looking_at_keys_and_no_file_is_needed() {
        let working = opened(RIG);
        keys(&working);
        assert_eq!(working.text(), RIG);
        let text = "[screen]\nshape = \"mesh\"\nfile = \"none.obj\"\n[[output]]\nkind = \"cubemap\"\n\
                    mask = { image = \"x.png\" }\n";
        let mut document: DocumentMut = text.parse().expect("TOML");
        name_no_files(document.as_item_mut());
        assert_eq!(document.to_string().matches(NO_FILE).count(), 2, "{document}");
        assert!(possible(&document, "x").iter().any(|key| key.path == "screen.scale"));
    }
}
