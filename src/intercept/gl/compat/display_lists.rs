//! Display lists: lists of the driver, and between them the commands that must not run once per
//! view.
//!
//! A list of the program becomes a sequence of items. Commands that only draw or set plain state
//! stay in lists of the driver, the first of which has the program's name. Commands that Cupola
//! follows (matrices, viewport, clears, nested lists …) are stored between these lists and run
//! through Cupola's hooks.

use crate::backend::gl::driver::api::{self, Gl};
use crate::intercept::gl::app_state::window_state;
use crate::intercept::gl::compat::{begin_end, matrices, raster_position};
use crate::intercept::gl::context::gl_context::Context;
use crate::intercept::gl::context::hooks::hooks;
use crate::intercept::gl::context::list_names;
use crate::intercept::gl::context::list_recording::{self, Command, Item, ListState, Primitive, Recording, record};
use crate::intercept::gl::draw::routing::draw;
use crate::intercept::gl::framebuffer::commands::{clears, draw_buffers};
use crate::intercept::gl::shader::program_use;
use crate::intercept::gl::state::draw::bounds::Bounds;
use crate::intercept::gl::state::draw::draw_class::Changes;
use crate::intercept::gl::state::driver::Driver;
use crate::lock::Lock;
use std::ffi::c_void;
use std::sync::Arc;

/// Greatest depth of lists that call lists: the least value that OpenGL allows for it.
const DEEPEST: u32 = 64;

/// Runs a list of the program. Between Begin and End its parts are recorded.
pub(super) fn call(ctx: &mut Context, list: u32, depth: u32) {
    if depth > DEEPEST {
        return;
    }
    let items = {
        let lists = ctx.share.lists.locked();
        lists.items.get(&list).cloned()
    };
    match items {
        None if ctx.compat.immediate.under_way() => {
            begin_end::note_list(&ctx.driver, &mut ctx.compat, list);
        }
        // A list that Cupola did not see compiled (a font of glXUseXFont, for example) may contain
        // any command.
        None => {
            run_real(ctx, list, true, true, &Bounds::UNKNOWN);
            ctx.driver.known_state.forget();
            ctx.compat.projection.touch(api::GL_PROJECTION);
            ctx.compat.projection.touch(api::GL_MODELVIEW);
            ctx.projected.note_switch();
        }
        Some(items) => {
            for item in items.iter() {
                match item {
                    Item::Real { list, draws, raster, sets_state, bounds, primitive } => {
                        if ctx.compat.immediate.under_way() || primitive.within.is_some() {
                            begin_end::run_part(ctx, *list, *primitive);
                        } else {
                            run_real(ctx, *list, *draws, *raster, bounds);
                        }
                        if *sets_state {
                            ctx.driver.known_state.forget();
                        }
                    }
                    Item::Command(command) if !calls(command) && ctx.compat.immediate.refuses(ctx.driver.gl) => {
                        // If Begin was passed on, the driver has noted the error already.
                        if ctx.compat.immediate.under_way() {
                            ctx.driver.note_error(api::GL_INVALID_OPERATION);
                        }
                    }
                    Item::Command(command) => run(ctx, command, depth),
                }
            }
        }
    }
}

/// Runs the list at an offset from the list base. For `glCallLists`, unlike `glCallList`, list 0 is
/// an empty list.
fn call_at(ctx: &mut Context, offset: u32, depth: u32) {
    let list = ctx.lists.base().wrapping_add(offset);
    if list != 0 {
        call(ctx, list, depth);
    }
}

/// True if a command runs other lists. Such a command is allowed between Begin and End.
fn calls(command: &Command) -> bool {
    matches!(command, Command::CallList(_) | Command::CallLists(_))
}

fn run_real(ctx: &mut Context, list: u32, draws: bool, raster: bool, bounds: &Bounds) {
    let gl = ctx.driver.gl;
    // SAFETY: a list that exists, or the program's own call.
    if raster && raster_position::draw_at_raster(ctx, Changes::Anything, |gl| unsafe { gl.call_list(list) }) {
        return;
    }
    if draws {
        // SAFETY: a list that exists, or the program's own call.
        draw(ctx, Changes::Anything, |_| *bounds, |_, gl| unsafe { gl.call_list(list) });
    } else {
        // SAFETY: as above.
        unsafe { gl.call_list(list) };
    }
}

