//! Bindings of the program for compute shaders. They are stored so that they can be restored after
//! a shader of Cupola.

use crate::intercept::vk::state::driver::Driver;
use crate::intercept::vk::state::driver::entry_points::NextLayer;
use crate::intercept::vk::state::recording::bindings::{BoundSet, PUSH_BYTES, Pushed, Write};
use ash::vk;

/// Bindings for compute shaders while a command buffer is recorded.
pub struct ComputeBindings {
    pipeline: vk::Pipeline,
    /// Push constants.
    push: [u8; PUSH_BYTES],
    /// Descriptor sets, by number and with the layout that they were bound for, in the order in
    /// which they were bound. The order matters: a set invalidates earlier ones whose layouts are
    /// not compatible with its own.
    sets: Vec<(u32, vk::PipelineLayout, BoundSet)>,
}

impl Default for ComputeBindings {
    fn default() -> Self {
        Self { pipeline: vk::Pipeline::null(), push: [0; PUSH_BYTES], sets: Vec::new() }
    }
}

impl ComputeBindings {
    /// Sets push constants from byte `start` on.
    pub fn push_constants(&mut self, start: usize, values: &[u8]) {
        let start = start.min(PUSH_BYTES);
        let end = (start + values.len()).min(PUSH_BYTES);
        self.push[start..end].copy_from_slice(&values[..end - start]);
    }

    /// Returns the push constants.
    pub fn pushed(&self) -> &[u8] {
        &self.push
    }

    /// Returns a set by its number.
    pub fn set(&self, number: u32) -> Option<&BoundSet> {
        self.sets.iter().find(|(known, ..)| *known == number).map(|(.., bound)| bound)
    }

    /// Notes a bound pipeline.
    pub fn bind(&mut self, pipeline: vk::Pipeline) {
        self.pipeline = pipeline;
    }

    /// Notes bound sets from the number `first` on.
    pub fn bind_sets(&mut self, layout: vk::PipelineLayout, first: u32, sets: Vec<BoundSet>) {
        for (number, bound) in (first..).zip(sets) {
            self.take(number);
            self.sets.push((number, layout, bound));
        }
    }

    /// Notes pushed descriptors.
    pub fn push(&mut self, layout: vk::PipelineLayout, number: u32, writes: Vec<Write>) {
        let before = self.take(number).and_then(|bound| bound.pushed);
        let bound = BoundSet { pushed: Some(Pushed::after(before, writes)), ..BoundSet::default() };
        self.sets.push((number, layout, bound));
    }

    /// Returns the pipeline.
    pub fn pipeline(&self) -> vk::Pipeline {
        self.pipeline
    }

    /// Returns the sets, with the layouts that they were bound for, in the order in which they were
    /// bound.
    pub fn sets(&self) -> &[(u32, vk::PipelineLayout, BoundSet)] {
        &self.sets
    }

    fn take(&mut self, number: u32) -> Option<BoundSet> {
        let known = self.sets.iter().position(|(known, ..)| *known == number)?;
        Some(self.sets.remove(known).2)
    }

    /// Binds everything again.
    ///
    /// # Safety
    /// The command buffer is being recorded.
    pub unsafe fn restore(&self, driver: &Driver, next: &NextLayer, buffer: vk::CommandBuffer) {
        let (functions, point) = (&driver.functions, vk::PipelineBindPoint::COMPUTE);
        // SAFETY: as promised; the program bound all of it in this command buffer, for these
        // layouts.
        unsafe {
            if self.pipeline != vk::Pipeline::null() {
                functions.cmd_bind_pipeline(buffer, point, self.pipeline);
            }
            for (number, layout, bound) in &self.sets {
                match &bound.pushed {
                    Some(pushed) => pushed.repeat(next, buffer, point, *layout, *number),
                    None => functions.cmd_bind_descriptor_sets(
                        buffer,
                        point,
                        *layout,
                        *number,
                        &[bound.set],
                        &bound.dynamic,
                    ),
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::ComputeBindings;
    use crate::intercept::vk::state::recording::bindings::BoundSet;
    use ash::vk::{self, Handle};

    #[test]
    fn what_was_bound_last_comes_last() {
        let (mut compute, layout) = (ComputeBindings::default(), vk::PipelineLayout::null());
        let set = |number| BoundSet { set: vk::DescriptorSet::from_raw(number), ..BoundSet::default() };
        compute.bind_sets(layout, 0, vec![set(10), set(11), set(12)]);
        compute.bind_sets(layout, 1, vec![set(21)]);
        let order: Vec<_> = compute.sets.iter().map(|(number, _, bound)| (*number, bound.set.as_raw())).collect();
        assert_eq!(order, [(0, 10), (2, 12), (1, 21)]);
    }
}
