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
    let meant = other_format(text)
        .map(str::to_owned)
        .or_else(|| meant(line))
        .map_or_else(String::new, |meant| format!("; {meant}"));
    format!("{why}, in column {column}{meant}")
}

/// Says what a text is that has another format as a whole.
fn other_format(text: &str) -> Option<&'static str> {
    let start = text.trim_start_matches('\u{feff}').trim_start();
    if text.contains('\0') {
        return Some("the file has zero bytes, so it is not a text file");
    }
    if start.starts_with('{') {
        return Some("the file begins like JSON; `cupola setup --from FILE` reads configurations of SGCT");
    }
    if start.starts_with('<') {
        return Some("the file begins like XML; `cupola setup --from FILE` reads the formats of docs/formats.md");
    }
    if text.contains('\r') && !text.contains('\n') {
        return Some("its lines end with a carriage return only; save it with the line ends of Unix or Windows");
    }
    None
}

/// Returns a hint at the correct form of a line.
fn meant(line: &str) -> Option<String> {
    if line.contains(['“', '”', '„', '‘', '’', '«', '»']) {
        return Some("words are in straight quotes: \"word\"".to_owned());
    }
    let Some((key, value)) = line.split_once('=') else {
        let (key, value) = line.split_once(':')?;
        let is_key =
            |text: &str| !text.is_empty() && text.chars().all(|c| c.is_ascii_alphanumeric() || "-_.".contains(c));
        if !is_key(key.trim()) || value.trim().is_empty() {
            return None;
        }
        return Some(format!("a key and its value are joined by `=`: {} = {}", key.trim(), value.trim()));
    };
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
        let deep = "[".repeat(5000);
        for (text, remedy) in [
            (format!("a = {deep}").as_str(), "nested too deeply"),
            ("{ \"a\": 1 }", "like JSON"),
            ("\n<xml/>", "like XML"),
            ("a\0b", "zero bytes"),
            ("[dome]\rradius = 5\r", "carriage return only"),
            ("radius: 5", "joined by `=`: radius = 5"),
        ] {
            let error = crate::rig::parse(text, "a.toml", Path::new("")).expect_err(text);
            assert!(error.message.contains(remedy), "{}", error.message);
        }
        let other = crate::rig::parse("[dome\nradius = 5\n", "a.toml", Path::new("")).expect_err("no bracket");
        assert!(other.message.contains("in column"), "{}", other.message);
    }
}
