//! Build script: makes the OpenGL function table from the Khronos registry, and the correction
//! shaders from WGSL.
//!
//! All are written as Rust source to `OUT_DIR` and included by `src/backend/gl/driver/api.rs`,
//! `src/intercept/gl/compat/vertex_commands.rs`,
//! `src/intercept/gl/state/compat/vertex_commands.rs`,
//! `src/intercept/gl/vertex_input/vertex_array_commands.rs`,
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
    // Both libraries are never unloaded: libEGL unloads its vendors while threads may still have
    // thread-local variables of Cupola. They bind their own names to themselves, whatever names the
    // program exports.
    println!("cargo::rustc-link-arg=-Wl,-z,nodelete");
    println!("cargo::rustc-link-arg=-Wl,-Bsymbolic");
    // By this SONAME libGLX finds the vendor "cupola" if the preload library is already loaded.
    // Cargo has no flags for a library among the examples alone. So each other kind of target gets
    // another SONAME after this one, and the last one counts. Executables get one, too: libGLX
    // would take an executable with this SONAME for the vendor.
    println!("cargo::rustc-link-arg=-Wl,-soname,libGLX_cupola.so.0");
    name_library();
    for kind in ["bins", "tests", "benches"] {
        println!("cargo::rustc-link-arg-{kind}=-Wl,-soname,cupola-executable");
    }
}

/// Sets the SONAME of `libcupola.so`. Packages set `CUPOLA_SONAME` to a name with the version of
/// the interface, and get exports of that version. Without it the SONAME is the name of the file
/// that cargo writes, so that programs that are linked with it find it without symbolic links.
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
