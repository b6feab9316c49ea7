//! Viewports and scissors by index (OpenGL 4.1).
//!
//! Views are made of the viewport and scissor of index 0. If the others differ, draws of programs
//! that choose one by its index are flat.

use crate::backend::gl::driver::api;
use crate::correct::LowerLeftRect;
use crate::intercept::gl::app_state::getters::is_answered;
use crate::intercept::gl::app_state::known_state;
use crate::intercept::gl::app_state::window_state::follow_viewport;
use crate::intercept::gl::context::gl_context::Context;
use crate::intercept::gl::context::hooks::hooks;
use crate::intercept::gl::context::list_recording::now_or_later;
use crate::intercept::gl::state::app::AppState;
use crate::intercept::gl::state::app::window_arrays::{self, Viewport, WindowArrays};
use crate::intercept::gl::state::drawable::Drawable;
use crate::intercept::gl::state::driver::Driver;
use crate::intercept::gl::state::driver::profile::ViewportLimits;

/// Returns the rectangles of a call, for the indices from `first` on. `None`: the driver gets the
/// call unchanged, as it refuses the rectangles or Cupola does not follow these indices.
///
/// # Safety
/// `numbers` must be null or point at four numbers for each of `count` rectangles.
unsafe fn rectangles<T: Copy + PartialOrd + Default, R: From<[T; 4]>>(
    ctx: &Context,
    first: u32,
    count: i32,
    numbers: *const T,
) -> Option<Vec<R>> {
    let count = usize::try_from(count).ok()?;
    if !ctx.driver.profile.viewport_arrays
        || numbers.is_null()
        || (first as usize).checked_add(count)? > window_arrays::COUNT
    {
        return None;
    }
    // SAFETY: as promised.
    let rectangles = unsafe { std::slice::from_raw_parts(numbers.cast::<[T; 4]>(), count) };
    let has_size = |[_, _, width, height]: &[T; 4]| *width >= T::default() && *height >= T::default();
    rectangles.iter().all(has_size).then(|| rectangles.iter().map(|numbers| R::from(*numbers)).collect())
}

/// Changes viewports and scissors of the program: now or, while a list is being compiled, each time
/// that list runs.
fn change(ctx: &mut Context, change: impl Fn(&mut WindowArrays) + Send + Sync + 'static) {
    now_or_later(ctx, move |ctx| {
        ctx.app.change_arrays(&change);
        follow_viewport(ctx);
        if !ctx.redirected() {
            ctx.restore_window_space();
        }
    });
}

fn set_viewports(ctx: &mut Context, first: u32, mut viewports: Vec<Viewport>) {
    let ViewportLimits { edge: [least, most], size: [widest, highest] } = ctx.driver.profile.viewport_limits;
    for Viewport { x, y, width, height } in &mut viewports {
        // The driver limits the numbers that it stores in the same way. `max` and `min` return the
        // bound for NaN.
        (*x, *y) = (x.max(least).min(most), y.max(least).min(most));
        (*width, *height) = (width.min(widest), height.min(highest));
    }
    change(ctx, move |arrays| {
        for (own, viewport) in arrays.viewports.iter_mut().skip(first as usize).zip(&viewports) {
            *own = *viewport;
        }
    });
}

fn set_scissors(ctx: &mut Context, first: u32, scissors: Vec<LowerLeftRect>) {
    change(ctx, move |arrays| {
        for (own, scissor) in arrays.scissors.iter_mut().skip(first as usize).zip(&scissors) {
            *own = *scissor;
        }
    });
}

/// Returns `index` if `cap` is the scissor test and Cupola follows the test of this index.
fn scissor_test(driver: &Driver, cap: u32, index: u32) -> Option<usize> {
    let is_followed = |index: &usize| cap == api::GL_SCISSOR_TEST && *index < window_arrays::COUNT;
    Some(index as usize).filter(|index| is_followed(index) && driver.profile.viewport_arrays)
}

/// Answer to a program's question about a viewport or scissor by its index.
enum Answer {
    Viewport(Viewport),
    Scissor(LowerLeftRect),
}

impl Answer {
    fn numbers(&self) -> [f64; 4] {
        match self {
            Self::Viewport(viewport) => viewport.to_array().map(f64::from),
            Self::Scissor(scissor) => scissor.to_array().map(f64::from),
        }
    }
}

