//! Queries that count what the program draws, though each draw is issued once per view.
//!
//! OpenGL cannot pause a query. So what must not be counted as it is (our own work, a picture that shows the same
//! once more, the repetitions of a draw) is kept apart by ending the object that counts and going on with one
//! of ours. What the program is told is the sum of these parts, each times its weight:
//!
//! - samples: all views together, scaled so that what fills the program's own picture counts as many as that has.
//!   What only a view beside that picture shows is counted too, or the program would leave it out on the dome.
//!   What was seen at all counts at least one. Flat drawing counts once;
//! - primitives and the work of shaders on them: divided by the number of times that the draw was issued;
//! - time: all of it but our own work; whether any samples passed: in any view.

use crate::backend::gl::api::{self, Gl};
use crate::intercept::gl::context::errors::take_error;
use crate::intercept::gl::context::gl_context::Context;
use crate::intercept::scene::query_weights::{Quantity, QueryWeights, weight};
use crate::runtime::Session;
use crate::runtime::session::Intrinsics;
use std::collections::HashMap;

/// The counting queries of a context.
#[derive(Default)]
pub struct Counting {
    pub(super) running: Vec<Running>,
    /// Finished queries whose result is more than what their object says, by the program's name for them.
    pub(super) split: HashMap<u32, Count>,
    /// Objects of ours that are in no use, with their target: an object stays what it was first.
    pub(super) own: Vec<(u32, u32)>,
    /// Objects of ours that were never anything.
    pub(super) fresh: Vec<u32>,
    /// The lens and viewport for which `worth` was computed.
    seen: Option<(Intrinsics, [i32; 4], bool)>,
    /// How many samples of the program's own picture one of the views' is worth.
    worth: f64,
    /// The context has results of 64 bits.
    pub(super) wide: bool,
}

/// A query between Begin and End.
pub(super) struct Running {
    pub(super) target: u32,
    pub(super) index: u32,
    pub(super) name: u32,
    /// The object that counts now, with its weight once something was drawn; `None` = nothing counts.
    pub(super) now: Option<(u32, Option<f64>)>,
    pub(super) before: Count,
}

/// What finished parts of a query counted.
#[derive(Default)]
pub(super) struct Count {
    pub(super) target: u32,
    /// Objects and weights.
    pub(super) parts: Vec<(u32, f64)>,
    /// Of parts that were read already.
    pub(super) sum: f64,
}

/// What a query of this target counts.
fn quantity(target: u32) -> Quantity {
    match target {
        api::GL_SAMPLES_PASSED | api::GL_FRAGMENT_SHADER_INVOCATIONS => Quantity::Samples,
        api::GL_PRIMITIVES_GENERATED
        | api::GL_VERTICES_SUBMITTED
        | api::GL_PRIMITIVES_SUBMITTED
        | api::GL_VERTEX_SHADER_INVOCATIONS
        | api::GL_TESS_CONTROL_SHADER_PATCHES
        | api::GL_TESS_EVALUATION_SHADER_INVOCATIONS
        | api::GL_GEOMETRY_SHADER_INVOCATIONS
        | api::GL_GEOMETRY_SHADER_PRIMITIVES_EMITTED
        | api::GL_CLIPPING_INPUT_PRIMITIVES
        | api::GL_CLIPPING_OUTPUT_PRIMITIVES => Quantity::Primitives,
        // Transform feedback is paused for the repetitions of a draw.
        _ => Quantity::Unscaled,
    }
}

/// Queries of one kind exclude each other.
fn kind(target: u32) -> u32 {
    match target {
        api::GL_ANY_SAMPLES_PASSED | api::GL_ANY_SAMPLES_PASSED_CONSERVATIVE => api::GL_SAMPLES_PASSED,
        other => other,
    }
}

/// More finished parts than this are read while their query runs on.
const MOST_PARTS: usize = 16;

/// So many names are taken from OpenGL for ours at once.
const OWN_NAMES: usize = 16;

/// Programs of the old profile use names that they never asked for; ours are this far from them.
const PROGRAM_NAMES: usize = 1024;

impl Counting {
    /// Whether any query runs.
    pub fn any(&self) -> bool {
        !self.running.is_empty()
    }

    /// Whether it is counted how many primitives there are, so that no draw may be left out.
    pub fn primitives(&self) -> bool {
        self.running.iter().any(|r| quantity(r.target) == Quantity::Primitives)
    }

    /// The views changed.
    pub fn forget_views(&mut self) {
        self.seen = None;
    }

