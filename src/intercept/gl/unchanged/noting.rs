//! What is noted of each call of the program.

use super::super::bound;
use super::super::context::Context;
use super::call::{Call, add_memory};
use super::calls::Kind;
use super::{LAST, TURNS};
use crate::backend::gl::api;
use crate::digest::Digest;
use std::sync::atomic::Ordering;

/// More bytes of a buffer than this are not looked at.
const MOST_BYTES: u64 = 1 << 24;

/// Notes a call of the program, before it is made.
///
/// # Safety
/// `words` must be the arguments of `call`, and those that point at something must do so as OpenGL asks of the program.
pub unsafe fn note(ctx: &mut Context, call: &Call, words: &[u64]) {
    if LAST.load(Ordering::Relaxed) != ctx.id {
        LAST.store(ctx.id, Ordering::Relaxed);
        TURNS.fetch_add(1, Ordering::Relaxed);
    }
    if ctx.unchanged.never {
        return;
    }
    // SAFETY: as promised.
    if crate::fence::guard(|| unsafe { note_now(ctx, call, words) }).is_none() {
        ctx.unchanged.give_up("a defect");
    }
}

/// # Safety
/// As of [`note`].
unsafe fn note_now(ctx: &mut Context, call: &Call, words: &[u64]) {
    ctx.unchanged.begun = true;
    let word = |place: u8| words.get(usize::from(place)).copied().unwrap_or(0);
    // What lasts.
    match call.kind {
        Kind::Never => return ctx.unchanged.give_up(call.name),
        Kind::Map(access) if word(access) as u32 & api::GL_MAP_PERSISTENT_BIT != 0 => {
            return ctx.unchanged.give_up(call.name);
        }
        Kind::BindBuffer if is_written_by_the_device(word(0) as u32) && words.iter().skip(1).any(|name| *name != 0) => {
            return ctx.unchanged.give_up(call.name);
        }
        Kind::Pointer(pointer) if word(pointer) != 0 && bound::buffer(ctx, api::GL_ARRAY_BUFFER) == Some(0) => {
            ctx.unchanged.own_arrays = true;
        }
        _ => {}
    }
    if ctx.compiling() {
        return compile(ctx, call, word(0));
    }
    if !ctx.unchanged.follows {
        return;
    }
    let drawn = ctx.believed.draw_framebuffer;
    let unchanged = &ctx.unchanged;
    let cleared = if drawn == 0 { unchanged.cleared } else { unchanged.cleared_framebuffer == Some(drawn) };
    // What is in the program's memory may change without a call.
    let own_arrays = ctx.unchanged.own_arrays && ctx.vertex_arrays.may_be_the_program_s();
    let known = match call.kind {
        _ if call.kind.draws_arrays() && own_arrays => false,
        Kind::Draw | Kind::Arrays | Kind::Lists => cleared,
        Kind::Elements(pointer) => {
            cleared && (word(pointer) == 0 || bound::buffer(ctx, api::GL_ELEMENT_ARRAY_BUFFER) != Some(0))
        }
        Kind::Draws { elements } => {
            cleared && (!elements || bound::buffer(ctx, api::GL_ELEMENT_ARRAY_BUFFER) != Some(0))
        }
        Kind::Indirect => cleared && bound::buffer(ctx, api::GL_DRAW_INDIRECT_BUFFER) != Some(0),
        Kind::Blit => drawn == 0 && ctx.believed.read_framebuffer != 0 && (cleared || fills_window(ctx, words)),
        // Texture matrices are not looked at: every unit has one.
        Kind::Matrix | Kind::MatrixNumbers => {
            word(0) as u32 != api::GL_TEXTURE
                && matches!(ctx.believed.matrix_mode, api::GL_MODELVIEW | api::GL_PROJECTION)
        }
        // Which attachments of a framebuffer of the program's were cleared is not followed.
        Kind::Buffers(several) => drawn == 0 && (!several || word(0) <= 16),
        Kind::Bytes { size, .. } => word(size) <= MOST_BYTES,
        Kind::Change | Kind::Map(_) | Kind::Pixels => false,
        _ => true,
    };
    if !known {
        let why = if call.kind.draws() && !cleared { "drawing over what was not cleared" } else { call.name };
        ctx.unchanged.change(why);
        return;
    }
    // Lists may hold any of these.
    let relative = matches!(call.kind, Kind::Matrix | Kind::MatrixNumbers | Kind::Draw | Kind::Lists);
    ctx.unchanged.relative |= relative && ctx.profile.compatibility();
    let calls = &mut ctx.unchanged.calls;
    calls.add(call.number);
    // SAFETY: memory that the program gives OpenGL to read, of the length that OpenGL reads.
    unsafe {
        match call.kind {
            Kind::Numbers { pointer, count, components } => {
                // OpenGL does not read what goes nowhere.
                let nowhere = count.is_some_and(|count| word(count - 1) as u32 as i32 == -1);
                let times = count.map_or(1, |count| (word(count) as u32 as i32).max(0) as u64);
                let times = if nowhere { 0 } else { times };
                add_but(calls, words, pointer);
                add_memory(calls, word(pointer), times * u64::from(components) * call.size as u64);
            }
            Kind::Buffers(true) => {
                calls.add(word(0));
                add_memory(calls, word(1), 4 * (word(0) as u32 as i32).max(0) as u64);
            }
            Kind::Parameter { pointer } => {
                add_but(calls, words, pointer);
                let name = word(pointer.saturating_sub(1)) as u32;
                add_memory(calls, word(pointer), parameter_length(name) * call.size as u64);
            }
            Kind::Bytes { size, pointer } => {
                add_but(calls, words, pointer);
                add_memory(calls, word(pointer), word(size));
            }
            Kind::Draws { elements } => {
                let count = (words.last().copied().unwrap_or(0) as u32 as i32).max(0) as u64;
                let (first, second) = if elements { (1, 3) } else { (1, 2) };
                calls.add(word(0));
                calls.add(if elements { word(2) } else { 0 });
                add_memory(calls, word(first), 4 * count);
                add_memory(calls, word(second), count * if elements { size_of::<usize>() as u64 } else { 4 });
            }
            // Drivers hold matrices in 32 bits. OpenSceneGraph's projections drift by the last of 64.
            Kind::MatrixNumbers if call.size == size_of::<f64>() && word(0) != 0 => {
                let matrix = (word(0) as usize as *const [f64; 16]).read_unaligned();
                matrix.iter().for_each(|entry| calls.add((*entry as f32).to_bits().into()));
            }
            Kind::MatrixNumbers => add_memory(calls, word(0), 16 * call.size as u64),
            Kind::Lists => {
                add_but(calls, words, 2);
                add_memory(calls, word(2), (word(0) as u32 as i32).max(0) as u64 * name_size(word(1) as u32));
            }
            _ => words.iter().for_each(|word| calls.add(*word)),
        }
    }
}

