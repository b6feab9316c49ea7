//! Frames in which nothing changed: the picture of the one before is shown again, and not corrected anew.
//!
//! Every call of OpenGL in any context is noted ([`calls`]), with what it points at. A frame is as the one before if its calls
//! are: then each draws with the same state, because calls that set state set it to what they say, and a frame that is repeated
//! a second time begins with the state that its own first run left. What may follow from itself (matrices, the raster position, how deep
//! stacks are) is compared at the end of each frame. Whatever else may change a picture (textures, mapped buffers, drawing
//! over what was not cleared, another context) makes the frame one that changed; memory that changes without a call
//! ends it for good. What is not known counts as a change.

pub mod call;
pub mod calls;
pub mod kept;
pub mod noting;
pub mod taps;
pub mod unknown;

use super::context::Context;
use super::counts::Found;
use crate::backend::gl::api;
use crate::digest::Digest;
pub use noting::note_clear;
use std::sync::atomic::{AtomicU64, Ordering};

/// Frames that must have been the same, one after the other, before a picture is kept: what is found out over some frames
/// (cameras, what lies behind the scene, scenes off screen) is then settled, too.
const SETTLED: u32 = 4;

/// After so many frames with other calls than the ones before only two of as many are looked at, which spares the
/// others the noting.
const RESTS: u32 = 16;

/// The context that made the last call, and how often that became another one.
static LAST: AtomicU64 = AtomicU64::new(u64::MAX);
static TURNS: AtomicU64 = AtomicU64::new(0);

/// What is known of a context's frames.
pub struct Unchanged {
    /// The frame may still be as the one before.
    follows: bool,
    /// Anything may change without a call.
    never: bool,
    /// Arrays that belong to no object may be in the program's memory.
    own_arrays: bool,
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
    /// So many frames in a row had other calls than the ones before.
    moving: u32,
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
            own_arrays: false,
            calls: Digest::default(),
            begun: false,
            cleared: false,
            cleared_framebuffer: None,
            relative: false,
            last: None,
            ended: None,
            streak: 0,
            moving: 0,
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
    unchanged.moving = if repeats { 0 } else { unchanged.moving.wrapping_add(1) };
    let rests = unchanged.moving >= RESTS && unchanged.moving % RESTS >= 2;
    unchanged.follows = !unchanged.never && !rests;
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