/// Runs a command of a list.
pub fn run(ctx: &mut Context, command: &Command, depth: u32) {
    let gl = ctx.driver.gl;
    if change_matrix(gl, command) {
        ctx.compat.projection.touch(ctx.app.matrix_mode());
        return;
    }
    match command {
        Command::MatrixMode(mode) => matrices::set_mode(&ctx.driver, &mut ctx.app, *mode),
        Command::Viewport(rect) => {
            ctx.app.set_viewport(*rect);
            if !ctx.redirected() {
                ctx.restore_window_space();
            }
        }
        Command::Scissor(rect) => {
            ctx.app.set_scissor(*rect);
            if !ctx.redirected() {
                ctx.restore_window_space();
            }
        }
        Command::ScissorTest(on) => {
            ctx.app.set_scissor_test(*on);
            if !ctx.redirected() {
                ctx.restore_window_space();
            }
        }
        Command::PushAttributes(mask) => {
            window_state::push_attributes(&ctx.driver, &mut ctx.app, &ctx.compat, &ctx.lists, *mask)
        }
        Command::PopAttributes => window_state::pop_attributes(ctx),
        Command::UseProgram(program) => program_use::select(&ctx.share, &mut ctx.driver, &mut ctx.shaders, *program),
        Command::Clear(mask) => clears::clear_window(ctx, *mask),
        Command::DrawBuffer(buffer) => draw_buffers::select_draw_buffer(ctx, *buffer),
        Command::ReadBuffer(buffer) => draw_buffers::select_read_buffer(ctx, *buffer),
        Command::RasterPosition(position) => raster_position::set_position(ctx, *position),
        Command::WindowPosition(position) => raster_position::set_window_position(ctx, *position),
        Command::CallList(list) => call(ctx, *list, depth + 1),
        Command::CallLists(offsets) => {
            for offset in offsets {
                call_at(ctx, *offset, depth + 1);
            }
        }
        Command::ListBase(base) => set_list_base(&ctx.driver, &mut ctx.lists, *base),
        Command::Later(later) => {
            (later.0)(ctx);
            ctx.driver.known_state.forget();
        }
        _ => {}
    }
}

/// Runs a command that changes the current matrix. `false`: it is another command.
fn change_matrix(gl: &Gl, command: &Command) -> bool {
    // SAFETY: the program's own commands, with the values that it recorded.
    unsafe {
        match command {
            Command::LoadIdentity => gl.load_identity(),
            Command::LoadMatrix(m) => gl.load_matrixd(m.as_ref().as_ptr()),
            Command::MultMatrix(m) => gl.mult_matrixd(m.as_ref().as_ptr()),
            Command::Frustum([l, r, b, t, n, f]) => gl.frustum(*l, *r, *b, *t, *n, *f),
            Command::Ortho([l, r, b, t, n, f]) => gl.ortho(*l, *r, *b, *t, *n, *f),
            Command::Rotate([a, x, y, z]) => gl.rotated(*a, *x, *y, *z),
            Command::Scale([x, y, z]) => gl.scaled(*x, *y, *z),
            Command::Translate([x, y, z]) => gl.translated(*x, *y, *z),
            Command::PushMatrix => gl.push_matrix(),
            Command::PopMatrix => gl.pop_matrix(),
            _ => return false,
        }
    }
    true
}

fn set_list_base(driver: &Driver, lists: &mut ListState, base: u32) {
    lists.set_base(base);
    // SAFETY: the program's own command.
    unsafe { driver.gl.list_base(base) };
}

