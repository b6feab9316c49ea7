//! Change of a shader's text that lets the program's own shader draw to a view.
//!
//! The last stage before rasterisation gets an epilogue that re-projects `gl_Position`
//! (`geom::reprojection`). A macro renames the program's `main`, and a new `main` calls it. So the
//! program's text does not change, and its line numbers stay correct.

use crate::correct::projected::projection::functions;
use std::borrow::Cow;

/// Stage that can be the last one before rasterisation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stage {
    /// Vertex shader.
    Vertex,
    /// Tessellation evaluation shader.
    TessellationEvaluation,
    /// Geometry shader.
    Geometry,
}

/// Returns `source` with the epilogue. `None`: the text cannot be patched (it has no `main`).
/// `es_context`: the context is OpenGL ES, which determines the language of a text without
/// `#version`. `curved`: there are views to whose lens vertices are projected.
pub fn patch(source: &str, stage: Stage, es_context: bool, curved: bool) -> Option<String> {
    let bare = strip_comments(source);
    if !defines_main(&bare) {
        return None;
    }
    let (version, es) = version(&bare, es_context);
    // The macro must come after `#version` and may come before `#extension`.
    let head_end = end_of_version_line(source, &bare);
    let (head, body) = source.split_at(head_end);
    // A text must continue on a new line after a directive. Otherwise it is wrong, and is not
    // patched.
    let ends_within = |part: &str| !part.is_empty() && !part.ends_with('\n');
    if ends_within(head) {
        return None;
    }
    let line = head.matches('\n').count() + 1;
    // Before GLSL 330 and ESSL 300, `#line n` numbers the *following* line n + 1.
    let line = if (es && version < 300) || (!es && version < 330) { line.saturating_sub(1) } else { line };
    let fix = functions(es, curved);
    Some(match stage {
        Stage::Vertex | Stage::TessellationEvaluation => format!(
            "{head}#define main cupola_main\n#line {line}\n{body}\n#undef main\n{fix}\n\
             void main() {{ cupola_main(); gl_Position = cupola_fix(gl_Position); }}\n"
        ),
        Stage::Geometry => {
            // A declaration must not stand before `#extension`, so it follows the last one.
            let split = after_last_extension(&bare).max(head_end);
            let (before, after) = source.split_at(split);
            if ends_within(before) {
                return None;
            }
            let line = before.matches('\n').count() + 1;
            let line = if !es && version < 330 { line.saturating_sub(1) } else { line };
            format!(
                "{before}void cupola_emit();\n#define EmitVertex cupola_emit\n#line {line}\n{after}\n\
                 #undef EmitVertex\n{fix}\nvoid cupola_emit() {{ gl_Position = cupola_fix(gl_Position); EmitVertex(); }}\n"
            )
        }
    })
}

/// True if a shader's text has the `main` of its stage.
pub fn has_main(source: &str) -> bool {
    defines_main(&strip_comments(source))
}

/// True if the text names `word` as a whole identifier, outside comments.
pub fn mentions(source: &str, word: &str) -> bool {
    let bare = strip_comments(source);
    let is_name = |c: char| c.is_ascii_alphanumeric() || c == '_';
    bare.match_indices(word).any(|(at, _)| {
        !bare[..at].chars().next_back().is_some_and(is_name)
            && !bare[at + word.len()..].chars().next().is_some_and(is_name)
    })
}

/// Replaces comments by spaces, byte for byte, so that offsets are those of the source.
pub fn strip_comments(source: &str) -> Cow<'_, str> {
    if !source.contains("//") && !source.contains("/*") {
        return Cow::Borrowed(source);
    }
    let bytes = source.as_bytes();
    let mut out = bytes.to_vec();
    let mut i = 0;
    while i + 1 < bytes.len() {
        let end = match &bytes[i..i + 2] {
            b"//" => source[i..].find('\n').map_or(bytes.len(), |n| i + n),
            b"/*" => source[i + 2..].find("*/").map_or(bytes.len(), |n| i + n + 4),
            _ => {
                i += 1;
                continue;
            }
        };
        for byte in &mut out[i..end] {
            if *byte != b'\n' {
                *byte = b' ';
            }
        }
        i = end;
    }
    // Only complete comments became ASCII spaces, so the text is still UTF-8.
    String::from_utf8(out).map_or(Cow::Borrowed(source), Cow::Owned)
}

/// Returns the version number, and whether the language is ESSL. Without `#version` it is GLSL 110,
/// or ESSL 100 in a context of OpenGL ES (many desktop texts contain precisions too, for `#ifdef
/// GL_ES`).
pub(in crate::intercept::gl) fn version(bare: &str, es_context: bool) -> (u32, bool) {
    for line in bare.lines() {
        let Some(rest) = line.trim_start().strip_prefix('#').map(str::trim_start) else { continue };
        if let Some(rest) = rest.strip_prefix("version") {
            let mut words = rest.split_whitespace();
            let number = words.next().and_then(|n| n.parse().ok()).unwrap_or(110);
            return (number, number == 100 || words.next() == Some("es"));
        }
    }
    if es_context { (100, true) } else { (110, false) }
}