/// Whether `glBlitFramebuffer` fills the window's colours.
fn fills_window(ctx: &Context, words: &[u64]) -> bool {
    let &[_, _, _, _, x0, y0, x1, y1, mask, _] = words else { return false };
    let [x0, y0, x1, y1] = [x0, y0, x1, y1].map(|word| word as u32 as i32);
    let from_to = [x0.min(x1), y0.min(y1), x0.max(x1), y0.max(y1)].map(i64::from);
    mask as u32 & api::GL_COLOR_BUFFER_BIT != 0 && is_around_window(ctx, from_to) && is_unscissored(ctx)
}

/// Whether a rectangle (left, bottom, right, top) holds the whole window.
fn is_around_window(ctx: &Context, [left, bottom, right, top]: [i64; 4]) -> bool {
    let around = |(w, h): (u32, u32)| left <= 0 && bottom <= 0 && right >= i64::from(w) && top >= i64::from(h);
    ctx.target.as_ref().is_some_and(|target| around(target.size()))
}

/// Whether nothing of what is drawn to is cut off. How large framebuffers of the program's are is not known.
fn is_unscissored(ctx: &Context) -> bool {
    let [x, y, width, height] = ctx.believed.scissor.map(i64::from);
    !ctx.believed.scissor_test
        || (ctx.believed.draw_framebuffer == 0 && is_around_window(ctx, [x, y, x + width, y + height]))
}

