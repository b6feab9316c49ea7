//! Coverage of flat draws. A flat draw to the window that samples an image may fill the window, or
//! a large part of it between the widgets of a toolkit: then it shows a scene. If it fills only a
//! small part, it is something like a map in a corner. A flat draw into an image may fill its
//! viewport, like a background, or only a part, like a text.
//!
//! Occlusion queries measure this once for each kind of draw: first the number of samples, and if
//! the draw fills a large part of the window, in the next frame its borders.

use crate::backend::gl::driver::api;
use crate::correct::LowerLeftRect;
use crate::intercept::gl::context::gl_context::Context;
use crate::intercept::gl::per_view::window_space::own_window_space;
use crate::intercept::gl::state::drawable::Drawable;
use crate::intercept::gl::state::driver::Driver;
use crate::intercept::gl::state::offscreen::coverage::{Kind, Measure, Measured, Signature, State};
use crate::intercept::gl::state::offscreen::images::Set;
use crate::intercept::gl::state::offscreen::single_sample::SingleSampleImage;
use crate::intercept::gl::state::offscreen::view_copies::ViewCopies;
use crate::intercept::gl::state::queries::Queries;
use crate::intercept::scene::viewport::parts::Picture;

/// Greatest number of kinds of draws. Of more the oldest are forgotten.
const GREATEST: usize = 64;

/// Returns the part of the window that the next draw fills, if it is a large one. `Err`: not known
/// yet, the draw must be measured.
pub fn filled_part(ctx: &mut Context, sampled: Set) -> Result<Option<LowerLeftRect>, Measure> {
    let Some(window) = window(&ctx.drawable) else { return Ok(None) };
    match look_up(ctx, (sampled, 0), window) {
        Answer::Part(part) => Ok(part),
        Answer::Measure(measure) => Err(measure),
        Answer::Later => Ok(None),
        Answer::Never => Ok(assumed(&ctx.drawable, &ctx.view_copies, sampled).then(|| window.whole())),
    }
}

/// Returns size and samples of the program's window.
pub fn window(drawable: &Drawable) -> Option<Picture> {
    let target = drawable.target()?;
    Some(Picture { size: target.size().into(), samples: target.config().samples.max(1).into() })
}

/// Returns whether the next draw, which samples no followed image, fills the program's viewport in
/// a framebuffer with `samples` samples per pixel. `Err`: not known yet, the draw must be measured.
pub fn fills_viewport(ctx: &mut Context, samples: i32) -> Result<bool, Measure> {
    let picture = Picture { size: ctx.app.viewport().size(), samples: samples.max(1).into() };
    match look_up(ctx, (0, 0), picture) {
        Answer::Part(part) => Ok(part.is_some()),
        Answer::Measure(measure) => Err(measure),
        Answer::Later | Answer::Never => Ok(true),
    }
}

/// Returns whether the next draw, which is the `number`-th flat draw behind the scene, fills
/// the program's viewport. `Err`: not known yet, the draw must be measured. `Ok(false)` if it cannot
/// be measured.
pub fn fills_window(ctx: &mut Context, number: u32) -> Result<bool, Measure> {
    let Some(window) = window(&ctx.drawable) else { return Ok(false) };
    let picture = Picture { size: ctx.app.viewport().size(), ..window };
    match look_up(ctx, (0, number), picture) {
        Answer::Part(part) => Ok(part.is_some()),
        Answer::Measure(measure) => Err(measure),
        Answer::Later | Answer::Never => Ok(false),
    }
}

/// What is known of the coverage of a draw.
enum Answer {
    /// The part of the picture that it fills.
    Part(Option<LowerLeftRect>),
    /// Nothing; the draw must be measured.
    Measure(Measure),
    /// Nothing; the results of the measurement are not available yet.
    Later,
    /// Nothing; it cannot be measured.
    Never,
}

