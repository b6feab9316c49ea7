//! Buffers that a context has bound.

use crate::backend::gl::driver::api;

/// The targets that are followed, each with the name of its binding.
pub(in crate::intercept::gl) const TARGETS: [(u32, u32); 8] = [
    (api::GL_ARRAY_BUFFER, api::GL_ARRAY_BUFFER_BINDING),
    (api::GL_UNIFORM_BUFFER, api::GL_UNIFORM_BUFFER_BINDING),
    (api::GL_COPY_READ_BUFFER, api::GL_COPY_READ_BUFFER_BINDING),
    (api::GL_COPY_WRITE_BUFFER, api::GL_COPY_WRITE_BUFFER_BINDING),
    (api::GL_PIXEL_UNPACK_BUFFER, api::GL_PIXEL_UNPACK_BUFFER_BINDING),
    (api::GL_DRAW_INDIRECT_BUFFER, api::GL_DRAW_INDIRECT_BUFFER_BINDING),
    (api::GL_DISPATCH_INDIRECT_BUFFER, api::GL_DISPATCH_INDIRECT_BUFFER_BINDING),
    (api::GL_TEXTURE_BUFFER, api::GL_TEXTURE_BUFFER_BINDING),
];

/// The buffers that a context has bound; 0 = none.
pub struct Bound {
    pub(in crate::intercept::gl) names: [Option<u32>; TARGETS.len()],
}

impl Default for Bound {
    fn default() -> Self {
        // A new context has no buffers bound.
        Self { names: [Some(0); TARGETS.len()] }
    }
}

impl Bound {
    /// Notes that any of the bindings may have changed.
    pub fn forget(&mut self) {
        self.names = [None; TARGETS.len()];
    }

    /// Forgets the buffer that is bound at `target`.
    pub fn forget_one(&mut self, target: u32) {
        if let Some(place) = place(target) {
            self.names[place] = None;
        }
    }
}

pub(in crate::intercept::gl) fn place(target: u32) -> Option<usize> {
    TARGETS.iter().position(|(followed, _)| *followed == target)
}
