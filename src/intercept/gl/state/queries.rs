//! Queries of the program. Each is a sequence of parts with factors.

use crate::backend::gl::driver::api::{self, Gl};
use crate::correct::LowerLeftRect;
use crate::intercept::scene::query_scaling::Quantity;
use crate::runtime::session::Intrinsics;
use std::collections::HashMap;

/// The counting queries of a context.
#[derive(Default)]
pub struct Queries {
    pub(in crate::intercept::gl) running: Vec<Running>,
    /// Finished queries whose result needs more than the program's own object, by the program's
    /// name for the query.
    pub(in crate::intercept::gl) split: HashMap<u32, Count>,
    /// Objects of Cupola that are not in use, with their target. An object keeps the target of its
    /// first use.
    pub(in crate::intercept::gl) own: Vec<(u32, u32)>,
    /// Objects of Cupola that were never used.
    pub(in crate::intercept::gl) fresh: Vec<u32>,
    /// Lens, viewport and off-screen mode for which `worth` was computed.
    pub(in crate::intercept::gl) seen: Option<(Intrinsics, LowerLeftRect, bool)>,
    /// Factor from samples in all views to samples in the program's own picture.
    pub(in crate::intercept::gl) worth: f64,
    /// True if the context has results of 64 bits.
    pub(in crate::intercept::gl) wide: bool,
    /// True if the context has buffers for results.
    pub(in crate::intercept::gl) has_buffers: bool,
    /// True if a query has counted what is drawn.
    pub(in crate::intercept::gl) have_counted: bool,
    /// Conditional rendering.
    pub(in crate::intercept::gl) condition: Condition,
}

/// A query between Begin and End.
pub(in crate::intercept::gl) struct Running {
    pub(in crate::intercept::gl) target: u32,
    pub(in crate::intercept::gl) index: u32,
    pub(in crate::intercept::gl) name: u32,
    /// Object that counts now, with its factor once something was drawn; `None` = no object counts.
    pub(in crate::intercept::gl) now: Option<(u32, Option<f64>)>,
    pub(in crate::intercept::gl) before: Count,
}

/// Counts of the finished parts of a query.
#[derive(Default)]
pub(in crate::intercept::gl) struct Count {
    pub(in crate::intercept::gl) target: u32,
    /// Objects of the parts, with their factors.
    pub(in crate::intercept::gl) parts: Vec<(u32, f64)>,
    /// Sum of the parts that were read already.
    pub(in crate::intercept::gl) sum: f64,
}

