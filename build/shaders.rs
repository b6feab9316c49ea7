//! WGSL → GLSL 330 / ESSL 300, at build time, so that nothing that compiles shaders from
//! source is linked into the injected library.

/// Rust source with the generated shader texts.
pub fn generate() -> String {
    String::new()
}
