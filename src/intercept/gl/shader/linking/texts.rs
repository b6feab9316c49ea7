//! Texts of a program's shaders, with Cupola's changes.

use crate::backend::gl::driver::api;
use crate::intercept::gl::shader::camera_matrices::text::{self, Named};
use crate::intercept::gl::shader::source::dependence;
use crate::intercept::gl::shader::source::frag_coord;
use crate::intercept::gl::shader::source::patch::{self, Stage};
use crate::intercept::gl::shader::source::text::brackets::behind;
use crate::intercept::gl::shader::source::text::tokens;
use crate::intercept::gl::state::shader::camera_matrices::MatrixStage;
use crate::intercept::gl::state::shader::position_names::PositionNames;
use std::collections::HashMap;
use std::sync::Arc;

/// Parts of a program's texts that are changed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Changes {
    /// Position in the last stage before rasterisation.
    pub position: bool,
    /// Window coordinates of the fragment shaders.
    pub frag_coord: bool,
    /// Matrices of the camera.
    pub matrices: bool,
}

/// Result of linking a program's shaders.
#[derive(Default)]
pub struct Linked {
    /// Parts of the texts that are changed.
    pub changes: Changes,
    /// Texts of the changed shaders.
    pub texts: HashMap<u32, String>,
    /// True if the fragment shaders count rows from the top.
    pub upper_left: bool,
    /// Matrices for which a stage can choose between the program's and those of Cupola.
    pub matrices: Vec<(MatrixStage, Vec<Named>)>,
}

/// The texts of a program's shaders.
pub struct Texts<'a> {
    /// Texts from which the shaders were compiled.
    pub sources: &'a HashMap<u32, Arc<str>>,
    /// Name and kind of each shader object.
    pub shaders: &'a [(u32, u32)],
    /// Names that flow into the position; `None` = unknown.
    pub position_names: Option<&'a PositionNames>,
    /// True if the context is OpenGL ES.
    pub es: bool,
    /// True if there are views to whose lens vertices are projected.
    pub curved: bool,
}

impl Texts<'_> {
    /// Returns the text from which a shader was compiled.
    pub fn source(&self, shader: u32) -> &str {
        self.sources.get(&shader).map_or("", |source| source)
    }

    fn of_kind(&self, kind: u32) -> impl Iterator<Item = (u32, &Arc<str>)> {
        let shaders = self.shaders.iter().filter(move |shader| shader.1 == kind);
        shaders.filter_map(|(shader, _)| Some((*shader, self.sources.get(shader)?)))
    }

    /// Returns the shader object with the `main` of the last stage that computes positions. This is
    /// not a geometry shader that gets positions in clip space: it may compute values from them
    /// that belong to the pixels of the view.
    pub fn position(&self) -> Option<(u32, Stage)> {
        let stages = [
            (api::GL_GEOMETRY_SHADER, Stage::Geometry),
            (api::GL_TESS_EVALUATION_SHADER, Stage::TessellationEvaluation),
            (api::GL_VERTEX_SHADER, Stage::Vertex),
        ];
        let present = stages.into_iter().filter(|(kind, _)| self.shaders.iter().any(|s| s.1 == *kind));
        let mut mains = present.map(|(kind, stage)| {
            let patched = |source: &str| patch::patch(source, stage, self.es, self.curved).is_some();
            self.of_kind(kind).find(|(_, source)| patched(source)).map(|(shader, _)| (shader, stage))
        });
        let last = mains.next()??;
        let in_clip_space = last.1 == Stage::Geometry && !self.curved && self.works_in_clip_space(last.0);
        Some(mains.next().flatten().filter(|_| in_clip_space).unwrap_or(last))
    }

    /// True if a geometry shader passes positions on, or divides by their w to compute window
    /// coordinates. A geometry shader with its own matrix computes positions itself.
    fn works_in_clip_space(&self, shader: u32) -> bool {
        let source = self.source(shader);
        if passes_positions_on(source) {
            return true;
        }
        let stage = [(shader, api::GL_GEOMETRY_SHADER)];
        let Some(names) = dependence::position_names(self.sources, &stage) else { return false };
        (names.contain("gl_in") || names.contain("gl_PositionIn"))
            && divides_by_w(source)
            && !matrices(source).iter().any(|name| names.contain(name))
    }

    /// Returns the fragment shaders that use their window coordinates.
    pub fn asking(&self) -> impl Iterator<Item = u32> {
        let fragments = self.of_kind(api::GL_FRAGMENT_SHADER);
        fragments.filter(|(_, source)| patch::mentions(source, "gl_FragCoord")).map(|(shader, _)| shader)
    }

    /// Returns the changed texts and related data. `None`: one of the changes is not possible.
    pub fn changed(&self, changes: Changes) -> Option<Linked> {
        let mut linked = Linked { changes, ..Default::default() };
        if changes.matrices {
            let stages = [
                (api::GL_VERTEX_SHADER, MatrixStage::Vertex),
                (api::GL_FRAGMENT_SHADER, MatrixStage::Fragment),
                (api::GL_COMPUTE_SHADER, MatrixStage::Fragment),
            ];
            for (kind, stage) in stages {
                self.choose_matrices(kind, stage, &mut linked);
            }
            if linked.matrices.is_empty() {
                return None;
            }
        }
        if changes.frag_coord {
            for shader in self.asking() {
                let text = linked.texts.get(&shader).map_or(self.source(shader), String::as_str);
                let (text, convention) = frag_coord::patch(text, self.es)?;
                linked.upper_left = convention.upper_left;
                linked.texts.insert(shader, text);
            }
        }
        if changes.position {
            let (shader, stage) = self.position()?;
            let text = linked.texts.get(&shader).map_or(self.source(shader), String::as_str);
            let text = patch::patch(text, stage, self.es, self.curved)?;
            linked.texts.insert(shader, text);
        }
        Some(linked)
    }

    /// Adds the choices of matrices to the text of a stage. A stage with several texts is not
    /// changed.
    fn choose_matrices(&self, kind: u32, stage: MatrixStage, linked: &mut Linked) {
        let mut shaders = self.of_kind(kind);
        let (Some((shader, source)), None) = (shaders.next(), shaders.next()) else { return };
        let wanted = |name: &str| match stage {
            MatrixStage::Fragment => true,
            // The next stage uses the outputs, which must match the position.
            MatrixStage::Vertex => self.position_names.is_some_and(|names| !names.contain(name)),
        };
        if let Some((text, matrices)) = text::with_choices(source, self.es, stage.names(), wanted) {
            linked.texts.insert(shader, text);
            linked.matrices.push((stage, matrices));
        }
    }
}