    fn object(&mut self, gl: &Gl, target: u32) -> u32 {
        if let Some(index) = self.own.iter().position(|own| own.0 == target) {
            return self.own.swap_remove(index).1;
        }
        if self.fresh.is_empty() {
            let mut names = [0; PROGRAM_NAMES + OWN_NAMES];
            // SAFETY: writes as many names as there is room for, and gives back those that are not for us.
            unsafe {
                gl.gen_queries(names.len() as i32, names.as_mut_ptr());
                gl.delete_queries(PROGRAM_NAMES as i32, names.as_ptr());
            }
            self.fresh.extend_from_slice(&names[PROGRAM_NAMES..]);
        }
        self.fresh.pop().unwrap_or_default()
    }

    /// The objects of ours in `count` are free again.
    pub(super) fn give_back(&mut self, count: &Count, name: u32) {
        let parts = count.parts.iter().filter(|part| part.0 != name);
        self.own.extend(parts.map(|part| (count.target, part.0)));
    }

    /// Goes on counting with an object of ours, unless one counts already.
    fn begin_part(&mut self, gl: &Gl, number: usize, weight: Option<f64>) {
        let target = self.running[number].target;
        let object = self.object(gl, target);
        let running = &mut self.running[number];
        begin_real(gl, running.target, running.index, object);
        running.now = Some((object, weight));
        if running.before.parts.len() > MOST_PARTS {
            let mut kept = Vec::new();
            for (object, weight) in std::mem::take(&mut running.before.parts) {
                let count = result(gl, self.wide, object);
                // One that saw something is kept for conditional rendering.
                if object == running.name || (count > 0 && kept.len() < 2) {
                    kept.push((object, weight));
                } else {
                    running.before.sum += count as f64 * weight;
                    self.own.push((target, object));
                }
            }
            running.before.parts = kept;
        }
    }
}

impl Running {
    /// Ends the part that counts now.
    pub(super) fn end_part(&mut self, gl: &Gl) {
        if let Some((object, weight)) = self.now.take() {
            end_real(gl, self.target, self.index);
            self.before.parts.push((object, weight.unwrap_or(1.0)));
        }
    }
}

fn begin_real(gl: &Gl, target: u32, index: u32, object: u32) {
    // SAFETY: a query of the program's kind, with its object or one of ours.
    unsafe { if index == 0 { gl.begin_query(target, object) } else { gl.begin_query_indexed(target, index, object) } }
}

fn end_real(gl: &Gl, target: u32, index: u32) {
    // SAFETY: as above.
    unsafe { if index == 0 { gl.end_query(target) } else { gl.end_query_indexed(target, index) } }
}

/// The count of a finished object; waits for it.
fn result(gl: &Gl, has_wide: bool, object: u32) -> u64 {
    let mut wide = 0u64;
    let mut narrow = 0u32;
    // SAFETY: each call writes one number; no buffer is bound for results (`read` sees to it).
    unsafe {
        if has_wide {
            gl.get_query_objectui64v(object, api::GL_QUERY_RESULT, &mut wide);
        } else {
            gl.get_query_objectuiv(object, api::GL_QUERY_RESULT, &mut narrow);
            wide = narrow.into();
        }
    }
    wide
}

pub(super) fn available(gl: &Gl, object: u32) -> bool {
    let mut answer = 0;
    // SAFETY: writes one number.
    unsafe { gl.get_query_objectuiv(object, api::GL_QUERY_RESULT_AVAILABLE, &mut answer) };
    answer != 0
}

impl Count {
    pub(super) fn total(&self, gl: &Gl, wide: bool) -> u64 {
        let parts = self.parts.iter().map(|(object, weight)| (result(gl, wide, *object), *weight));
        let (seen, sum) = parts.fold((self.sum > 0.0, self.sum), |(seen, sum), (count, weight)| {
            (seen || count > 0, sum + count as f64 * weight)
        });
        match self.target {
            api::GL_ANY_SAMPLES_PASSED
            | api::GL_ANY_SAMPLES_PASSED_CONSERVATIVE
            | api::GL_TRANSFORM_FEEDBACK_OVERFLOW
            | api::GL_TRANSFORM_FEEDBACK_STREAM_OVERFLOW => u64::from(seen),
            _ => (sum.round() as u64).max(u64::from(seen)),
        }
    }
}

/// The next draw counts with these weights.
pub fn weigh(ctx: &mut Context, weights: QueryWeights) {
    let gl = ctx.gl;
    for number in 0..ctx.counting.running.len() {
        let running = &mut ctx.counting.running[number];
        let wanted = weights.of(quantity(running.target));
        match &mut running.now {
            Some((_, weight)) if weight.is_none_or(|w| w == wanted) && wanted > 0.0 => *weight = Some(wanted),
            None if wanted == 0.0 => {}
            _ => {
                running.end_part(gl);
                if wanted > 0.0 {
                    ctx.counting.begin_part(gl, number, Some(wanted));
                }
            }
        }
    }
}

