//! Answers to a program's questions about its state. They give the state that the program set, not
//! the state that a view needs.

use super::wide_projection;
use crate::backend::gl::driver::api;
use crate::correct::LowerLeftRect;
use crate::intercept::gl::context::gl_context::Context;
use crate::intercept::gl::context::hooks::hooks;
use crate::intercept::gl::state::compat::Compat;

/// Returns up to four numbers that answer `glGet` for state that Cupola follows, and how many of
/// them count.
fn app_state_answer(ctx: &mut Context, name: u32) -> Option<([f64; 4], usize)> {
    let four = |rect: LowerLeftRect| Some((rect.to_array().map(f64::from), 4));
    let one = |v: f64| Some(([v, 0.0, 0.0, 0.0], 1));
    match (name, ctx.lists.recording()) {
        // In between, the driver compiles lists of Cupola instead of the program's.
        (api::GL_LIST_INDEX, Some(recording)) => return one(recording.list().into()),
        (api::GL_LIST_MODE, Some(recording)) if recording.executes() => return one(api::GL_COMPILE_AND_EXECUTE.into()),
        _ => {}
    }
    ctx.drawable.target()?;
    match name {
        api::GL_VIEWPORT => Some((ctx.app.viewport_at(0).to_array().map(f64::from), 4)),
        api::GL_SCISSOR_BOX => four(ctx.app.scissor()),
        api::GL_SCISSOR_TEST => one(f64::from(u8::from(ctx.app.scissor_test()))),
        api::GL_DRAW_FRAMEBUFFER_BINDING => one(ctx.app.draw_framebuffer().into()),
        api::GL_READ_FRAMEBUFFER_BINDING => one(ctx.app.read_framebuffer().into()),
        api::GL_DRAW_BUFFER if ctx.redirected() => one(ctx.app.buffers().draw()[0].into()),
        api::GL_DRAW_BUFFER0..=api::GL_DRAW_BUFFER15 if ctx.redirected() => {
            one(ctx.app.buffers().draw()[(name - api::GL_DRAW_BUFFER0) as usize].into())
        }
        api::GL_READ_BUFFER if ctx.reads_redirected() => one(ctx.app.buffers().read().into()),
        api::GL_NUM_PROGRAM_BINARY_FORMATS => one(0.0),
        // Without formats there is no number to return.
        api::GL_PROGRAM_BINARY_FORMATS => Some(([0.0; 4], 0)),
        _ if ctx.app.draw_framebuffer() == 0 => {
            let config = ctx.drawable.target()?.config();
            match name {
                api::GL_DOUBLEBUFFER => one(f64::from(u8::from(config.double_buffered))),
                api::GL_STEREO => one(0.0),
                api::GL_SAMPLES => one(config.samples.into()),
                api::GL_SAMPLE_BUFFERS => one(f64::from(u8::from(config.samples > 0))),
                api::GL_ALPHA_BITS => one(config.alpha_bits.into()),
                api::GL_DEPTH_BITS => one(config.depth_bits.into()),
                api::GL_STENCIL_BITS => one(config.stencil_bits.into()),
                api::GL_ACCUM_RED_BITS
                | api::GL_ACCUM_GREEN_BITS
                | api::GL_ACCUM_BLUE_BITS
                | api::GL_ACCUM_ALPHA_BITS => one(config.accumulation_bits.into()),
                _ => None,
            }
        }
        _ => None,
    }
}

/// Returns the place of a raster position of the driver in the program's window.
fn raster_position(compat: &Compat, [x, y, _, _]: [f64; 4]) -> [f64; 2] {
    let [left, bottom] = compat.raster_origin().map(f64::from);
    [x - left, y - bottom]
}

/// True if the driver answers a question. `ask` asks the question, with room for the answer. A
/// driver that does not have the state reports an error and writes nothing; then Cupola gives no
/// answer either.
pub(super) fn is_answered<T>(ask: impl FnOnce(*mut T)) -> bool {
    const UNUSED: u64 = 0xa5a5_a5a5_a5a5_a5a5;
    let mut room = [UNUSED; 64];
    ask(room.as_mut_ptr().cast());
    let [first, ..] = room;
    // The types of answers have at most eight bytes.
    let unused = u64::MAX >> (64 - 8 * size_of::<T>());
    (first ^ UNUSED) & unused != 0
}

macro_rules! getters {
    ($( $name:literal $method:ident $t:ty, $convert:expr; )*) => {
        hooks! {
            $( $name $method(name: u32, values: *mut $t) = |ctx, gl| {
                if values.is_null() {
                    gl.$method(name, values);
                } else if name == api::GL_CURRENT_RASTER_POSITION && ctx.drawable.target().is_some() {
                    let answered = is_answered(|room: *mut $t| gl.$method(name, room));
                    gl.$method(name, values);
                    if answered && ctx.compat.raster_origin() != [0; 2] {
                        let mut position = [0.0; 4];
                        gl.get_doublev(name, position.as_mut_ptr());
                        for (i, value) in raster_position(&ctx.compat, position).into_iter().enumerate() {
                            *values.add(i) = $convert(value);
                        }
                    }
                } else if let Some(matrix) = wide_projection::answer(&ctx.drawable, &mut ctx.compat, gl, name) {
                    for (i, value) in matrix.to_cols_array().into_iter().enumerate() {
                        *values.add(i) = $convert(value);
                    }
                } else if let Some((answer, count)) = app_state_answer(ctx, name) {
                    if !is_answered(|room: *mut $t| gl.$method(name, room)) {
                        return;
                    }
                    for (i, value) in answer.into_iter().take(count).enumerate() {
                        *values.add(i) = $convert(value);
                    }
                } else {
                    gl.$method(name, values);
                }
            }; )*
            "glIsEnabled" is_enabled(cap: u32) -> u8 = |ctx, gl| {
                if cap == api::GL_SCISSOR_TEST && ctx.drawable.target().is_some() { u8::from(ctx.app.scissor_test()) } else { gl.is_enabled(cap) }
            };
        }
    };
}

getters! {
    "glGetIntegerv" get_integerv i32, |v: f64| v.round() as i32;
    "glGetInteger64v" get_integer64v i64, |v: f64| v.round() as i64;
    "glGetFloatv" get_floatv f32, |v: f64| v as f32;
    "glGetDoublev" get_doublev f64, |v: f64| v;
    "glGetBooleanv" get_booleanv u8, |v: f64| u8::from(v != 0.0);
}
