//! Internal calls of Cupola in the context of the program.
//!
//! ```text
//! {
//!     let ctx: &mut Context = &mut OwnCalls::begin(ctx);   queries, messages and conditions are off
//!     ctx.driver.gl.…                                      work that the program does not notice
//! }                                                        all is back, also after a panic
//! ```

use crate::backend::gl::driver::api;
use crate::intercept::gl::context::gl_context::Context;
use std::ops::{Deref, DerefMut};

/// Scope of internal calls. Scopes that suspend queries do not nest.
pub struct OwnCalls<'a> {
    ctx: &'a mut Context,
    /// True if queries and conditional rendering are suspended.
    suspends: bool,
    /// True if debug output was on before the scope began.
    messages: bool,
}

impl<'a> OwnCalls<'a> {
    /// Begins a scope for work that draws. No query of the program counts the work, no conditional
    /// rendering leaves it out, and no debug message about it reaches the program.
    pub fn begin(ctx: &'a mut Context) -> Self {
        let gl = ctx.driver.gl;
        ctx.queries.end_parts(gl);
        let mut own = Self::without_messages(ctx);
        own.suspends = true;
        own.queries.suspend_condition(gl);
        own
    }

    /// Begins a scope for work that draws nothing, such as linking a program. Only debug messages
    /// are switched off.
    pub fn without_messages(ctx: &'a mut Context) -> Self {
        let gl = ctx.driver.gl;
        let knows = ctx.driver.profile.version >= if ctx.driver.profile.es { 32 } else { 43 };
        let messages = knows && ctx.driver.known_state.is_on(gl, api::GL_DEBUG_OUTPUT);
        if messages {
            // SAFETY: a switch that this version has; `drop` puts it back.
            unsafe { gl.disable(api::GL_DEBUG_OUTPUT) };
            ctx.driver.known_state.note(api::GL_DEBUG_OUTPUT, false);
        }
        Self { ctx, suspends: false, messages }
    }
}

impl Deref for OwnCalls<'_> {
    type Target = Context;

    fn deref(&self) -> &Context {
        self.ctx
    }
}

impl DerefMut for OwnCalls<'_> {
    fn deref_mut(&mut self) -> &mut Context {
        self.ctx
    }
}

impl Drop for OwnCalls<'_> {
    fn drop(&mut self) {
        let gl = self.ctx.driver.gl;
        if self.suspends {
            self.ctx.queries.resume_condition(gl);
        }
        if self.messages {
            // SAFETY: a switch that this version has.
            unsafe { gl.enable(api::GL_DEBUG_OUTPUT) };
            self.ctx.driver.known_state.note(api::GL_DEBUG_OUTPUT, true);
        }
        if self.suspends {
            self.ctx.queries.begin_parts(gl);
        }
    }
}