/// Runs work of ours, which is neither counted nor told of nor subject to the program's conditional rendering.
pub fn aside<R>(ctx: &mut Context, work: impl FnOnce(&mut Context) -> R) -> R {
    let gl = ctx.gl;
    for running in &mut ctx.counting.running {
        running.end_part(gl);
    }
    let answer = crate::intercept::gl::context::debug_output::quietly(ctx, |ctx| {
        crate::intercept::gl::draw::conditional_render::unconditionally(ctx, work)
    });
    for number in 0..ctx.counting.running.len() {
        ctx.counting.begin_part(gl, number, None);
    }
    answer
}

/// How many samples of the program's own picture one of the views' is worth: what fills that picture counts as
/// many as it has. `off_screen`: each view has as many samples as that picture.
pub fn scene_samples(ctx: &mut Context, session: &Session, off_screen: bool) -> f64 {
    let Some(lens) = ctx.lens else { return 1.0 };
    let seen = Some((lens, ctx.believed.viewport, off_screen));
    if ctx.counting.seen != seen {
        let [_, _, width, height] = ctx.believed.viewport.map(f64::from);
        let own = width * height;
        ctx.counting.worth = weight(own, session.samples(&lens, own, off_screen));
        ctx.counting.seen = seen;
    }
    ctx.counting.worth
}

/// `glBeginQuery`, `glBeginQueryIndexed`.
pub fn begin(ctx: &mut Context, target: u32, index: u32, name: u32) {
    let gl = ctx.gl;
    let collides = |r: &Running| (kind(r.target) == kind(target) && r.index == index) || r.name == name;
    if ctx.counting.running.iter().any(collides) {
        // The driver may have another object of that kind now, or none.
        return invalid(ctx);
    }
    take_error(ctx);
    begin_real(gl, target, index, name);
    // SAFETY: asks for the error flag. Whether the driver takes the query is told by that only.
    match unsafe { gl.get_error() } {
        api::GL_NO_ERROR => {
            if let Some(old) = ctx.counting.split.remove(&name) {
                ctx.counting.give_back(&old, name);
            }
            ctx.counting.wide = !ctx.profile.es && ctx.profile.version >= 33;
            let before = Count { target, ..Count::default() };
            ctx.counting.running.push(Running { target, index, name, now: Some((name, None)), before });
        }
        error if ctx.pending_error == api::GL_NO_ERROR => ctx.pending_error = error,
        _ => {}
    }
}

/// `glEndQuery`, `glEndQueryIndexed`.
pub fn end(ctx: &mut Context, target: u32, index: u32) {
    let gl = ctx.gl;
    let Some(number) = ctx.counting.running.iter().position(|r| r.target == target && r.index == index) else {
        // An error of the program's, for the driver to say.
        end_real(gl, target, index);
        return;
    };
    let mut running = ctx.counting.running.swap_remove(number);
    running.end_part(gl);
    let Running { name, before, .. } = running;
    if before.sum > 0.0 || before.parts != [(name, 1.0)] {
        ctx.counting.split.insert(name, before);
    }
}

pub(super) fn invalid(ctx: &mut Context) {
    if ctx.pending_error == api::GL_NO_ERROR {
        ctx.pending_error = api::GL_INVALID_OPERATION;
    }
}

/// The object that conditional rendering goes by, in place of the program's query: one that saw something.
pub fn condition(ctx: &Context, name: u32) -> u32 {
    let seen = |count: &Count| {
        count.parts.iter().find(|part| result(ctx.gl, ctx.counting.wide, part.0) > 0).map(|part| part.0)
    };
    ctx.counting.split.get(&name).and_then(seen).unwrap_or(name)
}

#[cfg(test)]
mod tests {
    use super::{Quantity, api, kind, quantity};

    #[test]
    fn each_kind_of_query_has_its_weight() {
        assert_eq!(quantity(api::GL_SAMPLES_PASSED), Quantity::Samples);
        assert_eq!(quantity(api::GL_PRIMITIVES_GENERATED), Quantity::Primitives);
        for whole in [api::GL_TIME_ELAPSED, api::GL_ANY_SAMPLES_PASSED, api::GL_TRANSFORM_FEEDBACK_PRIMITIVES_WRITTEN] {
            assert_eq!(quantity(whole), Quantity::Unscaled);
        }
    }

    #[test]
    fn occlusion_queries_exclude_each_other() {
        assert_eq!(kind(api::GL_ANY_SAMPLES_PASSED), kind(api::GL_SAMPLES_PASSED));
        assert_ne!(kind(api::GL_TIME_ELAPSED), kind(api::GL_SAMPLES_PASSED));
    }
}
