//! Buffers of the program whose content is known to be unchanged: Cupola sees every command that
//! may write to a buffer.
//!
//! A buffer is known if Cupola saw all commands that gave it its content. It becomes unknown for
//! good if the device itself may write to it (transform feedback, storage blocks, read-backs,
//! images over buffers), if it stays mapped, or if its name was deleted and used again (a vertex
//! array may still hold the old buffer).

use crate::backend::gl::driver::api;
use crate::intercept::gl::context::gl_context::ShareGroup;
use crate::intercept::gl::context::hooks::hooks;
use crate::intercept::gl::state::driver::Driver;
use crate::intercept::gl::state::vertex_input::VertexInput;
use crate::intercept::gl::state::vertex_input::buffers::Buffers;
use crate::intercept::gl::vertex_input::buffer_bindings;
use crate::intercept::process::call_sum;
use crate::lock::Lock;
use std::ffi::c_void;
use std::sync::MutexGuard;

/// Returns the buffers of a group of contexts.
pub fn of(share: &ShareGroup) -> MutexGuard<'_, Buffers> {
    share.buffers.locked()
}

/// Notes that the device may write to a buffer.
pub fn written_by_device(share: &ShareGroup, name: u32) {
    if name != 0 {
        of(share).forget(name);
    }
}

/// Returns the buffer that is bound at `target`; 0 = none, or a target that is not followed.
/// Buffers at such targets are not known any more.
fn bound(share: &ShareGroup, driver: &Driver, vertex_input: &mut VertexInput, target: u32) -> u32 {
    buffer_bindings::buffer(share, driver, vertex_input, target).unwrap_or(0)
}

/// True if the device may write to buffers that are bound at `target`.
fn is_written_to(target: u32) -> bool {
    matches!(
        target,
        api::GL_TRANSFORM_FEEDBACK_BUFFER
            | api::GL_SHADER_STORAGE_BUFFER
            | api::GL_ATOMIC_COUNTER_BUFFER
            | api::GL_PIXEL_PACK_BUFFER
            | api::GL_QUERY_BUFFER
            | api::GL_TEXTURE_BUFFER
    )
}

/// Notes that the program wrote to the buffer at `target`. `new`: the buffer got new storage by
/// that.
fn changed(share: &ShareGroup, driver: &Driver, vertex_input: &mut VertexInput, target: u32, new: bool) {
    if target == api::GL_SHADER_STORAGE_BUFFER {
        vertex_input.blocks.storage_changed();
    }
    let name = bound(share, driver, vertex_input, target);
    named_changed(share, vertex_input, name, new);
}

/// Notes that the program wrote to a buffer.
pub(super) fn named_changed(share: &ShareGroup, vertex_input: &mut VertexInput, name: u32, new: bool) {
    if name != 0 {
        of(share).write(name, new);
        vertex_input.blocks.changed(name);
    }
}

/// Notes that a buffer is mapped for writing.
pub(super) fn mapped(share: &ShareGroup, vertex_input: &mut VertexInput, name: u32, access: u32) {
    named_changed(share, vertex_input, name, false);
    if access & api::GL_MAP_PERSISTENT_BIT != 0 {
        of(share).forget(name);
    }
}

/// Notes that a buffer got immutable storage.
pub(super) fn stored(share: &ShareGroup, driver: &Driver, vertex_input: &mut VertexInput, name: u32, flags: u32) {
    named_changed(share, vertex_input, name, true);
    // OpenGL ES reads a buffer by mapping it.
    let unreadable = driver.profile.es && flags & api::GL_MAP_READ_BIT == 0;
    if unreadable || flags & (api::GL_MAP_PERSISTENT_BIT | api::GL_SPARSE_STORAGE_BIT_ARB) != 0 {
        of(share).forget(name);
    }
}

/// Notes that a buffer was bound to an indexed binding point.
fn bound_to(share: &ShareGroup, vertex_input: &mut VertexInput, target: u32, name: u32) {
    if is_written_to(target) {
        written_by_device(share, name);
    }
    vertex_input.buffer_bindings.forget_one(target);
    if matches!(target, api::GL_UNIFORM_BUFFER | api::GL_SHADER_STORAGE_BUFFER) {
        vertex_input.blocks.bound(name, target == api::GL_SHADER_STORAGE_BUFFER);
    }
}

