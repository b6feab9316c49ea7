//! Buffers by name with the commands of `GL_EXT_direct_state_access`. Unlike the commands of OpenGL
//! 4.5, these create the object of a name that was only generated, and some have one more
//! parameter.

use crate::intercept::gl::context::hooks::hooks;
use crate::intercept::gl::vertex_input::buffers::{mapped, named_changed, stored, written_by_device};
use std::ffi::c_void;

hooks! {
    "glNamedBufferDataEXT" named_buffer_data_ext(buffer: u32, size: isize, data: *const c_void, usage: u32) = |ctx, gl| {
        gl.named_buffer_data_ext(buffer, size, data, usage);
        named_changed(&ctx.share, &mut ctx.vertex_input, buffer, true);
    };
    "glNamedBufferStorageEXT" named_buffer_storage_ext(buffer: u32, size: isize, data: *const c_void, flags: u32) = |ctx, gl| {
        gl.named_buffer_storage_ext(buffer, size, data, flags);
        stored(&ctx.share, &ctx.driver, &mut ctx.vertex_input, buffer, flags);
    };
    "glNamedBufferSubDataEXT" named_buffer_sub_data_ext(buffer: u32, offset: isize, size: isize, data: *const c_void) = |ctx, gl| {
        gl.named_buffer_sub_data_ext(buffer, offset, size, data);
        named_changed(&ctx.share, &mut ctx.vertex_input, buffer, false);
    };
    "glClearNamedBufferDataEXT" clear_named_buffer_data_ext(buffer: u32, internal: u32, format: u32, kind: u32, data: *const c_void) = |ctx, gl| {
        gl.clear_named_buffer_data_ext(buffer, internal, format, kind, data);
        named_changed(&ctx.share, &mut ctx.vertex_input, buffer, false);
    };
    "glClearNamedBufferSubDataEXT" clear_named_buffer_sub_data_ext(buffer: u32, internal: u32, offset: isize, size: isize, format: u32, kind: u32, data: *const c_void) = |ctx, gl| {
        gl.clear_named_buffer_sub_data_ext(buffer, internal, offset, size, format, kind, data);
        named_changed(&ctx.share, &mut ctx.vertex_input, buffer, false);
    };
    "glNamedCopyBufferSubDataEXT" named_copy_buffer_sub_data_ext(read: u32, write: u32, from: isize, to: isize, size: isize) = |ctx, gl| {
        gl.named_copy_buffer_sub_data_ext(read, write, from, to, size);
        named_changed(&ctx.share, &mut ctx.vertex_input, write, false);
    };
    "glMapNamedBufferEXT" map_named_buffer_ext(buffer: u32, access: u32) -> *mut c_void = |ctx, gl| {
        named_changed(&ctx.share, &mut ctx.vertex_input, buffer, false);
        gl.map_named_buffer_ext(buffer, access)
    };
    "glMapNamedBufferRangeEXT" map_named_buffer_range_ext(buffer: u32, offset: isize, length: isize, access: u32) -> *mut c_void = |ctx, gl| {
        mapped(&ctx.share, &mut ctx.vertex_input, buffer, access);
        gl.map_named_buffer_range_ext(buffer, offset, length, access)
    };
    "glUnmapNamedBufferEXT" unmap_named_buffer_ext(buffer: u32) -> u8 = |ctx, gl| {
        named_changed(&ctx.share, &mut ctx.vertex_input, buffer, false);
        gl.unmap_named_buffer_ext(buffer)
    };
    "glTextureBufferEXT" texture_buffer_ext(texture: u32, target: u32, format: u32, buffer: u32) = |ctx, gl| {
        gl.texture_buffer_ext(texture, target, format, buffer);
        written_by_device(&ctx.share, buffer);
    };
    "glTextureBufferRangeEXT" texture_buffer_range_ext(texture: u32, target: u32, format: u32, buffer: u32, offset: isize, size: isize) = |ctx, gl| {
        gl.texture_buffer_range_ext(texture, target, format, buffer, offset, size);
        written_by_device(&ctx.share, buffer);
    };
}