/// Returns the words of a text without its directives.
fn words_of(bare: &str) -> Vec<&str> {
    let mut words = Vec::new();
    bare.lines().filter(|line| !line.trim_start().starts_with('#')).for_each(|line| tokens::words(line, &mut words));
    words
}

/// True if the text divides by a component w.
fn divides_by_w(source: &str) -> bool {
    let bare = tokens::bare(source);
    let words = words_of(&bare);
    (0..words.len()).filter(|at| words[*at] == "/" || words[*at] == "/=").any(|at| {
        let divisor = words[at + 1..].iter().take_while(|word| !matches!(**word, ";" | "," | "*" | "/" | "+" | "-"));
        divisor.collect::<Vec<_>>().windows(2).any(|pair| *pair[0] == "." && *pair[1] == "w")
    })
}

/// Returns the names that a text declares as 4×4 matrices, or as arrays of vectors that may be the
/// rows of one. Includes the matrices of the fixed-function pipeline and, if the text constructs a
/// matrix, the type itself.
fn matrices(source: &str) -> Vec<&str> {
    let mut found = vec!["gl_ModelViewProjectionMatrix", "gl_ProjectionMatrix"];
    let mut words = Vec::new();
    source.lines().for_each(|line| tokens::words(line, &mut words));
    for (at, word) in words.iter().enumerate() {
        let matrix = matches!(*word, "mat4" | "mat4x4" | "dmat4" | "dmat4x4");
        if !matrix && *word != "vec4" {
            continue;
        }
        let declared: Vec<&str> =
            words[at + 1..].iter().take_while(|word| !matches!(**word, ";" | "(" | ")" | "=")).copied().collect();
        let array = words[..at].iter().rev().take_while(|word| !matches!(**word, ";" | "}")).any(|w| *w == "uniform")
            && declared.contains(&"[");
        match declared.is_empty() {
            true if matrix => found.push(word),
            _ if matrix || array => found.extend(declared.into_iter().filter(|word| tokens::is_name(word))),
            _ => {}
        }
    }
    found
}

