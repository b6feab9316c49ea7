//! The page of `cupola inspect`: one file, without scripts, that a browser shows.

use super::{DrawNote, PassNote};
use crate::intercept::scene::lens::field_of_view;
use crate::runtime::run_results::{self, Picture, Statistics};
use std::fmt::{self, Write};

/// Content of a page.
pub struct Page<'a> {
    /// The program's command line.
    pub command: String,
    /// The passes of the frame.
    pub passes: &'a [PassNote],
    /// Statistics and notes.
    pub statistics: Option<&'a Statistics>,
    /// The outputs.
    pub outputs: &'a [Picture],
    /// The views, the panel and the program's own picture.
    pub views: &'a [Picture],
}

/// Width to which pictures are reduced, in pixels.
const WIDTH: u32 = 512;

const STYLE: &str = "body{font:15px/1.45 sans-serif;margin:2em;max-width:75em;color:#222;background:#fff}\
h1{font-size:1.5em}h2{font-size:1.2em;border-top:1px solid #ccc;padding-top:.8em;margin-top:1.6em}\
table{border-collapse:collapse;margin:.5em 0}td,th{border:1px solid #ccc;padding:.25em .6em;text-align:left;\
vertical-align:top}th{background:#f3f3f3}figure{display:inline-block;margin:.4em 1em .4em 0;vertical-align:top}\
figcaption{font-size:.85em;color:#555}img{max-width:22em;background:#888;border:1px solid #ccc}\
.scene{background:#e2f3e2}.flat{background:#fbeed2}code{font-size:.9em}pre{overflow:auto}";

/// Text in which the special characters of HTML are replaced.
struct Text<'a>(&'a str);

impl fmt::Display for Text<'_> {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        for character in self.0.chars() {
            match character {
                '<' => out.write_str("&lt;")?,
                '>' => out.write_str("&gt;")?,
                '&' => out.write_str("&amp;")?,
                '"' => out.write_str("&quot;")?,
                _ => out.write_char(character)?,
            }
        }
        Ok(())
    }
}

/// The page as HTML.
pub fn html(page: &Page<'_>) -> String {
    let mut out = String::new();
    // Writing to a string cannot fail.
    let _ = write_page(&mut out, page);
    out
}

fn write_page(out: &mut String, page: &Page<'_>) -> fmt::Result {
    let command = Text(&page.command);
    write!(out, "<!doctype html><html lang=en><meta charset=utf-8><title>cupola inspect: {command}</title>")?;
    write!(out, "<style>{STYLE}</style><h1>What Cupola saw of <code>{command}</code></h1>")?;
    summary(out, page)?;
    pictures(out, "Outputs", page.outputs)?;
    pictures(out, "Views, panel and the program's own picture", page.views)?;
    write!(out, "<h2>Passes</h2><p>Draws to one target that follow each other, in the order of the frame.</p>")?;
    let several_contexts = page.passes.windows(2).any(|pair| pair[0].context != pair[1].context);
    if page.passes.is_empty() {
        write!(out, "<p>No draw was described: the program ended by itself, or drew nothing in this frame.</p>")?;
    }
    for (number, pass) in page.passes.iter().enumerate() {
        write_pass(out, number + 1, pass, several_contexts)?;
    }
    if let Some(text) = page.statistics.and_then(|statistics| serde_json::to_string_pretty(statistics).ok()) {
        write!(out, "<h2>Statistics</h2><pre>{}</pre>", Text(&text))?;
    }
    write!(out, "</html>")
}

fn summary(out: &mut String, page: &Page<'_>) -> fmt::Result {
    let of_class = |class: &str| -> u64 {
        let draws = page.passes.iter().flat_map(|pass| &pass.draws);
        draws.filter(|(draw, _)| draw.class == class).map(|(_, count)| count).sum()
    };
    let mut classes: Vec<&str> = Vec::new();
    for (draw, _) in page.passes.iter().flat_map(|pass| &pass.draws) {
        if !classes.contains(&draw.class) {
            classes.push(draw.class);
        }
    }
    write!(out, "<table><tr><th>Cupola<td>{}", env!("CARGO_PKG_VERSION"))?;
    if let Some(statistics) = page.statistics {
        write!(out, "<tr><th>driver<td>{}<tr><th>rig<td>{}", Text(&statistics.driver), Text(&statistics.rig))?;
        write!(out, "<tr><th>frame<td>{}", statistics.frames)?;
    }
    write!(out, "<tr><th>passes<td>{}<tr><th>draws<td>", page.passes.len())?;
    for (number, class) in classes.iter().enumerate() {
        write!(out, "{}{} {}", if number == 0 { "" } else { ", " }, of_class(class), Text(class))?;
    }
    write!(out, "</table>")?;
    let notes = page.statistics.map(|statistics| &statistics.notes[..]).unwrap_or_default();
    if !notes.is_empty() {
        write!(out, "<h2>Notes</h2><ul>")?;
        for note in notes {
            write!(out, "<li>{}", Text(note))?;
        }
        write!(out, "</ul>")?;
    }
    Ok(())
}

