//! Views that contain only the clear colour, or other colours in a part only. The correction takes
//! the clear colour where nothing was drawn.

use crate::backend::gl::driver::api;
use crate::intercept::gl::state::app::AppState;
use crate::intercept::gl::state::drawable::Drawable;
use crate::intercept::gl::state::driver::Driver;
use crate::intercept::gl::state::queries::Queries;

/// Notes that the program cleared the colour of all views by `glClear`, with its present clear
/// state.
pub fn note_clear(driver: &Driver, app: &AppState, drawable: &mut Drawable, queries: &Queries) {
    let unconditional = !queries.is_conditional() && !app.discard() && !app.buffers().draws_nothing();
    let (gl, state) = (driver.gl, &driver.known_state);
    let srgb = drawable.target().is_some_and(|t| t.config().srgb);
    // OpenGL ES always converts to sRGB if the window supports it.
    let converts = srgb && (driver.profile.es || state.is_on(gl, api::GL_FRAMEBUFFER_SRGB));
    let (mask, [red, green, blue, _]) = (state.mask(gl), state.clear_color(gl));
    let known = unconditional && !converts && mask[..3].iter().all(|on| *on != 0);
    if let Some(target) = drawable.target_mut() {
        target.note_clear(if known { stored([red, green, blue]) } else { None });
    }
}

/// Returns the colour as 8 bits store it. `None`: the driver may round up or down.
fn stored(color: [f32; 3]) -> Option<[f32; 3]> {
    let steps = color.map(|c| 255.0 * c.clamp(0.0, 1.0));
    let certain = steps.iter().all(|s| (s - s.round()).abs() < 0.49);
    certain.then(|| steps.map(|s| s.round() / 255.0))
}

#[cfg(test)]
mod tests {
    use super::stored;
    use crate::correct::TexelSpan;
    use crate::intercept::gl::state::drawable::cleared_views::ViewContents;

    #[test]
    fn only_views_that_nothing_came_into_are_blank() {
        let mut content = ViewContents::default();
        assert!(content.views_cleared().is_none(), "nothing is known before the first clear");
        content.clear(Some([0.0; 3]));
        content.draw(1);
        content.draw(63);
        assert_eq!(content.views_cleared().map(|b| b.views), Some(!(2 | 1 << 63)));
        content.clear(Some([1.0; 3]));
        assert_eq!(content.views_cleared().map(|b| b.views), Some(u64::MAX));
        content.draw(64);
        assert!(content.views_cleared().is_none(), "views beyond the bits are not followed");
    }

    #[test]
    fn what_was_touched_grows_until_a_clear() {
        let mut content = ViewContents::default();
        content.clear(Some([0.0; 3]));
        content.draw_within(2, TexelSpan { left: 10, bottom: 20, right: 30, top: 40 });
        content.draw_within(2, TexelSpan { left: 25, bottom: 5, right: 60, top: 30 });
        let touched = |content: &ViewContents, view: usize| content.views_cleared().map(|b| b.touched[view]);
        assert_eq!(touched(&content, 2), Some(TexelSpan { left: 10, bottom: 5, right: 60, top: 40 }));
        assert!(touched(&content, 1).is_some_and(|texels| texels.is_empty()), "nothing");
        content.draw(2);
        assert_eq!(touched(&content, 2).map(|texels| texels.right), Some(i32::MAX));
        content.clear(Some([0.0; 3]));
        assert!(touched(&content, 2).is_some_and(|texels| texels.is_empty()));
    }

    #[test]
    fn colours_that_may_round_either_way_are_not_known() {
        assert_eq!(stored([0.0, 1.0, 2.0]), Some([0.0, 1.0, 1.0]));
        assert_eq!(stored([0.3, 0.0, -1.0]), None, "76.5 steps");
        assert_eq!(stored([100.2 / 255.0, 0.0, 0.0]), Some([100.0 / 255.0, 0.0, 0.0]));
        assert_eq!(stored([f32::NAN, 0.0, 0.0]), None);
    }
}
