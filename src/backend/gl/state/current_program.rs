//! The program in use. It is restored together with its subroutines, which `glUseProgram` resets.

use crate::backend::gl::driver::api::{self, Gl};
use crate::backend::gl::driver::values::integer;

/// Stages that can have subroutines, each with its interface of subroutine uniforms.
const STAGES: [(u32, u32); 6] = [
    (api::GL_VERTEX_SHADER, api::GL_VERTEX_SUBROUTINE_UNIFORM),
    (api::GL_TESS_CONTROL_SHADER, api::GL_TESS_CONTROL_SUBROUTINE_UNIFORM),
    (api::GL_TESS_EVALUATION_SHADER, api::GL_TESS_EVALUATION_SUBROUTINE_UNIFORM),
    (api::GL_GEOMETRY_SHADER, api::GL_GEOMETRY_SUBROUTINE_UNIFORM),
    (api::GL_FRAGMENT_SHADER, api::GL_FRAGMENT_SUBROUTINE_UNIFORM),
    (api::GL_COMPUTE_SHADER, api::GL_COMPUTE_SUBROUTINE_UNIFORM),
];

/// Returns the number of locations of subroutine uniforms of a stage of a linked program.
fn locations(gl: &Gl, program: u32, version: i32, (stage, interface): (u32, u32)) -> i32 {
    let mut count = 0;
    // SAFETY: a linked program; one integer is written.
    unsafe {
        if version >= 43 {
            // For a stage that the program lacks, Mesa raises an error in the call below, but not
            // here.
            gl.get_program_interfaceiv(program, interface, api::GL_ACTIVE_RESOURCES, &mut count);
            if count <= 0 {
                return 0;
            }
        }
        gl.get_program_stageiv(program, stage, api::GL_ACTIVE_SUBROUTINE_UNIFORM_LOCATIONS, &mut count);
    }
    count
}

/// A program that was in use, and the subroutines that were chosen for it. Allocates only if there
/// are subroutines.
pub struct CurrentProgram {
    name: u32,
    /// Values of the subroutine uniforms, for each stage that has them.
    subroutines: Vec<(u32, Vec<u32>)>,
}

impl CurrentProgram {
    /// Returns the program that is in use. `version`: 10·major + minor of OpenGL, or 0 if no
    /// subroutines were chosen, as always in OpenGL ES.
    pub fn save(gl: &Gl, version: i32) -> Self {
        let mut saved = Self { name: integer(gl, api::GL_CURRENT_PROGRAM) as u32, subroutines: Vec::new() };
        if saved.name == 0 || version < 40 {
            return saved;
        }
        let known = if version >= 43 { &STAGES[..] } else { &STAGES[..5] };
        for &(stage, interface) in known {
            let count = locations(gl, saved.name, version, (stage, interface));
            if count <= 0 {
                continue;
            }
            let value = |location: i32| {
                let mut value = 0;
                // SAFETY: writes one number; the location is below their number.
                unsafe { gl.get_uniform_subroutineuiv(stage, location, &mut value) };
                value
            };
            saved.subroutines.push((stage, (0..count).map(value).collect()));
        }
        saved
    }

    /// Chooses the same subroutines for `other`, which is in use and contains the program's stages
    /// beside its own.
    pub fn copy_subroutines(&self, gl: &Gl, other: u32) {
        for (stage, values) in &self.subroutines {
            let mut count = 0;
            // SAFETY: a linked program; one integer is written, and the array has as many values as
            // the stage.
            unsafe {
                gl.get_program_stageiv(other, *stage, api::GL_ACTIVE_SUBROUTINE_UNIFORM_LOCATIONS, &mut count);
                if count as usize == values.len() {
                    gl.uniform_subroutinesuiv(*stage, count, values.as_ptr());
                }
            }
        }
    }

    /// Uses the program again, with its subroutines.
    pub fn restore(&self, gl: &Gl) {
        // SAFETY: a program that was in use; as many values as its stage has.
        unsafe {
            gl.use_program(self.name);
            for (stage, values) in &self.subroutines {
                gl.uniform_subroutinesuiv(*stage, values.len() as i32, values.as_ptr());
            }
        }
    }
}