/// Returns what is known of the coverage of draws like the next one.
fn look_up(ctx: &mut Context, (sampled, number): (Set, u32), picture: Picture) -> Answer {
    let program = ctx.shaders.program().filter(|p| p.draws_vertices()).map_or(0, |p| p.name);
    let signature = Signature { program, sampled, viewport: ctx.app.viewport(), number };
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
    let can_measure = || can_measure(&ctx.driver, &ctx.queries);
    match kinds[kind].state {
        State::Known(part) => Answer::Part(part),
        // OpenGL ES also cannot copy a part of a picture with several samples to another place.
        State::New if number != 0 && ctx.driver.profile.es => match picture.samples == 1 && can_probe(ctx) {
            true => Answer::Measure(Measure { kind, what: Measured::Probes(picture) }),
            false => Answer::Never,
        },
        State::New if can_measure() => Answer::Measure(Measure { kind, what: Measured::Samples(picture) }),
        State::New => Answer::Never,
        State::Large(..) if can_measure() && !ctx.app.feedback() && !has_stencil_test(&ctx.driver) => {
            Answer::Measure(Measure { kind, what: Measured::Borders })
        }
        State::Measured(..) | State::Large(..) | State::Crossed(..) | State::Probed(..) => Answer::Later,
    }
}

/// True if repetitions of a draw might change the stencil buffer.
fn has_stencil_test(driver: &Driver) -> bool {
    driver.known_state.is_on(driver.gl, api::GL_STENCIL_TEST)
}

/// True if a context of OpenGL ES can tell whether a draw reaches certain pixels.
fn can_probe(ctx: &Context) -> bool {
    ctx.driver.profile.version >= 30
        && !ctx.queries.any()
        && !ctx.app.feedback()
        && !has_stencil_test(&ctx.driver)
        && run_no_queries(&ctx.driver, &[api::GL_ANY_SAMPLES_PASSED, api::GL_ANY_SAMPLES_PASSED_CONSERVATIVE])
}

/// True if none of these queries runs.
fn run_no_queries(driver: &Driver, targets: &[u32]) -> bool {
    targets.iter().all(|target| {
        let mut current = 0;
        // SAFETY: writes one integer.
        unsafe { driver.gl.get_queryiv(*target, api::GL_CURRENT_QUERY, &mut current) };
        current == 0
    })
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
    run_no_queries(driver, targets)
}

/// Returns the answer without a measurement: an image with the window's shape that is not small is
/// taken for the window's picture.
fn assumed(drawable: &Drawable, view_copies: &ViewCopies, sampled: Set) -> bool {
    let Some(target) = drawable.target() else { return false };
    let images = view_copies.images.iter().enumerate().take(64);
    images
        .filter(|(i, _)| sampled >> i & 1 != 0)
        .any(|(_, image)| crate::intercept::scene::viewport::has_shape_of_window(image.size, target.size()))
}

/// Issues the draw and measures its samples, with the program's own window space.
pub fn measure(ctx: &mut Context, what: Measure, issue: impl FnOnce(&mut Context)) {
    let Measured::Samples(picture) = what.what else { return issue(ctx) };
    let query = counted(ctx, api::GL_SAMPLES_PASSED, issue);
    set_state(ctx, what, State::Measured(query, picture), &[query]);
}

/// Measures the borders of a draw in `tile`, which shows the program's own window, or what it reaches
/// there, if this is to be measured. `issue` issues the draw and restores what it changes.
pub fn measure_parts(ctx: &mut Context, what: Measure, tile: LowerLeftRect, mut issue: impl FnMut(&mut Context)) {
    match what.what {
        Measured::Samples(_) => {}
        Measured::Borders => measure_borders(ctx, what, tile, issue),
        Measured::Probes(picture) => {
            // The place of the program's viewport in the tile.
            let viewport = ctx.app.viewport().moved_into(tile);
            let kind = api::GL_ANY_SAMPLES_PASSED;
            let probes = picture.probes().map(|probe| probe.moved_into(viewport));
            let queries = measured_in(ctx, tile, (probes, kind), &mut issue);
            own_window_space(ctx, tile);
            set_state(ctx, what, State::Probed(queries, picture), &queries);
        }
    }
}

