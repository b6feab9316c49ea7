//! The contexts of the process, and which one is current on a thread.

use crate::backend::gl::driver::api::Gl;
use crate::intercept::gl::context::gl_context::Context;
use crate::intercept::process::log;
use crate::lock::Lock;
use std::cell::Cell;
use std::sync::atomic::{AtomicPtr, Ordering};

thread_local! {
    pub(in crate::intercept::gl) static CURRENT: Cell<*mut Context> = const { Cell::new(std::ptr::null_mut()) };
    /// The window system's handle of the current context.
    pub(in crate::intercept::gl) static HANDLE: Cell<usize> = const { Cell::new(0) };
}

static DRIVER: AtomicPtr<Gl> = AtomicPtr::new(std::ptr::null_mut());

/// The context that is current on this thread.
pub fn current() -> Option<&'static mut Context> {
    let pointer = CURRENT.get();
    // SAFETY: set only by `make_current` to a live, leaked Context; OpenGL lets a context be
    // current on one thread at a time, so the reference is unique while a hook runs.
    unsafe { pointer.as_mut() }
}

/// The driver's table for calls without a context of Cupola.
pub fn driver() -> &'static Gl {
    // SAFETY: set once, from a leaked table, before libglvnd can dispatch any GL call to Cupola.
    unsafe { DRIVER.load(Ordering::Acquire).as_ref() }.expect("a vendor was loaded before any call")
}

/// Sets the table for calls without a context of Cupola.
pub fn set_driver(gl: &'static Gl) {
    DRIVER.store(std::ptr::from_ref(gl).cast_mut(), Ordering::Release);
}

/// Switches the current context off after a panic in the hook `name`. All later calls in this
/// context go straight to the driver.
pub fn after_panic(name: &str) {
    log::once(&format!("a defect of Cupola in {name}: this context keeps the program's own picture; please report it"));
    if let Some(ctx) = current() {
        ctx.switched_off = true;
        ctx.share.buffers.locked().lose();

        ctx.leave_alone();
    }
}
