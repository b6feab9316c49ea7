//! The contexts of the process, by their handles.

use crate::intercept::gl::context::gl_context::{Context, ShareGroup};
use crate::intercept::gl::state::drawable::default_framebuffer::DefaultFramebuffer;
use crate::intercept::gl::state::drawable::window::Window;
use crate::lock::Lock;
use crate::runtime::session::Session;
use std::collections::HashMap;
use std::sync::{Arc, Mutex};

static CONTEXTS: Mutex<Option<Contexts>> = Mutex::new(None);

/// All contexts of the process.
#[derive(Default)]
pub(in crate::intercept::gl) struct Contexts {
    /// Contexts by the window system's handles.
    pub(in crate::intercept::gl) known: HashMap<usize, Entry>,
    /// Addresses of contexts that the program destroyed while they were current on a thread. They
    /// are freed when that thread releases them.
    dying: Vec<usize>,
}

pub(in crate::intercept::gl) struct Entry {
    pub(in crate::intercept::gl) share: Arc<ShareGroup>,
    /// Address of a leaked Context; 0 = not current yet. Freed when the program destroys the
    /// context.
    pub(in crate::intercept::gl) context: usize,
    /// True if the context is current on a thread.
    pub(in crate::intercept::gl) current: bool,
}

impl Contexts {
    /// Notes that a context is no longer current on the thread that had it.
    pub(in crate::intercept::gl) fn release(&mut self, handle: usize, address: usize) {
        if let Some(index) = self.dying.iter().position(|dying| *dying == address) {
            self.dying.swap_remove(index);
            free(address);
        } else if let Some(entry) = self.known.get_mut(&handle).filter(|e| e.context == address) {
            entry.current = false;
        }
    }

    /// Frees the context of `entry`, or marks it to be freed when its thread releases it. The
    /// program destroyed the context, or its handle came back for a new one.
    fn forget(&mut self, entry: Entry) {
        if entry.current {
            self.dying.push(entry.context);
        } else if entry.context != 0 {
            free(entry.context);
        }
    }
}

/// Frees a context that is not current on any thread. The driver has deleted its OpenGL objects.
fn free(address: usize) {
    // SAFETY: the address came from Box::into_raw, and was just taken out of the only table that
    // holds it; no thread has the context current, so that no reference to it is left.
    let context = unsafe { Box::from_raw(address as *mut Context) };
    context.share.programs.locked().uses.change(context.shaders.used(), 0);
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

/// Notes that the program destroyed `handle`. A context that is current on a thread lives until the
/// thread releases it.
pub fn destroyed(handle: usize) {
    contexts(|contexts| {
        if let Some(entry) = contexts.known.remove(&handle) {
            contexts.forget(entry);
        }
    });
}

/// Returns the plan of the window of which another context of the group has ended a frame last, and
/// the number of that frame; 0 if no such frame has ended. That context is not current on any
/// thread. Toolkits make contexts with windows that show nothing.
pub fn lend_session(share: &Arc<ShareGroup>) -> Option<(u64, Arc<Session>)> {
    contexts(|contexts| {
        let others = contexts.known.values().filter(|e| !e.current && e.context != 0);
        let targets = others.filter(|entry| Arc::ptr_eq(&entry.share, share)).filter_map(|entry| {
            // SAFETY: a live context that is current on no thread, and cannot become current while
            // the table is locked.
            let other = unsafe { &*(entry.context as *const Context) };
            other.drawable.target().map(|target| (other.frame.last(), target))
        });
        targets.max_by_key(|(last, _)| *last).map(|(last, target)| (last, target.session.clone()))
    })
}

/// Takes the stand-in for `window` from another context of the group that is not current on any
/// thread. Contexts that draw to one window share one stand-in.
pub fn take_picture(share: &Arc<ShareGroup>, window: &Window) -> Option<Box<DefaultFramebuffer>> {
    contexts(|contexts| {
        let others = contexts.known.values().filter(|e| !e.current && e.context != 0);
        others.filter(|entry| Arc::ptr_eq(&entry.share, share)).find_map(|entry| {
            // SAFETY: a live context that is current on no thread, and cannot become current while
            // the table is locked.
            let other = unsafe { &mut *(entry.context as *mut Context) };
            other.give_picture(window)
        })
    })
}

/// Calls `look` with each context that is not current on any thread.
pub fn each_idle(mut look: impl FnMut(&Context)) {
    contexts(|contexts| {
        for entry in contexts.known.values().filter(|entry| !entry.current && entry.context != 0) {
            // SAFETY: a live context that is current on no thread, and cannot become current while
            // the table is locked.
            look(unsafe { &*(entry.context as *const Context) });
        }
    });
}
