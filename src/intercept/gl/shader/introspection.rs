//! Introspection: answers to the program's questions about its shaders, without Cupola's own
//! uniforms.

use crate::backend::gl::driver::api;
use crate::intercept::gl::context::gl_context::ShareGroup;
use crate::intercept::gl::context::hooks::hooks;
use crate::intercept::gl::shader::programs::{self, asked};
use crate::intercept::gl::state::driver::Driver;
use crate::lock::Lock;
use std::ffi::c_char;

/// Indices of Cupola's own uniforms among the active ones, in ascending order.
struct Own {
    indices: Vec<u32>,
}

impl Own {
    fn any(&self) -> bool {
        !self.indices.is_empty()
    }

    fn count(&self) -> i32 {
        self.indices.len() as i32
    }

    /// Returns the driver's index for the program's index, which does not count own uniforms.
    fn shifted(&self, index: u32) -> u32 {
        self.indices.iter().fold(index, |index, ours| if index >= *ours { index.saturating_add(1) } else { index })
    }

    /// Returns the program's index for the driver's index.
    fn unshifted(&self, index: u32) -> u32 {
        let before = self.indices.iter().filter(|ours| **ours < index).count() as u32;
        if index == api::GL_INVALID_INDEX { index } else { index - before }
    }
}

fn own_uniforms(share: &ShareGroup, program: u32) -> Own {
    // A program that answers for another one, as the last link failed, has no uniforms.
    let record = programs::record(share, program).filter(|record| record.asked() == program);
    Own { indices: record.map_or(Vec::new(), |program| program.own_uniforms.clone()) }
}

/// Returns the program of which the driver is asked for a property: the properties that do not
/// depend on the last link are those of the program itself.
fn of_property(share: &ShareGroup, program: u32, property: u32) -> u32 {
    match property {
        api::GL_ATTACHED_SHADERS
        | api::GL_DELETE_STATUS
        | api::GL_PROGRAM_SEPARABLE
        | api::GL_PROGRAM_BINARY_RETRIEVABLE_HINT
        | api::GL_TRANSFORM_FEEDBACK_BUFFER_MODE
        | api::GL_TRANSFORM_FEEDBACK_VARYINGS
        | api::GL_TRANSFORM_FEEDBACK_VARYING_MAX_LENGTH => program,
        _ => asked(share, program),
    }
}

/// True if the program has deleted a program that is still in use.
fn is_deleted(share: &ShareGroup, program: u32) -> bool {
    share.programs.locked().uses.is_deleted(program)
}

/// Returns the driver's index for the program's index.
fn shifted(share: &ShareGroup, program: u32, index: u32) -> u32 {
    own_uniforms(share, program).shifted(index)
}

/// Returns the length of the longest name of the program's active uniforms, with its NUL; 0 = there
/// are no uniforms.
fn longest_name(share: &ShareGroup, driver: &Driver, program: u32) -> i32 {
    let gl = driver.gl;
    let (mut count, mut longest) = (0, 0);
    let mut name = [0; 1024];
    // SAFETY: writes one number.
    unsafe { gl.get_programiv(program, api::GL_ACTIVE_UNIFORMS, &mut count) };
    let ours = own_uniforms(share, program);
    for index in (0..count as u32).filter(|index| !ours.indices.contains(index)) {
        let (mut length, mut size, mut kind) = (0, 0, 0);
        // SAFETY: writes one number each, and no more characters than the buffer can hold.
        unsafe { gl.get_active_uniform(program, index, 1024, &mut length, &mut size, &mut kind, name.as_mut_ptr()) };
        longest = longest.max(length + 1);
    }
    longest
}

/// Returns the driver's index of a resource.
fn resource(share: &ShareGroup, program: u32, interface: u32, index: u32) -> u32 {
    if interface == api::GL_UNIFORM { shifted(share, program, index) } else { index }
}

