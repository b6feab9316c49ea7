//! Begin/End: recorded, and then issued like any other draw.
//!
//! While the program is between Begin and End the driver is, too, but gets no vertices: so it says the
//! program's errors as it would without us. What cannot be played back (elements of arrays, display lists
//! in between) is compiled into a list of the driver's instead.

use crate::backend::gl::api::{self, Gl};
use crate::intercept::gl::compat::display_lists;
use crate::intercept::gl::context::gl_context::Context;
use crate::intercept::gl::context::hooks::hooks;
use crate::intercept::gl::context::list_recording::ListState;
use crate::intercept::gl::context::{list_recording, methods};
use crate::intercept::gl::draw::dispatch::draw;
use crate::intercept::gl::draw::divided;
use crate::intercept::gl::per_view::issue::plain_program;
use crate::intercept::gl::projected_vertices;
use crate::intercept::gl::state::compat::begin_end::Phase;
use crate::intercept::gl::state::compat::vertex_recorder::Recorder;
use crate::intercept::gl::state::draw::bounds::Bounds;
use crate::intercept::gl::state::draw::draw_class::Changes;
use crate::intercept::gl::state::draw::primitives::Shape;
use crate::intercept::gl::state::projected_vertices::ProjectedVertices;
use std::ffi::c_void;

/// What cannot be played back is coming: from here on, and with what came already, a list is compiled.
pub fn into_list(ctx: &mut Context) {
    if ctx.compat.immediate.phase == Phase::Recording && ctx.lists.recording.is_some() {
        give_to_list(ctx);
    }
    if ctx.compat.immediate.phase == Phase::Recording {
        // SAFETY: the driver is between Begin and End, where it can neither be asked nor compile.
        unsafe { ctx.driver.gl.end() };
        if ctx.compat.immediate.list == 0 {
            ctx.compat.immediate.list = list_recording::own_name(ctx);
        }
        let (gl, immediate) = (ctx.driver.gl, &mut ctx.compat.immediate);
        // SAFETY: the list is ours, and ends with the program's End.
        unsafe {
            let current = Current::get(gl, [true; 3]);
            gl.new_list(immediate.list, api::GL_COMPILE);
            current.set(gl);
            gl.begin(immediate.mode);
            immediate.recorder.play(gl);
        }
        immediate.phase = Phase::IntoList;
    }
    if ctx.compat.immediate.under_way() {
        ctx.compat.immediate.bounds.add_unknown();
        // An element, or a list, may set attributes itself: those that came before no longer hold.
        ctx.compat.immediate.trailing = ctx.compat.immediate.recorder.place();
    }
}

/// Colour, normal and texture coordinate, those that are wanted.
struct Current([Option<[f32; 4]>; 3]);

impl Current {
    fn get(gl: &Gl, wanted: [bool; 3]) -> Self {
        let names = [api::GL_CURRENT_COLOR, api::GL_CURRENT_NORMAL, api::GL_CURRENT_TEXTURE_COORDS];
        Self(std::array::from_fn(|i| {
            wanted[i].then(|| {
                let mut value = [0.0; 4];
                // SAFETY: writes four floats at most.
                unsafe { gl.get_floatv(names[i], value.as_mut_ptr()) };
                value
            })
        }))
    }

    /// Sets them to what they were. Before the first vertex also what is so already: Mesa gives vertices
    /// a wrong value of an attribute that comes only after them, unless it was set before them.
    fn set(&self, gl: &Gl) {
        let [color, normal, texture] = &self.0;
        // SAFETY: reads three or four floats.
        unsafe {
            if let Some(color) = color {
                gl.color4fv(color.as_ptr());
            }
            if let Some(normal) = normal {
                gl.normal3fv(normal.as_ptr());
            }
            if let Some(texture) = texture {
                gl.tex_coord4fv(texture.as_ptr());
            }
        }
    }
}

/// Issues what was recorded between Begin and End.
fn issue(ctx: &mut Context, mode: u32, bounds: Bounds, recorder: &Recorder) {
    ctx.draw.wide_primitives.shape = Shape::of_mode(mode);
    let current = Current::get(ctx.driver.gl, recorder.sets_late());
    let changes = if recorder.sets_others_late() {
        Changes::Attributes
    } else if recorder.sets_anything() {
        Changes::Alike
    } else {
        Changes::Nothing
    };
    let whole = |_: &mut Context, gl: &Gl| {
        // SAFETY: the program's own commands, outside of its Begin/End.
        unsafe {
            gl.begin(mode);
            current.set(gl);
            recorder.play(gl);
            gl.end();
        }
    };
    if !projected_vertices::reads_vertices(ctx, mode) {
        draw(ctx, changes, |_| bounds, whole);
        return;
    }
    let vertices = projected_vertices::Vertices::of_recorded(ctx.driver.gl, mode, recorder);
    // SAFETY: the program's own attributes: materials count for all vertices, all else is set with each of them.
    unsafe { recorder.play_attributes(ctx.driver.gl, 0) };
    divided::draw_read(ctx, changes, bounds, &vertices, whole);
    // SAFETY: as above; between vertices others were set.
    unsafe { recorder.play_attributes(ctx.driver.gl, 0) };
}

