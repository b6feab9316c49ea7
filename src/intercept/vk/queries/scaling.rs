//! Queries that count what a program draws, though each draw is issued once per view.
//!
//! A query counts all that is issued while it runs. What the program is told is that number times a
//! weight ([`QueryWeights`]), which is known when the command buffer is submitted, as what its draws
//! are is known then. Each draw is issued a known number of times, so that counts of primitives are
//! exact where all draws of a query are issued as often, or where the program says how large they
//! are.
//!
//! [`running`] finds the weights, `results` tells the program what it
//! reads, `copies` what a command copies for it.

use crate::intercept::scene::query_weights::{Quantity, QueryWeights};
use crate::intercept::vk::layer::device::Device;
use crate::intercept::vk::layer::hooks::hooks;
use crate::intercept::vk::queries::copies::{self, Scratch, Weigher};
use crate::intercept::vk::queries::results::{self, Wanted};
use crate::intercept::vk::queries::running;
use ash::vk;
use std::collections::HashMap;
use std::ffi::c_void;
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

/// A weight of one: weights have 32 bits behind the point.
pub(super) const ONE: u64 = 1 << 32;

/// A weight with 32 bits behind the point.
pub(super) fn fixed(weight: f64) -> u64 {
    if weight.is_finite() && weight > 0.0 { (weight * ONE as f64).round() as u64 } else { ONE }
}

/// `count` × `weight`, rounded; more than nothing if `count` is.
pub(super) fn weighed(count: u64, weight: u64) -> u64 {
    let product = (u128::from(count) * u128::from(weight) + u128::from(ONE / 2)) >> 32;
    u64::try_from(product).unwrap_or(u64::MAX).max(u64::from(count > 0))
}

/// What the numbers of a query's result are; empty for queries whose numbers are the program's as they are.
fn meanings(info: &vk::QueryPoolCreateInfo<'_>) -> Vec<Quantity> {
    use vk::QueryPipelineStatisticFlags as S;
    match info.query_type {
        vk::QueryType::OCCLUSION => vec![Quantity::Samples],
        vk::QueryType::PRIMITIVES_GENERATED_EXT | vk::QueryType::MESH_PRIMITIVES_GENERATED_EXT => {
            vec![Quantity::Primitives]
        }
        vk::QueryType::PIPELINE_STATISTICS => {
            let bits = (0..u32::BITS).map(|bit| S::from_raw(1 << bit));
            let of = |bit| match bit {
                S::FRAGMENT_SHADER_INVOCATIONS => Quantity::Samples,
                // What clipping leaves of a primitive is left in the views that show it.
                S::CLIPPING_PRIMITIVES | S::COMPUTE_SHADER_INVOCATIONS => Quantity::Unscaled,
                _ => Quantity::Primitives,
            };
            bits.filter(|bit| info.pipeline_statistics.contains(*bit)).map(of).collect()
        }
        _ => Vec::new(),
    }
}

/// A pool of queries that count.
pub struct Pool {
    pub(super) meanings: Vec<Quantity>,
    /// The queries' weights, as of their last submission.
    pub(super) weights: Mutex<Vec<QueryWeights>>,
    /// What copies of its results need, once there is one.
    pub(super) scratch: Mutex<Option<Scratch>>,
}

impl Pool {
    /// The weight of each number of a query's result.
    pub(super) fn weights(&self, query: u32) -> impl Iterator<Item = u64> + '_ {
        let all = self.weights.lock().unwrap_or_else(PoisonError::into_inner);
        let weights = all.get(query as usize).copied().unwrap_or(QueryWeights::ONCE);
        self.meanings.iter().map(move |quantity| fixed(weights.of(*quantity)))
    }

    /// A query that is submitted will count with these weights.
    pub(super) fn weigh(&self, device: &Device, query: u32, new: QueryWeights) {
        match self.weights.lock().unwrap_or_else(PoisonError::into_inner).get_mut(query as usize) {
            Some(weights) if *weights != new => *weights = new,
            _ => return,
        }
        if let Some(scratch) = &*self.scratch.lock().unwrap_or_else(PoisonError::into_inner) {
            scratch.weigh(device, query, &self.weights(query).collect::<Vec<_>>());
        }
    }

    /// Of queries whose weights are these.
    pub(super) fn new(meanings: Vec<Quantity>, weights: Vec<QueryWeights>) -> Self {
        Self { meanings, weights: Mutex::new(weights), scratch: Mutex::default() }
    }
}

/// The program's pools of queries that count.
#[derive(Default)]
pub struct Queries {
    pools: Mutex<HashMap<vk::QueryPool, Arc<Pool>>>,
    pub(super) weigher: OnceLock<Option<Weigher>>,
}

impl Queries {
    /// A pool, if its queries are weighed.
    pub fn get(&self, handle: vk::QueryPool) -> Option<Arc<Pool>> {
        self.pools.lock().unwrap_or_else(PoisonError::into_inner).get(&handle).cloned()
    }

    /// A pool is gone.
    fn forget(&self, device: &Device, handle: vk::QueryPool) {
        let gone = self.pools.lock().unwrap_or_else(PoisonError::into_inner).remove(&handle);
        let scratch = gone.and_then(|gone| gone.scratch.lock().unwrap_or_else(PoisonError::into_inner).take());
        scratch.into_iter().for_each(|mut scratch| scratch.destroy(device));
    }

    /// Destroys what is ours, before the device is destroyed.
    pub fn clear(&self, device: &Device) {
        let all: Vec<_> = self.pools.lock().unwrap_or_else(PoisonError::into_inner).keys().copied().collect();
        all.into_iter().for_each(|handle| self.forget(device, handle));
        self.weigher.get().iter().copied().flatten().for_each(|weigher| weigher.destroy(device));
    }
}

