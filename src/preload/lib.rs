//! `LD_PRELOAD=…/libcupola_preload.so program`: Cupola without a launcher.
//!
//! It interposes nothing. Its SONAME is that of a GLX vendor library called "cupola", so that the
//! library that is already loaded answers libGLX's own request for that vendor. Before the
//! program's `main` it names that vendor in the environment, and gives libEGL a vendor file that
//! names this very library.

#![deny(unsafe_op_in_unsafe_fn)]

use std::ffi::{CStr, c_int, c_void};
use std::io::{Seek, Write};
use std::os::fd::{FromRawFd, IntoRawFd};

// Entry points for libGLX and libEGL; the re-export keeps them in this library.
pub use cupola::intercept::gl::entry::egl::__egl_Main;
pub use cupola::intercept::gl::entry::glx::__glx_Main;

/// Called by the dynamic linker before the program's `main`.
// SAFETY: a function pointer in the section where the linker expects function pointers.
#[used]
#[unsafe(link_section = ".init_array")]
static BEFORE_MAIN: extern "C" fn(c_int, *const c_void, *const c_void) = before_main;

extern "C" fn before_main(_: c_int, _: *const c_void, _: *const c_void) {
    // A panic here would end the program; without the variables the program runs without Cupola.
    let _ = cupola::fence::guard(name_vendors);
}

fn name_vendors() {
    if cupola::intercept::process::settings::switched_off() {
        return;
    }
    let previous = std::env::var("__GLX_VENDOR_LIBRARY_NAME").ok().filter(|name| name != "cupola");
    // SAFETY: the process has one thread before `main`.
    unsafe {
        if let Some(previous) = previous {
            std::env::set_var("CUPOLA_GLX_REAL", previous);
        }
        std::env::set_var("__GLX_VENDOR_LIBRARY_NAME", "cupola");
    }
    let Some(vendor_file) = egl_vendor_file() else { return };
    // A child that does not inherit LD_PRELOAD finds no library under the first name; the system's
    // own file keeps its EGL working.
    let system = std::env::var("__EGL_VENDOR_LIBRARY_FILENAMES")
        .unwrap_or_else(|_| "/usr/share/glvnd/egl_vendor.d/50_mesa.json".to_owned());
    // A process that was itself started by Cupola already names such a file first.
    let system = system.split(':').filter(|name| !name.starts_with("/proc/self/fd/")).collect::<Vec<_>>().join(":");
    // SAFETY: as above.
    unsafe { std::env::set_var("__EGL_VENDOR_LIBRARY_FILENAMES", format!("{vendor_file}:{system}")) };
}

/// Creates a vendor file for libEGL in memory, which names this library. Returns its path.
fn egl_vendor_file() -> Option<String> {
    let library = own_path()?;
    // SAFETY: a fresh descriptor, owned by the File until it is leaked on purpose: libEGL opens it
    // by name.
    let mut file = unsafe {
        let descriptor = libc::memfd_create(c"cupola-egl-vendor".as_ptr(), libc::MFD_CLOEXEC);
        if descriptor < 0 {
            return None;
        }
        std::fs::File::from_raw_fd(descriptor)
    };
    let library = library.replace('\\', "\\\\").replace('"', "\\\"");
    write!(file, "{{\"file_format_version\": \"1.0.0\", \"ICD\": {{\"library_path\": \"{library}\"}}}}").ok()?;
    file.rewind().ok()?;
    Some(format!("/proc/self/fd/{}", file.into_raw_fd()))
}

/// The path from which the dynamic linker loaded this library.
fn own_path() -> Option<String> {
    // SAFETY: asks the dynamic linker about an address in this library; the answer's strings are
    // its own.
    unsafe {
        let mut info: libc::Dl_info = std::mem::zeroed();
        if libc::dladdr(before_main as *const c_void, &mut info) == 0 || info.dli_fname.is_null() {
            return None;
        }
        let path = CStr::from_ptr(info.dli_fname).to_str().ok()?;
        Some(std::fs::canonicalize(path).ok()?.to_string_lossy().into_owned())
    }
}
