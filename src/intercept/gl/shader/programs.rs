//! The program's shaders: the lens that they draw with, and the values that they get for a view.

use crate::backend::gl::driver::api::{self, Gl};
use crate::correct::projected::matrices::{LensConstants, ReprojectionMatrix};
use crate::intercept::gl::context::gl_context::Context;
use crate::intercept::gl::context::gl_context::ShareGroup;
use crate::intercept::gl::shader::attribute_matrices::{self, FoundLens};
use crate::intercept::gl::shader::{assembly, camera_matrices, uniforms};
use crate::intercept::gl::state::drawable::Drawable;
use crate::intercept::gl::state::driver::Driver;
use crate::intercept::gl::state::shader::Shaders;
use crate::intercept::gl::state::shader::programs::{Program, ProgramLens};
use crate::intercept::gl::state::vertex_input::VertexInput;
use crate::intercept::gl::vertex_input::buffers;
use crate::intercept::process::log;
use crate::intercept::scene::lens::Told;
use crate::lock::Lock;
use crate::runtime::session::{MatrixClass, Session};
use glam::Mat4;
use std::sync::Arc;
use std::sync::atomic::Ordering;

impl Program {
    /// Returns the lens in the present matrices.
    pub fn lens(&self, ctx: &mut Context) -> ProgramLens {
        if self.location < 0 {
            return ProgramLens::Flat;
        }
        if self.fixed_matrices {
            ctx.compat.projection.refresh(ctx.driver.gl, ctx.drawable.session());
            if let MatrixClass::Perspective(intrinsics) = *ctx.compat.projection.class() {
                return ProgramLens::Perspective(Told::sure(intrinsics), "fixed-function matrix in a shader");
            }
        }
        let (lens, known) = self.uniforms_lens(&ctx.share, &ctx.driver, &ctx.vertex_input);
        if lens != ProgramLens::Flat {
            return lens;
        }
        let mut matrices = self.attribute_matrices.locked();
        if matrices.is_empty() {
            return if known { lens } else { given(&ctx.driver, &ctx.drawable) };
        }
        match attribute_matrices::lens(ctx, &mut matrices) {
            FoundLens::Lens(told) => ProgramLens::Perspective(told, "matrix of a vertex attribute"),
            _ if known => ProgramLens::Flat,
            FoundLens::Nothing => given(&ctx.driver, &ctx.drawable),
            FoundLens::Unreadable => {
                let lens = given(&ctx.driver, &ctx.drawable);
                if ctx.session().and_then(Session::given_lens).is_none() {
                    log::once(
                        "a shader gets its matrix from a vertex attribute that cannot be read: its drawing appears flat. \
                         If it is a scene, set camera.lens in the rig",
                    );
                }
                lens
            }
        }
    }

    /// Returns the lens in the present uniforms, and whether the uniforms are sufficient to decide
    /// this.
    fn uniforms_lens(&self, share: &ShareGroup, driver: &Driver, vertex_input: &VertexInput) -> (ProgramLens, bool) {
        let mut uniforms = self.uniforms.locked();
        if !uniforms.any() && !self.fixed_matrices {
            return (ProgramLens::Flat, false);
        }
        let generation = vertex_input.generation();
        let lens = uniforms.lens(driver.gl, generation, &buffers::of(share));
        (lens, !uniforms.unclear)
    }
}

/// Returns the rig's lens, for draws with a depth test by a program without a matrix.
pub fn given(driver: &Driver, drawable: &Drawable) -> ProgramLens {
    match drawable.session().and_then(Session::given_lens) {
        Some(lens) if driver.known_state.is_on(driver.gl, api::GL_DEPTH_TEST) => {
            ProgramLens::Perspective(Told::sure(lens), "the rig's lens")
        }
        _ => ProgramLens::Flat,
    }
}

/// Sends `reprojection` to the program in use, unless it has it already.
pub fn upload(driver: &Driver, shaders: &Shaders, reprojection: &ReprojectionMatrix) {
    if let Some(program) = shaders.assembly() {
        assembly::upload(driver, program, reprojection);
    } else if let Some(program) = shaders.program() {
        send(driver, shaders, program, reprojection);
    }
}

