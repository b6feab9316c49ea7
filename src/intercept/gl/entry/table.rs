//! The table of all hooks, by the names of their entry points.

use crate::intercept::gl::app_state::{getters, indexed_viewports, known_state, summed_state, window_state};
use crate::intercept::gl::compat::{begin_end, display_lists, list_calls, matrices, raster_position, vertex_commands};
use crate::intercept::gl::draw::{anisotropy, arrays, commands, compute, transform_feedback};
use crate::intercept::gl::frame::front_buffer;
use crate::intercept::gl::framebuffer::commands::{
    accumulation, bindings, blits, clears, direct_state, direct_state_ext, draw_buffers, textures, window_answers,
};
use crate::intercept::gl::framebuffer::reading::read_back;
use crate::intercept::gl::per_view::culling::max_width;
use crate::intercept::gl::per_view::wide_primitives;
use crate::intercept::gl::projected_vertices;
use crate::intercept::gl::queries::{conditional_render, results};
use crate::intercept::gl::shader::{
    assembly, introspection, linking, program_pipelines, program_use, summed_uniforms, uniform_commands,
};
use crate::intercept::gl::vertex_input::{buffers, named_buffers_ext, vertex_array_commands};
use crate::intercept::process::nodes;
use std::collections::HashMap;
use std::sync::OnceLock;

/// Returns Cupola's function for an entry point, by any of its names.
pub fn find(name: &str) -> Option<*const ()> {
    table().get(core_name(name)).map(|address| *address as *const ())
}

/// All hooks by the core names of their entry points.
fn table() -> &'static HashMap<&'static str, usize> {
    static TABLE: OnceLock<HashMap<&'static str, usize>> = OnceLock::new();
    TABLE.get_or_init(|| {
        let files = [
            accumulation::HOOKS,
            buffers::HOOKS,
            conditional_render::HOOKS,
            results::HOOKS,
            arrays::HOOKS,
            max_width::HOOKS,
            commands::HOOKS,
            compute::HOOKS,
            transform_feedback::HOOKS,
            anisotropy::HOOKS,
            known_state::HOOKS,
            front_buffer::HOOKS,
            begin_end::HOOKS,
            vertex_commands::HOOKS,
            indexed_viewports::HOOKS,
            display_lists::HOOKS,
            list_calls::HOOKS,
            matrices::HOOKS,
            direct_state::HOOKS,
            direct_state_ext::HOOKS,
            named_buffers_ext::HOOKS,
            wide_primitives::HOOKS,
            program_pipelines::HOOKS,
            linking::HOOKS,
            program_use::HOOKS,
            introspection::HOOKS,
            assembly::HOOKS,
            uniform_commands::HOOKS,
            uniform_commands::refused_locations::HOOKS,
            linking::relinking::HOOKS,
            vertex_array_commands::HOOKS,
            projected_vertices::HOOKS,
            getters::HOOKS,
            raster_position::HOOKS,
            textures::HOOKS,
            window_state::HOOKS,
            bindings::HOOKS,
            clears::HOOKS,
            draw_buffers::HOOKS,
            blits::HOOKS,
            read_back::HOOKS,
            window_answers::HOOKS,
        ];
        let more = nodes::are_there().then_some([summed_uniforms::HOOKS, summed_state::HOOKS]);
        files
            .iter()
            .chain(more.iter().flatten())
            .flat_map(|hooks| hooks.iter())
            .map(|hook| (hook.name, hook.address as usize))
            .collect()
    })
}

/// Returns the core name of an entry point.
fn core_name(name: &str) -> &str {
    match name {
        // Aliases in the registry, but these also make the object of a name that was only reserved.
        "glNamedBufferStorageEXT" | "glNamedBufferSubDataEXT" => name,
        // Not aliases in the registry (their error rules differ), but Cupola treats them alike.
        "glBindFramebufferEXT" | "glBindFramebufferOES" => "glBindFramebuffer",
        "glBlitFramebufferANGLE" => "glBlitFramebuffer",
        "glActiveShaderProgramEXT"
        | "glBeginQueryEXT"
        | "glBindProgramPipelineEXT"
        | "glCreateShaderProgramvEXT"
        | "glDeleteProgramPipelinesEXT"
        | "glDeleteQueriesEXT"
        | "glDeleteTexturesEXT"
        | "glEndQueryEXT"
        | "glGetIntegeri_vEXT"
        | "glGetQueryObjectuivEXT"
        | "glGetQueryivEXT"
        | "glIsQueryEXT"
        | "glUseProgramStagesEXT"
        | "glCopyTexSubImage3DOES"
        | "glDeleteFramebuffersOES"
        | "glFramebufferRenderbufferOES"
        | "glFramebufferTexture2DOES"
        | "glGenerateMipmapOES"
        | "glGetFramebufferAttachmentParameterivOES"
        | "glIsFramebufferOES" => &name[..name.len() - 3],
        "glDrawBuffersNV" | "glReadBufferNV" => &name[..name.len() - 2],
        _ => crate::backend::gl::driver::api::core_name(name),
    }
}

#[cfg(test)]
mod tests {
    use super::table;

    /// Each call of a hooked entry point costs time. An entry point is therefore hooked only if
    /// Cupola must see its calls. `cupola-lab structure` reads this number.
    #[test]
    fn the_number_of_hooked_entry_points_is_known() {
        assert_eq!(table().len(), 851);
    }
}
