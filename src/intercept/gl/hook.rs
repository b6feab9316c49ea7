//! How a hook is written, and how a name finds its hook.

use std::collections::HashMap;
use std::sync::OnceLock;

/// A name of the API and the function of ours that answers it.
pub struct Hook {
    /// The entry point's core name.
    pub name: &'static str,
    /// Our function, with the entry point's own signature.
    pub address: *const (),
}

// SAFETY: an address of a function never changes and may be read from any thread.
unsafe impl Sync for Hook {}

/// Defines hooks and the table `HOOKS` of them.
///
/// Each body gets the current context (`$ctx`) and the driver's table (`$gl`). Without a context
/// of ours the call goes straight to the driver; so it does after a panic, which switches the
/// context off: interception fails open. Between Begin and End of a draw of ours it goes to the driver,
/// too, which says that it is not allowed there; hooks of what is allowed say so by `between;`.
macro_rules! hooks {
    (between; $($hooks:tt)*) => {
        $crate::intercept::gl::hook::hooks! { @between true; $($hooks)* }
    };
    (@between $between:literal; $( $name:literal $method:ident ( $($p:ident : $t:ty),* ) $(-> $r:ty)? = |$ctx:ident, $gl:ident| $body:expr; )*) => {
        $(
            // Some bodies need no unsafe call; the block below serves them all.
            #[allow(unused_unsafe)]
            unsafe extern "system" fn $method($($p: $t),*) $(-> $r)? {
                let Some($ctx) = $crate::intercept::gl::registry::current() else {
                    // SAFETY: the program's own call, passed on with its own arguments.
                    return unsafe { $crate::intercept::gl::registry::driver().$method($($p),*) };
                };
                let $gl = $ctx.gl;
                if $ctx.switched_off || (!$between && $ctx.immediate.under_way()) {
                    // SAFETY: as above.
                    return unsafe { $gl.$method($($p),*) };
                }
                // SAFETY: what the bodies call are the driver's functions, with the program's
                // arguments or with our own objects, on the thread whose context this is.
                match $crate::fence::guard(|| unsafe { $body }) {
                    Some(answer) => answer,
                    None => {
                        $crate::intercept::gl::registry::after_panic($name);
                        // SAFETY: as above.
                        unsafe { $gl.$method($($p),*) }
                    }
                }
            }
        )*
        /// The hooks of this file.
        pub static HOOKS: &[$crate::intercept::gl::hook::Hook] = &[
            $( $crate::intercept::gl::hook::Hook { name: $name, address: $method as *const () }, )*
        ];
    };
    ($($hooks:tt)*) => {
        $crate::intercept::gl::hook::hooks! { @between false; $($hooks)* }
    };
}
pub(crate) use hooks;

/// Our function for an entry point, by its core name.
pub fn find(name: &str) -> Option<*const ()> {
    static TABLE: OnceLock<HashMap<&'static str, usize>> = OnceLock::new();
    let table = TABLE.get_or_init(|| {
        let files = [
            super::accumulation::HOOKS,
            super::buffers::HOOKS,
            super::conditional::HOOKS,
            super::counting::told::HOOKS,
            super::culling::arrays::HOOKS,
            super::culling::widths::HOOKS,
            super::draw::HOOKS,
            super::feedback::HOOKS,
            super::filtering::HOOKS,
            super::known_state::HOOKS,
            super::front::HOOKS,
            super::immediate::HOOKS,
            super::immediate::commands::HOOKS,
            super::indexed::HOOKS,
            super::lists::HOOKS,
            super::matrices::HOOKS,
            super::named::HOOKS,
            super::outlines::HOOKS,
            super::pipelines::HOOKS,
            super::programs::HOOKS,
            super::reflection::HOOKS,
            super::uniforms::HOOKS,
            super::vertex_arrays::commands::HOOKS,
            super::vertices::fixed::HOOKS,
            super::queries::HOOKS,
            super::raster::HOOKS,
            super::samplers::HOOKS,
            super::state::HOOKS,
            super::targets::HOOKS,
            super::reads::HOOKS,
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
