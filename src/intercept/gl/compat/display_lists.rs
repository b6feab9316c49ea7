//! Display lists: real lists between the commands that must not run once per view.
//!
//! A list of the program becomes a sequence of items. What only draws or sets plain state stays
//! in real lists of the driver (the first under the program's own name); commands that we follow
//! (matrices, viewport, clears, nested lists …) are kept beside them and run through our hooks.

use crate::backend::gl::api::{self, Gl};
use crate::intercept::gl::context::gl_context::Context;
use crate::intercept::gl::context::hooks::hooks;
use crate::intercept::gl::draw::culling::bounds::Bounds;
use crate::intercept::gl::draw::issue::{Changes, draw};
use std::collections::HashMap;
use std::ffi::c_void;
use std::sync::{Arc, PoisonError};

/// A command that runs once, not once per view.
#[derive(Clone, Debug, PartialEq)]
#[allow(missing_docs)] // Each is the OpenGL command of its name.
pub enum Command {
    MatrixMode(u32),
    LoadIdentity,
    LoadMatrix([f64; 16]),
    MultMatrix([f64; 16]),
    Frustum([f64; 6]),
    Ortho([f64; 6]),
    Rotate([f64; 4]),
    Scale([f64; 3]),
    Translate([f64; 3]),
    PushMatrix,
    PopMatrix,
    Viewport([i32; 4]),
    Scissor([i32; 4]),
    ScissorTest(bool),
    PushAttributes(u32),
    PopAttributes,
    UseProgram(u32),
    Clear(u32),
    DrawBuffer(u32),
    ReadBuffer(u32),
    RasterPosition([f64; 4]),
    WindowPosition([f64; 3]),
    CallList(u32),
    /// Offsets to be added to `glListBase` when the list runs.
    CallLists(Vec<u32>),
    ListBase(u32),
    Later(Later),
}

/// Any other command, as what it does when the list runs.
#[derive(Clone)]
pub struct Later(Arc<dyn Fn(&mut Context) + Send + Sync>);

impl std::fmt::Debug for Later {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("Later")
    }
}

impl PartialEq for Later {
    fn eq(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.0, &other.0)
    }
}

/// Does what a command of the program does: now, or whenever the list runs that is being compiled.
pub fn now_or_later(ctx: &mut Context, run: impl Fn(&mut Context) + Send + Sync + 'static) {
    if ctx.compiling() { record(ctx, Command::Later(Later(Arc::new(run)))) } else { run(ctx) }
}

/// A part of a list.
#[derive(Clone, Debug)]
enum Item {
    /// A real list of the driver.
    Real { list: u32, draws: bool, raster: bool, sets_state: bool, bounds: Bounds },
    /// A command of ours.
    Command(Command),
}

/// The program's lists that are more than one real list.
#[derive(Default)]
pub struct Lists {
    items: HashMap<u32, Arc<Vec<Item>>>,
    /// Names of ours that are in no use.
    own: Vec<u32>,
}

/// So many names are taken from OpenGL for ours at once.
const OWN_NAMES: u32 = 1024;

/// Old programs use names from 1 on that they never asked for. Ours are this far from them.
const PROGRAM_NAMES: u32 = 8192;

/// A name for a list of our own, which no program takes by itself.
pub fn own_name(ctx: &Context) -> u32 {
    let gl = ctx.gl;
    let mut lists = ctx.share.lists.lock().unwrap_or_else(PoisonError::into_inner);
    if lists.own.is_empty() {
        // SAFETY: takes names, and gives those back that are not for us.
        let first = unsafe {
            let first = gl.gen_lists((PROGRAM_NAMES + OWN_NAMES) as i32);
            gl.delete_lists(first, PROGRAM_NAMES as i32);
            first + PROGRAM_NAMES
        };
        lists.own.extend((first..first + OWN_NAMES).rev());
    }
    lists.own.pop().unwrap_or_default()
}

/// The list that is being compiled.
pub struct Recording {
    list: u32,
    execute: bool,
    items: Vec<Item>,
    real: u32,
    /// The present real list draws something.
    draws: bool,
    /// … at the raster position.
    raster: bool,
    /// It sets what is followed.
    pub sets_state: bool,
    /// Around the vertices of the present real list.
    pub bounds: Bounds,
}

/// Lists may call lists this deep, as OpenGL says at least.
const DEEPEST: u32 = 64;

/// A draw comes into the list that is compiled, at the `raster` position or not. Each of these gets a real list without the
/// other, as they are issued in different ways. Not between `glBegin` and `glEnd`.
pub fn will_draw(ctx: &mut Context, raster: bool) {
    if ctx.recording.as_ref().is_some_and(|recording| recording.draws && recording.raster != raster) {
        next_part(ctx, None);
    }
    if let Some(recording) = &mut ctx.recording {
        recording.draws = true;
        recording.raster = raster;
    }
}

