//! Coverage of flat draws. A flat draw that samples an image fills the window, as one that shows a
//! scene does, or a part of it, as a map in a corner does. A draw into such an image fills its
//! viewport, as a background does, or a part, as a text does. An occlusion query counts this once
//! for each kind of draw.

use crate::backend::gl::driver::api;
use crate::intercept::gl::context::gl_context::Context;
use crate::intercept::gl::state::drawable::Drawable;
use crate::intercept::gl::state::driver::Driver;
use crate::intercept::gl::state::offscreen::coverage::{Kind, Measure, Signature, State};
use crate::intercept::gl::state::offscreen::images::Set;
use crate::intercept::gl::state::offscreen::view_copies::ViewCopies;
use crate::intercept::gl::state::queries::Queries;

/// Of more kinds of draws the oldest are forgotten.
const GREATEST: usize = 64;

/// Tests whether the next draw fills the window; `Err`: it is to be measured, if it can be.
pub fn fills(ctx: &mut Context, sampled: Set) -> Result<bool, Measure> {
    let Some(target) = ctx.drawable.target() else { return Ok(false) };
    let (width, height) = target.size();
    let all = i64::from(width) * i64::from(height) * i64::from(target.config().samples.max(1));
    known(ctx, sampled, all, false).unwrap_or_else(|| Ok(assumed(&ctx.drawable, &ctx.view_copies, sampled)))
}

/// Tests whether the next draw, which samples no image that is followed, fills the program's
/// viewport in a framebuffer with so many samples per pixel; `Err`: it is to be measured.
pub fn fills_viewport(ctx: &mut Context, samples: i32) -> Result<bool, Measure> {
    let [width, height] = ctx.app.viewport.size().map(i64::from);
    known(ctx, 0, width * height * i64::from(samples.max(1)), true).unwrap_or(Ok(true))
}

/// Returns the known coverage of draws like the next one; `meanwhile` until the result of the
/// measurement is there. `None`: it cannot be measured.
fn known(ctx: &mut Context, sampled: Set, all: i64, meanwhile: bool) -> Option<Result<bool, Measure>> {
    let program = ctx.shaders.program.as_ref().filter(|p| p.draws_vertices()).map_or(0, |p| p.name);
    let signature = Signature { program, sampled, viewport: ctx.app.viewport };
    let kinds = &mut ctx.view_copies.coverage.0;
    let kind = match kinds.iter().position(|kind| kind.signature == signature) {
        Some(index) => index,
        None => {
            if kinds.len() >= GREATEST {
                kinds.remove(0).destroy(ctx.driver.gl);
            }
            kinds.push(Kind { signature, state: State::New });
            kinds.len() - 1
        }
    };
    match kinds[kind].state {
        State::Known(fills) => Some(Ok(fills)),
        State::Measured(..) => Some(Ok(meanwhile)),
        State::New => can_measure(&ctx.driver, &ctx.queries).then_some(Err(Measure { kind, all })),
    }
}

/// OpenGL counts samples, OpenGL ES does not; and a query of the program's must not be disturbed.
fn can_measure(driver: &Driver, queries: &Queries) -> bool {
    if driver.profile.es || driver.profile.version < 15 || queries.any() {
        return false;
    }
    let targets: &[u32] = match driver.profile.version {
        43.. => &[api::GL_SAMPLES_PASSED, api::GL_ANY_SAMPLES_PASSED, api::GL_ANY_SAMPLES_PASSED_CONSERVATIVE],
        33.. => &[api::GL_SAMPLES_PASSED, api::GL_ANY_SAMPLES_PASSED],
        _ => &[api::GL_SAMPLES_PASSED],
    };
    targets.iter().all(|target| {
        let mut current = 0;
        // SAFETY: writes one integer.
        unsafe { driver.gl.get_queryiv(*target, api::GL_CURRENT_QUERY, &mut current) };
        current == 0
    })
}

/// Without a measurement: what has the window's shape and is not small is taken for its picture.
fn assumed(drawable: &Drawable, view_copies: &ViewCopies, sampled: Set) -> bool {
    let Some(target) = drawable.target() else { return false };
    let images = view_copies.images.iter().enumerate().take(64);
    images.filter(|(i, _)| sampled >> i & 1 != 0).any(|(_, image)| {
        crate::intercept::scene::viewport::has_shape_of_window(
            image.size[0].into(),
            image.size[1].into(),
            target.size(),
        )
    })
}

/// Issues the draw that is measured, with the program's own window space.
pub fn measure(ctx: &mut Context, what: Measure, issue: impl FnOnce(&mut Context)) {
    let gl = ctx.driver.gl;
    let mut query = 0;
    // SAFETY: a query of Cupola around the draw; no other counts samples, as `can_measure` saw.
    unsafe {
        gl.gen_queries(1, &mut query);
        gl.begin_query(api::GL_SAMPLES_PASSED, query);
    }
    issue(ctx);
    // SAFETY: begun above.
    unsafe { gl.end_query(api::GL_SAMPLES_PASSED) };
    match ctx.view_copies.coverage.0.get_mut(what.kind) {
        Some(kind) => kind.state = State::Measured(query, what.all),
        // SAFETY: an object of Cupola.
        None => unsafe { gl.delete_queries(1, &query) },
    }
}