/// Sends `reprojection` to a program, which is the one in use or part of a pipeline.
pub fn send(driver: &Driver, shaders: &Shaders, program: &Program, reprojection: &ReprojectionMatrix) {
    if program.location < 0 {
        return;
    }
    let mut uploaded = program.uploaded.locked();
    if uploaded.reprojection.as_ref() != Some(reprojection) {
        set_vectors(driver, shaders, program, program.location, &reprojection.to_array());
        uploaded.reprojection = Some(*reprojection);
    }
}

/// Sends the reprojection matrix of a view to the program in use, and the lens if the matrix leads to the axes of
/// one.
pub fn upload_view(
    driver: &Driver,
    shaders: &Shaders,
    reprojection: &ReprojectionMatrix,
    lens: Option<&LensConstants>,
) {
    upload(driver, shaders, reprojection);
    let (Some(program), Some(lens)) = (shaders.program(), lens) else { return };
    let mut uploaded = program.uploaded.locked();
    if program.lens_location >= 0 && uploaded.lens.as_ref() != Some(lens) {
        set_vectors(driver, shaders, program, program.lens_location, &lens.to_array());
        uploaded.lens = Some(*lens);
    }
}

/// Sets vectors in a uniform of Cupola.
pub(super) fn set_vectors(driver: &Driver, shaders: &Shaders, program: &Program, location: i32, vectors: &[f32]) {
    let count = vectors.len() as i32 / 4;
    // SAFETY: the location is that of the array, of its second half or of a vector. If no program
    // is in use, there are pipelines, and with them the command that takes a program's name.
    unsafe {
        if shaders.used() == program.name {
            driver.gl.uniform4fv(location, count, vectors.as_ptr());
        } else {
            driver.gl.program_uniform4fv(program.name, location, count, vectors.as_ptr());
        }
    }
}

/// Sets a 4×4 matrix in a uniform of Cupola.
pub(super) fn set_matrix(driver: &Driver, shaders: &Shaders, program: &Program, location: i32, matrix: &Mat4) {
    // SAFETY: the location is that of the matrix; the rest as for `set_vectors`.
    unsafe {
        if shaders.used() == program.name {
            driver.gl.uniform_matrix4fv(location, 1, 0, matrix.as_ref().as_ptr());
        } else {
            driver.gl.program_uniform_matrix4fv(program.name, location, 1, 0, matrix.as_ref().as_ptr());
        }
    }
}

/// Sets a number in a uniform of Cupola.
pub(super) fn set_number(driver: &Driver, shaders: &Shaders, program: &Program, location: i32, number: f32) {
    // SAFETY: the location is that of the number; the rest as for `set_vectors`.
    unsafe {
        if shaders.used() == program.name {
            driver.gl.uniform1fv(location, 1, &number);
        } else {
            driver.gl.program_uniform1fv(program.name, location, 1, &number);
        }
    }
}

/// Returns the record of a program.
pub fn record(share: &ShareGroup, name: u32) -> Option<Arc<Program>> {
    share.programs.locked().programs.get(&name).cloned()
}

/// Returns the name of the program that answers the application's questions about `name`.
pub fn asked(share: &ShareGroup, name: u32) -> u32 {
    share.programs.locked().programs.get(&name).map_or(name, |program| program.asked())
}

/// Reads the matrices of `name` again after one of its blocks was bound elsewhere.
pub fn read_again(share: &ShareGroup, driver: &Driver, name: u32) {
    let Some(old) = record(share, name) else { return };
    let (gl, profile) = (driver.gl, &driver.profile);
    let (uniforms, _) = uniforms::read(gl, profile, name, old.position_names.as_ref());
    *old.uniforms.locked() = uniforms;
    if old.has_camera_matrices {
        camera_matrices::read_again(gl, profile, name, &mut old.camera_matrices.locked());
    }
}

/// Forgets all about a program.
pub(super) fn forget_program(share: &ShareGroup, driver: &Driver, name: u32) {
    let record = share.programs.locked().programs.remove(&name);
    forget(driver.gl, record);
}

/// Deletes what Cupola has made for a program that is no longer recorded.
pub(super) fn forget(gl: &Gl, record: Option<Arc<Program>>) {
    if let Some(record) = record {
        record.variants.locked().destroy(gl);
        // SAFETY: a program of Cupola; 0 is ignored.
        unsafe { gl.delete_program(record.failed.load(Ordering::Relaxed)) };
    }
}