/// Issues what was recorded since `glBegin`.
fn issue_recorded(ctx: &mut Context) {
    let recorder = std::mem::take(&mut ctx.compat.immediate.recorder);
    issue(ctx, ctx.compat.immediate.mode, ctx.compat.immediate.bounds, &recorder);
    ctx.compat.immediate.recorder = recorder;
}

/// Whether Begin/End becomes a command of its own in the list that is compiled, so that it can be divided when the list runs.
fn is_kept_apart(lists: &ListState, projected: &ProjectedVertices) -> bool {
    lists.recording.is_some() && !projected.views_only && methods::division_asked_for()
}

/// What was recorded becomes a command of the list that is compiled.
fn keep_apart(ctx: &mut Context) {
    let (mode, bounds) = (ctx.compat.immediate.mode, ctx.compat.immediate.bounds);
    let recorder = std::mem::take(&mut ctx.compat.immediate.recorder);
    list_recording::now_or_later(ctx, move |ctx| issue(ctx, mode, bounds, &recorder));
}

/// What was recorded, and what comes until the program's End, goes into the list that is compiled as it is.
fn give_to_list(ctx: &mut Context) {
    list_recording::will_draw(ctx, false);
    let Some(recording) = &mut ctx.lists.recording else { return };
    recording.bounds.add_unknown();
    ctx.compat.immediate.phase = Phase::Outside;
    // SAFETY: the program's own commands, into the list that the driver compiles.
    unsafe {
        ctx.driver.gl.begin(ctx.compat.immediate.mode);
        ctx.compat.immediate.recorder.play(ctx.driver.gl);
    }
}

/// Issues the list that stands for a Begin/End. What is current afterwards is what the program set last, but a
/// list that ends with an attribute after its last vertex leaves something else on Mesa: it is set again.
fn issue_list(ctx: &mut Context) {
    let (list, bounds, trailing) =
        (ctx.compat.immediate.list, ctx.compat.immediate.bounds, ctx.compat.immediate.trailing);
    ctx.draw.wide_primitives.shape = Shape::of_mode(ctx.compat.immediate.mode);
    // SAFETY: a list of ours.
    draw(ctx, Changes::Attributes, |_| bounds, |_, gl| unsafe { gl.call_list(list) });
    // SAFETY: attributes of the program's.
    unsafe { ctx.compat.immediate.recorder.play_attributes(ctx.driver.gl, trailing) };
}

hooks! {
    between;
    "glBegin" begin(mode: u32) = |ctx, gl| {
        if is_kept_apart(&ctx.lists, &ctx.projected) && !ctx.compat.immediate.under_way() && mode <= api::GL_POLYGON {
            ctx.compat.immediate.begin(mode);
            return;
        } else if ctx.lists.recording.is_some() {
            list_recording::will_draw(ctx, false);
        } else if ctx.session().is_none() || ctx.app.picking {
            plain_program(ctx);
        } else if !ctx.compat.immediate.under_way() && mode <= api::GL_PATCHES {
            ctx.compat.immediate.begin(mode);
        }
        gl.begin(mode);
    };
    "glEnd" end() = |ctx, gl| {
        if ctx.lists.recording.is_some() && ctx.compat.immediate.phase == Phase::Recording {
            ctx.compat.immediate.phase = Phase::Outside;
            keep_apart(ctx);
            return;
        }
        gl.end();
        match std::mem::take(&mut ctx.compat.immediate.phase) {
            Phase::Outside => {}
            Phase::Recording => issue_recorded(ctx),
            Phase::IntoList => {
                gl.end_list();
                issue_list(ctx);
            }
        }
    };
    "glEndList" end_list() = |ctx, gl| {
        if ctx.lists.recording.is_some() {
            // A primitive whose end is in another list.
            into_list(ctx);
        }
        if ctx.compat.immediate.under_way() { gl.end_list() } else { display_lists::finish_recording(ctx) }
    };
    "glCallList" call_list(list: u32) = |ctx, gl| {
        if ctx.compat.immediate.under_way() {
            into_list(ctx);
            gl.call_list(list);
        } else {
            display_lists::call_list(ctx, list);
        }
    };
    "glCallLists" call_lists(count: i32, kind: u32, names: *const c_void) = |ctx, gl| {
        if ctx.compat.immediate.under_way() {
            into_list(ctx);
            gl.call_lists(count, kind, names);
        } else {
            display_lists::call_lists(ctx, count, kind, names);
        }
    };
}
