//! The table of all hooks, and the next layer's functions that they call.

use ash::vk;
use std::collections::HashMap;
use std::ffi::CStr;
use std::sync::OnceLock;

/// The next layer's functions that are called by hooks for the views.
pub struct NextLayer {
    /// Command buffers.
    pub recording: crate::intercept::vk::commands::recording::Next,
    /// Bound pipelines, descriptors, viewports.
    pub state: crate::intercept::vk::commands::bound_state::Next,
    /// Draws.
    pub draws: crate::intercept::vk::commands::draws::Next,
    /// Render passes and framebuffers.
    pub framebuffers: crate::intercept::vk::commands::framebuffers::Next,
    /// Their begin and end.
    pub passes: crate::intercept::vk::commands::passes::Next,
    /// Pipelines.
    pub pipelines: crate::intercept::vk::pipelines::program_pipelines::Next,
    /// Pipeline layouts and shaders.
    pub layouts: crate::intercept::vk::pipelines::layouts::Next,
    /// Descriptors.
    pub descriptors: crate::intercept::vk::descriptors::sets::Next,
    /// Descriptors that are pushed.
    pub pushed: crate::intercept::vk::descriptors::push_descriptors::Next,
    /// Buffers and memory.
    pub memory: crate::intercept::vk::submit::host_memory::Next,
    /// Images.
    pub images: crate::intercept::vk::offscreen::images::Next,
    /// Barriers and clears.
    pub transfers: crate::intercept::vk::commands::barriers_and_clears::Next,
    /// Copies between images.
    pub copies: crate::intercept::vk::commands::copies::Next,
    /// Conditions.
    pub conditional: crate::intercept::vk::commands::conditional_render::Next,
    /// Queries.
    pub queries: crate::intercept::vk::queries::scaling::Next,
    /// Commands that are not followed.
    pub unfollowed: crate::intercept::vk::commands::unsupported::Next,
    /// Submissions.
    pub submit: crate::intercept::vk::submit::queue::Next,
}

impl NextLayer {
    /// # Safety
    /// `find` must give a device's functions.
    pub unsafe fn load(find: &dyn Fn(&CStr) -> vk::PFN_vkVoidFunction) -> Self {
        // SAFETY: as promised.
        unsafe {
            Self {
                recording: crate::intercept::vk::commands::recording::Next::load(find),
                state: crate::intercept::vk::commands::bound_state::Next::load(find),
                draws: crate::intercept::vk::commands::draws::Next::load(find),
                framebuffers: crate::intercept::vk::commands::framebuffers::Next::load(find),
                passes: crate::intercept::vk::commands::passes::Next::load(find),
                pipelines: crate::intercept::vk::pipelines::program_pipelines::Next::load(find),
                layouts: crate::intercept::vk::pipelines::layouts::Next::load(find),
                descriptors: crate::intercept::vk::descriptors::sets::Next::load(find),
                pushed: crate::intercept::vk::descriptors::push_descriptors::Next::load(find),
                memory: crate::intercept::vk::submit::host_memory::Next::load(find),
                images: crate::intercept::vk::offscreen::images::Next::load(find),
                transfers: crate::intercept::vk::commands::barriers_and_clears::Next::load(find),
                copies: crate::intercept::vk::commands::copies::Next::load(find),
                conditional: crate::intercept::vk::commands::conditional_render::Next::load(find),
                queries: crate::intercept::vk::queries::scaling::Next::load(find),
                unfollowed: crate::intercept::vk::commands::unsupported::Next::load(find),
                submit: crate::intercept::vk::submit::queue::Next::load(find),
            }
        }
    }
}

/// Hooks that are needed without views, too.
pub const ALWAYS: [&CStr; 1] = [c"vkCreateImageView"];

/// Our function for a device's function of this name that is needed for views.
pub fn find(name: &CStr) -> Option<*const ()> {
    static TABLE: OnceLock<HashMap<&'static CStr, usize>> = OnceLock::new();
    let table = TABLE.get_or_init(|| {
        let files = [
            crate::intercept::vk::commands::recording::HOOKS,
            crate::intercept::vk::commands::bound_state::HOOKS,
            crate::intercept::vk::commands::draws::HOOKS,
            crate::intercept::vk::commands::framebuffers::HOOKS,
            crate::intercept::vk::commands::passes::HOOKS,
            crate::intercept::vk::pipelines::program_pipelines::HOOKS,
            crate::intercept::vk::pipelines::layouts::HOOKS,
            crate::intercept::vk::descriptors::sets::HOOKS,
            crate::intercept::vk::descriptors::push_descriptors::HOOKS,
            crate::intercept::vk::submit::host_memory::HOOKS,
            crate::intercept::vk::offscreen::images::HOOKS,
            crate::intercept::vk::commands::barriers_and_clears::HOOKS,
            crate::intercept::vk::commands::copies::HOOKS,
            crate::intercept::vk::commands::conditional_render::HOOKS,
            crate::intercept::vk::queries::scaling::HOOKS,
            crate::intercept::vk::commands::unsupported::HOOKS,
            crate::intercept::vk::submit::queue::HOOKS,
        ];
        let hooks = files.into_iter().flatten();
        hooks.flat_map(|hook| hook.names.iter().map(|name| (*name, hook.address as usize))).collect()
    });
    table.get(name).map(|address| *address as *const ())
}
