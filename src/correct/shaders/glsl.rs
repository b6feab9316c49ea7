//! The correction shaders: texts generated from WGSL at build time, and their specialisation.
//!
//! A generated text has a gap where its uniform block was. [`specialise`] fills it with the
//! values as a constant of the language. Loading uniforms per pixel dominates software rendering
//! (10.5 ms against 3.3 ms for one pass at 1080p on llvmpipe), and only a constant lets the
//! compiler drop the branches of a pass that a batch does not need.

use crate::correct::shaders::constants::{Constants, Pass};
use std::fmt::Write;

/// The language of a text.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Language {
    /// GLSL 3.30 core, for OpenGL 3.3 and later.
    Glsl330,
    /// GLSL ES 3.00, for OpenGL ES 3.0 and later.
    Essl300,
}

/// Output of the last stage.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Stage {
    /// The corrected picture.
    Present,
    /// The map itself: atlas x, atlas y (0…1), number of the view plus one (0: nothing is shown),
    /// weight (linear light).
    Map,
}

/// A program in two texts, ready to be compiled.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct Specialised {
    /// The vertex stage. Attribute 0: clip coordinates (x, y); attribute 1: the source's
    /// coordinates (x, y), or for [`Pass::Mesh`] a direction and a weight.
    pub vertex: &'static str,
    /// The fragment stage.
    pub fragment: String,
    /// Uniform name and texture (`atlas`, `mask`, `table` or `black_picture`) of each sampler.
    pub samplers: &'static [(&'static str, &'static str)],
}

/// The generated texts of one pass.
struct PassText {
    pass: Pass,
    /// True if the picture is content, not views.
    content: bool,
    /// The constant's constructor: `%` stands for a float, `#` for an unsigned number.
    constructor: &'static str,
    texts: &'static [StageText],
}

struct StageText {
    language: Language,
    stage: Stage,
    vertex: &'static str,
    /// Before the gap, type and name of the constant, after the gap.
    fragment: (&'static str, &'static str, &'static str),
    samplers: &'static [(&'static str, &'static str)],
}

include!(concat!(env!("OUT_DIR"), "/shaders.rs"));

/// Returns the generated texts of `pass`.
fn text_of(pass: Pass, content: bool) -> &'static PassText {
    // PASSES has an entry for each; the build script and a test make sure of that.
    PASSES.iter().find(|text| text.pass == pass && text.content == content).unwrap_or(&PASSES[0])
}

/// Returns the program of `constants` in `language`.
///
/// [`Pass::Black`] has only the stage [`Stage::Present`], which serves for every stage.
pub fn specialise(constants: &Constants, language: Language, stage: Stage) -> Specialised {
    let pass = text_of(constants.pass(), constants.shows_content());
    let stage = if constants.pass() == Pass::Black { Stage::Present } else { stage };
    let text = pass.texts.iter().find(|t| t.language == language && t.stage == stage).unwrap_or(&pass.texts[0]);
    let (head, declaration, tail) = text.fragment;
    let mut fragment = String::with_capacity(head.len() + tail.len() + 16 * constants.scalars().len() + 64);
    fragment.push_str(head);
    if !declaration.is_empty() {
        fragment.push_str("const ");
        fragment.push_str(declaration);
        fragment.push_str(" = ");
        write_constructor(pass.constructor, constants.scalars(), &mut fragment);
        fragment.push(';');
    }
    fragment.push_str(tail);
    Specialised { vertex: text.vertex, fragment, samplers: text.samplers }
}

/// Replaces the placeholders of `constructor` by `values`.
fn write_constructor(constructor: &str, values: &[f32], out: &mut String) {
    let mut values = values.iter();
    for c in constructor.chars() {
        // Writing to a String cannot fail. `Constants` has as many values as there are
        // placeholders.
        match c {
            // The shortest decimal that reads back as the same f32.
            '%' => _ = write!(out, "{:e}", values.next().copied().unwrap_or_default()),
            '#' => _ = write!(out, "{}u", values.next().copied().unwrap_or_default() as u32),
            c => out.push(c),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::correct::shaders::constants::members;

    #[test]
    fn every_pass_has_its_texts_in_both_languages() {
        for pass in [
            Pass::Fisheye,
            Pass::Projector,
            Pass::Optics,
            Pass::Perspective,
            Pass::Panorama,
            Pass::Table,
            Pass::Mesh,
            Pass::Black,
        ]
        .into_iter()
        .flat_map(|pass| [(pass, false), (pass, true)])
        .filter(|(pass, content)| *pass != Pass::Black || !content)
        {
            let (pass, content) = pass;
            let text = text_of(pass, content);
            assert_eq!((text.pass, text.content), (pass, content));
            let placeholders = text.constructor.matches(['%', '#']).count();
            assert_eq!(members(pass).iter().map(|member| member.1).sum::<usize>(), placeholders, "{pass:?}");
            for language in [Language::Glsl330, Language::Essl300] {
                let stages = text.texts.iter().filter(|t| t.language == language).count();
                assert_eq!(stages, if pass == Pass::Black { 1 } else { 2 });
            }
            for text in text.texts {
                assert!(!text.fragment.2.contains("layout(std140)"), "a uniform block is left in {pass:?}");
                // Built-ins whose precision drivers may choose freely.
                for name in ["sin(", "cos(", "tan(", "atan(", "acos(", "asin("] {
                    assert!(!text.fragment.2.contains(name), "{pass:?} uses {name}");
                }
            }
        }
    }

    #[test]
    fn literals_read_back_as_the_same_number() {
        let mut out = String::new();
        let values = [1.0 / 3.0, -1.5e-38, 3.402_823_5e38, 0.0, 7.0];
        write_constructor("f(%,%,%,%,#)", &values, &mut out);
        let inner = out.trim_start_matches("f(").trim_end_matches(')');
        let parts: Vec<&str> = inner.split(',').collect();
        for (part, value) in parts.iter().zip(values).take(4) {
            assert_eq!(part.parse::<f32>().map(f32::to_bits), Ok(value.to_bits()));
            assert!(part.contains('e'), "{part} would be an integer");
        }
        assert_eq!(parts[4], "7u");
    }
}
