//! Head of a shader's text. Uniforms of Cupola are declared after it.

use crate::intercept::gl::shader::source::patch::{end_of_version_line, version};

/// Text before all declarations: `#version`, the last `#extension`, and the conditions around it.
pub struct Head<'a> {
    text: &'a str,
    rest: &'a str,
    version: u32,
    es: bool,
}

impl<'a> Head<'a> {
    /// Returns the head of `source`. `bare` is the same text without comments, byte for byte.
    /// `None`: a declaration would have no line of its own. `es_context`: as for
    /// [`patch`](super::patch::patch).
    pub fn of(source: &'a str, bare: &str, es_context: bool) -> Option<Self> {
        let (version, es) = version(bare, es_context);
        let (text, rest) = source.split_at(after_extensions(bare).max(end_of_version_line(source, bare)));
        (text.is_empty() || text.ends_with('\n')).then_some(Self { text, rest, version, es })
    }

    /// Returns the number of bytes.
    pub fn length(&self) -> usize {
        self.text.len()
    }

    /// Returns the text that follows the head.
    pub fn rest(&self) -> &'a str {
        self.rest
    }

    /// Returns the declaration of a uniform, with the highest precision. `value`: its initial
    /// value, if the language allows one.
    pub fn uniform(&self, kind: &str, name: &str, value: Option<&str>) -> String {
        match (self.es, self.version, value) {
            // The text may not have set the default precision yet, and a fragment shader may not
            // support high precision.
            (true, 100, _) => format!(
                "#ifdef GL_FRAGMENT_PRECISION_HIGH\nuniform highp {kind} {name};\n#else\nuniform mediump {kind} {name};\n\
                 #endif\n"
            ),
            (true, ..) => format!("uniform highp {kind} {name};\n"),
            (false, 120.., Some(value)) => format!("uniform {kind} {name}={value};\n"),
            (false, ..) => format!("uniform {kind} {name};\n"),
        }
    }

    /// Returns the text with `declarations`, followed by `rest`, whose lines keep their numbers.
    pub fn declaring(&self, declarations: &str, rest: &str) -> String {
        let line = self.text.matches('\n').count() + 1;
        // Before GLSL 330 and ESSL 300, `#line n` numbers the *following* line n + 1.
        let old = self.version < if self.es { 300 } else { 330 };
        let line = if old { line.saturating_sub(1) } else { line };
        format!("{}{declarations}#line {line}\n{rest}", self.text)
    }
}

/// Returns the offset after the last `#extension`, and after the conditions around it.
fn after_extensions(bare: &str) -> usize {
    let (mut offset, mut found, mut depth) = (0, 0, 0_usize);
    let mut waits = false;
    for line in bare.split_inclusive('\n') {
        offset += line.len();
        let directive = line.trim_start().strip_prefix('#').map_or("", str::trim_start);
        if directive.starts_with("if") {
            depth += 1;
        } else if directive.starts_with("endif") {
            depth = depth.saturating_sub(1);
        } else {
            waits |= directive.starts_with("extension");
        }
        if waits && depth == 0 {
            (found, waits) = (offset, false);
        }
    }
    found
}
