//! Frames in which nothing changed: the picture of the one before is shown again, and not corrected anew.
//!
//! Every call of OpenGL in any context is noted ([`calls`]), with what it points at. A frame is as the one before if its calls
//! are: then each draws with the same state, because calls that set state set it to what they say, and a frame that is repeated
//! a second time begins with the state that its own first run left. What may follow from itself (matrices, the raster position, how deep
//! stacks are) is compared at the end of each frame. Whatever else may change a picture (textures, mapped buffers, drawing
//! over what was not cleared, another context) makes the frame one that changed; memory that changes without a call
//! ends it for good. What is not known counts as a change.

pub mod calls;
pub mod kept;
pub mod taps;
pub mod unknown;

use super::bound;
use super::context::Context;
use super::counts::Found;
use crate::backend::gl::api;
use calls::Kind;
use std::sync::atomic::{AtomicU64, Ordering};

/// Frames that must have been the same, one after the other, before a picture is kept: what is found out over some frames
/// (cameras, what lies behind the scene, scenes off screen) is then settled, too.
const SETTLED: u32 = 4;

/// More bytes of a buffer than this are not looked at.
const MOST_BYTES: u64 = 1 << 24;

/// The context that made the last call, and how often that became another one.
static LAST: AtomicU64 = AtomicU64::new(u64::MAX);
static TURNS: AtomicU64 = AtomicU64::new(0);

/// A call as it is noted.
pub struct Call {
    name: &'static str,
    /// A number that tells it from others.
    number: u64,
    kind: Kind,
    /// Bytes of one number that an argument points at.
    size: usize,
}

impl Call {
    /// Of the entry point `name` with arguments that may point at something (`points`), at numbers of so many bytes (`sizes`).
    pub const fn new<const N: usize>(name: &'static str, points: [bool; N], sizes: [usize; N]) -> Self {
        Self::of_kind(name, calls::kind(name, &points), sizes)
    }

    /// The same, of a known kind.
    pub const fn of_kind<const N: usize>(name: &'static str, kind: Kind, sizes: [usize; N]) -> Self {
        let size = match kind {
            Kind::Numbers { pointer, .. } | Kind::Parameter { pointer } => sizes[pointer as usize],
            Kind::MatrixNumbers => sizes[0],
            _ => 1,
        };
        // FNV-1a, which tells names apart.
        let mut hash: u64 = 0xCBF2_9CE4_8422_2325;
        let mut i = 0;
        while i < name.len() {
            hash = (hash ^ name.as_bytes()[i] as u64).wrapping_mul(0x0100_0000_01B3);
            i += 1;
        }
        Self { name, number: hash, kind, size }
    }

    /// Whether it has to be noted at all.
    pub const fn counts(&self) -> bool {
        !matches!(self.kind, Kind::Nothing)
    }
}

/// An argument of a call.
pub trait Word: Copy {
    /// It may point at something.
    const POINTS: bool = false;
    /// … at numbers of so many bytes.
    const SIZE: usize = 1;
    /// Its bits.
    fn word(self) -> u64;
}

macro_rules! words {
    ($($kind:ty)*) => { $( impl Word for $kind { fn word(self) -> u64 { self as u64 } } )* };
}
words!(u8 i8 u16 i16 u32 i32 u64 i64 isize);

impl Word for f32 {
    fn word(self) -> u64 {
        self.to_bits().into()
    }
}

impl Word for f64 {
    fn word(self) -> u64 {
        self.to_bits()
    }
}

impl<T> Word for *const T {
    const POINTS: bool = true;
    const SIZE: usize = size_of::<T>();
    fn word(self) -> u64 {
        self as usize as u64
    }
}

impl<T> Word for *mut T {
    const POINTS: bool = true;
    const SIZE: usize = size_of::<T>();
    fn word(self) -> u64 {
        self as usize as u64
    }
}

/// What is known of a context's frames.
pub struct Unchanged {
    /// The frame may still be as the one before.
    follows: bool,
    /// Anything may change without a call.
    never: bool,
    calls: Digest,
    /// It has had a call that counts.
    begun: bool,
    /// Its window's colour, depth and, where it matters, stencil were cleared as a whole.
    cleared: bool,
    /// The framebuffer of the program's of which the same is true. Of two, each could show what the other held in the
    /// frame before.
    cleared_framebuffer: Option<u32>,
    /// It had calls after which state may follow from what it was.
    relative: bool,
    /// Of the last frame, if that may be repeated.
    last: Option<Digest>,
    /// What its state was at its end, where that may follow from what it was.
    ended: Option<Relative>,
    /// So many frames before this one were the same.
    streak: u32,
    /// What had been counted when the frame began.
    counted: [u64; 4],
    turns: u64,
    kept: kept::Kept,
    /// Why frames were not like the ones before: calls, by their names.
    pub reasons: Found,
}

/// State that may follow from its last value: two matrices and the raster position.
type Relative = [f32; 36];