fn add_but(calls: &mut Digest, words: &[u64], pointer: u8) {
    let others = words.iter().enumerate().filter(|(place, _)| *place != usize::from(pointer));
    others.for_each(|(_, word)| calls.add(*word));
}

/// A call goes into a display list. What a list may do is known if it only sets state and draws.
fn compile(ctx: &mut Context, call: &Call, first: u64) {
    match call.kind {
        Kind::Change | Kind::Blit => ctx.unchanged.give_up(call.name),
        Kind::Matrix if first as u32 == api::GL_TEXTURE => ctx.unchanged.give_up(call.name),
        _ => ctx.unchanged.change(call.name),
    }
}

/// Buffers at these places are written to by shaders and by answers of the device.
fn is_written_by_the_device(target: u32) -> bool {
    matches!(target, api::GL_SHADER_STORAGE_BUFFER | api::GL_ATOMIC_COUNTER_BUFFER | api::GL_QUERY_BUFFER)
}

/// How many numbers a parameter of lights, materials, fog, textures or points has.
fn parameter_length(name: u32) -> u64 {
    match name {
        api::GL_AMBIENT
        | api::GL_DIFFUSE
        | api::GL_SPECULAR
        | api::GL_POSITION
        | api::GL_EMISSION
        | api::GL_AMBIENT_AND_DIFFUSE
        | api::GL_LIGHT_MODEL_AMBIENT
        | api::GL_FOG_COLOR
        | api::GL_TEXTURE_ENV_COLOR
        | api::GL_OBJECT_PLANE
        | api::GL_EYE_PLANE
        | api::GL_TEXTURE_BORDER_COLOR
        | api::GL_TEXTURE_SWIZZLE_RGBA => 4,
        api::GL_SPOT_DIRECTION | api::GL_COLOR_INDEXES | api::GL_POINT_DISTANCE_ATTENUATION => 3,
        _ => 1,
    }
}

/// Bytes of a name for `glCallLists`.
fn name_size(kind: u32) -> u64 {
    match kind {
        api::GL_BYTE | api::GL_UNSIGNED_BYTE => 1,
        api::GL_SHORT | api::GL_UNSIGNED_SHORT | api::GL_2_BYTES => 2,
        api::GL_3_BYTES => 3,
        _ => 4,
    }
}

/// The program cleared its framebuffer by `glClear`.
pub fn note_clear(ctx: &mut Context, mask: u32) {
    if !ctx.unchanged.follows {
        return;
    }
    let (gl, drawn) = (ctx.gl, ctx.believed.draw_framebuffer);
    let stencil = if ctx.workload.tests_stencils() { api::GL_STENCIL_BUFFER_BIT } else { 0 };
    let needed = api::GL_COLOR_BUFFER_BIT | api::GL_DEPTH_BUFFER_BIT | stencil;
    let whole = is_unscissored(ctx) && ctx.condition.is_none() && !ctx.discard;
    let writes = ctx.known_state.writes_depth(gl) && ctx.known_state.mask(gl).iter().all(|on| *on != 0);
    let shown = drawn != 0 || ctx.believed.draw_buffer == api::GL_BACK;
    if mask & needed != needed || !whole || !writes || !shown {
        return;
    }
    if drawn == 0 {
        ctx.unchanged.cleared = true;
    } else if ctx.unchanged.cleared_framebuffer.replace(drawn).is_some_and(|other| other != drawn) {
        ctx.unchanged.change("two framebuffers");
    }
}
