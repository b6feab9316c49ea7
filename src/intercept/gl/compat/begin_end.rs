//! Begin/End: the commands are recorded, and then issued like any other draw.
//!
//! While the program is between Begin and End the driver is too, but gets no vertices. So the
//! driver reports the program's errors as usual. Display lists are called when the draw is issued.
//! Array elements (`glArrayElement`) are compiled into lists of Cupola, which are called then too.
//! Begin or End may be part of a display list of the program.

use crate::backend::gl::driver::api::{self, Gl};
use crate::intercept::gl::context::gl_context::Context;
use crate::intercept::gl::context::hooks::hooks;
use crate::intercept::gl::context::list_recording::{ListState, Primitive};
use crate::intercept::gl::context::{list_recording, methods};
use crate::intercept::gl::draw::divided;
use crate::intercept::gl::draw::routing::draw;
use crate::intercept::gl::per_view::issue::plain_program;
use crate::intercept::gl::per_view::window_space::program_window_space;
use crate::intercept::gl::projected_vertices::{self, Attribute};
use crate::intercept::gl::state::compat::Compat;
use crate::intercept::gl::state::compat::begin_end::{Phase, list_of};
use crate::intercept::gl::state::compat::vertex_recorder::Recorder;
use crate::intercept::gl::state::draw::bounds::Bounds;
use crate::intercept::gl::state::draw::draw_class::Changes;
use crate::intercept::gl::state::draw::primitives::Shape;
use crate::intercept::gl::state::driver::Driver;
use crate::intercept::gl::state::projected_vertices::ProjectedVertices;

/// Prepares for an array element, or a command that belongs to it: the driver compiles it next,
/// into a display list of Cupola.
pub fn note_element(ctx: &mut Context) {
    leave_to_list(ctx);
    if let Some(list) = &mut ctx.lists.recording {
        list.bounds.add_unknown();
    }
    if ctx.compat.immediate.phase == Phase::Recording {
        // SAFETY: ends the driver's own Begin/End, since the driver creates no lists there.
        unsafe { ctx.driver.gl.end() };
        if ctx.compat.immediate.used_lists == ctx.compat.immediate.lists.len() {
            let name = list_recording::own_name(&ctx.share, &ctx.driver);
            ctx.compat.immediate.lists.push(name);
        }
        let immediate = &mut ctx.compat.immediate;
        immediate.bounds.add_unknown();
        immediate.phase = Phase::Elements;
        let list = immediate.lists.get(immediate.used_lists).copied().unwrap_or_default();
        // SAFETY: the driver compiles a list of Cupola; `close_elements` ends the list.
        unsafe { ctx.driver.gl.new_list(list, api::GL_COMPILE) };
    }
}

/// Records the call of a display list of the driver between Begin and End.
pub fn note_list(driver: &Driver, compat: &mut Compat, list: u32) {
    compat.immediate.close_elements(driver.gl);
    compat.immediate.bounds.add_unknown();
    compat.immediate.recorder.push_list(list);
}

/// Moves the recorded commands to the display list that the program compiles, if there is one. The
/// commands that follow go there directly.
pub fn leave_to_list(ctx: &mut Context) {
    if ctx.compat.immediate.under_way() && ctx.lists.recording.is_some() {
        give_to_list(ctx);
    }
}

/// Current colour, normal and texture coordinate; `None` for those that are not needed.
struct Current([Option<[f32; 4]>; 3]);

impl Current {
    const ATTRIBUTES: [Attribute; 3] = [Attribute::Color, Attribute::Normal, Attribute::Texture(0)];

    fn get(gl: &Gl, wanted: [bool; 3]) -> Self {
        Self(std::array::from_fn(|i| wanted[i].then(|| Self::ATTRIBUTES[i].current(gl))))
    }

    /// Restores the current values. Before the first vertex also sets values that are current
    /// already: if an attribute changes only after some vertices, Mesa gives these vertices a wrong
    /// value unless the attribute was set before them.
    fn set(&self, gl: &Gl) {
        for (attribute, value) in Self::ATTRIBUTES.iter().zip(&self.0) {
            if let Some(value) = value {
                // SAFETY: the program calls glBegin, so that it has the fixed-function pipeline.
                unsafe { attribute.set(gl, value) };
            }
        }
    }
}

/// True for Begin and End if the command is issued here. Otherwise a recorded display list contains
/// it.
#[derive(Clone, Copy)]
struct Own {
    begin: bool,
    end: bool,
}

/// Issues the commands that were recorded between Begin and End.
fn issue(ctx: &mut Context, mode: u32, own: Own, bounds: Bounds, recorder: &Recorder) {
    ctx.draw.note_shape(Shape::of_mode(mode));
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
            if own.begin {
                gl.begin(mode);
            }
            current.set(gl);
            recorder.play(gl);
            if own.end {
                gl.end();
            }
        }
    };
    if recorder.has_lists() || !projected_vertices::reads_vertices(&ctx.app, &ctx.drawable, &ctx.shaders, mode) {
        draw(ctx, changes, |_| bounds, whole);
        return;
    }
    let vertices = projected_vertices::Vertices::of_recorded(ctx.driver.gl, mode, recorder);
    // SAFETY: the program's own attributes. A material applies to all vertices; all other
    // attributes are set with each vertex.
    unsafe { recorder.play_attributes(ctx.driver.gl, 0) };
    divided::draw_read(ctx, changes, bounds, &vertices, whole);
    // SAFETY: as above. The draw has set other values between the vertices.
    unsafe { recorder.play_attributes(ctx.driver.gl, 0) };
}