impl Unchanged {
    /// Of a new context.
    pub fn new(wanted: bool) -> Self {
        Self {
            follows: wanted,
            never: !wanted,
            calls: Digest::default(),
            begun: false,
            cleared: false,
            cleared_framebuffer: None,
            relative: false,
            last: None,
            ended: None,
            streak: 0,
            counted: [0; 4],
            turns: 0,
            kept: kept::Kept::default(),
            reasons: Found::default(),
        }
    }

    /// The frame is not as the one before, or may not be, by this call or for this reason.
    pub fn change(&mut self, why: &'static str) {
        if self.follows {
            self.reasons.count(why);
        }
        self.follows = false;
        self.last = None;
        self.kept.forget();
    }

    /// Something may change without a call from now on.
    pub fn give_up(&mut self, why: &'static str) {
        if !std::mem::replace(&mut self.never, true) {
            self.reasons.count(why);
        }
        self.follows = false;
        self.change(why);
    }
}

/// Two sums of numbers in their order.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Digest([u64; 2]);

impl Default for Digest {
    fn default() -> Self {
        Self([0x9E37_79B9_7F4A_7C15, 0xC2B2_AE3D_27D4_EB4F])
    }
}

impl Digest {
    fn add(&mut self, word: u64) {
        let product = u128::from(self.0[0] ^ word).wrapping_mul(0xA076_1D64_78BD_642F_E703_7ED1_A0B4_28DB);
        self.0[0] = (product as u64) ^ (product >> 64) as u64;
        self.0[1] = (self.0[1].rotate_left(23) ^ word).wrapping_mul(0x9FB2_1C65_1E98_DF25);
    }

    /// # Safety
    /// `start` must point at `length` bytes.
    unsafe fn add_memory(&mut self, start: u64, length: u64) {
        self.add(length);
        if start == 0 || length == 0 {
            return;
        }
        // SAFETY: as promised.
        let bytes = unsafe { std::slice::from_raw_parts(start as usize as *const u8, length as usize) };
        let (words, rest) = bytes.as_chunks::<8>();
        words.iter().for_each(|word| self.add(u64::from_ne_bytes(*word)));
        let mut last = [0; 8];
        last[..rest.len()].copy_from_slice(rest);
        self.add(u64::from_ne_bytes(last));
    }
}

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
            return ctx.unchanged.give_up(call.name);
        }
        _ if ctx.compiling() => return compile(ctx, call, word(0)),
        _ => {}
    }
    if !ctx.unchanged.follows {
        return;
    }
    let drawn = ctx.believed.draw_framebuffer;
    let unchanged = &ctx.unchanged;
    let cleared = if drawn == 0 { unchanged.cleared } else { unchanged.cleared_framebuffer == Some(drawn) };
    let known = match call.kind {
        Kind::Draw | Kind::Lists => cleared,
        Kind::Elements(pointer) => {
            cleared && (word(pointer) == 0 || bound::buffer(ctx, api::GL_ELEMENT_ARRAY_BUFFER) != Some(0))
        }
        Kind::Draws { elements } => {
            cleared && (!elements || bound::buffer(ctx, api::GL_ELEMENT_ARRAY_BUFFER) != Some(0))
        }
        Kind::Indirect => cleared && bound::buffer(ctx, api::GL_DRAW_INDIRECT_BUFFER) != Some(0),
        Kind::Blit => cleared && drawn == 0 && ctx.believed.read_framebuffer != 0,
        // Texture matrices are not looked at: every unit has one.
        Kind::Matrix | Kind::MatrixNumbers => {
            word(0) as u32 != api::GL_TEXTURE
                && matches!(ctx.believed.matrix_mode, api::GL_MODELVIEW | api::GL_PROJECTION)
        }
        // Which attachments of a framebuffer of the program's were cleared is not followed.
        Kind::Buffers(_) => drawn == 0,
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
                let times = count.map_or(1, |count| (word(count) as u32 as i32).max(0) as u64);
                add_but(calls, words, pointer);
                calls.add_memory(word(pointer), times * u64::from(components) * call.size as u64);
            }
            Kind::Buffers(true) => {
                calls.add(word(0));
                calls.add_memory(word(1), 4 * (word(0) as u32 as i32).max(0) as u64);
            }
            Kind::Parameter { pointer } => {
                add_but(calls, words, pointer);
                let name = word(pointer.saturating_sub(1)) as u32;
                calls.add_memory(word(pointer), parameter_length(name) * call.size as u64);
            }
            Kind::Bytes { size, pointer } => {
                add_but(calls, words, pointer);
                calls.add_memory(word(pointer), word(size));
            }
            Kind::Draws { elements } => {
                let count = (words.last().copied().unwrap_or(0) as u32 as i32).max(0) as u64;
                let (first, second) = if elements { (1, 3) } else { (1, 2) };
                calls.add(word(0));
                calls.add(if elements { word(2) } else { 0 });
                calls.add_memory(word(first), 4 * count);
                calls.add_memory(word(second), count * if elements { size_of::<usize>() as u64 } else { 4 });
            }
            Kind::MatrixNumbers => calls.add_memory(word(0), 16 * call.size as u64),
            Kind::Lists => {
                add_but(calls, words, 2);
                calls.add_memory(word(2), (word(0) as u32 as i32).max(0) as u64 * name_size(word(1) as u32));
            }
            _ => words.iter().for_each(|word| calls.add(*word)),
        }
    }
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
    let whole = !ctx.believed.scissor_test && ctx.condition.is_none() && !ctx.discard;
    let mut depth = 0u8;
    // SAFETY: writes one value.
    unsafe { gl.get_booleanv(api::GL_DEPTH_WRITEMASK, &mut depth) };
    let writes = depth != 0 && ctx.known_state.mask(gl).iter().all(|on| *on != 0);
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