/// Issues a draw, which `tile` shows, once in each of these parts, without writing anything, and
/// returns queries of this kind.
fn measured_in<const N: usize>(
    ctx: &mut Context,
    tile: LowerLeftRect,
    (parts, kind): ([LowerLeftRect; N], u32),
    issue: &mut impl FnMut(&mut Context),
) -> [u32; N] {
    let gl = ctx.driver.gl;
    let (mut depth, colours) = (0, ctx.driver.known_state.mask(gl));
    // SAFETY: nothing is written; the masks are put back below.
    unsafe {
        gl.get_booleanv(api::GL_DEPTH_WRITEMASK, &mut depth);
        gl.depth_mask(0);
        gl.color_mask(0, 0, 0, 0);
    }
    let own = ctx.app.scissor_test().then(|| ctx.app.scissor().moved_into(tile));
    let queries = parts.map(|part| {
        ctx.set_scissor(Some(own.map_or(part, |own| own.intersection(part))));
        counted(ctx, kind, &mut *issue)
    });
    // SAFETY: the program's masks.
    unsafe {
        gl.depth_mask(depth);
        gl.color_mask(colours[0], colours[1], colours[2], colours[3]);
    }
    queries
}

/// [`measure_parts`] for borders. A window with several samples per pixel is replaced by a picture with
/// one: llvmpipe counts samples beside the scissor there.
fn measure_borders(ctx: &mut Context, what: Measure, tile: LowerLeftRect, mut issue: impl FnMut(&mut Context)) {
    let kind = ctx.view_copies.coverage.0.get(what.kind);
    let (Measured::Borders, Some(State::Large(samples, picture))) = (what.what, kind.map(|kind| &kind.state)) else {
        return;
    };
    let (gl, samples, picture, window) = (ctx.driver.gl, *samples, *picture, tile);
    let has_samples = picture.samples > 1;
    let canvas = has_samples.then(|| SingleSampleImage::new(gl, picture.size, api::GL_RGBA8)).flatten();
    let (samples, picture, tile) = match &canvas {
        None => (samples, picture, window),
        Some(canvas) => {
            // SAFETY: a framebuffer of Cupola; the window's is bound again below.
            unsafe { gl.bind_framebuffer(api::GL_DRAW_FRAMEBUFFER, canvas.framebuffer()) };
            let whole = picture.whole();
            own_window_space(ctx, whole);
            (samples / picture.samples, Picture { samples: 1, ..picture }, whole)
        }
    };
    let arms = picture.arms().map(|arm| arm.moved_into(tile));
    let queries = measured_in(ctx, tile, (arms, api::GL_SAMPLES_PASSED), &mut issue);
    if let (Some(canvas), Some(target)) = (canvas, ctx.drawable.target()) {
        // SAFETY: the framebuffer that stands for the window.
        unsafe { gl.bind_framebuffer(api::GL_DRAW_FRAMEBUFFER, target.framebuffer()) };
        canvas.destroy(gl);
    }
    own_window_space(ctx, window);
    set_state(ctx, what, State::Crossed(queries, samples, picture), &queries);
}

/// Issues a draw and returns a query of this kind about its samples.
fn counted(ctx: &mut Context, kind: u32, issue: impl FnOnce(&mut Context)) -> u32 {
    let gl = ctx.driver.gl;
    let mut query = 0;
    // SAFETY: a query of Cupola around the draw. `can_measure` or `can_probe` made sure that no other
    // query counts samples.
    unsafe {
        gl.gen_queries(1, &mut query);
        gl.begin_query(kind, query);
    }
    issue(ctx);
    // SAFETY: begun above.
    unsafe { gl.end_query(kind) };
    query
}

/// Notes a measurement. If its kind was forgotten meanwhile, deletes the queries.
fn set_state(ctx: &mut Context, what: Measure, state: State, queries: &[u32]) {
    match ctx.view_copies.coverage.0.get_mut(what.kind) {
        Some(kind) => kind.state = state,
        // SAFETY: objects of Cupola.
        None => unsafe { ctx.driver.gl.delete_queries(queries.len() as i32, queries.as_ptr()) },
    }
}
