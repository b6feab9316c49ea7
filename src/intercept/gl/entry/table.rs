//! The table of all hooks: how a name finds its function.

use std::collections::HashMap;
use std::sync::OnceLock;

/// Our function for an entry point, by its core name.
pub fn find(name: &str) -> Option<*const ()> {
    static TABLE: OnceLock<HashMap<&'static str, usize>> = OnceLock::new();
    let table = TABLE.get_or_init(|| {
        let files = [
            crate::intercept::gl::framebuffer::accumulation::HOOKS,
            crate::intercept::gl::vertex_input::buffers::HOOKS,
            crate::intercept::gl::draw::conditional_render::HOOKS,
            crate::intercept::gl::queries::results::HOOKS,
            crate::intercept::gl::draw::culling::arrays::HOOKS,
            crate::intercept::gl::draw::culling::max_width::HOOKS,
            crate::intercept::gl::draw::issue::HOOKS,
            crate::intercept::gl::draw::transform_feedback::HOOKS,
            crate::intercept::gl::draw::anisotropy::HOOKS,
            crate::intercept::gl::context::known_state::HOOKS,
            crate::intercept::gl::frame::front_buffer::HOOKS,
            crate::intercept::gl::compat::begin_end::HOOKS,
            crate::intercept::gl::compat::vertex_commands::HOOKS,
            crate::intercept::gl::context::indexed_viewports::HOOKS,
            crate::intercept::gl::compat::display_lists::HOOKS,
            crate::intercept::gl::compat::matrices::HOOKS,
            crate::intercept::gl::framebuffer::direct_state::HOOKS,
            crate::intercept::gl::draw::wide_primitives::HOOKS,
            crate::intercept::gl::shader::program_pipelines::HOOKS,
            crate::intercept::gl::shader::programs::HOOKS,
            crate::intercept::gl::shader::introspection::HOOKS,
            crate::intercept::gl::shader::uniforms::HOOKS,
            crate::intercept::gl::vertex_input::vertex_array_commands::HOOKS,
            crate::intercept::gl::projected_vertices::fixed_function::substitute::HOOKS,
            crate::intercept::gl::context::getters::HOOKS,
            crate::intercept::gl::compat::raster_position::HOOKS,
            crate::intercept::gl::shader::samplers::HOOKS,
            crate::intercept::gl::context::window_state::HOOKS,
            crate::intercept::gl::framebuffer::bindings::HOOKS,
            crate::intercept::gl::framebuffer::read_back::HOOKS,
        ];
        files.iter().flat_map(|hooks| hooks.iter()).map(|hook| (hook.name, hook.address as usize)).collect()
    });
    let core = match name {
        // Not aliases in the registry (their error rules differ), but the same call for us.
        "glBindFramebufferEXT" | "glBindFramebufferOES" => "glBindFramebuffer",
        "glBlitFramebufferANGLE" => "glBlitFramebuffer",
        "glActiveShaderProgramEXT"
        | "glBeginQueryEXT"
        | "glBindProgramPipelineEXT"
        | "glClearNamedBufferDataEXT"
        | "glClearNamedBufferSubDataEXT"
        | "glMapNamedBufferEXT"
        | "glMapNamedBufferRangeEXT"
        | "glTextureBufferEXT"
        | "glTextureBufferRangeEXT"
        | "glCheckNamedFramebufferStatusEXT"
        | "glCreateShaderProgramvEXT"
        | "glDeleteProgramPipelinesEXT"
        | "glDeleteQueriesEXT"
        | "glDeleteTexturesEXT"
        | "glEndQueryEXT"
        | "glGetIntegeri_vEXT"
        | "glGetNamedFramebufferAttachmentParameterivEXT"
        | "glGetQueryivEXT"
        | "glIsQueryEXT"
        | "glNamedBufferDataEXT"
        | "glUnmapNamedBufferEXT"
        | "glUseProgramStagesEXT"
        | "glCopyTexSubImage3DOES"
        | "glDeleteFramebuffersOES"
        | "glFramebufferRenderbufferOES"
        | "glFramebufferTexture2DOES"
        | "glGenerateMipmapOES"
        | "glGetFramebufferAttachmentParameterivOES"
        | "glIsFramebufferOES" => &name[..name.len() - 3],
        "glNamedCopyBufferSubDataEXT" => "glCopyNamedBufferSubData",
        "glDrawBuffersNV" | "glReadBufferNV" => &name[..name.len() - 2],
        _ => crate::backend::gl::api::core_name(name),
    };
    table.get(core).map(|address| *address as *const ())
}
