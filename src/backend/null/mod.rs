//! A driver that draws nothing: an OpenGL function table that records Cupola's calls. With it,
//! planning, passes and the C interface are tested without a driver.
//!
//! ```text
//! rig → plan → GlBackend, Embedded or the C interface → Gl table ─ find() → Record
//! ```
//!
//! Each thread has its own record, as it has its own current context. The record counts live
//! objects, so that tests find leaks. The driver can raise an error at a chosen call.

mod functions;
#[cfg(test)]
mod tests;

use crate::correct::LowerLeftRect;
use std::cell::RefCell;
use std::collections::BTreeMap;

pub use functions::find;

/// One draw call that the driver received.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct DrawCall {
    /// Framebuffer that is bound for drawing; 0 is the window.
    pub framebuffer: u32,
    /// Viewport.
    pub viewport: LowerLeftRect,
    /// Program in use.
    pub program: u32,
    /// Number of indices or vertices.
    pub count: i32,
}

/// Calls that the driver received since [`reset`].
#[derive(Clone, Debug, Default)]
pub struct Record {
    /// The draw calls, in order.
    pub draws: Vec<DrawCall>,
    /// Number of programs that were linked.
    pub linked: u32,
    /// Number of objects that were generated and not deleted, by kind.
    pub alive: BTreeMap<&'static str, i64>,
    /// Number of calls that reached the driver.
    pub calls: u64,
    names: u32,
    framebuffers: [u32; 2],
    program: u32,
    viewport: LowerLeftRect,
    /// Number of the call at which the error flag is set, once.
    fails_at: Option<u64>,
    error: u32,
}

thread_local! {
    static RECORD: RefCell<Record> = RefCell::default();
}

/// Begins a new record, for a context whose window has this viewport.
pub fn reset(viewport: LowerLeftRect) {
    RECORD.set(Record { viewport, ..Record::default() });
}

/// Sets the error flag to `GL_OUT_OF_MEMORY` at the call of this number.
pub fn fail_at(call: u64) {
    RECORD.with_borrow_mut(|record| record.fails_at = Some(call));
}

/// Returns the record of this thread.
pub fn recorded() -> Record {
    RECORD.with_borrow(Clone::clone)
}

/// Returns the function table of the driver.
pub fn driver() -> crate::backend::gl::driver::api::Gl {
    crate::backend::gl::driver::api::Gl::load(find)
}

/// Counts a call, and runs `work` on the record.
fn note<R>(work: impl FnOnce(&mut Record) -> R) -> R {
    RECORD.with_borrow_mut(|record| {
        record.calls += 1;
        if record.fails_at.is_some_and(|at| record.calls >= at) {
            record.fails_at = None;
            record.error = crate::backend::gl::driver::api::GL_OUT_OF_MEMORY;
        }
        work(record)
    })
}