/// Ends the present real list, keeps `command`, and begins another.
pub fn record(ctx: &mut Context, command: Command) {
    next_part(ctx, Some(command));
}

fn next_part(ctx: &mut Context, command: Option<Command>) {
    let gl = ctx.gl;
    if let Some(recording) = &mut ctx.recording {
        recording.end_part(gl);
    }
    let real = own_name(ctx);
    let Some(recording) = &mut ctx.recording else { return };
    recording.items.extend(command.map(Item::Command));
    recording.real = real;
    // SAFETY: a list of our own; the program is compiling, and the list that was open has just ended.
    unsafe { gl.new_list(real, api::GL_COMPILE) };
}

impl Recording {
    fn end_part(&mut self, gl: &Gl) {
        // SAFETY: ends the list that we, or the program, began.
        unsafe { gl.end_list() };
        let Self { real: list, draws, raster, sets_state, bounds, .. } = *self;
        self.items.push(Item::Real { list, draws, raster, sets_state, bounds });
        self.draws = false;
        self.sets_state = false;
        self.raster = false;
        self.bounds = Bounds::EMPTY;
    }
}

/// Runs a list of the program.
fn call(ctx: &mut Context, list: u32, depth: u32) {
    if depth > DEEPEST {
        return;
    }
    let items = {
        let lists = ctx.share.lists.lock().unwrap_or_else(PoisonError::into_inner);
        lists.items.get(&list).cloned()
    };
    match items {
        // A list that we did not see compiled (a font of glXUseXFont, say) may do anything.
        None => {
            run_real(ctx, list, true, true, &Bounds::UNKNOWN);
            ctx.known_state.forget();
            ctx.projection.touch(api::GL_PROJECTION);
            ctx.projection.touch(api::GL_MODELVIEW);
            ctx.fixed.touch();
        }
        Some(items) => {
            for item in items.iter() {
                match item {
                    Item::Real { list, draws, raster, sets_state, bounds } => {
                        run_real(ctx, *list, *draws, *raster, bounds);
                        if *sets_state {
                            ctx.known_state.forget();
                        }
                    }
                    Item::Command(command) => run(ctx, command, depth),
                }
            }
        }
    }
}

fn run_real(ctx: &mut Context, list: u32, draws: bool, raster: bool, bounds: &Bounds) {
    let gl = ctx.gl;
    // SAFETY: a list that exists, or the program's own call.
    if raster
        && crate::intercept::gl::compat::raster_position::draw_at_raster(ctx, Changes::Anything, |gl| unsafe {
            gl.call_list(list)
        })
    {
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
    let gl = ctx.gl;
    let mut matrix = true;
    // SAFETY: the program's own commands, with the values that it recorded.
    unsafe {
        match command {
            Command::LoadIdentity => gl.load_identity(),
            Command::LoadMatrix(m) => gl.load_matrixd(m.as_ptr()),
            Command::MultMatrix(m) => gl.mult_matrixd(m.as_ptr()),
            Command::Frustum([l, r, b, t, n, f]) => gl.frustum(*l, *r, *b, *t, *n, *f),
            Command::Ortho([l, r, b, t, n, f]) => gl.ortho(*l, *r, *b, *t, *n, *f),
            Command::Rotate([a, x, y, z]) => gl.rotated(*a, *x, *y, *z),
            Command::Scale([x, y, z]) => gl.scaled(*x, *y, *z),
            Command::Translate([x, y, z]) => gl.translated(*x, *y, *z),
            Command::PushMatrix => gl.push_matrix(),
            Command::PopMatrix => gl.pop_matrix(),
            _ => matrix = false,
        }
    }
    if matrix {
        ctx.projection.touch(ctx.believed.matrix_mode);
        return;
    }
    match command {
        Command::MatrixMode(mode) => {
            // SAFETY: the program's own command.
            unsafe { gl.matrix_mode(*mode) };
            ctx.believed.matrix_mode = *mode;
        }
        Command::Viewport(rect) => {
            ctx.believed.viewport = *rect;
            if !ctx.redirected() {
                ctx.set_viewport(*rect);
            }
        }
        Command::Scissor(rect) => {
            ctx.believed.scissor = *rect;
            if !ctx.redirected() {
                ctx.restore_window_space();
            }
        }
        Command::ScissorTest(on) => {
            ctx.believed.scissor_test = *on;
            if !ctx.redirected() {
                ctx.restore_window_space();
            }
        }
        Command::PushAttributes(mask) => crate::intercept::gl::context::window_state::push_attributes(ctx, *mask),
        Command::PopAttributes => crate::intercept::gl::context::window_state::pop_attributes(ctx),
        Command::UseProgram(program) => crate::intercept::gl::shader::programs::select(ctx, *program),
        Command::Clear(mask) => crate::intercept::gl::framebuffer::bindings::clear_window(ctx, *mask),
        Command::DrawBuffer(buffer) => crate::intercept::gl::framebuffer::bindings::select_draw_buffer(ctx, *buffer),
        Command::ReadBuffer(buffer) => crate::intercept::gl::framebuffer::bindings::select_read_buffer(ctx, *buffer),
        Command::RasterPosition(position) => {
            crate::intercept::gl::compat::raster_position::set_position(ctx, *position)
        }
        Command::WindowPosition(position) => {
            crate::intercept::gl::compat::raster_position::set_window_position(ctx, *position)
        }
        Command::CallList(list) => call(ctx, *list, depth + 1),
        Command::CallLists(offsets) => {
            for offset in offsets {
                call(ctx, ctx.list_base.wrapping_add(*offset), depth + 1);
            }
        }
        Command::ListBase(base) => set_list_base(ctx, *base),
        Command::Later(later) => {
            (later.0)(ctx);
            ctx.known_state.forget();
        }
        _ => {}
    }
}

fn set_list_base(ctx: &mut Context, base: u32) {
    ctx.list_base = base;
    // SAFETY: the program's own command.
    unsafe { ctx.gl.list_base(base) };
}

/// The offset at `index` of the array of `glCallLists`.
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
    // SAFETY: the program's own command; execution comes when the list ends.
    unsafe { ctx.gl.new_list(list, if mode == api::GL_COMPILE_AND_EXECUTE { api::GL_COMPILE } else { mode }) };
    if list != 0 && matches!(mode, api::GL_COMPILE | api::GL_COMPILE_AND_EXECUTE) && !ctx.compiling() {
        let execute = mode == api::GL_COMPILE_AND_EXECUTE;
        let (items, bounds) = (Vec::new(), Bounds::EMPTY);
        let (draws, raster, sets_state) = (false, false, false);
        ctx.recording = Some(Recording { list, execute, items, real: list, draws, raster, sets_state, bounds });
    }
}

