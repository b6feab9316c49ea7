//! Begin/End: recorded, and then issued like any other draw.
//!
//! While the program is between Begin and End the driver is, too, but gets no vertices: so it says the
//! program's errors as it would without us. What cannot be played back (elements of arrays, display lists
//! in between) is compiled into a list of the driver's instead.

use crate::backend::gl::api::{self, Gl};
use crate::intercept::gl::context::gl_context::Context;
use crate::intercept::gl::context::hooks::hooks;
use crate::intercept::gl::context::list_recording::{ListState, Primitive};
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

/// What cannot be played back is coming: from here on, and with what came already, a list is compiled.
pub fn into_list(ctx: &mut Context) {
    if ctx.compat.immediate.phase == Phase::Recording && ctx.lists.recording.is_some() {
        give_to_list(ctx);
    }
    if ctx.compat.immediate.phase == Phase::Recording {
        let gl = ctx.driver.gl;
        // SAFETY: the driver is between Begin and End, where it can neither be asked nor compile.
        unsafe { gl.end() };
        let current = Current::get(gl, [true; 3]);
        begin_list(ctx);
        let immediate = &ctx.compat.immediate;
        // SAFETY: the program's own commands, into the list that is compiled.
        unsafe {
            current.set(gl);
            gl.begin(immediate.mode);
            immediate.recorder.play(gl);
        }
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

/// The mode of separate primitives that has the same errors as `mode`. The driver is between Begin and End in it, without
/// vertices: of strips, fans and polygons Mesa drops what follows an empty one of the same mode.
fn list_of(mode: u32) -> u32 {
    match mode {
        api::GL_LINE_LOOP | api::GL_LINE_STRIP => api::GL_LINES,
        api::GL_TRIANGLE_STRIP | api::GL_TRIANGLE_FAN | api::GL_QUAD_STRIP | api::GL_POLYGON => api::GL_TRIANGLES,
        api::GL_LINE_STRIP_ADJACENCY => api::GL_LINES_ADJACENCY,
        api::GL_TRIANGLE_STRIP_ADJACENCY => api::GL_TRIANGLES_ADJACENCY,
        _ => mode,
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
    recording.primitive.begin(ctx.compat.immediate.mode);
    ctx.compat.immediate.phase = Phase::Outside;
    // SAFETY: the program's own commands, into the list that the driver compiles.
    unsafe {
        ctx.driver.gl.begin(ctx.compat.immediate.mode);
        ctx.compat.immediate.recorder.play(ctx.driver.gl);
    }
}

/// Runs a part of a list of the program that begins or ends a primitive, or lies inside of one.
pub(super) fn run_part(ctx: &mut Context, list: u32, primitive: Primitive) {
    let gl = ctx.driver.gl;
    if let (false, Some(mode)) = (ctx.compat.immediate.under_way(), primitive.within) {
        if ctx.session().is_none() || ctx.app.picking {
            plain_program(ctx);
            // SAFETY: the program's own call.
            unsafe { gl.call_list(list) };
            return;
        }
        // What comes until the End is one draw, with this list.
        ctx.compat.immediate.begin(mode);
        ctx.compat.immediate.bounds.add_unknown();
        begin_list(ctx);
    }
    // SAFETY: the program's own call, into the list that is compiled.
    unsafe { gl.call_list(list) };
    ctx.compat.immediate.bounds.add_unknown();
    ctx.compat.immediate.trailing = ctx.compat.immediate.recorder.place();
    if let (true, None) = (primitive.ends, primitive.within) {
        ctx.compat.immediate.phase = Phase::Outside;
        issue_list(ctx);
    }
}

/// Begins the list of ours that stands for a Begin/End.
fn begin_list(ctx: &mut Context) {
    if ctx.compat.immediate.list == 0 {
        ctx.compat.immediate.list = list_recording::own_name(ctx);
    }
    // SAFETY: the list is ours, and ends with the program's End; the driver is outside of Begin and End.
    unsafe { ctx.driver.gl.new_list(ctx.compat.immediate.list, api::GL_COMPILE) };
    ctx.compat.immediate.phase = Phase::IntoList;
}

/// Issues the list that stands for a Begin/End. What is current afterwards is what the program set last, but a
/// list that ends with an attribute after its last vertex leaves something else on Mesa: it is set again.
fn issue_list(ctx: &mut Context) {
    let (list, bounds, trailing) =
        (ctx.compat.immediate.list, ctx.compat.immediate.bounds, ctx.compat.immediate.trailing);
    ctx.draw.wide_primitives.shape = Shape::of_mode(ctx.compat.immediate.mode);
    // SAFETY: the list of ours that is being compiled.
    unsafe { ctx.driver.gl.end_list() };
    // SAFETY: as above.
    draw(ctx, Changes::Attributes, |_| bounds, |_, gl| unsafe { gl.call_list(list) });
    // SAFETY: attributes of the program's.
    unsafe { ctx.compat.immediate.recorder.play_attributes(ctx.driver.gl, trailing) };
}

hooks! {
    between;
    "glBegin" begin(mode: u32) = |ctx, gl| {
        if !ctx.driver.profile.compatibility() {
            // The driver refuses it.
        } else if is_kept_apart(&ctx.lists, &ctx.projected) && !ctx.compat.immediate.under_way() && mode <= api::GL_POLYGON {
            ctx.compat.immediate.begin(mode);
            return;
        } else if ctx.lists.recording.is_some() {
            list_recording::will_draw(ctx, false);
            if let Some(recording) = &mut ctx.lists.recording {
                recording.primitive.begin(mode);
            }
        } else if ctx.session().is_none() || ctx.app.picking {
            plain_program(ctx);
        } else if !ctx.compat.immediate.under_way() && mode <= api::GL_PATCHES {
            ctx.compat.immediate.begin(mode);
            gl.begin(list_of(mode));
            return;
        }
        gl.begin(mode);
    };
    "glGetError" get_error() -> u32 = |ctx, gl| {
        match ctx.compat.immediate.phase {
            Phase::Outside => ctx.driver.error(),
            Phase::Recording => gl.get_error(),
            // It is not allowed here, but the driver, which compiles, would answer.
            Phase::IntoList => {
                ctx.driver.note_error(api::GL_INVALID_OPERATION);
                api::GL_NO_ERROR
            }
        }
    };
    "glEnd" end() = |ctx, gl| {
        if ctx.lists.recording.is_some() && ctx.compat.immediate.phase == Phase::Recording {
            ctx.compat.immediate.phase = Phase::Outside;
            keep_apart(ctx);
            return;
        }
        gl.end();
        if let Some(recording) = &mut ctx.lists.recording {
            recording.primitive.end();
        }
        match std::mem::take(&mut ctx.compat.immediate.phase) {
            Phase::Outside => {}
            Phase::Recording => issue_recorded(ctx),
            Phase::IntoList => issue_list(ctx),
        }
    };
}
