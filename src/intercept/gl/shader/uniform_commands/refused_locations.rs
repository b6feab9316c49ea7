//! Locations of Cupola's own uniforms. The program cannot set or ask for their values: OpenGL refuses
//! the location, as it does without Cupola, where no uniform has it.
//!
//! Nearly all of Cupola's uniforms are vectors of four numbers and matrices of 4×4. OpenGL itself
//! refuses commands for other types, so only those of these types, in [`uniform_commands`], look at
//! the location. The others have no hooks, which would cost each call of a right program 29 ns. A
//! wrong one can reach only the numbers of `camera_matrices` by them.
//!
//! [`uniform_commands`]: crate::intercept::gl::shader::uniform_commands

use crate::intercept::gl::context::gl_context::{Context, ShareGroup};
use crate::intercept::gl::context::hooks::hooks;
use crate::intercept::gl::shader::program_pipelines::with_current;
use crate::intercept::gl::shader::programs;

/// A location that no program has.
const NOWHERE: i32 = i32::MAX;

/// Returns the location for the driver, in the program that `glUniform` sets.
pub(super) fn in_use(ctx: &Context, location: i32) -> i32 {
    // A list that is compiled sets uniforms of a program that is not known yet.
    let refused = !ctx.compiling()
        && with_current(&ctx.share, &ctx.shaders, |program| program.is_some_and(|program| program.refuses(location)));
    if refused { NOWHERE } else { location }
}

/// Returns the program and the location for the driver.
pub(super) fn of(share: &ShareGroup, program: u32, location: i32) -> (u32, i32) {
    match programs::record(share, program) {
        Some(record) if record.refuses(location) => (record.asked(), NOWHERE),
        _ => (program, location),
    }
}

/// Hooks of questions about the values of uniforms.
macro_rules! questions {
    ($( $question:literal $get:ident $bounded:literal $get_bounded:ident $answer:ty; )*) => {
        hooks! {
            $( $question $get(program: u32, location: i32, values: *mut $answer) = |ctx, gl| {
                let (program, location) = of(&ctx.share, program, location);
                gl.$get(program, location, values);
            }; )*
            $( $bounded $get_bounded(program: u32, location: i32, room: i32, values: *mut $answer) = |ctx, gl| {
                let (program, location) = of(&ctx.share, program, location);
                gl.$get_bounded(program, location, room, values);
            }; )*
        }
    };
}

questions! {
    "glGetUniformfv" get_uniformfv "glGetnUniformfv" getn_uniformfv f32;
    "glGetUniformiv" get_uniformiv "glGetnUniformiv" getn_uniformiv i32;
    "glGetUniformuiv" get_uniformuiv "glGetnUniformuiv" getn_uniformuiv u32;
    "glGetUniformdv" get_uniformdv "glGetnUniformdv" getn_uniformdv f64;
}