/// Renumbers `count` indices from the driver, so that they do not count own uniforms.
///
/// # Safety
/// `indices` must be null or point at `count` numbers.
unsafe fn renumber(ours: &Own, count: i32, indices: *mut i32) {
    let Ok(count) = usize::try_from(count) else { return };
    if ours.any() && !indices.is_null() {
        // SAFETY: as promised above.
        for index in unsafe { std::slice::from_raw_parts_mut(indices, count) } {
            *index = ours.unshifted(*index as u32) as i32;
        }
    }
}

hooks! {
    "glGetProgramiv" get_programiv(program: u32, name: u32, value: *mut i32) = |ctx, gl| {
        gl.get_programiv(of_property(&ctx.share, program, name), name, value);
        if name == api::GL_DELETE_STATUS && is_deleted(&ctx.share, program) && !value.is_null() {
            *value = 1;
        }
        let ours = own_uniforms(&ctx.share, program);
        if !value.is_null() && ours.any() {
            match name {
                api::GL_ACTIVE_UNIFORMS => *value -= ours.count(),
                api::GL_ACTIVE_UNIFORM_MAX_LENGTH => *value = longest_name(&ctx.share, &ctx.driver, program),
                // A stored binary would contain the own uniforms, and would not work without
                // Cupola.
                api::GL_PROGRAM_BINARY_LENGTH => *value = 0,
                _ => {}
            }
        }
    };
    "glGetObjectParameterivARB" get_object_parameteriv_arb(object: u32, name: u32, value: *mut i32) = |ctx, gl| {
        gl.get_object_parameteriv_arb(of_property(&ctx.share, object, name), name, value);
        if name == api::GL_OBJECT_DELETE_STATUS_ARB && is_deleted(&ctx.share, object) && !value.is_null() {
            *value = 1;
        }
        let ours = own_uniforms(&ctx.share, object);
        if !value.is_null() && ours.any() {
            match name {
                api::GL_OBJECT_ACTIVE_UNIFORMS_ARB => *value -= ours.count(),
                api::GL_OBJECT_ACTIVE_UNIFORM_MAX_LENGTH_ARB => *value = longest_name(&ctx.share, &ctx.driver, object),
                _ => {}
            }
        }
    };
    "glGetActiveUniform" get_active_uniform(program: u32, index: u32, room: i32, length: *mut i32, size: *mut i32, kind: *mut u32, name: *mut c_char) = |ctx, gl| {
        let program = asked(&ctx.share, program);
        gl.get_active_uniform(program, shifted(&ctx.share, program, index), room, length, size, kind, name);
    };
    "glGetActiveUniformName" get_active_uniform_name(program: u32, index: u32, room: i32, length: *mut i32, name: *mut c_char) = |ctx, gl| {
        let program = asked(&ctx.share, program);
        gl.get_active_uniform_name(program, shifted(&ctx.share, program, index), room, length, name);
    };
    "glGetActiveUniformsiv" get_active_uniformsiv(program: u32, count: i32, indices: *const u32, what: u32, values: *mut i32) = |ctx, gl| {
        let program = asked(&ctx.share, program);
        if !own_uniforms(&ctx.share, program).any() || indices.is_null() {
            gl.get_active_uniformsiv(program, count, indices, what, values);
        } else {
            let given = std::slice::from_raw_parts(indices, usize::try_from(count).unwrap_or(0));
            let moved: Vec<u32> = given.iter().map(|i| shifted(&ctx.share, program, *i)).collect();
            gl.get_active_uniformsiv(program, count, moved.as_ptr(), what, values);
        }
    };
    "glGetUniformIndices" get_uniform_indices(program: u32, count: i32, names: *const *const c_char, indices: *mut u32) = |ctx, gl| {
        let program = asked(&ctx.share, program);
        gl.get_uniform_indices(program, count, names, indices);
        renumber(&own_uniforms(&ctx.share, program), count, indices.cast());
    };
    "glGetActiveUniformBlockiv" get_active_uniform_blockiv(program: u32, block: u32, what: u32, values: *mut i32) = |ctx, gl| {
        let program = asked(&ctx.share, program);
        gl.get_active_uniform_blockiv(program, block, what, values);
        if what == api::GL_UNIFORM_BLOCK_ACTIVE_UNIFORM_INDICES {
            let mut count = 0;
            gl.get_active_uniform_blockiv(program, block, api::GL_UNIFORM_BLOCK_ACTIVE_UNIFORMS, &mut count);
            renumber(&own_uniforms(&ctx.share, program), count, values);
        }
    };
    "glGetProgramInterfaceiv" get_program_interfaceiv(program: u32, interface: u32, name: u32, values: *mut i32) = |ctx, gl| {
        let program = asked(&ctx.share, program);
        gl.get_program_interfaceiv(program, interface, name, values);
        let ours = own_uniforms(&ctx.share, program);
        if interface == api::GL_UNIFORM && !values.is_null() && ours.any() {
            match name {
                api::GL_ACTIVE_RESOURCES => *values -= ours.count(),
                api::GL_MAX_NAME_LENGTH => *values = longest_name(&ctx.share, &ctx.driver, program),
                _ => {}
            }
        }
    };
    "glGetProgramResourceIndex" get_program_resource_index(program: u32, interface: u32, name: *const c_char) -> u32 = |ctx, gl| {
        let program = asked(&ctx.share, program);
        let index = gl.get_program_resource_index(program, interface, name);
        if interface == api::GL_UNIFORM { own_uniforms(&ctx.share, program).unshifted(index) } else { index }
    };
    "glGetProgramResourceName" get_program_resource_name(program: u32, interface: u32, index: u32, room: i32, length: *mut i32, name: *mut c_char) = |ctx, gl| {
        let program = asked(&ctx.share, program);
        gl.get_program_resource_name(program, interface, resource(&ctx.share, program, interface, index), room, length, name);
    };
    "glGetProgramResourceiv" get_program_resourceiv(program: u32, interface: u32, index: u32, count: i32, what: *const u32, room: i32, length: *mut i32, values: *mut i32) = |ctx, gl| {
        let program = asked(&ctx.share, program);
        gl.get_program_resourceiv(program, interface, resource(&ctx.share, program, interface, index), count, what, room, length, values);
        // Renumbers a block's list of uniforms only if it is the only question, as is usual.
        // Otherwise other values in the array would be changed.
        if count == 1 && !what.is_null() && *what == api::GL_ACTIVE_VARIABLES && interface == api::GL_UNIFORM_BLOCK {
            let mut one = 0;
            let of_block = [api::GL_NUM_ACTIVE_VARIABLES];
            gl.get_program_resourceiv(program, interface, index, 1, of_block.as_ptr(), 1, std::ptr::null_mut(), &mut one);
            renumber(&own_uniforms(&ctx.share, program), one.min(room), values);
        }
    };
    "glGetProgramBinary" get_program_binary(program: u32, room: i32, length: *mut i32, format: *mut u32, binary: *mut std::ffi::c_void) = |ctx, gl| {
        let program = asked(&ctx.share, program);
        if !own_uniforms(&ctx.share, program).any() {
            gl.get_program_binary(program, room, length, format, binary);
        } else {
            // Drivers without a format for binaries report this error, and Cupola reports that
            // there is no format.
            if !length.is_null() {
                *length = 0;
            }
            ctx.driver.note_error(api::GL_INVALID_OPERATION);
        }
    };
}

#[cfg(test)]
mod tests {
    use super::Own;
    use crate::backend::gl::driver::api;

    /// The program's indices skip the driver's indices of own uniforms.
    #[test]
    fn indices_do_not_count_ours() {
        let own = |ours: &[u32]| Own { indices: ours.to_vec() };
        for ours in [&[][..], &[0], &[3], &[0, 1], &[2, 3], &[1, 4]] {
            let driver: Vec<u32> = (0..8).filter(|index| !ours.contains(index)).collect();
            for (index, driver) in (0..).zip(driver) {
                assert_eq!((own(ours).shifted(index), own(ours).unshifted(driver)), (driver, index), "{ours:?}");
            }
            assert_eq!(own(ours).unshifted(api::GL_INVALID_INDEX), api::GL_INVALID_INDEX);
        }
    }
}