/// Returns the names that the program passed.
///
/// # Safety
/// `names` must be null or point at `count` names, as the program promises OpenGL.
unsafe fn all<'a>(count: i32, names: *const u32) -> &'a [u32] {
    match usize::try_from(count) {
        // SAFETY: as promised.
        Ok(count) if !names.is_null() => unsafe { std::slice::from_raw_parts(names, count) },
        _ => &[],
    }
}

/// Adds the data for a buffer to the checksum of the frame's calls.
///
/// # Safety
/// `data` must be null or point at `size` bytes, as the program promises OpenGL.
unsafe fn sum_up(size: isize, data: *const c_void) {
    // SAFETY: as promised.
    unsafe { call_sum::add_values(data.cast::<u8>(), usize::try_from(size).unwrap_or(0)) };
}

hooks! {
    "glBufferData" buffer_data(target: u32, size: isize, data: *const c_void, usage: u32) = |ctx, gl| {
        sum_up(size, data);
        gl.buffer_data(target, size, data, usage);
        changed(&ctx.share, &ctx.driver, &mut ctx.vertex_input, target, true);
    };
    "glBufferStorage" buffer_storage(target: u32, size: isize, data: *const c_void, flags: u32) = |ctx, gl| {
        sum_up(size, data);
        gl.buffer_storage(target, size, data, flags);
        let name = bound(&ctx.share, &ctx.driver, &mut ctx.vertex_input, target);
        stored(&ctx.share, &ctx.driver, &mut ctx.vertex_input, name, flags);
    };
    "glBufferSubData" buffer_sub_data(target: u32, offset: isize, size: isize, data: *const c_void) = |ctx, gl| {
        sum_up(size, data);
        gl.buffer_sub_data(target, offset, size, data);
        changed(&ctx.share, &ctx.driver, &mut ctx.vertex_input, target, false);
    };
    "glNamedBufferData" named_buffer_data(buffer: u32, size: isize, data: *const c_void, usage: u32) = |ctx, gl| {
        sum_up(size, data);
        gl.named_buffer_data(buffer, size, data, usage);
        named_changed(&ctx.share, &mut ctx.vertex_input, buffer, true);
    };
    "glNamedBufferStorage" named_buffer_storage(buffer: u32, size: isize, data: *const c_void, flags: u32) = |ctx, gl| {
        sum_up(size, data);
        gl.named_buffer_storage(buffer, size, data, flags);
        stored(&ctx.share, &ctx.driver, &mut ctx.vertex_input, buffer, flags);
    };
    "glNamedBufferSubData" named_buffer_sub_data(buffer: u32, offset: isize, size: isize, data: *const c_void) = |ctx, gl| {
        sum_up(size, data);
        gl.named_buffer_sub_data(buffer, offset, size, data);
        named_changed(&ctx.share, &mut ctx.vertex_input, buffer, false);
    };
    "glClearBufferData" clear_buffer_data(target: u32, internal: u32, format: u32, kind: u32, data: *const c_void) = |ctx, gl| {
        gl.clear_buffer_data(target, internal, format, kind, data);
        changed(&ctx.share, &ctx.driver, &mut ctx.vertex_input, target, false);
    };
    "glClearBufferSubData" clear_buffer_sub_data(target: u32, internal: u32, offset: isize, size: isize, format: u32, kind: u32, data: *const c_void) = |ctx, gl| {
        gl.clear_buffer_sub_data(target, internal, offset, size, format, kind, data);
        changed(&ctx.share, &ctx.driver, &mut ctx.vertex_input, target, false);
    };
    "glClearNamedBufferData" clear_named_buffer_data(buffer: u32, internal: u32, format: u32, kind: u32, data: *const c_void) = |ctx, gl| {
        gl.clear_named_buffer_data(buffer, internal, format, kind, data);
        named_changed(&ctx.share, &mut ctx.vertex_input, buffer, false);
    };
    "glClearNamedBufferSubData" clear_named_buffer_sub_data(buffer: u32, internal: u32, offset: isize, size: isize, format: u32, kind: u32, data: *const c_void) = |ctx, gl| {
        gl.clear_named_buffer_sub_data(buffer, internal, offset, size, format, kind, data);
        named_changed(&ctx.share, &mut ctx.vertex_input, buffer, false);
    };
    "glInvalidateBufferData" invalidate_buffer_data(buffer: u32) = |ctx, gl| {
        gl.invalidate_buffer_data(buffer);
        named_changed(&ctx.share, &mut ctx.vertex_input, buffer, false);
    };
    "glInvalidateBufferSubData" invalidate_buffer_sub_data(buffer: u32, offset: isize, length: isize) = |ctx, gl| {
        gl.invalidate_buffer_sub_data(buffer, offset, length);
        named_changed(&ctx.share, &mut ctx.vertex_input, buffer, false);
    };
    "glMapBuffer" map_buffer(target: u32, access: u32) -> *mut c_void = |ctx, gl| {
        changed(&ctx.share, &ctx.driver, &mut ctx.vertex_input, target, false);
        gl.map_buffer(target, access)
    };
    "glMapNamedBuffer" map_named_buffer(buffer: u32, access: u32) -> *mut c_void = |ctx, gl| {
        named_changed(&ctx.share, &mut ctx.vertex_input, buffer, false);
        gl.map_named_buffer(buffer, access)
    };
    "glMapBufferRange" map_buffer_range(target: u32, offset: isize, length: isize, access: u32) -> *mut c_void = |ctx, gl| {
        let name = bound(&ctx.share, &ctx.driver, &mut ctx.vertex_input, target);
        mapped(&ctx.share, &mut ctx.vertex_input, name, access);
        gl.map_buffer_range(target, offset, length, access)
    };
    "glMapNamedBufferRange" map_named_buffer_range(buffer: u32, offset: isize, length: isize, access: u32) -> *mut c_void = |ctx, gl| {
        mapped(&ctx.share, &mut ctx.vertex_input, buffer, access);
        gl.map_named_buffer_range(buffer, offset, length, access)
    };
    "glUnmapBuffer" unmap_buffer(target: u32) -> u8 = |ctx, gl| {
        changed(&ctx.share, &ctx.driver, &mut ctx.vertex_input, target, false);
        gl.unmap_buffer(target)
    };
    "glUnmapNamedBuffer" unmap_named_buffer(buffer: u32) -> u8 = |ctx, gl| {
        named_changed(&ctx.share, &mut ctx.vertex_input, buffer, false);
        gl.unmap_named_buffer(buffer)
    };
    "glCopyBufferSubData" copy_buffer_sub_data(read: u32, write: u32, from: isize, to: isize, size: isize) = |ctx, gl| {
        gl.copy_buffer_sub_data(read, write, from, to, size);
        changed(&ctx.share, &ctx.driver, &mut ctx.vertex_input, write, false);
    };
    "glCopyNamedBufferSubData" copy_named_buffer_sub_data(read: u32, write: u32, from: isize, to: isize, size: isize) = |ctx, gl| {
        gl.copy_named_buffer_sub_data(read, write, from, to, size);
        named_changed(&ctx.share, &mut ctx.vertex_input, write, false);
    };
    "glDeleteBuffers" delete_buffers(count: i32, names: *const u32) = |ctx, gl| {
        for name in all(count, names) {
            let mut buffers = of(&ctx.share);
            buffers.forget(*name);
            buffers.objects.remove(name);
        }
        gl.delete_buffers(count, names);
        // Deleted buffers are unbound from all targets.
        ctx.vertex_input.buffer_bindings.forget();
        ctx.vertex_input.vertex_arrays.forget();
    };
    "glBindBuffer" bind_buffer(target: u32, buffer: u32) = |ctx, gl| {
        gl.bind_buffer(target, buffer);
        buffer_bindings::note(ctx, target, buffer);
        if is_written_to(target) {
            written_by_device(&ctx.share, buffer);
        }
    };
    "glBindBufferBase" bind_buffer_base(target: u32, index: u32, buffer: u32) = |ctx, gl| {
        gl.bind_buffer_base(target, index, buffer);
        bound_to(&ctx.share, &mut ctx.vertex_input, target, buffer);
    };
    "glBindBufferRange" bind_buffer_range(target: u32, index: u32, buffer: u32, offset: isize, size: isize) = |ctx, gl| {
        gl.bind_buffer_range(target, index, buffer, offset, size);
        bound_to(&ctx.share, &mut ctx.vertex_input, target, buffer);
    };
    "glBindBufferOffsetEXT" bind_buffer_offset_ext(target: u32, index: u32, buffer: u32, offset: isize) = |ctx, gl| {
        gl.bind_buffer_offset_ext(target, index, buffer, offset);
        bound_to(&ctx.share, &mut ctx.vertex_input, target, buffer);
    };
    "glBindBuffersBase" bind_buffers_base(target: u32, first: u32, count: i32, buffers: *const u32) = |ctx, gl| {
        gl.bind_buffers_base(target, first, count, buffers);
        all(count, buffers).iter().for_each(|buffer| bound_to(&ctx.share, &mut ctx.vertex_input, target, *buffer));
        bound_to(&ctx.share, &mut ctx.vertex_input, target, 0);
    };
    "glBindBuffersRange" bind_buffers_range(target: u32, first: u32, count: i32, buffers: *const u32, offsets: *const isize, sizes: *const isize) = |ctx, gl| {
        gl.bind_buffers_range(target, first, count, buffers, offsets, sizes);
        all(count, buffers).iter().for_each(|buffer| bound_to(&ctx.share, &mut ctx.vertex_input, target, *buffer));
        bound_to(&ctx.share, &mut ctx.vertex_input, target, 0);
    };
    "glTransformFeedbackBufferBase" transform_feedback_buffer_base(feedback: u32, index: u32, buffer: u32) = |ctx, gl| {
        gl.transform_feedback_buffer_base(feedback, index, buffer);
        written_by_device(&ctx.share, buffer);
    };
    "glTransformFeedbackBufferRange" transform_feedback_buffer_range(feedback: u32, index: u32, buffer: u32, offset: isize, size: isize) = |ctx, gl| {
        gl.transform_feedback_buffer_range(feedback, index, buffer, offset, size);
        written_by_device(&ctx.share, buffer);
    };
    "glTexBuffer" tex_buffer(target: u32, format: u32, buffer: u32) = |ctx, gl| {
        gl.tex_buffer(target, format, buffer);
        written_by_device(&ctx.share, buffer);
    };
    "glTexBufferRange" tex_buffer_range(target: u32, format: u32, buffer: u32, offset: isize, size: isize) = |ctx, gl| {
        gl.tex_buffer_range(target, format, buffer, offset, size);
        written_by_device(&ctx.share, buffer);
    };
    "glTextureBuffer" texture_buffer(texture: u32, format: u32, buffer: u32) = |ctx, gl| {
        gl.texture_buffer(texture, format, buffer);
        written_by_device(&ctx.share, buffer);
    };
    "glTextureBufferRange" texture_buffer_range(texture: u32, format: u32, buffer: u32, offset: isize, size: isize) = |ctx, gl| {
        gl.texture_buffer_range(texture, format, buffer, offset, size);
        written_by_device(&ctx.share, buffer);
    };
    "glMakeBufferResidentNV" make_buffer_resident_nv(target: u32, access: u32) = |ctx, gl| {
        gl.make_buffer_resident_nv(target, access);
        let name = bound(&ctx.share, &ctx.driver, &mut ctx.vertex_input, target);
        written_by_device(&ctx.share, name);
    };
    "glMakeNamedBufferResidentNV" make_named_buffer_resident_nv(buffer: u32, access: u32) = |ctx, gl| {
        gl.make_named_buffer_resident_nv(buffer, access);
        written_by_device(&ctx.share, buffer);
    };
}
