//! Versions of the interface, with their history, and of the package.

use super::status::{call, cupola_status};

/// Version of the binary interface. A program works with a library of the same number only.
///
/// It grows when a function or a field is removed or changed, so that compiled programs have to be
/// compiled again. Additions do not change it. History:
///
/// - 1: since 0.1.
pub const CUPOLA_ABI_VERSION: u32 = 1;

/// Version of the interface's contents. A program works with a library of the same or a greater
/// number.
///
/// It grows with each addition. History:
///
/// - 1: 0.1 as it was first published: rigs, exact directions, OpenGL (`cupola_gl_...`), blending,
///   projecting shaders, and Vulkan (`cupola_vk_...`).
/// - 2: `cupola_abi_version`, `cupola_api_version` and their macros; `cupola_set_log_callback`;
///   structs of smaller and larger `struct_size` are served.
pub const CUPOLA_API_VERSION: u32 = 2;

/// Returns the `CUPOLA_ABI_VERSION` of the library. The macro is that of the header with which the
/// program was compiled. If the two differ, the program must not use the library.
///
/// # Threads
/// Any thread.
#[unsafe(no_mangle)]
pub extern "C" fn cupola_abi_version() -> u32 {
    CUPOLA_ABI_VERSION
}

/// Returns the `CUPOLA_API_VERSION` of the library. The library lacks functions and fields of later
/// versions.
///
/// # Threads
/// Any thread.
#[unsafe(no_mangle)]
pub extern "C" fn cupola_api_version() -> u32 {
    CUPOLA_API_VERSION
}

/// Returns the version of the library's package: major, minor and patch. To find out what the
/// library can do, use `cupola_api_version`.
///
/// # Parameters
/// - `major`, `minor`, `patch`: receive the numbers; each may be null.
///
/// # Returns
/// `CUPOLA_OK`.
///
/// # Threads
/// Any thread.
///
/// # Safety
/// Each pointer is null or writable.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cupola_version(major: *mut u32, minor: *mut u32, patch: *mut u32) -> cupola_status {
    call(|| {
        let parts = [env!("CARGO_PKG_VERSION_MAJOR"), env!("CARGO_PKG_VERSION_MINOR"), env!("CARGO_PKG_VERSION_PATCH")];
        for (pointer, part) in [major, minor, patch].into_iter().zip(parts) {
            if !pointer.is_null() {
                // SAFETY: writable, as this function's contract says.
                unsafe { *pointer = part.parse().unwrap_or(0) };
            }
        }
        Ok(())
    })
}
