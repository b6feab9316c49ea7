//! Build script: the OpenGL function table from the Khronos registry, and the
//! correction shaders from WGSL.
//!
//! All end as Rust source under `OUT_DIR`, included by `src/backend/gl/api.rs`,
//! `src/intercept/gl/immediate/commands.rs`, `src/intercept/gl/vertex_arrays/commands.rs`,
//! `src/correct/shaders/{constants,glsl,spirv}.rs`, `src/intercept/vk/queries/copies.rs` and
//! `src/intercept/vk/spirv/functions.rs`.

mod constants;
mod gl_arrays;
mod gl_attributes;
mod gl_registry;
mod projection;
mod shaders;
mod spirv;

use std::path::PathBuf;

fn main() {
    println!("cargo::rerun-if-changed=build");
    println!("cargo::rerun-if-changed=shaders");
    for texts in
        ["src/correct/projected/division.rs", "src/correct/projected/projection.rs", "src/geom/division/rule.rs"]
    {
        println!("cargo::rerun-if-changed={texts}");
    }
    let out = PathBuf::from(std::env::var_os("OUT_DIR").expect("cargo sets OUT_DIR"));
    let [table, attributes, arrays] = gl_registry::generate();
    std::fs::write(out.join("gl_api.rs"), table).expect("OUT_DIR is writable");
    std::fs::write(out.join("gl_attributes.rs"), attributes).expect("OUT_DIR is writable");
    std::fs::write(out.join("gl_arrays.rs"), arrays).expect("OUT_DIR is writable");
    let [texts, modules, constants] = shaders::generate();
    std::fs::write(out.join("shaders.rs"), texts).expect("OUT_DIR is writable");
    std::fs::write(out.join("shader_constants.rs"), constants).expect("OUT_DIR is writable");
    std::fs::write(out.join("spirv.rs"), modules).expect("OUT_DIR is writable");
    std::fs::write(out.join("queries_spirv.rs"), shaders::queries()).expect("OUT_DIR is writable");
    std::fs::write(out.join("projection_spirv.rs"), projection::generate()).expect("OUT_DIR is writable");
    // Both libraries stay loaded for good (libEGL unloads its vendors while threads may still hold
    // our thread-locals), and bind their own names to themselves whatever the program exports.
    println!("cargo::rustc-link-arg=-Wl,-z,nodelete");
    println!("cargo::rustc-link-arg=-Wl,-Bsymbolic");
    // The SONAME answers libGLX's request for a vendor called "cupola" when the preload library is
    // loaded already. Cargo has no flags for a library among the examples alone, so each other kind
    // of target gets a name of its own after it, and the last one counts. Executables too: libGLX
    // would take one of that name for the vendor.
    println!("cargo::rustc-link-arg=-Wl,-soname,libGLX_cupola.so.0");
    name_library();
    for kind in ["bins", "tests", "benches"] {
        println!("cargo::rustc-link-arg-{kind}=-Wl,-soname,cupola-executable");
    }
}

/// SONAME of `libcupola.so`. Packages set `CUPOLA_SONAME` to a name with the version of the
/// interface, and get exports of that version. Without it the name is the file's own, as cargo
/// leaves it: programs that are linked with it find it without further links.
fn name_library() {
    println!("cargo::rerun-if-env-changed=CUPOLA_SONAME");
    match std::env::var("CUPOLA_SONAME") {
        Ok(name) => {
            println!("cargo::rustc-cdylib-link-arg=-Wl,-soname,{name}");
            // rustc's own list of exports is a version script without a version, and linkers refuse
            // a second one. GNU's linker can give all exports the SONAME as their version.
            println!("cargo::rustc-cdylib-link-arg=-fuse-ld=bfd");
            println!("cargo::rustc-cdylib-link-arg=-Wl,--default-symver");
        }
        Err(_) => println!("cargo::rustc-cdylib-link-arg=-Wl,-soname,libcupola.so"),
    }
}
