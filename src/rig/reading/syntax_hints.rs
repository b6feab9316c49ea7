//! Guesses at the intended text where a text is not TOML.

use std::ops::Range;

/// Message `why` about `span` of `text`, with its column and, if one can be found, with a
/// correction.
pub(in crate::rig) fn with_hint(text: &str, span: Option<Range<usize>>, why: String) -> String {
    let Some(start) = span.map(|span| span.start.min(text.len())).filter(|start| text.is_char_boundary(*start)) else {
        return why;
    };
    let first = text[..start].rfind('\n').map_or(0, |newline| newline + 1);
    let line = text[first..].lines().next().unwrap_or_default();
    let column = text[first..start].chars().count() + 1;
    let meant = meant(line).map_or_else(String::new, |meant| format!("; {meant}"));
    format!("{why}, in column {column}{meant}")
}

/// Returns a hint at the correct form of a line.
fn meant(line: &str) -> Option<String> {
    if line.contains(['“', '”', '„', '‘', '’', '«', '»']) {
        return Some("words are in straight quotes: \"word\"".to_owned());
    }
    let (key, value) = line.split_once('=')?;
    let (key, value) = (key.trim(), value.split('#').next().unwrap_or_default().trim());
    let digits = |text: &str| !text.is_empty() && text.chars().all(|c| c.is_ascii_digit());
    let sign = if value.starts_with('-') { "-" } else { "" };
    if let Some((whole, part)) = value.trim_start_matches(['-', '+']).split_once(',')
        && digits(whole)
        && digits(part)
    {
        return Some(format!("a decimal point is meant: {key} = {sign}{whole}.{part}"));
    }
    let number = value.trim_end_matches(|c: char| c.is_alphabetic() || "°²%\"' ".contains(c));
    if number.len() < value.len() && number.parse::<f64>().is_ok() {
        return Some(format!("units are left out, lengths are in metres and angles in degrees: {key} = {number}"));
    }
    let is_word = !value.is_empty() && value.chars().all(|c| c.is_ascii_alphanumeric() || "-_".contains(c));
    (is_word && value.parse::<f64>().is_err()).then(|| format!("words are in quotes: {key} = \"{value}\""))
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    #[test]
    fn common_mistakes_get_their_remedy() {
        for (line, column, remedy) in [
            ("radius = 5,0", 11, "radius = 5.0"),
            ("tilt = -2,25 # down", 10, "tilt = -2.25"),
            ("radius = 5 m", 10, "radius = 5"),
            ("tilt = 30°", 0, "tilt = 30"),
            ("name = “dome”", 8, "straight quotes"),
            ("shape = sphere", 9, "shape = \"sphere\""),
        ] {
            let error = crate::rig::parse(&format!("[dome]\n{line}\n"), "a.toml", Path::new("")).expect_err(line);
            assert!(error.message.starts_with("a.toml:2: this is not TOML: "), "{}", error.message);
            assert!(error.message.contains(remedy), "{}", error.message);
            assert!(column == 0 || error.message.contains(&format!("in column {column}")), "{}", error.message);
        }
        let other = crate::rig::parse("[dome\nradius = 5\n", "a.toml", Path::new("")).expect_err("no bracket");
        assert!(other.message.contains("in column"), "{}", other.message);
    }
}