/// True if a geometry shader only uses positions of its input.
fn passes_positions_on(source: &str) -> bool {
    let bare = tokens::bare(source);
    let directives = bare.lines().filter(|line| line.trim_start().starts_with('#'));
    if directives.clone().any(|line| line.contains("gl_Position") || line.contains('\\')) {
        return false;
    }
    let words = words_of(&bare);
    let mut written = (0..words.len())
        .filter(|at| words[*at] == "gl_Position" && at.checked_sub(1).is_none_or(|before| words[before] != "."))
        .peekable();
    written.peek().is_some()
        && written.all(|at| match words.get(at + 1..at + 3) {
            Some(["=", "gl_in"]) => {
                behind(&words, at + 3).is_some_and(|end| words.get(end..end + 3) == Some(&[".", "gl_Position", ";"]))
            }
            Some(["=", "gl_PositionIn"]) => behind(&words, at + 3).is_some_and(|end| words.get(end) == Some(&";")),
            _ => false,
        })
}

#[cfg(test)]
mod tests {
    use super::{Texts, divides_by_w, passes_positions_on};
    use crate::backend::gl::driver::api;
    use std::collections::HashMap;
    use std::sync::Arc;

    fn works_in_clip_space(geometry: &str) -> bool {
        let shaders = [(1, api::GL_GEOMETRY_SHADER)];
        let sources = HashMap::from([(1, Arc::from(geometry))]);
        let texts = Texts { sources: &sources, shaders: &shaders, position_names: None, es: false, curved: false };
        texts.works_in_clip_space(1)
    }

    #[test]
    fn a_geometry_shader_with_a_matrix_of_its_own_is_the_last_stage() {
        let main = |text: &str| format!("#version 330\n{text} EmitVertex(); }}");
        let moved = "gl_Position = gl_in[0].gl_Position; gl_Position.xy += wide * gl_Position.w;";
        let divided = "vec2 p = gl_in[0].gl_Position.xy / gl_in[0].gl_Position.w;";
        let beside = "uniform mat4 other; out vec4 o; void main() { o = other * vec4(1.0);";
        assert!(works_in_clip_space(&main(&format!("void main() {{ {divided} {moved}"))));
        assert!(works_in_clip_space(&main(&format!("{beside} {divided} {moved}"))), "other is not for positions");
        assert!(!works_in_clip_space(&main(&format!("void main() {{ {moved}"))), "a billboard of the scene");
        for own in [
            "uniform mat4 P; void main() { gl_Position = P * gl_in[0].gl_Position;",
            "uniform Camera { mat4 all[3]; } c; void main() { gl_Position = c.all[1] * gl_in[0].gl_Position;",
            "uniform vec4 r[4]; void main() { gl_Position = vec4(dot(r[0], gl_in[0].gl_Position));",
            "uniform vec4 a; void main() { gl_Position = mat4(a, a, a, a) * gl_in[0].gl_Position;",
            "void main() { gl_Position = gl_ProjectionMatrix * gl_in[0].gl_Position;",
        ] {
            assert!(!works_in_clip_space(&main(&format!("{own} {divided}"))), "{own}");
        }
    }

    #[test]
    fn divisions_by_w() {
        for text in ["a = p.xy / p.w;", "a = p[i].xy/p[i].w;", "a.xyz /= (b.w);"] {
            assert!(divides_by_w(text), "{text}");
        }
        for text in ["a = p.xy / 2.0 * p.w;", "a = b.w;", "// a / b.w\n"] {
            assert!(!divides_by_w(text), "{text}");
        }
    }

    #[test]
    fn positions_are_passed_on_where_nothing_else_is_written() {
        let main = |text: &str| format!("#version 330\nvoid main() {{ {text} EmitVertex(); }}");
        for text in [
            "gl_Position = gl_in[0].gl_Position;",
            "for (int i = 0; i < 3; i++) { gl_Position = gl_in[i + f(i)].gl_Position; a = gl_in[i].gl_Position.xy; }",
            "gl_Position = gl_PositionIn[i];",
        ] {
            assert!(passes_positions_on(&main(text)), "{text}");
        }
        for text in [
            "gl_Position = gl_in[0].gl_Position + vec4(1.0);",
            "gl_Position = P * gl_in[0].gl_Position;",
            "gl_Position = gl_in[0].gl_Position; gl_Position.x += 1.0;",
            "gl_Position = gl_PositionIn[i] * 2.0;",
            "",
        ] {
            assert!(!passes_positions_on(&main(text)), "{text}");
        }
        assert!(!passes_positions_on(&format!(
            "#define A gl_Position\n{}",
            main("gl_Position = gl_in[0].gl_Position;")
        )));
    }
}
