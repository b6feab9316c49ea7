//! Captures of outputs at their own resolution, which do not go to the window.

use crate::backend::gl::{OwnFramebuffer, Target};
use crate::correct::LowerLeftRect;
use crate::intercept::gl::context::read_pixels;
use crate::intercept::gl::state::drawable::Drawable;
use crate::intercept::gl::state::driver::Driver;
use crate::runtime::run_results::Picture;

/// Returns the picture of output `index` at its own resolution.
pub fn picture(driver: &Driver, drawable: &Drawable, index: usize, name: &str) -> Option<Picture> {
    let gl = driver.gl;
    let target = drawable.target()?;
    let whole = LowerLeftRect::of_size(target.session.plan().passes.get(index)?.size);
    let canvas = OwnFramebuffer::new(gl, whole.width, whole.height);
    // The outputs are presented in order. The outputs before this one get an empty viewport.
    let mut targets = vec![Target { framebuffer: canvas.framebuffer, viewport: LowerLeftRect::default() }; index];
    targets.push(Target { framebuffer: canvas.framebuffer, viewport: whole });
    target.backend().present(gl, target.texture(), &targets);
    let picture = read_pixels::read_back(gl, canvas.framebuffer, name, whole);
    canvas.destroy(gl);
    Some(picture)
}