/// `glEndList`.
pub fn finish_recording(ctx: &mut Context) {
    let gl = ctx.gl;
    let Some(mut recording) = ctx.recording.take() else {
        // SAFETY: an error of the program's, for the driver to say.
        unsafe { gl.end_list() };
        return;
    };
    recording.end_part(gl);
    if ctx.session().is_some() && !ctx.redirected() {
        // What could not be set while the list was compiled.
        ctx.restore_window_space();
    }
    forget(ctx, recording.list, 1);
    let list = recording.list;
    let mut lists = ctx.share.lists.lock().unwrap_or_else(PoisonError::into_inner);
    lists.items.insert(list, Arc::new(recording.items));
    drop(lists);
    if recording.execute {
        call(ctx, list, 0);
    }
}

/// Forgets what the lists were, and empties our parts of them.
fn forget(ctx: &Context, first: u32, count: u32) {
    let mut lists = ctx.share.lists.lock().unwrap_or_else(PoisonError::into_inner);
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

impl Lists {
    fn forget(&mut self, ctx: &Context, list: u32) {
        let Some(items) = self.items.remove(&list) else { return };
        for item in items.iter() {
            if let Item::Real { list: part, .. } = item
                && *part != list
            {
                // The name stays ours, or the driver might give it to the program.
                self.own.push(*part);
                if !ctx.compiling() {
                    // SAFETY: a list of our own that nothing else names; an empty one takes its place.
                    unsafe {
                        ctx.gl.new_list(*part, api::GL_COMPILE);
                        ctx.gl.end_list();
                    }
                }
            }
        }
    }
}

/// `glCallList`.
pub fn call_list(ctx: &mut Context, list: u32) {
    if ctx.compiling() { record(ctx, Command::CallList(list)) } else { call(ctx, list, 0) }
}

/// `glCallLists`.
///
/// # Safety
/// `names` must hold `count` elements of the type `kind`, as the program promises OpenGL.
pub unsafe fn call_lists(ctx: &mut Context, count: i32, kind: u32, names: *const c_void) {
    let count = if names.is_null() { 0 } else { usize::try_from(count).unwrap_or(0) };
    // SAFETY: as promised.
    let offsets = (0..count).map(|index| unsafe { offset(kind, names, index) });
    if ctx.compiling() {
        record(ctx, Command::CallLists(offsets.collect()));
    } else {
        offsets.for_each(|offset| call(ctx, ctx.list_base.wrapping_add(offset), 0));
    }
}

hooks! {
    "glNewList" new_list(list: u32, mode: u32) = |ctx, _gl| begin_recording(ctx, list, mode);
    "glListBase" list_base(base: u32) = |ctx, _gl| {
        if ctx.compiling() { record(ctx, Command::ListBase(base)) } else { set_list_base(ctx, base) }
    };
    "glDeleteLists" delete_lists(list: u32, range: i32) = |ctx, gl| {
        forget(ctx, list, u32::try_from(range).unwrap_or(0));
        gl.delete_lists(list, range);
    };
}