/// Returns the offset at `index` of the array of `glCallLists`.
///
/// # Safety
/// `lists` must hold more than `index` elements of the type `kind`, as the program promises OpenGL.
unsafe fn offset(kind: u32, lists: *const c_void, index: usize) -> u32 {
    let bytes = |width: usize| -> u32 {
        // SAFETY: inside the program's array of elements of `width` bytes.
        (0..width).fold(0, |sum, k| sum << 8 | u32::from(unsafe { *lists.cast::<u8>().add(index * width + k) }))
    };
    // SAFETY: inside the program's array; unaligned reads are allowed here.
    unsafe {
        match kind {
            api::GL_BYTE => i32::from(lists.cast::<i8>().add(index).read_unaligned()) as u32,
            api::GL_UNSIGNED_BYTE => u32::from(lists.cast::<u8>().add(index).read_unaligned()),
            api::GL_SHORT => i32::from(lists.cast::<i16>().add(index).read_unaligned()) as u32,
            api::GL_UNSIGNED_SHORT => u32::from(lists.cast::<u16>().add(index).read_unaligned()),
            api::GL_INT | api::GL_UNSIGNED_INT => lists.cast::<u32>().add(index).read_unaligned(),
            api::GL_FLOAT => lists.cast::<f32>().add(index).read_unaligned() as i64 as u32,
            api::GL_2_BYTES => bytes(2),
            api::GL_3_BYTES => bytes(3),
            api::GL_4_BYTES => bytes(4),
            _ => 0,
        }
    }
}

fn begin_recording(ctx: &mut Context, list: u32, mode: u32) {
    // SAFETY: a question about a name.
    let is_new = unsafe { ctx.driver.gl.is_list(list) } == 0;
    // SAFETY: the program's own command. The list is executed after its end.
    unsafe { ctx.driver.gl.new_list(list, if mode == api::GL_COMPILE_AND_EXECUTE { api::GL_COMPILE } else { mode }) };
    let takes = list != 0 && !ctx.compiling();
    if takes && matches!(mode, api::GL_COMPILE | api::GL_COMPILE_AND_EXECUTE) {
        let execute = mode == api::GL_COMPILE_AND_EXECUTE;
        let (items, bounds) = (Vec::new(), Bounds::EMPTY);
        let (draws, raster, sets_state, primitive) = (false, false, false, Primitive::default());
        ctx.lists.recording =
            Some(Recording { list, is_new, execute, items, real: list, draws, raster, sets_state, bounds, primitive });
    }
}

/// `glEndList`.
pub fn finish_recording(ctx: &mut Context) {
    let gl = ctx.driver.gl;
    let Some(mut recording) = ctx.lists.recording.take() else {
        // SAFETY: an error of the program, which the driver reports.
        unsafe { gl.end_list() };
        return;
    };
    recording.end_part(gl);
    if ctx.session().is_some() && !ctx.redirected() {
        // This state could not be set while the list was compiled.
        ctx.restore_window_space();
    }
    forget(ctx, recording.list, 1);
    let list = recording.list;
    let mut lists = ctx.share.lists.locked();
    lists.items.insert(list, Arc::new(recording.items));
    lists.names.note(list);
    drop(lists);
    if recording.execute {
        call(ctx, list, 0);
        if recording.primitive.within.is_some() {
            // The list ends, but OpenGL refuses this command between Begin and End. In mode
            // GL_COMPILE the driver cannot notice that.
            ctx.driver.note_error(api::GL_INVALID_OPERATION);
        }
    }
}

/// Forgets the items of these lists, and empties the lists of Cupola that are parts of them.
pub(in crate::intercept::gl) fn forget(ctx: &Context, first: u32, count: u32) {
    let mut lists = ctx.share.lists.locked();
    if (count as usize) < lists.items.len() {
        for list in first..first.saturating_add(count) {
            lists.forget(ctx, list);
        }
    } else {
        let known: Vec<u32> = lists.items.keys().copied().filter(|list| list.wrapping_sub(first) < count).collect();
        for list in known {
            lists.forget(ctx, list);
        }
    }
}

