//! Texts of a program's shaders with what Cupola changes in them.

use crate::backend::gl::driver::api;
use crate::intercept::gl::shader::camera_matrices::text::{self, Named};
use crate::intercept::gl::shader::frag_coord;
use crate::intercept::gl::shader::patch::{self, Stage};
use crate::intercept::gl::state::shader::camera_matrices::MatrixStage;
use crate::intercept::gl::state::shader::position_names::PositionNames;
use std::collections::HashMap;
use std::sync::Arc;

/// What is changed in the texts of a program.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Changes {
    /// The position of the last stage before rasterisation.
    pub position: bool,
    /// Window coordinates of the fragment shaders.
    pub frag_coord: bool,
    /// Matrices of the camera.
    pub matrices: bool,
}

/// What linking made of a program's shaders.
#[derive(Default)]
pub struct Linked {
    /// What is changed.
    pub changes: Changes,
    /// The fragment shaders count rows from above.
    pub upper_left: bool,
    /// The matrices between which and ours a stage chooses.
    pub matrices: Vec<(MatrixStage, Vec<Named>)>,
}

/// The texts of a program's shaders.
pub struct Texts<'a> {
    /// What the shaders were compiled from.
    pub sources: &'a HashMap<u32, Arc<str>>,
    /// Names and kinds.
    pub shaders: &'a [(u32, u32)],
    /// What flows into the position; `None` = unknown.
    pub position_names: Option<&'a PositionNames>,
    /// The context is OpenGL ES.
    pub es: bool,
    /// There are views to whose lens vertices are projected.
    pub curved: bool,
}

impl Texts<'_> {
    /// What a shader was compiled from.
    pub fn source(&self, shader: u32) -> &str {
        self.sources.get(&shader).map_or("", |source| source)
    }

    fn of_kind(&self, kind: u32) -> impl Iterator<Item = (u32, &Arc<str>)> {
        let shaders = self.shaders.iter().filter(move |shader| shader.1 == kind);
        shaders.filter_map(|(shader, _)| Some((*shader, self.sources.get(shader)?)))
    }

    /// The shader object with the `main` of the last stage before rasterisation.
    pub fn position(&self) -> Option<(u32, Stage)> {
        let stages = [
            (api::GL_GEOMETRY_SHADER, Stage::Geometry),
            (api::GL_TESS_EVALUATION_SHADER, Stage::TessellationEvaluation),
            (api::GL_VERTEX_SHADER, Stage::Vertex),
        ];
        let (kind, stage) = stages.into_iter().find(|(kind, _)| self.shaders.iter().any(|s| s.1 == *kind))?;
        let main = self.of_kind(kind).find(|(_, source)| patch::patch(source, stage, self.es, self.curved).is_some());
        main.map(|(shader, _)| (shader, stage))
    }

    /// The fragment shaders that ask where on the screen they are.
    pub fn asking(&self) -> impl Iterator<Item = u32> {
        let fragments = self.of_kind(api::GL_FRAGMENT_SHADER);
        fragments.filter(|(_, source)| patch::mentions(source, "gl_FragCoord")).map(|(shader, _)| shader)
    }

    /// The texts of the shaders that are changed, and what comes of it; `None` where one of them cannot be.
    pub fn changed(&self, changes: Changes) -> Option<(HashMap<u32, String>, Linked)> {
        let mut linked = Linked { changes, ..Default::default() };
        let mut texts: HashMap<u32, String> = HashMap::new();
        if changes.matrices {
            for (kind, stage) in
                [(api::GL_VERTEX_SHADER, MatrixStage::Vertex), (api::GL_FRAGMENT_SHADER, MatrixStage::Fragment)]
            {
                self.choose_matrices(kind, stage, &mut texts, &mut linked);
            }
            if linked.matrices.is_empty() {
                return None;
            }
        }
        if changes.frag_coord {
            for shader in self.asking() {
                let text = texts.get(&shader).map_or(self.source(shader), String::as_str);
                let (text, convention) = frag_coord::patch(text, self.es)?;
                linked.upper_left = convention.upper_left;
                texts.insert(shader, text);
            }
        }
        if changes.position {
            let (shader, stage) = self.position()?;
            let text = texts.get(&shader).map_or(self.source(shader), String::as_str);
            texts.insert(shader, patch::patch(text, stage, self.es, self.curved)?);
        }
        Some((texts, linked))
    }

    /// Puts choices into the text of a stage. A stage of several texts stays as it is.
    fn choose_matrices(&self, kind: u32, stage: MatrixStage, texts: &mut HashMap<u32, String>, linked: &mut Linked) {
        let mut shaders = self.of_kind(kind);
        let (Some((shader, source)), None) = (shaders.next(), shaders.next()) else { return };
        let wanted = |name: &str| match stage {
            MatrixStage::Fragment => true,
            // Another stage takes what it hands on.
            MatrixStage::Vertex => self.position_names.is_some_and(|names| !names.contain(name)),
        };
        if let Some((text, matrices)) = text::with_choices(source, self.es, stage.names(), wanted) {
            texts.insert(shader, text);
            linked.matrices.push((stage, matrices));
        }
    }
}
