//! Keys are taken out of a rig file. All else, with its comments, stays as it is.

use super::{name_of, of_output};
use std::ops::Range;
use toml_edit::{Document, DocumentMut, Item, TableLike};

/// The text without these keys, such as `output.NAME.yaw`; `*` stands for all outputs that have the
/// key. Comments stay. A table that becomes empty is removed, too.
///
/// # Errors
/// The text is not TOML, or lacks a key.
pub fn without(text: &str, keys: &[String]) -> Result<String, String> {
    keys.iter().try_fold(text.to_owned(), |text, key| without_key(&text, key.trim()))
}

fn without_key(text: &str, key: &str) -> Result<String, String> {
    let document = parsed(text)?;
    let missing = || format!("{key} is not in the file, so it cannot be removed");
    let Some((name, path)) = of_output(document.as_table(), key) else {
        let path: Vec<&str> = key.split('.').collect();
        return without_path(text, None, &path)?.ok_or_else(missing);
    };
    let outputs = document.get("output").and_then(Item::as_array_of_tables);
    let names = outputs.into_iter().flatten().enumerate().map(|(index, output)| name_of(output, index));
    let wanted: Vec<bool> = names.map(|own| name == "*" || name == own).collect();
    let (mut text, mut found) = (text.to_owned(), false);
    for (index, _) in wanted.iter().enumerate().filter(|(_, is_wanted)| **is_wanted) {
        if let Some(shorter) = without_path(&text, Some(index), &path)? {
            (text, found) = (shorter, true);
        }
    }
    if found { Ok(text) } else { Err(missing()) }
}

fn parsed(text: &str) -> Result<Document<&str>, String> {
    Document::parse(text).map_err(|error| format!("the file is not valid TOML: {error}"))
}

/// The text without a key of the file, or of the output with this index; `None` if it is absent.
fn without_path(text: &str, output: Option<usize>, path: &[&str]) -> Result<Option<String>, String> {
    let document = parsed(text)?;
    let root = document.as_item();
    let start = output.map_or(Some(root), |index| root.get("output")?.get(index));
    let Some((last, parents)) = path.split_last() else { return Ok(None) };
    let mut item = start;
    let mut is_inline = false;
    for name in parents {
        item = item.and_then(|item| item.get(name));
        is_inline |= item.is_some_and(Item::is_inline_table);
    }
    let Some(table) = item.and_then(Item::as_table_like) else { return Ok(None) };
    if !table.contains_key(last) {
        return Ok(None);
    }
    // An output is a table of its own, and stays.
    if table.len() == 1 && !parents.is_empty() {
        let rest = if is_inline { text.to_owned() } else { cut(text, &ranges(table, last)) };
        return without_path(&rest, output, parents).map(|shorter| Some(shorter.unwrap_or(rest)));
    }
    if !is_inline {
        return Ok(Some(cut(text, &ranges(table, last))));
    }
    let mut document: DocumentMut = text.parse().map_err(|error| format!("the file is not valid TOML: {error}"))?;
    let root = document.as_item_mut();
    let mut item = match output {
        Some(index) => root.get_mut("output").and_then(|all| all.get_mut(index)),
        None => Some(root),
    };
    for name in parents {
        item = item.and_then(|item| item.get_mut(name));
    }
    if let Some(table) = item.and_then(Item::as_table_like_mut) {
        table.remove(last);
    }
    Ok(Some(document.to_string()))
}

/// Ranges of the text of a key: the key with its value, or all keys of its tables and their headings.
fn ranges(table: &dyn TableLike, key: &str) -> Vec<Range<usize>> {
    let of_table = |table: &toml_edit::Table| {
        let heading = table.span().filter(|_| !table.is_dotted() && !table.is_implicit());
        heading.into_iter().chain(table.iter().flat_map(|(key, _)| ranges(table, key))).collect::<Vec<_>>()
    };
    match table.get_key_value(key) {
        Some((_, Item::Table(inner))) => of_table(inner),
        Some((_, Item::ArrayOfTables(tables))) => tables.iter().flat_map(of_table).collect(),
        Some((key, Item::Value(value))) => {
            let ends = key.span().zip(value.span());
            ends.map(|(key, value)| key.start..value.end).into_iter().collect()
        }
        _ => Vec::new(),
    }
}

