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
    /// By their window system's handle.
    pub(in crate::intercept::gl) known: HashMap<usize, Entry>,
    /// Addresses of contexts that the program destroyed while a thread had them current: they live
    /// until it has another.
    dying: Vec<usize>,
}

pub(in crate::intercept::gl) struct Entry {
    pub(in crate::intercept::gl) share: Arc<ShareGroup>,
    /// The address of a leaked Context; 0 = not current yet. Freed when the program destroys it.
    pub(in crate::intercept::gl) context: usize,
    /// A thread has it current.
    pub(in crate::intercept::gl) current: bool,
}

impl Contexts {
    /// The thread that had a context current has it no longer.
    pub(in crate::intercept::gl) fn release(&mut self, handle: usize, address: usize) {
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
fn free(address: usize) {
    // SAFETY: the address came from Box::into_raw, and was just taken out of the only table that
    // holds it; no thread has the context current, so that no reference to it is left.
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

/// The program destroyed `handle`. A context that is current on any thread lives on until it is
/// not.
pub fn destroyed(handle: usize) {
    contexts(|contexts| {
        if let Some(entry) = contexts.known.remove(&handle) {
            contexts.forget(entry);
        }
    });
}

/// The plan of a window that another context of the group draws, which is not current on any
/// thread.
pub fn lend_session(share: &Arc<ShareGroup>) -> Option<Arc<Session>> {
    contexts(|contexts| {
        let others = contexts.known.values().filter(|e| !e.current && e.context != 0);
        others.filter(|entry| Arc::ptr_eq(&entry.share, share)).find_map(|entry| {
            // SAFETY: a live context that is current on no thread, and cannot become so while the
            // table is locked.
            let other = unsafe { &*(entry.context as *const Context) };
            other.drawable.target().map(|target| target.session.clone())
        })
    })
}

/// Takes the picture of `window` from another context of the group that is not current on any
/// thread: contexts that draw to one window draw one picture.
pub fn take_picture(share: &Arc<ShareGroup>, window: &Window) -> Option<Box<DefaultFramebuffer>> {
    contexts(|contexts| {
        let others = contexts.known.values().filter(|e| !e.current && e.context != 0);
        others.filter(|entry| Arc::ptr_eq(&entry.share, share)).find_map(|entry| {
            // SAFETY: a live context that is current on no thread, and cannot become so while the
            // table is locked.
            let other = unsafe { &mut *(entry.context as *mut Context) };
            other.give_picture(window)
        })
    })
}

/// Looks at all contexts that are current on no thread.
pub fn each_idle(mut look: impl FnMut(&Context)) {
    contexts(|contexts| {
        for entry in contexts.known.values().filter(|entry| !entry.current && entry.context != 0) {
            // SAFETY: a live context that is current on no thread, and cannot become so while the
            // table is locked.
            look(unsafe { &*(entry.context as *const Context) });
        }
    });
}
