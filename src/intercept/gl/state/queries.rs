//! Queries of the program, as parts with factors.

use crate::backend::gl::driver::api::{self, Gl};
use crate::correct::LowerLeftRect;
use crate::intercept::scene::query_scaling::Quantity;
use crate::runtime::session::Intrinsics;
use std::collections::HashMap;

/// The counting queries of a context.
#[derive(Default)]
pub struct Queries {
    pub(in crate::intercept::gl) running: Vec<Running>,
    /// Finished queries whose result is more than what their object says, by the program's name for
    /// them.
    pub(in crate::intercept::gl) split: HashMap<u32, Count>,
    /// Objects of Cupola that are in no use, with their target: an object stays what it was first.
    pub(in crate::intercept::gl) own: Vec<(u32, u32)>,
    /// Objects of Cupola that were never anything.
    pub(in crate::intercept::gl) fresh: Vec<u32>,
    /// The lens and viewport for which `worth` was computed.
    pub(in crate::intercept::gl) seen: Option<(Intrinsics, LowerLeftRect, bool)>,
    /// Number of samples of the program's own picture that one of the views' is worth.
    pub(in crate::intercept::gl) worth: f64,
    /// The context has results of 64 bits.
    pub(in crate::intercept::gl) wide: bool,
    /// Conditional rendering.
    pub(in crate::intercept::gl) condition: Condition,
}

/// A query between Begin and End.
pub(in crate::intercept::gl) struct Running {
    pub(in crate::intercept::gl) target: u32,
    pub(in crate::intercept::gl) index: u32,
    pub(in crate::intercept::gl) name: u32,
    /// The object that counts now, with its factor once something was drawn; `None` = nothing
    /// counts.
    pub(in crate::intercept::gl) now: Option<(u32, Option<f64>)>,
    pub(in crate::intercept::gl) before: Count,
}

/// Counts of the finished parts of a query.
#[derive(Default)]
pub(in crate::intercept::gl) struct Count {
    pub(in crate::intercept::gl) target: u32,
    /// Objects and factors.
    pub(in crate::intercept::gl) parts: Vec<(u32, f64)>,
    /// Of parts that were read already.
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

/// Queries of one kind exclude each other.
pub(in crate::intercept::gl) fn kind(target: u32) -> u32 {
    match target {
        api::GL_ANY_SAMPLES_PASSED | api::GL_ANY_SAMPLES_PASSED_CONSERVATIVE => api::GL_SAMPLES_PASSED,
        other => other,
    }
}

/// More finished parts than this are read while their query runs on.
pub(in crate::intercept::gl) const MOST_PARTS: usize = 16;

/// Number of names that are generated at once.
pub(in crate::intercept::gl) const OWN_NAMES: usize = 16;

/// Programs of the old profile use names that they never asked for; ours are this far from them.
pub(in crate::intercept::gl) const PROGRAM_NAMES: usize = 1024;

impl Queries {
    /// True if any query runs.
    pub fn any(&self) -> bool {
        !self.running.is_empty()
    }

    /// True if it is counted how many primitives there are, so that no draw may be left out.
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
            self.fresh = own_names(gl, OWN_NAMES);
        }
        self.fresh.pop().unwrap_or_default()
    }

    /// The objects of Cupola in `count` are free again.
    pub(in crate::intercept::gl) fn give_back(&mut self, count: &Count, name: u32) {
        let parts = count.parts.iter().filter(|part| part.0 != name);
        self.own.extend(parts.map(|part| (count.target, part.0)));
    }

    /// Goes on counting with an object of Cupola, unless one counts already.
    pub(in crate::intercept::gl) fn begin_part(&mut self, gl: &Gl, number: usize, factor: Option<f64>) {
        let target = self.running[number].target;
        let object = self.object(gl, target);
        let running = &mut self.running[number];
        begin_real(gl, running.target, running.index, object);
        running.now = Some((object, factor));
        if running.before.parts.len() > MOST_PARTS {
            let mut kept = Vec::new();
            for (object, factor) in std::mem::take(&mut running.before.parts) {
                let count = result(gl, self.wide, object);
                // One that saw something is kept for conditional rendering.
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

/// Names of `count` objects of Cupola, which are not deleted.
pub(in crate::intercept::gl) fn own_names(gl: &Gl, count: usize) -> Vec<u32> {
    let mut names = vec![0; PROGRAM_NAMES + count];
    // SAFETY: writes as many names as there is room for, and gives back those that are not for us.
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

/// The count of a finished object; waits for it.
pub(in crate::intercept::gl) fn result(gl: &Gl, has_wide: bool, object: u32) -> u64 {
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

/// The object and the mode that `glBeginConditionalRender` stands for, while it is in force.
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
