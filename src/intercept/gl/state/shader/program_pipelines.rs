//! Program pipelines.

use crate::backend::gl::driver::api;
use std::collections::HashMap;

/// The pipelines of a context.
#[derive(Default)]
pub(super) struct Pipelines {
    pipelines: HashMap<u32, Stages>,
    pub(super) bound: u32,
    /// Program of `glUseProgram`, which takes precedence over any pipeline; 0 = none.
    pub(super) used: u32,
}

/// The programs of a pipeline that Cupola follows, by their names; 0 = none.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Stages {
    vertex: u32,
    evaluation: u32,
    geometry: u32,
    fragment: u32,
    compute: u32,
    /// Program of `glActiveShaderProgram`.
    pub(super) active: u32,
}

impl Stages {
    /// Returns the program of the fragment stage.
    pub fn fragment(&self) -> u32 {
        self.fragment
    }

    /// Returns the program of the compute stage.
    pub fn compute(&self) -> u32 {
        self.compute
    }

    /// Returns the programs before rasterisation, the last one first.
    pub fn last_first(&self) -> [u32; 3] {
        [self.geometry, self.evaluation, self.vertex]
    }

    /// Returns the program of `glActiveShaderProgram`.
    pub fn active(&self) -> u32 {
        self.active
    }

    /// `glUseProgramStages` with a program that has the stages `present`.
    pub(super) fn set(&mut self, stages: u32, program: u32, present: u32) {
        if stages & api::GL_FRAGMENT_SHADER_BIT != 0 {
            self.fragment = program;
        }
        if stages & api::GL_COMPUTE_SHADER_BIT != 0 {
            self.compute = program;
        }
        let slots = [
            (api::GL_VERTEX_SHADER_BIT, &mut self.vertex),
            (api::GL_TESS_EVALUATION_SHADER_BIT, &mut self.evaluation),
            (api::GL_GEOMETRY_SHADER_BIT, &mut self.geometry),
        ];
        for (bit, slot) in slots {
            if stages & bit != 0 {
                *slot = if present & bit != 0 { program } else { 0 };
            }
        }
    }
}

impl Pipelines {
    pub(super) fn of(&mut self, pipeline: u32) -> &mut Stages {
        self.pipelines.entry(pipeline).or_default()
    }

    pub(super) fn delete(&mut self, pipeline: u32) {
        self.pipelines.remove(&pipeline);
        if self.bound == pipeline {
            self.bound = 0;
        }
    }

    pub(super) fn stages(&self) -> Stages {
        self.pipelines.get(&self.bound).copied().unwrap_or_default()
    }
}

#[cfg(test)]
mod tests {
    use super::{Stages, api};

    #[test]
    fn a_stage_that_a_program_lacks_becomes_empty() {
        let mut stages = Stages::default();
        stages.set(api::GL_GEOMETRY_SHADER_BIT, 7, api::GL_GEOMETRY_SHADER_BIT);
        stages.set(api::GL_VERTEX_SHADER_BIT | api::GL_FRAGMENT_SHADER_BIT, 3, api::GL_VERTEX_SHADER_BIT);
        assert_eq!(stages.last_first(), [7, 0, 3]);
        assert_eq!(stages.fragment(), 3);
        stages.set(api::GL_ALL_SHADER_BITS, 5, api::GL_VERTEX_SHADER_BIT);
        assert_eq!(stages.last_first(), [0, 0, 5]);
    }
}
