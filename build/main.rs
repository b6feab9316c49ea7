//! Build script: the OpenGL function table from the Khronos registry, and the
//! correction shaders from WGSL.
//!
//! Both end as Rust source under `OUT_DIR`, included by `src/backend/gl/api.rs`
//! and `src/correct/shaders.rs`.

mod gl_registry;
mod shaders;

use std::path::PathBuf;

fn main() {
    println!("cargo::rerun-if-changed=build");
    println!("cargo::rerun-if-changed=shaders");
    let out = PathBuf::from(std::env::var_os("OUT_DIR").expect("cargo sets OUT_DIR"));
    std::fs::write(out.join("gl_api.rs"), gl_registry::generate()).expect("OUT_DIR is writable");
    std::fs::write(out.join("shaders.rs"), shaders::generate()).expect("OUT_DIR is writable");
    // The same file answers libGLX's request for a vendor called "cupola", stays loaded for
    // good (libEGL unloads its vendors while threads may still hold our thread-locals), and
    // binds its own names to itself whatever the program exports.
    for argument in ["-Wl,-soname,libcupola.so.0", "-Wl,-z,nodelete", "-Wl,-Bsymbolic"] {
        println!("cargo::rustc-cdylib-link-arg={argument}");
    }
}
