//! Effects of making a context current and of leaving it.

use crate::backend::gl::driver::api::Gl;
use crate::intercept::gl::context::current::{CURRENT, HANDLE, after_panic, current};
use crate::intercept::gl::context::gl_context::Context;
use crate::intercept::gl::context::registry::{Entry, contexts};
use crate::intercept::gl::frame::leaving;
use crate::intercept::gl::state::drawable::window::Window;
use crate::intercept::process::ending;
use std::sync::Arc;

/// Corrects the picture of the window that the program is about to leave by making another context
/// or window current. The program may swap the buffers of the old window while another one is
/// current.
pub fn leaving(handle: usize, window: Option<&Window>) {
    let Some(ctx) = current().filter(|c| !c.switched_off && c.frame.begun() && !ending::has_begun()) else { return };
    if HANDLE.get() == handle && ctx.drawable.window() == window {
        return;
    }
    if crate::fence::guard(|| leaving::leave(ctx)).is_none() {
        after_panic("leaving a window");
    }
    if handle == 0 {
        // The program may have waited until its own drawing was finished. Mesa's llvmpipe hangs if
        // a display is closed while work is left. SAFETY: the context is current.
        unsafe { ctx.driver.gl.finish() };
    }
}

/// Notes that the context `handle` was made current with `window` (`None`: with no window of the
/// program). `reads_elsewhere`: the context reads from another drawable.
pub fn make_current(handle: usize, gl: &'static Gl, window: Option<Window>, reads_elsewhere: bool) {
    let left = CURRENT.replace(std::ptr::null_mut());
    let left_handle = HANDLE.replace(handle);
    let pointer = contexts(|contexts| {
        if !left.is_null() {
            // SAFETY: the context was current on this thread until now, and no other thread can get
            // it before the table is unlocked.
            let context = unsafe { &mut *left };
            context.view_copies.deposit(&context.share.off_screen);
            contexts.release(left_handle, left as usize);
        }
        if handle == 0 {
            return std::ptr::null_mut();
        }
        let new = || Entry { share: Arc::default(), context: 0, current: false };
        let entry = contexts.known.entry(handle).or_insert_with(new);
        if entry.context == 0 {
            entry.context = Box::into_raw(Box::new(Context::new(gl, entry.share.clone()))) as usize;
        }
        entry.current = true;
        entry.context as *mut Context
    });
    CURRENT.set(pointer);
    if ending::has_begun() {
        return;
    }
    ending::watch(Some(leaving::at_end));
    if let Some(ctx) = current()
        && !ctx.switched_off
        && crate::fence::guard(|| ctx.attach(window, reads_elsewhere)).is_none()
    {
        after_panic("make current");
    }
}