fn app_state_answer(app: &AppState, drawable: &Drawable, name: u32, index: u32) -> Option<Answer> {
    drawable.target()?;
    let index = Some(index as usize).filter(|index| *index < window_arrays::COUNT)?;
    match name {
        api::GL_VIEWPORT => Some(Answer::Viewport(app.viewport_at(index))),
        api::GL_SCISSOR_BOX => Some(Answer::Scissor(app.scissor_at(index))),
        _ => None,
    }
}

macro_rules! hooks_with_getters {
    ($( $name:literal $method:ident $t:ty, $convert:expr; )* ; $($hooks:tt)*) => {
        hooks! {
            $($hooks)*
            $( $name $method(name: u32, index: u32, values: *mut $t) = |ctx, gl| {
                match app_state_answer(&ctx.app, &ctx.drawable, name, index).filter(|_| !values.is_null()) {
                    Some(answer) if is_answered(|room: *mut $t| gl.$method(name, index, room)) => {
                        *values.cast::<[$t; 4]>() = answer.numbers().map($convert);
                    }
                    Some(_) => {}
                    None => gl.$method(name, index, values),
                }
            }; )*
        }
    };
}

hooks_with_getters! {
    "glGetIntegeri_v" get_integeri_v i32, |v| v.round() as i32;
    "glGetInteger64i_v" get_integer64i_v i64, |v| v.round() as i64;
    "glGetFloati_v" get_floati_v f32, |v| v as f32;
    "glGetDoublei_v" get_doublei_v f64, |v| v;
    ;
    "glViewportIndexedf" viewport_indexedf(index: u32, x: f32, y: f32, width: f32, height: f32) = |ctx, gl| {
        match rectangles(ctx, index, 1, [x, y, width, height].as_ptr()) {
            Some(viewports) => set_viewports(ctx, index, viewports),
            None => gl.viewport_indexedf(index, x, y, width, height),
        }
    };
    "glViewportIndexedfv" viewport_indexedfv(index: u32, v: *const f32) = |ctx, gl| {
        match rectangles(ctx, index, 1, v) {
            Some(viewports) => set_viewports(ctx, index, viewports),
            None => gl.viewport_indexedfv(index, v),
        }
    };
    "glViewportArrayv" viewport_arrayv(first: u32, count: i32, v: *const f32) = |ctx, gl| {
        match rectangles(ctx, first, count, v) {
            Some(viewports) => set_viewports(ctx, first, viewports),
            None => gl.viewport_arrayv(first, count, v),
        }
    };
    "glScissorIndexed" scissor_indexed(index: u32, x: i32, y: i32, width: i32, height: i32) = |ctx, gl| {
        match rectangles(ctx, index, 1, [x, y, width, height].as_ptr()) {
            Some(scissors) => set_scissors(ctx, index, scissors),
            None => gl.scissor_indexed(index, x, y, width, height),
        }
    };
    "glScissorIndexedv" scissor_indexedv(index: u32, v: *const i32) = |ctx, gl| {
        match rectangles(ctx, index, 1, v) {
            Some(scissors) => set_scissors(ctx, index, scissors),
            None => gl.scissor_indexedv(index, v),
        }
    };
    "glScissorArrayv" scissor_arrayv(first: u32, count: i32, v: *const i32) = |ctx, gl| {
        match rectangles(ctx, first, count, v) {
            Some(scissors) => set_scissors(ctx, first, scissors),
            None => gl.scissor_arrayv(first, count, v),
        }
    };
    "glEnablei" enablei(cap: u32, index: u32) = |ctx, gl| {
        match scissor_test(&ctx.driver, cap, index) {
            Some(index) => change(ctx, move |arrays| arrays.tests |= 1 << index),
            None => gl.enablei(cap, index),
        }
        known_state::note(ctx, |known| known.forget_switch(cap));
    };
    "glDisablei" disablei(cap: u32, index: u32) = |ctx, gl| {
        match scissor_test(&ctx.driver, cap, index) {
            Some(index) => change(ctx, move |arrays| arrays.tests &= !(1 << index)),
            None => gl.disablei(cap, index),
        }
        known_state::note(ctx, |known| known.forget_switch(cap));
    };
    "glIsEnabledi" is_enabledi(cap: u32, index: u32) -> u8 = |ctx, gl| {
        match scissor_test(&ctx.driver, cap, index).filter(|_| ctx.drawable.target().is_some()) {
            Some(index) => u8::from(ctx.app.scissor_test_at(index)),
            None => gl.is_enabledi(cap, index),
        }
    };
}
