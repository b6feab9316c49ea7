//! The contexts of the process, by their handles.

use crate::backend::gl::driver::api::Gl;
use crate::intercept::ending;
use crate::intercept::gl::context::current::{CURRENT, HANDLE, after_panic, current};
use crate::intercept::gl::context::gl_context::{Context, ShareGroup};
use crate::intercept::gl::frame::present;
use crate::intercept::gl::state::drawable::default_framebuffer::DefaultFramebuffer;
use crate::intercept::gl::state::drawable::window::Window;
use crate::lock::Lock;
use crate::runtime::session::Session;
use std::collections::HashMap;
use std::sync::{Arc, Mutex};

pub(in crate::intercept::gl) static CONTEXTS: Mutex<Option<Contexts>> = Mutex::new(None);

/// All contexts of the process.
#[derive(Default)]
pub(in crate::intercept::gl) struct Contexts {
    /// By their window system's handle.
    known: HashMap<usize, Entry>,
    /// Addresses of contexts that the program destroyed while a thread had them current: they live until it
    /// has another.
    dying: Vec<usize>,
}

pub(in crate::intercept::gl) struct Entry {
    share: Arc<ShareGroup>,
    // The address of a leaked Context; 0 = not current yet. Freed when the program destroys it.
    context: usize,
    /// A thread has it current.
    current: bool,
}

impl Contexts {
    /// The thread that had a context current has it no longer.
    fn release(&mut self, handle: usize, address: usize) {
        if let Some(index) = self.dying.iter().position(|dying| *dying == address) {
            self.dying.swap_remove(index);
            free(address);
        } else if let Some(entry) = self.known.get_mut(&handle).filter(|e| e.context == address) {
            entry.current = false;
        }
    }

    /// The program destroyed a context, or its handle came back without that.
    fn forget(&mut self, entry: Entry) {
        if entry.current {
            self.dying.push(entry.context);
        } else if entry.context != 0 {
            free(entry.context);
        }
    }
}

/// Frees a context that is current nowhere; its OpenGL objects went with it.
pub(in crate::intercept::gl) fn free(address: usize) {
    // SAFETY: the address came from Box::into_raw, and was just taken out of the only table that holds it;
    // no thread has the context current, so that no reference to it is left.
    let context = unsafe { Box::from_raw(address as *mut Context) };
    context.share.programs.locked().uses.change(context.shaders.pipelines.used, 0);
}

pub(in crate::intercept::gl) fn contexts<R>(use_them: impl FnOnce(&mut Contexts) -> R) -> R {
    use_them(CONTEXTS.locked().get_or_insert_with(Contexts::default))
}

/// Notes that `handle` was created, sharing objects with `shared` (0 = with none).
pub fn created(handle: usize, shared: usize) {
    contexts(|contexts| {
        let share = contexts.known.get(&shared).map(|e| e.share.clone()).unwrap_or_default();
        if let Some(old) = contexts.known.insert(handle, Entry { share, context: 0, current: false }) {
            contexts.forget(old);
        }
    });
}

/// The program is about to make another context or window current: what it drew is shown to the window that it
/// leaves, whose buffers it may swap when another is current.
pub fn leaving(handle: usize, window: Option<&Window>) {
    let Some(ctx) = current().filter(|c| !c.switched_off && c.frame.begun && !ending::has_begun()) else { return };
    if HANDLE.get() == handle && ctx.drawable.window.as_ref() == window {
        return;
    }
    if crate::fence::guard(|| present::leave(ctx)).is_none() {
        after_panic("leaving a window");
    }
    if handle == 0 {
        // The program may have waited for all that it drew. Mesa's llvmpipe hangs where a display is closed with work left.
        // SAFETY: the context is current.
        unsafe { ctx.driver.gl.finish() };
    }
}

/// The context `handle` was made current with `window` (`None`: no window of the program's). `reads_elsewhere`: it
/// reads from another drawable.
pub fn make_current(handle: usize, gl: &'static Gl, window: Option<Window>, reads_elsewhere: bool) {
    let left = CURRENT.replace(std::ptr::null_mut());
    let left_handle = HANDLE.replace(handle);
    let pointer = contexts(|contexts| {
        if !left.is_null() {
            // SAFETY: this thread had the context until now, and nobody can have it before the table is free.
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
    ending::watch(Some(present::at_end));
    if let Some(ctx) = current()
        && !ctx.switched_off
        && crate::fence::guard(|| ctx.attach(window, reads_elsewhere)).is_none()
    {
        after_panic("make current");
    }
}

/// The program destroyed `handle`. A context that is current on any thread lives on until it is not.
pub fn destroyed(handle: usize) {
    contexts(|contexts| {
        if let Some(entry) = contexts.known.remove(&handle) {
            contexts.forget(entry);
        }
    });
}

/// The plan of a window that another context of the group draws, which is not current on any thread.
pub fn lend_session(share: &Arc<ShareGroup>) -> Option<Arc<Session>> {
    contexts(|contexts| {
        let others = contexts.known.values().filter(|e| !e.current && e.context != 0);
        others.filter(|entry| Arc::ptr_eq(&entry.share, share)).find_map(|entry| {
            // SAFETY: a live context that is current on no thread, and cannot become so while the table is locked.
            let other = unsafe { &*(entry.context as *const Context) };
            other.drawable.target().map(|target| target.session.clone())
        })
    })
}

/// What another context of the group has for `window`, which is not current on any thread: contexts that draw to one
/// window draw one picture.
pub fn take_picture(share: &Arc<ShareGroup>, window: &Window) -> Option<Box<DefaultFramebuffer>> {
    contexts(|contexts| {
        let others = contexts.known.values().filter(|e| !e.current && e.context != 0);
        others.filter(|entry| Arc::ptr_eq(&entry.share, share)).find_map(|entry| {
            // SAFETY: a live context that is current on no thread, and cannot become so while the table is locked.
            let other = unsafe { &mut *(entry.context as *mut Context) };
            other.give_picture(window)
        })
    })
}
