//! Flat drawing behind the scene ([`crate::intercept::scene::frame_order`]). It goes to the views
//! themselves, at the position of the panel. A flat clip position is a point of the panel. The
//! panel's opening is the lens.

use crate::correct::LowerLeftRect;
use crate::intercept::gl::per_view::classify;
use crate::intercept::gl::state::app::AppState;
use crate::intercept::gl::state::compat::Compat;
use crate::intercept::gl::state::drawable::Drawable;
use crate::intercept::gl::state::frame::Frame;
use crate::intercept::scene::viewport::parts::PanelPart;

/// True if a flat draw with the present state goes behind the scene.
pub fn is_behind(app: &AppState, drawable: &Drawable, frame: &mut Frame, compat: &Compat) -> bool {
    if !frame.is_behind() || !classify::main_viewport(app, frame) {
        return false;
    }
    let Some(target) = drawable.target() else { return false };
    // Widgets are drawn in a scissor of their own. The scene between them may have one around its
    // viewport.
    let scissor = app.scissor();
    let whole = scissor.contains(LowerLeftRect::of_size(target.size())) || scissor.contains(app.viewport());
    (whole || !app.scissor_test()) && prepare(drawable, frame, compat, PanelPart::default())
}

/// Computes the matrices from flat clip positions to the views. Returns false if there are none.
pub fn prepare(drawable: &Drawable, frame: &mut Frame, compat: &Compat, part: PanelPart) -> bool {
    let Some(session) = drawable.session() else { return false };
    frame.prepare_background(session, compat.projection.matrix(), part)
}
