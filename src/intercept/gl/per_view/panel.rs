//! The flat panel: its blending and its clears.

use crate::backend::gl::KnownState;
use crate::backend::gl::driver::api::{self, Gl};
use crate::correct::LowerLeftRect;
use crate::intercept::gl::context::gl_context::Context;

/// Blending for draws to the panel: its alpha collects how much of it is covered, for the
/// correction.
pub(in crate::intercept::gl) struct PanelBlend {
    factors: [u32; 4],
}

impl PanelBlend {
    pub(in crate::intercept::gl) fn begin(gl: &Gl, known: &KnownState) -> Option<Self> {
        if !known.is_on(gl, api::GL_BLEND) {
            return None;
        }
        let factors = known.blending(gl);
        let [source, destination, ..] = factors;
        let covers = destination == api::GL_ONE_MINUS_SRC_ALPHA;
        let (source_alpha, destination_alpha) =
            if covers { (api::GL_ONE, api::GL_ONE_MINUS_SRC_ALPHA) } else { (api::GL_ZERO, api::GL_ONE) };
        // SAFETY: sets plain state; put back in `end`.
        unsafe { gl.blend_func_separate(source, destination, source_alpha, destination_alpha) };
        Some(Self { factors })
    }

    pub(in crate::intercept::gl) fn end(self, gl: &Gl) {
        let [source, destination, source_alpha, destination_alpha] = self.factors;
        // SAFETY: puts back what `begin` found.
        unsafe { gl.blend_func_separate(source, destination, source_alpha, destination_alpha) };
    }
}

/// Clears the panel to transparent. It acts like a pane of glass: cleared parts show the scene
/// behind.
pub fn clear_panel(ctx: &mut Context) {
    if let Some(panel) = ctx.drawable.target().and_then(|t| t.panel()) {
        // The gutter is cleared too. Otherwise the filter would mix its old colour into the
        // borders.
        ctx.set_scissor(Some(LowerLeftRect::new(panel.x - 1, panel.y - 1, panel.width + 2, panel.height + 2)));
        clear_transparent(ctx.driver.gl, &ctx.driver.known_state);
    }
}

/// Clears a rectangle of the program's window on the panel to transparent.
pub fn clear_part(ctx: &mut Context, part: LowerLeftRect) {
    if let Some(panel) = ctx.drawable.target().and_then(|t| t.panel()) {
        ctx.set_scissor(Some(part.moved_into(panel)));
        clear_transparent(ctx.driver.gl, &ctx.driver.known_state);
    }
}

/// Clears the bound framebuffer's colour within the scissor to transparent black.
pub fn clear_transparent(gl: &Gl, known: &KnownState) {
    clear_all(gl, known, [0.0; 4]);
}

/// Clears the bound framebuffer's colour within the scissor to an opaque colour.
pub fn clear_to(gl: &Gl, known: &KnownState, [red, green, blue]: [f32; 3]) {
    clear_all(gl, known, [red, green, blue, 1.0]);
}

fn clear_all(gl: &Gl, known: &KnownState, colour: [f32; 4]) {
    let mask = known.mask(gl);
    // SAFETY: the colour mask is put back.
    unsafe {
        gl.color_mask(1, 1, 1, 1);
        gl.clear_bufferfv(api::GL_COLOR, 0, colour.as_ptr());
        let [red, green, blue, alpha] = mask;
        gl.color_mask(red, green, blue, alpha);
    }
}