/// Issues the commands that were recorded since Begin. `own_end`: End is issued here, it is not
/// part of a display list.
fn issue_recorded(ctx: &mut Context, own_end: bool) {
    let immediate = &mut ctx.compat.immediate;
    immediate.phase = Phase::Outside;
    let own = Own { begin: !immediate.begun_by_list, end: own_end };
    let (mode, bounds, recorder) = (immediate.mode, immediate.bounds, std::mem::take(&mut immediate.recorder));
    issue(ctx, mode, own, bounds, &recorder);
    ctx.compat.immediate.recorder = recorder;
}

/// True if Begin/End becomes an item of its own in the display list that is being compiled, so that
/// its primitives can be divided when the list runs.
fn is_kept_apart(lists: &ListState, projected: &ProjectedVertices) -> bool {
    lists.recording.is_some() && !projected.views_only() && methods::division_asked_for()
}

/// Adds the recorded commands to the display list that is being compiled, as one item.
fn keep_apart(ctx: &mut Context) {
    let (mode, bounds) = (ctx.compat.immediate.mode, ctx.compat.immediate.bounds);
    let recorder = std::mem::take(&mut ctx.compat.immediate.recorder);
    let own = Own { begin: true, end: true };
    list_recording::now_or_later(ctx, move |ctx| issue(ctx, mode, own, bounds, &recorder));
}

/// Moves the recorded commands to the display list that is being compiled. The commands until the
/// program's End go there directly.
fn give_to_list(ctx: &mut Context) {
    list_recording::will_draw(&ctx.share, &ctx.driver, &mut ctx.lists, false);
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

/// Runs a part of a display list of the program that begins or ends a primitive, or lies inside
/// one.
pub(super) fn run_part(ctx: &mut Context, list: u32, primitive: Primitive) {
    let gl = ctx.driver.gl;
    if let (false, Some(mode)) = (ctx.compat.immediate.under_way(), primitive.within) {
        if ctx.session().is_none() || ctx.app.picking() {
            program_window_space(&mut ctx.draw);
            plain_program(ctx);
            ctx.compat.immediate.passed_on = true;
            // SAFETY: the program's own call.
            unsafe { gl.call_list(list) };
            return;
        }
        // All commands until End are one draw, together with this list.
        ctx.compat.immediate.begin(mode, ctx.driver.profile.generic_attributes);
        ctx.compat.immediate.begun_by_list = true;
        // SAFETY: brings the driver between Begin and End, where the program is.
        unsafe { gl.begin(list_of(mode)) };
    }
    note_list(&ctx.driver, &mut ctx.compat, list);
    if (primitive.ends, primitive.within) == (true, None) {
        // SAFETY: ends the driver's own Begin/End.
        unsafe { gl.end() };
        issue_recorded(ctx, false);
    }
}

hooks! {
    between;
    "glBegin" begin(mode: u32) = |ctx, gl| {
        if ctx.app.draw_framebuffer() != 0
            && !ctx.compiling()
            && gl.check_framebuffer_status(api::GL_DRAW_FRAMEBUFFER) != api::GL_FRAMEBUFFER_COMPLETE
        {
            // The driver refuses the command.
        } else if is_kept_apart(&ctx.lists, &ctx.projected) && !ctx.compat.immediate.under_way() && mode <= api::GL_POLYGON {
            ctx.compat.immediate.begin(mode, ctx.driver.profile.generic_attributes);
            ctx.compat.immediate.apart = true;
            return;
        } else if ctx.lists.recording.is_some() {
            list_recording::will_draw(&ctx.share, &ctx.driver, &mut ctx.lists, false);
            if let Some(recording) = &mut ctx.lists.recording {
                recording.primitive.begin(mode);
            }
        } else if ctx.session().is_none() || ctx.app.picking() {
            program_window_space(&mut ctx.draw);
            plain_program(ctx);
            ctx.compat.immediate.passed_on = true;
        } else if !ctx.compat.immediate.under_way() && mode <= api::GL_PATCHES {
            ctx.compat.immediate.begin(mode, ctx.driver.profile.generic_attributes);
            gl.begin(list_of(mode));
            return;
        }
        gl.begin(mode);
    };
    "glGetError" get_error() -> u32 = |ctx, gl| {
        ctx.compat.immediate.close_elements(gl);
        if !ctx.compat.immediate.under_way() {
            // After a Begin that went to the driver as it was, the driver is asked: it returns none.
            return if ctx.compat.immediate.refuses(gl) { gl.get_error() } else { ctx.driver.error() };
        }
        // Between Begin and End this call is an error, and should return none.
        let error = gl.get_error();
        if error != api::GL_NO_ERROR {
            ctx.compat.immediate.refuses(gl);
        }
        error
    };
    "glEnd" end() = |ctx, gl| {
        if ctx.lists.recording.is_some() && ctx.compat.immediate.phase == Phase::Recording {
            ctx.compat.immediate.phase = Phase::Outside;
            keep_apart(ctx);
            return;
        }
        ctx.compat.immediate.close_elements(gl);
        gl.end();
        ctx.compat.immediate.passed_on = false;
        if let Some(recording) = &mut ctx.lists.recording {
            recording.primitive.end();
        }
        if ctx.compat.immediate.under_way() {
            issue_recorded(ctx, true);
        }
    };
}