/// What is to be done at the end of a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Frame {
    /// It is corrected.
    New,
    /// It is corrected; the picture is worth being kept.
    Settled,
    /// The picture that was kept is that of this frame, too.
    Kept,
}

/// The frame ends.
pub fn end_frame(ctx: &mut Context) -> Frame {
    let turns = TURNS.load(Ordering::Relaxed);
    let alone = std::mem::replace(&mut ctx.unchanged.turns, turns) == turns;
    let off_screen = super::duplicate::draws(ctx);
    let counts = [ctx.counts.draws_seen, ctx.counts.panel_draws, ctx.counts.primary_draws, off_screen];
    let before = std::mem::replace(&mut ctx.unchanged.counted, counts);
    if !alone {
        ctx.unchanged.change("another context");
    } else if ctx.condition.is_some() || ctx.compiling() {
        ctx.unchanged.change("a frame in the middle of something");
    }
    let follows = ctx.unchanged.follows;
    let mut calls = std::mem::take(&mut ctx.unchanged.calls);
    counts.iter().zip(before).for_each(|(now, before)| calls.add(now - before));
    // A frame without a call repeats the one before.
    let same = follows && (ctx.unchanged.last == Some(calls) || (!ctx.unchanged.begun && ctx.unchanged.last.is_some()));
    let follows_itself = ctx.unchanged.relative;
    let ended = if same && follows_itself { relative(ctx) } else { None };
    let unchanged = &mut ctx.unchanged;
    let repeats = same && (!unchanged.begun || !follows_itself || (ended.is_some() && unchanged.ended == ended));
    unchanged.streak = if repeats { unchanged.streak + 1 } else { 0 };
    if !same {
        unchanged.last = follows.then_some(calls);
    }
    if unchanged.begun {
        unchanged.ended = ended;
    }
    if !repeats {
        unchanged.kept.forget();
        if follows {
            unchanged.reasons.count("arguments");
        }
    }
    unchanged.follows = !unchanged.never;
    unchanged.begun = false;
    unchanged.cleared = false;
    unchanged.cleared_framebuffer = None;
    unchanged.relative = false;
    match unchanged.streak {
        0..SETTLED => Frame::New,
        _ if unchanged.kept.is_valid() => Frame::Kept,
        _ => Frame::Settled,
    }
}

/// State that may follow from what it was before; none where more of it may than is looked at. Asked for only where the calls were
/// those of the frame before.
fn relative(ctx: &Context) -> Option<Relative> {
    let gl = ctx.gl;
    let mut state = [0.0; 36];
    let (matrices, raster) = state.split_at_mut(32);
    let (modelview, projection) = matrices.split_at_mut(16);
    let mut depths = [0; 2];
    // SAFETY: matrices have sixteen numbers, the raster position four, the others one.
    unsafe {
        gl.get_floatv(api::GL_MODELVIEW_MATRIX, modelview.as_mut_ptr());
        gl.get_floatv(api::GL_PROJECTION_MATRIX, projection.as_mut_ptr());
        gl.get_floatv(api::GL_CURRENT_RASTER_POSITION, raster.as_mut_ptr());
        gl.get_integerv(api::GL_MODELVIEW_STACK_DEPTH, &mut depths[0]);
        gl.get_integerv(api::GL_PROJECTION_STACK_DEPTH, &mut depths[1]);
    }
    let looked_at = matches!(ctx.believed.matrix_mode, api::GL_MODELVIEW | api::GL_PROJECTION);
    (looked_at && depths == [1, 1] && ctx.attribute_stack.is_empty()).then_some(state)
}

/// A call of the window system's changes what is drawn.
pub fn change_in_the_current_context() {
    if let Some(ctx) = super::registry::current() {
        ctx.unchanged.change("a font of the window system's");
    }
}

/// A call of the window system's lets something else write to what the program samples.
pub fn give_up_in_the_current_context() {
    if let Some(ctx) = super::registry::current() {
        ctx.unchanged.give_up("a picture of the window system's");
    }
}

#[cfg(test)]
mod tests;
