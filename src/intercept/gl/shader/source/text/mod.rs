//! Words of a shader's text. All analyses of texts read them.
//!
//! `tokens` splits a text into words, `brackets` finds the end of a bracket.

pub(in crate::intercept::gl::shader) mod brackets;
pub(in crate::intercept::gl::shader) mod tokens;