/// The text without these ranges, each from the start of its line, because a dotted key begins
/// there. Lines that are blank then are removed, but comments behind the ranges stay.
fn cut(text: &str, ranges: &[Range<usize>]) -> String {
    let mut ranges = ranges.to_vec();
    ranges.sort_by_key(|range| range.start);
    ranges.dedup();
    let mut text = text.to_owned();
    for range in ranges.into_iter().rev() {
        let mut start = text[..range.start].rfind('\n').map_or(0, |newline| newline + 1);
        let line = &text[range.end..];
        let blanks = line.len() - line.trim_start_matches([' ', '\t']).len();
        let mut end = range.end + blanks;
        if !text[end..].starts_with('#') {
            end += text[end..].find('\n').map_or(text.len() - end, |newline| newline + 1);
            // Of two blank lines around it, or of one before the end, only one stays, or none.
            let is_after_blank = text[..start].ends_with("\n\n");
            if is_after_blank && (end == text.len() || text[end..].starts_with('\n')) {
                start -= 1;
            }
        }
        text.replace_range(start..end, "");
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tune::changed;

    const RIG: &str = "# mine\nname = \"x\"\n\n[dome]\n# measured\nradius = 4.0 # wide\ntilt = 3\n\n[[output]]\n\
                       name = \"left.up\"\nblend = { ramp = 0.2, gamma = 2.4 }\nsize = [\n  10, # wide\n  20\n]\n\n\
                       [[output]]\nkind = \"projector\"\nmirror.radius = 1\n\n# glass\n[output.fisheye] # lens\n\
                       aperture = 170 # measured\n\n[[output.blend.ramps]]\nzero = 3\n";

    fn removed(key: &str) -> String {
        let text = without(RIG, &[key.to_owned()]).unwrap_or_else(|why| panic!("{key}: {why}"));
        assert!(text.parse::<DocumentMut>().is_ok(), "{key}: {text}");
        text
    }

    #[test]
    fn only_the_key_goes() {
        for (key, is, becomes) in [
            ("name", "name = \"x\"\n", ""),
            ("dome.radius", "radius = 4.0 # wide", "# wide"),
            ("dome.tilt", "tilt = 3\n", ""),
            ("output.left.up.blend.ramp", "{ ramp = 0.2, gamma = 2.4 }", "{ gamma = 2.4 }"),
            ("output.left.up.blend", "blend = { ramp = 0.2, gamma = 2.4 }\n", ""),
            ("output.left.up.size", "size = [\n  10, # wide\n  20\n]\n", ""),
            ("output.output-2.mirror.radius", "mirror.radius = 1\n", ""),
            ("output.*.kind", "kind = \"projector\"\n", ""),
            (
                "output.output-2.fisheye.aperture",
                "[output.fisheye] # lens\naperture = 170 # measured",
                "# lens\n# measured",
            ),
            ("output.output-2.fisheye", "[output.fisheye] # lens\naperture = 170 # measured", "# lens\n# measured"),
            ("output.output-2.blend.ramps", "\n[[output.blend.ramps]]\nzero = 3\n", ""),
        ] {
            assert!(RIG.contains(is), "{key}");
            assert_eq!(removed(key), RIG.replacen(is, becomes, 1), "{key}");
        }
    }

    #[test]
    fn a_key_that_was_set_leaves_nothing_when_it_is_removed() {
        for (change, key) in [
            ("overlay.yaw=3", "overlay.yaw"),
            ("content.kind=\"cubemap\"", "content.kind"),
            ("output.left.up.mask.image=\"a.png\"", "output.left.up.mask.image"),
            ("output.output-2.eye=0.1", "output.output-2.eye"),
            ("dome.coverage=90", "dome.coverage"),
        ] {
            let text = changed(RIG, &[change.to_owned()]).expect("good");
            assert_ne!(text, RIG);
            assert_eq!(without(&text, &[key.to_owned()]).expect("there"), RIG, "{text}");
        }
    }

    #[test]
    fn what_is_not_there_is_not_removed() {
        for key in
            ["", "dome.radios", "dome.radius.x", "output.right.eye", "output.left.up.eye", "output.*.eye", "output"]
        {
            // All outputs together are no key.
            assert!(without(RIG, &[key.to_owned()]).is_err() || key == "output", "{key}");
        }
        assert!(without("a = [", &["a".to_owned()]).is_err());
    }
}
