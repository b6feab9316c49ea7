//! What the keys of a rig file accept, from the messages about wrong values.

use std::path::Path;

/// Messages about `rig` with `key = value` at its mark. A line of the rig with the same key is left
/// out.
pub fn messages(rig: &str, key: &str, value: &str) -> Vec<String> {
    let others: Vec<&str> = rig.lines().filter(|line| line.split(" =").next() != Some(key)).collect();
    let text = others.join("\n").replace('@', &format!("{key} = {value}"));
    let rig = cupola::rig::parse(&text, "x", Path::new(""));
    rig.err().map_or_else(Vec::new, |error| problems(&error.message))
}

/// Lines of a message, without the name of the output behind its key.
pub fn problems(message: &str) -> Vec<String> {
    message.lines().map(|line| line.replace(" (output-1)", "")).collect()
}

/// The keys that are possible at the mark of `rig`.
pub fn possible_keys(rig: &str) -> Vec<String> {
    let messages = messages(rig, "qqq", "1");
    let list = messages.iter().find_map(|line| line.split(".qqq: unknown key; possible here: ").nth(1));
    let list =
        list.or_else(|| messages.iter().find_map(|line| line.split(" qqq: unknown key; possible here: ").nth(1)));
    list.unwrap_or_else(|| panic!("{rig}: {messages:?}")).split(", ").map(str::to_owned).collect()
}

/// Writes `1000000` as `10⁶`.
pub fn number(text: &str) -> String {
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
pub fn accepted(rig: &str, key: &str) -> String {
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
