//! Viewports and scissors by index (OpenGL 4.1): the first is the one that views are made of.
//!
//! The others are passed on as they are; a view's own viewport replaces them all while the window is drawn.

use crate::backend::gl::api;
use crate::correct::LowerLeftRect;
use crate::intercept::gl::app_state::getters::is_answered;
use crate::intercept::gl::app_state::known_state;
use crate::intercept::gl::app_state::window_state::{set_program_scissor, set_program_viewport, set_scissor_test};
use crate::intercept::gl::context::gl_context::Context;
use crate::intercept::gl::context::hooks::hooks;

/// Whether `count` rectangles have sizes that OpenGL takes; else the program gets its error, and nothing is set.
///
/// # Safety
/// `v` must be null or point at so many rectangles.
unsafe fn takes<T: Copy + PartialOrd + Default>(ctx: &mut Context, count: i32, v: *const T) -> bool {
    let rectangles = usize::try_from(count).unwrap_or(0);
    let size = |i: usize| {
        // SAFETY: as promised.
        unsafe { [*v.add(4 * i + 2), *v.add(4 * i + 3)] }
    };
    let takes = v.is_null() || (0..rectangles).all(|i| size(i).into_iter().all(|side| side >= T::default()));
    if !takes {
        ctx.driver.note_error(api::GL_INVALID_VALUE);
    }
    takes
}

/// The first viewport from its four numbers, rounded like a driver does that has no fractions.
fn first_viewport(ctx: &mut Context, numbers: [f32; 4]) {
    set_program_viewport(ctx, numbers.map(|v| v.round() as i32).into());
}

hooks! {
    "glViewportIndexedf" viewport_indexedf(index: u32, x: f32, y: f32, width: f32, height: f32) = |ctx, gl| {
        if index == 0 {
            if !takes(ctx, 1, [x, y, width, height].as_ptr()) {
                return;
            }
            first_viewport(ctx, [x, y, width, height]);
        }
        if index != 0 || !ctx.redirected() {
            gl.viewport_indexedf(index, x, y, width, height);
        }
    };
    "glViewportIndexedfv" viewport_indexedfv(index: u32, v: *const f32) = |ctx, gl| {
        if index == 0 && !v.is_null() {
            if !takes(ctx, 1, v) {
                return;
            }
            first_viewport(ctx, *v.cast::<[f32; 4]>());
        }
        if index != 0 || !ctx.redirected() {
            gl.viewport_indexedfv(index, v);
        }
    };
    "glViewportArrayv" viewport_arrayv(first: u32, count: i32, v: *const f32) = |ctx, gl| {
        if first == 0 && count > 0 && !v.is_null() {
            if !takes(ctx, count, v) {
                return;
            }
            first_viewport(ctx, *v.cast::<[f32; 4]>());
        }
        if first != 0 || !ctx.redirected() {
            gl.viewport_arrayv(first, count, v);
        } else if count > 1 {
            gl.viewport_arrayv(1, count - 1, v.add(4));
        }
    };
    "glScissorIndexed" scissor_indexed(index: u32, x: i32, y: i32, width: i32, height: i32) = |ctx, gl| {
        if index == 0 && width >= 0 && height >= 0 {
            set_program_scissor(ctx, LowerLeftRect::new(x, y, width, height));
        } else {
            gl.scissor_indexed(index, x, y, width, height);
        }
    };
    "glScissorIndexedv" scissor_indexedv(index: u32, v: *const i32) = |ctx, gl| {
        if index == 0 && !v.is_null() {
            if !takes(ctx, 1, v) {
                return;
            }
            set_program_scissor(ctx, (*v.cast::<[i32; 4]>()).into());
        } else {
            gl.scissor_indexedv(index, v);
        }
    };
    "glScissorArrayv" scissor_arrayv(first: u32, count: i32, v: *const i32) = |ctx, gl| {
        if first != 0 || count < 1 || v.is_null() {
            gl.scissor_arrayv(first, count, v);
        } else if takes(ctx, count, v) {
            set_program_scissor(ctx, (*v.cast::<[i32; 4]>()).into());
            if count > 1 {
                gl.scissor_arrayv(1, count - 1, v.add(4));
            }
        }
    };
    "glEnablei" enablei(cap: u32, index: u32) = |ctx, gl| {
        if cap == api::GL_SCISSOR_TEST && index == 0 { set_scissor_test(ctx, true) } else { gl.enablei(cap, index) }
        known_state::note(ctx, |known| known.forget_switch(cap));
    };
    "glDisablei" disablei(cap: u32, index: u32) = |ctx, gl| {
        if cap == api::GL_SCISSOR_TEST && index == 0 { set_scissor_test(ctx, false) } else { gl.disablei(cap, index) }
        known_state::note(ctx, |known| known.forget_switch(cap));
    };
    "glIsEnabledi" is_enabledi(cap: u32, index: u32) -> u8 = |ctx, gl| {
        let ours = cap == api::GL_SCISSOR_TEST && index == 0 && ctx.drawable.target().is_some();
        if ours { u8::from(ctx.app.scissor_test) } else { gl.is_enabledi(cap, index) }
    };
    "glGetIntegeri_v" get_integeri_v(name: u32, index: u32, values: *mut i32) = |ctx, gl| {
        match believed(ctx, name, index).filter(|_| !values.is_null()) {
            Some(rect) if is_answered(|room: *mut i32| gl.get_integeri_v(name, index, room)) => {
                *values.cast::<[i32; 4]>() = rect.to_array();
            }
            Some(_) => {}
            None => gl.get_integeri_v(name, index, values),
        }
    };
    "glGetInteger64i_v" get_integer64i_v(name: u32, index: u32, values: *mut i64) = |ctx, gl| {
        match believed(ctx, name, index).filter(|_| !values.is_null()) {
            Some(rect) if is_answered(|room: *mut i64| gl.get_integer64i_v(name, index, room)) => {
                *values.cast::<[i64; 4]>() = rect.to_array().map(i64::from);
            }
            Some(_) => {}
            None => gl.get_integer64i_v(name, index, values),
        }
    };
    "glGetFloati_v" get_floati_v(name: u32, index: u32, values: *mut f32) = |ctx, gl| {
        match believed(ctx, name, index).filter(|_| !values.is_null()) {
            Some(rect) if is_answered(|room: *mut f32| gl.get_floati_v(name, index, room)) => {
                *values.cast::<[f32; 4]>() = rect.to_array().map(|v| v as f32);
            }
            Some(_) => {}
            None => gl.get_floati_v(name, index, values),
        }
    };
    "glGetDoublei_v" get_doublei_v(name: u32, index: u32, values: *mut f64) = |ctx, gl| {
        match believed(ctx, name, index).filter(|_| !values.is_null()) {
            Some(rect) if is_answered(|room: *mut f64| gl.get_doublei_v(name, index, room)) => {
                *values.cast::<[f64; 4]>() = rect.to_array().map(f64::from);
            }
            Some(_) => {}
            None => gl.get_doublei_v(name, index, values),
        }
    };
}

fn believed(ctx: &Context, name: u32, index: u32) -> Option<LowerLeftRect> {
    match name {
        _ if index != 0 || ctx.drawable.target().is_none() => None,
        api::GL_VIEWPORT => Some(ctx.app.viewport),
        api::GL_SCISSOR_BOX => Some(ctx.app.scissor),
        _ => None,
    }
}