/// `glGenLists`: the names are those that the driver would give without the lists of Cupola.
/// Programs may store them in bytes.
fn generate(ctx: &mut Context, range: i32) -> u32 {
    let gl = ctx.driver.gl;
    let count = u32::try_from(range).unwrap_or(0);
    // SAFETY: a question about a name.
    let first = ctx.share.lists.locked().names.take(count, |list| unsafe { gl.is_list(list) } != 0);
    let Some(first) = first else {
        // SAFETY: the program's own call.
        return unsafe { gl.gen_lists(range) };
    };
    let compiling = list_recording::pause(&ctx.share, &ctx.driver, &mut ctx.lists);
    for list in first..first + count {
        // SAFETY: no list is being compiled in this context, and none has this name. OpenGL makes
        // such empty lists, too.
        unsafe {
            gl.new_list(list, api::GL_COMPILE);
            gl.end_list();
        }
    }
    if compiling {
        list_recording::go_on(&ctx.share, &ctx.driver, &mut ctx.lists, None);
    }
    first
}

/// Deletes lists of the program. The list that is being compiled replaces an earlier one of its name
/// only at its end, so that its parts stay.
fn delete(ctx: &mut Context, first: u32, count: u32) {
    forget(ctx, first, count);
    let gl = ctx.driver.gl;
    let compiled = ctx.lists.recording.as_mut().filter(|recording| recording.list.wrapping_sub(first) < count);
    let first_part = compiled.and_then(|recording| {
        recording.is_new = true;
        (!recording.items.is_empty()).then_some(recording.list)
    });
    let before = first_part.map_or(count, |list| list - first);
    // SAFETY: the program's own call, without the name that the driver has for the first part.
    unsafe {
        gl.delete_lists(first, before as i32);
        if let Some(list) = first_part {
            gl.delete_lists(list.wrapping_add(1), (count - before - 1) as i32);
        }
    }
}

/// `glCallList`.
pub fn call_list(ctx: &mut Context, list: u32) {
    if ctx.compiling() {
        record(&ctx.share, &ctx.driver, &mut ctx.lists, Command::CallList(list))
    } else {
        call(ctx, list, 0)
    }
}

/// `glCallLists`.
///
/// # Safety
/// `names` must hold `count` elements of the type `kind`, as the program promises OpenGL.
pub unsafe fn call_lists(ctx: &mut Context, count: i32, kind: u32, names: *const c_void) {
    let known = (api::GL_BYTE..=api::GL_4_BYTES).contains(&kind);
    if count < 0 || !known {
        // SAFETY: the driver reports the error. It reads no names if the number or the type is
        // wrong.
        list_recording::now_or_later(ctx, move |ctx| unsafe {
            ctx.driver.gl.call_lists(count, kind, std::ptr::null())
        });
        return;
    }
    let count = if names.is_null() { 0 } else { usize::try_from(count).unwrap_or(0) };
    // SAFETY: as promised.
    let offsets = (0..count).map(|index| unsafe { offset(kind, names, index) });
    if ctx.compiling() {
        record(&ctx.share, &ctx.driver, &mut ctx.lists, Command::CallLists(offsets.collect()));
    } else {
        offsets.for_each(|offset| call_at(ctx, offset, 0));
    }
}

hooks! {
    "glNewList" new_list(list: u32, mode: u32) = |ctx, _gl| begin_recording(ctx, list, mode);
    "glIsList" is_list(list: u32) -> u8 = |ctx, gl| {
        // The first part of the list may be complete in the driver, under the list's name.
        let is_compiled = ctx.lists.recording.as_ref().is_some_and(|recording| recording.is_new && recording.list == list);
        if is_compiled { 0 } else { gl.is_list(list) }
    };
    "glListBase" list_base(base: u32) = |ctx, _gl| {
        if ctx.compiling() { record(&ctx.share, &ctx.driver, &mut ctx.lists, Command::ListBase(base)) } else { set_list_base(&ctx.driver, &mut ctx.lists, base) }
    };
    "glGenLists" gen_lists(range: i32) -> u32 = |ctx, _gl| generate(ctx, range);
    "glDeleteLists" delete_lists(list: u32, range: i32) = |ctx, gl| {
        let Some(count) = u32::try_from(range).ok().filter(|count| *count > 0) else {
            gl.delete_lists(list, range);
            return;
        };
        // A program that deletes all names must not delete the lists of Cupola.
        let is_long = count > list_names::OWN_NAMES;
        let parts = if is_long { ctx.share.lists.locked().names.of_program(list, count) } else { vec![(list, count)] };
        for (first, count) in parts {
            delete(ctx, first, count);
        }
    };
}
