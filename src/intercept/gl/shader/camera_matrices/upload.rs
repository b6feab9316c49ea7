//! Upload of a view's matrices for the draws to that view.

use crate::correct::single;
use crate::intercept::gl::context::gl_context::Context;
use crate::intercept::gl::context::gl_context::ShareGroup;
use crate::intercept::gl::shader::programs;
use crate::intercept::gl::state::draw::draw_class::DrawClass;
use crate::intercept::gl::state::drawable::Drawable;
use crate::intercept::gl::state::driver::Driver;
use crate::intercept::gl::state::frame::Frame;
use crate::intercept::gl::state::shader::Shaders;
use crate::intercept::gl::state::shader::camera_matrices::{CameraMatrices, MatrixStage, Substitute};
use crate::intercept::gl::state::shader::programs::Program;
use crate::intercept::gl::state::vertex_input::VertexInput;
use crate::intercept::gl::vertex_input::buffers;
use crate::lock::Lock;
use crate::runtime::session::{Intrinsics, eye_axes};
use glam::{DMat4, Mat4};
use std::sync::Arc;

/// Returns the programs of the present vertex and fragment shaders, if they have such matrices.
fn drawing(share: &ShareGroup, shaders: &Shaders) -> [Option<Arc<Program>>; 2] {
    let holds = |program: &Arc<Program>| program.has_camera_matrices;
    let drawn = shaders.program();
    let fragment = if shaders.used() == 0 && shaders.bound_pipeline() != 0 {
        programs::record(share, shaders.stages().fragment())
    } else {
        None
    };
    let other = |program: &Arc<Program>| drawn.is_none_or(|drawn| drawn.name != program.name);
    [drawn.filter(|program| holds(program)).cloned(), fragment.filter(|program| holds(program) && other(program))]
}

/// True if a present shader has a matrix that transforms from the clip coordinates of a camera.
pub fn holds_inverse(ctx: &Context) -> bool {
    let programs = drawing(&ctx.share, &ctx.shaders);
    programs.iter().flatten().any(|program| {
        recognise(&ctx.share, &ctx.driver, &ctx.frame, &ctx.vertex_input, &mut program.camera_matrices.locked())
    })
}

fn recognise(
    share: &ShareGroup,
    driver: &Driver,
    frame: &Frame,
    vertex_input: &VertexInput,
    matrices: &mut CameraMatrices,
) -> bool {
    let generation = vertex_input.generation();
    matrices.recognise(driver.gl, generation, &buffers::of(share), frame.cameras())
}

/// Gives the present shaders the matrices of a view. In draws of a scene positions are
/// re-projected, so the vertex shader keeps its own matrices.
pub fn load_view(ctx: &mut Context, view: usize, class: DrawClass) {
    let scene = !matches!(class, DrawClass::Flat | DrawClass::Screen);
    for program in drawing(&ctx.share, &ctx.shaders).into_iter().flatten() {
        let mut matrices = program.camera_matrices.locked();
        recognise(&ctx.share, &ctx.driver, &ctx.frame, &ctx.vertex_input, &mut matrices);
        let CameraMatrices { uniforms, substitutes, eye, .. } = &mut *matrices;
        let eye = eye.filter(|_| class == DrawClass::Screen).and_then(|(lens, transposed)| {
            let turn = eye_axes::turn(&reprojection(&ctx.drawable, &mut ctx.frame, &lens, view)?, &lens)?;
            Some((turn, transposed))
        });
        for substitute in substitutes {
            if scene && substitute.stage == MatrixStage::Vertex {
                substitute.set(ctx, &program, None);
                continue;
            }
            let (turned, known) = &mut substitute.of_views;
            if *turned != eye.is_some() {
                *turned = eye.is_some();
                known.clear();
            }
            // A matrix that is the same for many draws is computed once.
            let known = known.get(view).copied().flatten();
            let ours = known.or_else(|| {
                let value = uniforms.value(substitute.matrix)?;
                let matrix = match (substitute.function, substitute.view_matrix, eye) {
                    (Some((function, lens)), _, Some((turn, _))) if function.is_of_projection(value, &lens) => function
                        .for_turned_view(value, &reprojection(&ctx.drawable, &mut ctx.frame, &lens, view)?, turn),
                    (Some((function, lens)), ..) => {
                        function.for_view(value, &reprojection(&ctx.drawable, &mut ctx.frame, &lens, view)?)
                    }
                    (None, Some(matrix), Some((turn, transposed))) => Some(matrix.turned(value, transposed, turn)),
                    _ => None,
                };
                matrix.map(|matrix| single::matrix4(&matrix))
            });
            let known = &mut substitute.of_views.1;
            known.resize(known.len().max(view + 1), None);
            known[view] = ours;
            substitute.set(ctx, &program, ours);
        }
    }
}

/// Returns the reprojection matrix of a view for a lens.
fn reprojection(drawable: &Drawable, frame: &mut Frame, lens: &Intrinsics, view: usize) -> Option<DMat4> {
    let session = drawable.session()?;
    let camera = frame.camera(lens, session);
    Some(frame.cameras().get(camera)?.reprojections.get(view)?.matrix())
}

/// Gives the present shaders the program's own matrices.
pub fn load_own(ctx: &Context) {
    for program in drawing(&ctx.share, &ctx.shaders).into_iter().flatten() {
        for substitute in &mut program.camera_matrices.locked().substitutes {
            substitute.set(ctx, &program, None);
        }
    }
}

impl Substitute {
    /// Uses `matrix` instead of the program's matrix; `None`: uses the program's matrix again.
    fn set(&mut self, ctx: &Context, program: &Program, matrix: Option<Mat4>) {
        if let Some(matrix) = matrix.filter(|_| self.uploaded != matrix) {
            programs::set_matrix(&ctx.driver, &ctx.shaders, program, self.location, &matrix);
            self.uploaded = Some(matrix);
        }
        if self.chosen != matrix.is_some() {
            self.chosen = matrix.is_some();
            programs::set_number(
                &ctx.driver,
                &ctx.shaders,
                program,
                self.chosen_location,
                f32::from(u8::from(self.chosen)),
            );
        }
    }
}