/// Returns the quantity that a query of this target counts.
pub(in crate::intercept::gl) fn quantity(target: u32) -> Quantity {
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

/// Returns the kind of a query's target. Queries of one kind exclude each other.
pub(in crate::intercept::gl) fn kind(target: u32) -> u32 {
    match target {
        api::GL_ANY_SAMPLES_PASSED | api::GL_ANY_SAMPLES_PASSED_CONSERVATIVE => api::GL_SAMPLES_PASSED,
        other => other,
    }
}

/// Greatest number of finished parts that wait while their query is running. If there are more,
/// they are read.
pub(in crate::intercept::gl) const MOST_PARTS: usize = 16;

/// Number of names that are generated at once.
pub(in crate::intercept::gl) const OWN_NAMES: usize = 16;

/// Number of low names that are left to the program. Programs with the compatibility profile use
/// names without reserving them.
pub(in crate::intercept::gl) const PROGRAM_NAMES: usize = 1024;

impl Queries {
    /// True if any query runs.
    pub fn any(&self) -> bool {
        !self.running.is_empty()
    }

    /// True if a running query counts primitives, so that no draw may be left out.
    pub fn primitives(&self) -> bool {
        self.running.iter().any(|r| quantity(r.target) == Quantity::Primitives)
    }

    /// True if a query has counted what is drawn. Its result must not depend on the machine, and
    /// depends on draws outside of the query, too, which may hide what it counts.
    pub fn have_counted(&self) -> bool {
        self.have_counted
    }

    /// Ends the part of each running query that counts now, before internal drawing of Cupola.
    pub fn end_parts(&mut self, gl: &Gl) {
        for running in &mut self.running {
            running.end_part(gl);
        }
    }

    /// Begins a part of each running query, after internal drawing of Cupola.
    pub fn begin_parts(&mut self, gl: &Gl) {
        for number in 0..self.running.len() {
            self.begin_part(gl, number, None);
        }
    }

    /// True while conditional rendering is in force.
    pub fn is_conditional(&self) -> bool {
        self.condition.is_some()
    }

    /// Suspends conditional rendering, before internal drawing of Cupola.
    pub fn suspend_condition(&self, gl: &Gl) {
        if self.condition.is_some() {
            // SAFETY: conditional rendering is in force, as its hook saw.
            unsafe { gl.end_conditional_render() };
        }
    }

    /// Puts conditional rendering back.
    pub fn resume_condition(&self, gl: &Gl) {
        if let Some((query, mode)) = self.condition {
            // SAFETY: the object and mode that were in force.
            unsafe { gl.begin_conditional_render(query, mode) };
        }
    }

    /// Forgets the factor, as the views have changed.
    pub fn forget_views(&mut self) {
        self.seen = None;
    }

    fn object(&mut self, gl: &Gl, target: u32) -> u32 {
        if let Some(index) = self.own.iter().position(|own| own.0 == target) {
            return self.own.swap_remove(index).1;
        }
        if self.fresh.is_empty() {
            self.fresh = own_names(gl, OWN_NAMES);
        }
        self.fresh.pop().unwrap_or_default()
    }

    /// Makes the objects of Cupola in `count` available again. `name` is the program's own object.
    pub(in crate::intercept::gl) fn give_back(&mut self, count: &Count, name: u32) {
        let parts = count.parts.iter().filter(|part| part.0 != name);
        self.own.extend(parts.map(|part| (count.target, part.0)));
    }

    /// Begins the next part of a query, with an object of Cupola. No part of the query may be
    /// counting.
    pub(in crate::intercept::gl) fn begin_part(&mut self, gl: &Gl, number: usize, factor: Option<f64>) {
        let target = self.running[number].target;
        let object = self.object(gl, target);
        let running = &mut self.running[number];
        begin_real(gl, running.target, running.index, object);
        running.now = Some((object, factor));
        if running.before.parts.len() > MOST_PARTS {
            let _unbound = ResultBuffer::unbind(gl, self.has_buffers);
            let mut kept = Vec::new();
            for (object, factor) in std::mem::take(&mut running.before.parts) {
                let count = result(gl, self.wide, object);
                // A part that counted something is stored for conditional rendering.
                if object == running.name || (count > 0 && kept.len() < 2) {
                    kept.push((object, factor));
                } else {
                    running.before.sum += count as f64 * factor;
                    self.own.push((target, object));
                }
            }
            running.before.parts = kept;
        }
    }
}

/// Returns names for `count` objects of Cupola, which are never deleted.
pub(in crate::intercept::gl) fn own_names(gl: &Gl, count: usize) -> Vec<u32> {
    let mut names = vec![0; PROGRAM_NAMES + count];
    // SAFETY: writes as many names as there is room for, and frees those that are not for Cupola.
    unsafe {
        gl.gen_queries(names.len() as i32, names.as_mut_ptr());
        gl.delete_queries(PROGRAM_NAMES as i32, names.as_ptr());
    }
    names.split_off(PROGRAM_NAMES)
}

impl Running {
    /// Ends the part that counts now.
    pub(in crate::intercept::gl) fn end_part(&mut self, gl: &Gl) {
        if let Some((object, factor)) = self.now.take() {
            end_real(gl, self.target, self.index);
            self.before.parts.push((object, factor.unwrap_or(1.0)));
        }
    }
}

pub(in crate::intercept::gl) fn begin_real(gl: &Gl, target: u32, index: u32, object: u32) {
    // SAFETY: a query of the program's kind, with its object or one of Cupola's.
    unsafe { if index == 0 { gl.begin_query(target, object) } else { gl.begin_query_indexed(target, index, object) } }
}

pub(in crate::intercept::gl) fn end_real(gl: &Gl, target: u32, index: u32) {
    // SAFETY: as above.
    unsafe { if index == 0 { gl.end_query(target) } else { gl.end_query_indexed(target, index) } }
}

/// The program's buffer for results, which is unbound until this value is dropped. While the buffer
/// is bound, the driver would write Cupola's own reads into it.
pub(in crate::intercept::gl) struct ResultBuffer<'a> {
    gl: &'a Gl,
    buffer: u32,
}

impl<'a> ResultBuffer<'a> {
    /// `has_buffers`: the context has buffers for results ([`Queries::has_buffers`]).
    pub fn unbind(gl: &'a Gl, has_buffers: bool) -> Self {
        let mut buffer = 0;
        if has_buffers {
            // SAFETY: writes one integer.
            unsafe { gl.get_integerv(api::GL_QUERY_BUFFER_BINDING, &mut buffer) };
        }
        if buffer != 0 {
            // SAFETY: the context has this target.
            unsafe { gl.bind_buffer(api::GL_QUERY_BUFFER, 0) };
        }
        Self { gl, buffer: buffer as u32 }
    }

    /// Name of the buffer; 0: the program has bound none.
    pub fn name(&self) -> u32 {
        self.buffer
    }
}

impl Drop for ResultBuffer<'_> {
    fn drop(&mut self) {
        if self.buffer != 0 {
            // SAFETY: the buffer that was bound.
            unsafe { self.gl.bind_buffer(api::GL_QUERY_BUFFER, self.buffer) };
        }
    }
}

/// Returns the count of a finished object. Waits for it. No buffer for results may be bound
/// ([`ResultBuffer`]).
pub(in crate::intercept::gl) fn result(gl: &Gl, has_wide: bool, object: u32) -> u64 {
    let mut wide = 0u64;
    let mut narrow = 0u32;
    // SAFETY: each call writes one number, as no buffer is bound for results.
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

pub(in crate::intercept::gl) fn available(gl: &Gl, object: u32) -> bool {
    let mut answer = 0;
    // SAFETY: writes one number.
    unsafe { gl.get_query_objectuiv(object, api::GL_QUERY_RESULT_AVAILABLE, &mut answer) };
    answer != 0
}

impl Count {
    pub(in crate::intercept::gl) fn total(&self, gl: &Gl, wide: bool) -> u64 {
        let parts = self.parts.iter().map(|(object, factor)| (result(gl, wide, *object), *factor));
        let (seen, sum) = parts.fold((self.sum > 0.0, self.sum), |(seen, sum), (count, factor)| {
            (seen || count > 0, sum + count as f64 * factor)
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

/// Object and mode of `glBeginConditionalRender`, while it is in force.
pub type Condition = Option<(u32, u32)>;

#[cfg(test)]
mod tests {
    use super::{Quantity, api, kind, quantity};

    #[test]
    fn each_kind_of_query_has_its_factor() {
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