fn pictures(out: &mut String, title: &str, pictures: &[Picture]) -> fmt::Result {
    if pictures.is_empty() {
        return Ok(());
    }
    write!(out, "<h2>{title}</h2>")?;
    pictures.iter().try_for_each(|picture| write_picture(out, picture))
}

fn write_picture(out: &mut String, picture: &Picture) -> fmt::Result {
    if picture.width == 0 || picture.height == 0 {
        return Ok(());
    }
    let (name, width, height) = (Text(&picture.name), picture.width, picture.height);
    let Ok(png) = run_results::reduced_png(picture, WIDTH) else {
        return write!(out, "<p>{name}: the picture cannot be written</p>");
    };
    write!(out, "<figure><img alt=\"{name}\" src=\"data:image/png;base64,")?;
    write_base64(out, &png)?;
    write!(out, "\"><figcaption>{name}, {width} × {height}</figcaption></figure>")
}

fn write_pass(out: &mut String, number: usize, pass: &PassNote, several_contexts: bool) -> fmt::Result {
    let context = if several_contexts { format!(", context {}", pass.context) } else { String::new() };
    write!(out, "<h3>{number}. {}{context}</h3><p>{}</p>", Text(&pass.target), Text(&pass.how))?;
    if let Some(picture) = &pass.picture {
        write_picture(out, picture)?;
    }
    write!(out, "<table><tr><th>draws<th>taken for<th>because<th>lens<th>shaders<th>state<th>matrices")?;
    for (draw, count) in &pass.draws {
        write_draw(out, draw, *count)?;
    }
    write!(out, "</table>")
}

fn write_draw(out: &mut String, draw: &DrawNote, count: u64) -> fmt::Result {
    let colour = if draw.class == "flat" { "flat" } else { "scene" };
    write!(out, "<tr class={colour}><td>{count}<td>{}<td>{}<td>", Text(draw.class), Text(&draw.why))?;
    if let Some(lens) = &draw.lens {
        write!(out, "{}", field_of_view(lens))?;
    }
    write!(out, "<td>{}<td>{}<td>", Text(&draw.shaders), Text(&draw.state))?;
    for matrix in &draw.matrices {
        write!(out, "<code>{}</code> ({}): {}<br>", Text(&matrix.name), matrix.form, Text(&matrix.says))?;
    }
    Ok(())
}

fn write_base64(out: &mut String, bytes: &[u8]) -> fmt::Result {
    const DIGITS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    for three in bytes.chunks(3) {
        let byte = |i: usize| u32::from(three.get(i).copied().unwrap_or(0));
        let bits = byte(0) << 16 | byte(1) << 8 | byte(2);
        for digit in 0..4 {
            let present = digit <= three.len();
            let value = (bits >> (18 - 6 * digit) & 63) as usize;
            out.write_char(if present { char::from(DIGITS[value]) } else { '=' })?;
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::{Page, html, write_base64};
    use crate::intercept::inspection::{DrawNote, PassNote};
    use crate::intercept::scene::lens::field_of_view;
    use crate::runtime::run_results::Picture;
    use crate::runtime::session::Intrinsics;

    #[test]
    fn base64_is_that_of_the_standard() {
        // The examples of RFC 4648.
        for (bytes, expected) in [("", ""), ("f", "Zg=="), ("fo", "Zm8="), ("foo", "Zm9v"), ("foobar", "Zm9vYmFy")] {
            let mut text = String::new();
            write_base64(&mut text, bytes.as_bytes()).expect("a string");
            assert_eq!(text, expected);
        }
    }

    #[test]
    fn a_lens_is_told_by_its_angles() {
        let lens = Intrinsics { a: 1.0, b: 0.0, c: 1.0 / 30_f64.to_radians().tan(), d: 0.0, e: -1.0, f: None };
        assert_eq!(field_of_view(&lens), "90.00° × 60.00°");
        // From 0 to 45 degrees.
        let aside = Intrinsics { a: 2.0, b: 1.0, ..lens };
        assert_eq!(field_of_view(&aside), "45.00° × 60.00°, off centre");
    }

    #[test]
    fn names_of_the_program_are_text_and_no_markup() {
        let draw = DrawNote { class: "flat", why: "a < b & \"c\"".to_owned(), ..DrawNote::default() };
        let pass = PassNote {
            context: 0,
            target: "<script>".to_owned(),
            how: String::new(),
            draws: vec![(draw, 3)],
            picture: Some(Picture { name: "p".to_owned(), width: 1, height: 1, rgba: vec![1, 2, 3, 4] }),
        };
        let page = Page { command: "x <y>".to_owned(), passes: &[pass], statistics: None, outputs: &[], views: &[] };
        let text = html(&page);
        assert!(!text.contains("<script>") && text.contains("&lt;script&gt;") && text.contains("x &lt;y&gt;"));
        assert!(text.contains("a &lt; b &amp; &quot;c&quot;") && text.contains("<td>3<td>flat"), "{text}");
        assert!(text.contains("data:image/png;base64,iVBOR"), "the signature of a PNG file: {text}");
    }
}
