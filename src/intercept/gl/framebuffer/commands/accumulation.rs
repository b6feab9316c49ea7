//! The accumulation buffer (`glAccum`, for example for motion blur), of all views at once.

use crate::backend::gl::accumulation::{Accumulation, Operation};
use crate::backend::gl::driver::api;
use crate::correct::LowerLeftRect;
use crate::intercept::gl::context::errors::take_own_errors;
use crate::intercept::gl::context::gl_context::Context;
use crate::intercept::gl::context::hooks::hooks;
use crate::intercept::gl::context::list_recording;
use crate::intercept::gl::context::own_calls::OwnCalls;
use crate::intercept::gl::state::app::AppState;
use crate::intercept::gl::state::drawable::Drawable;
use crate::intercept::process::log;

/// Returns the parts of the atlas that an operation on the program's window affects: the whole
/// atlas, or the parts of the program's own pictures within the scissor. As for clears, a scissor
/// around most of the window counts as the whole window.
fn parts(app: &AppState, drawable: &Drawable) -> Vec<LowerLeftRect> {
    let Some(target) = drawable.target() else { return Vec::new() };
    let window = target.size();
    let part = app.scissor_test().then(|| app.scissor().moved_into(LowerLeftRect::of_size(window)));
    if part.is_none_or(|part| part.is_most_of(window)) {
        return vec![LowerLeftRect::of_size(target.session.surface_size())];
    }
    let tiles = target.flat_tiles().into_iter().flatten();
    tiles.map(|(tile, _)| app.scissor().moved_into(tile)).collect()
}

/// Runs `work` with the accumulation buffer, which is created at its first use.
fn with(ctx: &mut Context, work: impl FnOnce(&mut Context, &Accumulation)) {
    let ctx: &mut Context = &mut OwnCalls::begin(ctx);
    ctx.driver.take_errors();
    let gl = ctx.driver.gl;
    let surface = ctx.drawable.target().map(|t| t.session.surface_size());
    let size = surface.map_or((0, 0), |(width, height)| (width as i32, height as i32));
    // The tiles have moved, so the accumulated pictures are lost for one frame.
    let buffer = match ctx.drawable.take_accumulation() {
        Some(buffer) if buffer.size() == size => Ok(buffer),
        Some(old) => {
            old.destroy(gl);
            Accumulation::new(gl, size)
        }
        None => Accumulation::new(gl, size),
    };
    match buffer {
        Ok(buffer) => {
            work(ctx, &buffer);
            ctx.drawable.put_accumulation(buffer);
        }
        Err(error) => log::once(&format!("the program's accumulation buffer has no effect: {error}")),
    }
    take_own_errors(&mut ctx.driver);
}

/// True if the window has an accumulation buffer, which Cupola replaces then.
fn is_ours(ctx: &Context) -> bool {
    ctx.redirected() && ctx.drawable.target().is_some_and(|t| t.config().accumulation_bits > 0)
}

fn accumulate(ctx: &mut Context, name: u32, value: f32) {
    let operation = match name {
        api::GL_ACCUM => Operation::Accumulate,
        api::GL_LOAD => Operation::Load,
        api::GL_ADD => Operation::Add,
        api::GL_MULT => Operation::Multiply,
        api::GL_RETURN => Operation::Return,
        _ => {
            // SAFETY: an error of the program, which the driver reports.
            unsafe { ctx.driver.gl.accum(name, value) };
            return;
        }
    };
    if !is_ours(ctx) || !ctx.reads_redirected() {
        // SAFETY: the program's own call.
        unsafe { ctx.driver.gl.accum(name, value) };
        return;
    }
    if ctx.app.picking() || ctx.app.discard() {
        return;
    }
    ctx.note_drawn();
    let parts = parts(&ctx.app, &ctx.drawable);
    with(ctx, |ctx, buffer| {
        if let Some(target) = ctx.drawable.target_mut().filter(|_| operation == Operation::Return) {
            target.content.forget();
        }
        let Some(target) = ctx.drawable.target() else { return };
        if operation != Operation::Return {
            target.resolve(&ctx.driver, &ctx.app, &ctx.drawable, None);
        }
        buffer.operate(ctx.driver.gl, operation, value, target.readable().texture(), target.framebuffer(), &parts);
    });
}

/// `glClear` of the accumulation buffer.
pub fn clear(ctx: &mut Context) {
    if !is_ours(ctx) || ctx.app.picking() || ctx.app.discard() {
        return;
    }
    let mut colour = [0.0f32; 4];
    // SAFETY: writes four floats.
    unsafe { ctx.driver.gl.get_floatv(api::GL_ACCUM_CLEAR_VALUE, colour.as_mut_ptr()) };
    let parts = parts(&ctx.app, &ctx.drawable);
    with(ctx, |ctx, buffer| buffer.clear(ctx.driver.gl, colour, &parts));
}

hooks! {
    "glAccum" accum(operation: u32, value: f32) = |ctx, _gl|
        list_recording::now_or_later(ctx, move |ctx| accumulate(ctx, operation, value));
}