pub(in crate::intercept::gl) fn end_of_version_line(source: &str, bare: &str) -> usize {
    end_of_directive(source, bare, "version")
}

fn after_last_extension(bare: &str) -> usize {
    end_of_directive(bare, bare, "extension")
}

/// Returns the offset after the line of the last `#directive`; 0 if there is none.
fn end_of_directive(source: &str, bare: &str, directive: &str) -> usize {
    let mut offset = 0;
    let mut found = 0;
    for line in bare.split_inclusive('\n') {
        offset += line.len();
        let rest = line.trim_start().strip_prefix('#').map(str::trim_start);
        if rest.is_some_and(|r| r.starts_with(directive)) {
            found = offset;
        }
    }
    found.min(source.len())
}

/// True if there is a `main` followed by `(` outside of all braces.
fn defines_main(bare: &str) -> bool {
    let is_name = |c: char| c.is_ascii_alphanumeric() || c == '_';
    bare.match_indices("main").any(|(at, _)| {
        !bare[..at].chars().next_back().is_some_and(is_name)
            && bare[at + 4..].trim_start().starts_with('(')
            && bare[..at].matches('{').count() == bare[..at].matches('}').count()
    })
}

#[cfg(test)]
mod tests {
    use super::{Stage, mentions, patch};

    #[test]
    fn epilogue_follows_the_program_s_own_text() {
        let source =
            "#version 330 core\n#extension GL_ARB_foo : enable\nin vec4 p;\nvoid main() { gl_Position = p; }\n";
        let patched = patch(source, Stage::Vertex, false, false).expect("has a main");
        assert!(patched.starts_with("#version 330 core\n#define main cupola_main\n#line 2\n#extension"));
        assert!(patched.contains("void main() { cupola_main(); gl_Position = cupola_fix(gl_Position); }"));
        assert!(!patched.contains("highp"));
    }

    #[test]
    fn old_dialects_count_lines_from_the_one_before() {
        let patched = patch("#version 120\nvoid main() {}\n", Stage::Vertex, false, false).expect("has a main");
        assert!(patched.contains("#line 1\n"), "{patched}");
        let patched = patch("void main() {}\n", Stage::Vertex, false, false).expect("has a main");
        assert!(patched.starts_with("#define main cupola_main\n#line 0\n"), "{patched}");
    }

    #[test]
    fn es_texts_get_precisions() {
        let qualified = |source: &str, es_context: bool| {
            let patched = patch(source, Stage::Vertex, es_context, false).expect("has a main");
            patched.contains("uniform highp vec4 cupola_view[4];")
        };
        for source in ["#version 300 es\nvoid main() {}", "#version 100\nvoid main() {}"] {
            assert!(qualified(source, false) && qualified(source, true), "{source}");
        }
        // Many programs use the same text for both kinds of context.
        let both = "#ifdef GL_ES\nprecision mediump float;\n#endif\nvoid main() {}";
        assert!(qualified(both, true) && !qualified(both, false));
    }

    #[test]
    fn geometry_shaders_fix_each_vertex() {
        let source = "#version 330\n#extension GL_x : enable\nlayout(points) in;\nvoid main() { gl_Position = vec4(0); EmitVertex(); }";
        let patched = patch(source, Stage::Geometry, false, false).expect("has a main");
        let declared = patched.find("void cupola_emit();").expect("declared");
        assert!(
            declared > patched.find("#extension").expect("kept") && declared < patched.find("layout").expect("kept")
        );
    }

    #[test]
    fn a_main_in_a_comment_is_none() {
        assert_eq!(
            patch("/* void main() {} */ float f() { return 1.0; } // main()", Stage::Vertex, false, false),
            None
        );
        assert_eq!(patch("float domain(float x) { return x; }", Stage::Vertex, false, false), None);
        assert!(patch("// é\nvoid main ( ) {}", Stage::Vertex, false, false).is_some());
    }

    /// Added text would be on the line of the directive.
    #[test]
    fn a_main_on_the_line_of_the_version_is_none() {
        for source in ["#version 330 void main() {}", "// a\n#version 330 es void main() {}"] {
            assert_eq!(patch(source, Stage::Vertex, false, false), None, "{source}");
        }
        let geometry = "#version 330\n#extension GL_x : enable void main() {}";
        assert_eq!(patch(geometry, Stage::Geometry, false, false), None);
        assert!(patch("#version 330\r\nvoid main() {}", Stage::Vertex, false, false).is_some());
    }

    #[test]
    fn lenses_are_brought_only_where_they_are_used() {
        let source = "#version 330\nvoid main() { gl_Position = vec4(0); }\n";
        let plain = patch(source, Stage::Vertex, false, false).expect("has a main");
        assert!(plain.contains("cupola_view[4]") && !plain.contains("cupola_project"));
        let curved = patch(source, Stage::Vertex, false, true).expect("has a main");
        assert!(curved.contains("cupola_view[8]") && curved.contains("return cupola_project("));
        assert!(!curved.contains("PRECISION") && !curved.contains("CURVED"));
    }

    #[test]
    fn whole_words_only() {
        assert!(mentions("gl_Position = ftransform();", "ftransform"));
        assert!(!mentions("my_ftransform(); // ftransform", "ftransform"));
    }
}
