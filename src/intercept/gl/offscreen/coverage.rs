//! Coverage of flat draws. A flat draw to the window that samples an image may fill the window:
//! then it shows a scene. If it fills only a part, it is something like a map in a corner. A flat
//! draw into an image may fill its viewport, like a background, or only a part, like a text. An
//! occlusion query measures this once for each kind of draw.

use crate::backend::gl::driver::api;
use crate::intercept::gl::context::gl_context::Context;
use crate::intercept::gl::state::drawable::Drawable;
use crate::intercept::gl::state::driver::Driver;
use crate::intercept::gl::state::offscreen::coverage::{Kind, Measure, Signature, State};
use crate::intercept::gl::state::offscreen::images::Set;
use crate::intercept::gl::state::offscreen::view_copies::ViewCopies;
use crate::intercept::gl::state::queries::Queries;

/// Greatest number of kinds of draws. Of more the oldest are forgotten.
const GREATEST: usize = 64;

/// Returns whether the next draw fills the window. `Err`: not known yet, the draw must be measured.
pub fn fills(ctx: &mut Context, sampled: Set) -> Result<bool, Measure> {
    let Some(target) = ctx.drawable.target() else { return Ok(false) };
    let (width, height) = target.size();
    let all = i64::from(width) * i64::from(height) * i64::from(target.config().samples.max(1));
    known(ctx, sampled, all, false).unwrap_or_else(|| Ok(assumed(&ctx.drawable, &ctx.view_copies, sampled)))
}

/// Returns whether the next draw, which samples no followed image, fills the program's viewport in
/// a framebuffer with `samples` samples per pixel. `Err`: not known yet, the draw must be measured.
pub fn fills_viewport(ctx: &mut Context, samples: i32) -> Result<bool, Measure> {
    let [width, height] = ctx.app.viewport().size().map(i64::from);
    known(ctx, 0, width * height * i64::from(samples.max(1)), true).unwrap_or(Ok(true))
}

/// Returns the known coverage of draws like the next one. `meanwhile`: answer until the result of
/// the measurement is available. `None`: the coverage cannot be measured.
fn known(ctx: &mut Context, sampled: Set, all: i64, meanwhile: bool) -> Option<Result<bool, Measure>> {
    let program = ctx.shaders.program().filter(|p| p.draws_vertices()).map_or(0, |p| p.name);
    let signature = Signature { program, sampled, viewport: ctx.app.viewport() };
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

/// True if samples can be counted. OpenGL ES cannot count them, and a query of the program must not
/// be disturbed.
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

/// Returns the answer without a measurement: an image with the window's shape that is not small is
/// taken for the window's picture.
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

/// Issues the draw and measures it, with the program's own window space.
pub fn measure(ctx: &mut Context, what: Measure, issue: impl FnOnce(&mut Context)) {
    let gl = ctx.driver.gl;
    let mut query = 0;
    // SAFETY: a query of Cupola around the draw. `can_measure` made sure that no other query counts
    // samples.
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