hooks! { queries;
    [c"vkCreateQueryPool"] create_query_pool: vk::PFN_vkCreateQueryPool = (
        device: vk::Device, info: *const vk::QueryPoolCreateInfo<'_>, allocator: *const vk::AllocationCallbacks<'_>, made: *mut vk::QueryPool
    ) -> vk::Result { |state, next| {
        let result = next(device, info, allocator, made);
        let meanings = meanings(&*info);
        if result == vk::Result::SUCCESS && !meanings.is_empty() {
            let weights = vec![QueryWeights::ONCE; (*info).query_count as usize];
            let mut pools = state.queries.pools.lock().unwrap_or_else(PoisonError::into_inner);
            pools.insert(*made, Arc::new(Pool::new(meanings, weights)));
        }
        result
    } }
    [c"vkDestroyQueryPool"] destroy_query_pool: vk::PFN_vkDestroyQueryPool = (
        device: vk::Device, pool: vk::QueryPool, allocator: *const vk::AllocationCallbacks<'_>
    ) { |state, next| {
        state.queries.forget(&state, pool);
        next(device, pool, allocator)
    } }
    [c"vkCmdBeginQuery"] cmd_begin_query: vk::PFN_vkCmdBeginQuery = (
        buffer: vk::CommandBuffer, pool: vk::QueryPool, query: u32, flags: vk::QueryControlFlags
    ) { |state, next| {
        running::begin(&state, buffer, pool, query);
        next(buffer, pool, query, flags)
    } }
    [c"vkCmdBeginQueryIndexedEXT"] cmd_begin_query_indexed: vk::PFN_vkCmdBeginQueryIndexedEXT = (
        buffer: vk::CommandBuffer, pool: vk::QueryPool, query: u32, flags: vk::QueryControlFlags, index: u32
    ) { |state, next| {
        running::begin(&state, buffer, pool, query);
        next(buffer, pool, query, flags, index)
    } }
    [c"vkCmdEndQuery"] cmd_end_query: vk::PFN_vkCmdEndQuery = (
        buffer: vk::CommandBuffer, pool: vk::QueryPool, query: u32
    ) { |state, next| {
        running::end(&state, buffer, pool, query);
        next(buffer, pool, query)
    } }
    [c"vkCmdEndQueryIndexedEXT"] cmd_end_query_indexed: vk::PFN_vkCmdEndQueryIndexedEXT = (
        buffer: vk::CommandBuffer, pool: vk::QueryPool, query: u32, index: u32
    ) { |state, next| {
        running::end(&state, buffer, pool, query);
        next(buffer, pool, query, index)
    } }
    [c"vkGetQueryPoolResults"] get_query_pool_results: vk::PFN_vkGetQueryPoolResults = (
        device: vk::Device, pool: vk::QueryPool, first: u32, count: u32, size: usize, data: *mut c_void, stride: vk::DeviceSize, flags: vk::QueryResultFlags
    ) -> vk::Result { |state, next| match state.queries.get(pool) {
        None => next(device, pool, first, count, size, data, stride, flags),
        Some(known) => {
            let mut raw = vec![0_u64; count as usize * known.stride()];
            let (asked, bytes) = (flags | results::RAW, size_of_val(raw.as_slice()));
            let result = next(device, pool, first, count, bytes, raw.as_mut_ptr().cast(), known.stride_in_bytes(), asked);
            if result.as_raw() >= 0 {
                Wanted { to: data.cast(), size, stride: stride as usize, flags }.write(&known, first, &raw);
            }
            result
        }
    } }
    [c"vkCmdCopyQueryPoolResults"] cmd_copy_query_pool_results: vk::PFN_vkCmdCopyQueryPoolResults = (
        buffer: vk::CommandBuffer, pool: vk::QueryPool, first: u32, count: u32, to: vk::Buffer, offset: vk::DeviceSize, stride: vk::DeviceSize, flags: vk::QueryResultFlags
    ) { |state, next| {
        let wanted = copies::Wanted { queries: (first, count), to, place: (offset, stride), flags };
        state.queries.copy((&state, buffer), pool, &wanted, |to, offset, stride, flags| next(buffer, pool, first, count, to, offset, stride, flags))
    } }
}

#[cfg(test)]
mod tests {
    use super::{ONE, Quantity, meanings, weighed};
    use ash::vk;

    #[test]
    fn counts_are_multiplied_and_rounded_and_what_was_seen_stays_seen() {
        assert_eq!([weighed(0, ONE / 1000), weighed(1, ONE / 1000), weighed(1600, ONE / 1000)], [0, 1, 2]);
        assert_eq!(weighed(36 * 7, ONE / 7), 36);
        for count in [1, 65535, u64::from(u32::MAX), u64::MAX] {
            assert_eq!(weighed(count, ONE), count, "one changes nothing");
            assert_eq!(weighed(count, 3 * ONE), count.saturating_mul(3));
        }
    }

    #[test]
    fn each_number_has_its_meaning_in_the_order_of_the_bits() {
        use vk::QueryPipelineStatisticFlags as S;
        let asked = S::FRAGMENT_SHADER_INVOCATIONS | S::INPUT_ASSEMBLY_VERTICES | S::COMPUTE_SHADER_INVOCATIONS;
        let info = vk::QueryPoolCreateInfo::default().query_type(vk::QueryType::PIPELINE_STATISTICS);
        let all = meanings(&info.pipeline_statistics(asked));
        assert_eq!(all, [Quantity::Primitives, Quantity::Samples, Quantity::Unscaled]);
        assert!(meanings(&info.query_type(vk::QueryType::TIMESTAMP)).is_empty());
    }
}
