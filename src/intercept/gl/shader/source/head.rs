//! The head of a shader's text, behind which uniforms of Cupola are declared.

use crate::intercept::gl::shader::source::patch::{end_of_version_line, version};

/// Text before all declarations: `#version`, the last `#extension`, and conditions around it.
pub struct Head<'a> {
    text: &'a str,
    rest: &'a str,
    version: u32,
    es: bool,
}

impl<'a> Head<'a> {
    /// That of `source`; `bare` is the same without comments, byte for byte. `None` where a
    /// declaration would have no line of its own. `es_context`: as for
    /// [`patch`](super::patch::patch).
    pub fn of(source: &'a str, bare: &str, es_context: bool) -> Option<Self> {
        let (version, es) = version(bare, es_context);
        let (text, rest) = source.split_at(after_extensions(bare).max(end_of_version_line(source, bare)));
        (text.is_empty() || text.ends_with('\n')).then_some(Self { text, rest, version, es })
    }

    /// Number of its bytes.
    pub fn length(&self) -> usize {
        self.text.len()
    }

    /// Returns the text that follows it.
    pub fn rest(&self) -> &'a str {
        self.rest
    }

    /// The declaration of a uniform, with the highest precision. `value`: what it is at first,
    /// where the language can say that.
    pub fn uniform(&self, kind: &str, name: &str, value: Option<&str>) -> String {
        match (self.es, self.version, value) {
            // The precision of the stage's floats may not be set yet, and a fragment shader may not
            // have this one.
            (true, 100, _) => format!(
                "#ifdef GL_FRAGMENT_PRECISION_HIGH\nuniform highp {kind} {name};\n#else\nuniform mediump {kind} {name};\n\
                 #endif\n"
            ),
            (true, ..) => format!("uniform highp {kind} {name};\n"),
            (false, 120.., Some(value)) => format!("uniform {kind} {name}={value};\n"),
            (false, ..) => format!("uniform {kind} {name};\n"),
        }
    }

    /// The text with `declarations`, followed by `rest`, which has the lines that followed before.
    pub fn declaring(&self, declarations: &str, rest: &str) -> String {
        let line = self.text.matches('\n').count() + 1;
        // Before GLSL 330 and ESSL 300, `#line n` numbers the *following* line n + 1.
        let old = self.version < if self.es { 300 } else { 330 };
        let line = if old { line.saturating_sub(1) } else { line };
        format!("{}{declarations}#line {line}\n{rest}", self.text)
    }
}

/// The offset after the last `#extension`, and after the conditions that it is in.
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
