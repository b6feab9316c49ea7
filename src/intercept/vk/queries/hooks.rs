//! Hooks of queries that count draws.
//!
//! A query counts everything that is issued while it is active. The program gets that number times
//! a factor (`QueryScaling`), which is known at submission. Each draw is issued a known number of
//! times. So counts of primitives are exact if all draws of a query are issued equally often, or if
//! the sizes of the draws are known.

use crate::intercept::scene::query_scaling::{Quantity, QueryScaling};
use crate::intercept::vk::queries::results::HostResults;
use crate::intercept::vk::queries::{copies, results, running};
use crate::intercept::vk::state::device::Device;
use crate::intercept::vk::state::hooks::hooks;
use crate::intercept::vk::state::queries::{Pool, Queries};
use crate::lock::Lock;
use ash::vk;
use std::ffi::c_void;
use std::sync::Arc;
use std::sync::atomic::Ordering;

/// Returns the quantities of a query's result; empty for queries whose results are not scaled.
fn quantities(info: &vk::QueryPoolCreateInfo<'_>) -> Vec<Quantity> {
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
                // After clipping, a primitive remains only in views that show it, so the count is
                // not divided.
                S::CLIPPING_PRIMITIVES | S::COMPUTE_SHADER_INVOCATIONS => Quantity::Unscaled,
                _ => Quantity::Primitives,
            };
            bits.filter(|bit| info.pipeline_statistics.contains(*bit)).map(of).collect()
        }
        _ => Vec::new(),
    }
}

impl Queries {
    /// Forgets a destroyed pool.
    fn forget(&self, device: &Device, handle: vk::QueryPool) {
        let gone = self.pools.locked().remove(&handle);
        let scratch = gone.and_then(|gone| gone.scratch.locked().take());
        scratch.into_iter().for_each(|mut scratch| scratch.destroy(device));
    }

    /// Destroys objects of Cupola, before the device is destroyed.
    pub fn clear(&self, device: &Device) {
        let all: Vec<_> = self.pools.locked().keys().copied().collect();
        all.into_iter().for_each(|handle| self.forget(device, handle));
        self.scaler.get().iter().copied().flatten().for_each(|scaler| scaler.destroy(device));
    }
}

hooks! {
    create_query_pool = (
        device: vk::Device, info: *const vk::QueryPoolCreateInfo<'_>, allocator: *const vk::AllocationCallbacks<'_>, made: *mut vk::QueryPool
    ) -> vk::Result { |state, next| {
        let result = next(device, info, allocator, made);
        let quantities = quantities(&*info);
        if result == vk::Result::SUCCESS && !quantities.is_empty() {
            let factors = vec![QueryScaling::ONCE; (*info).query_count as usize];
            state.queries.have_counted.store(true, Ordering::Relaxed);
            let mut pools = state.queries.pools.locked();
            pools.insert(*made, Arc::new(Pool::new(quantities, factors)));
        }
        result
    } }
    destroy_query_pool = (
        device: vk::Device, pool: vk::QueryPool, allocator: *const vk::AllocationCallbacks<'_>
    ) { |state, next| {
        state.queries.forget(&state, pool);
        next(device, pool, allocator)
    } }
    cmd_begin_query = (
        buffer: vk::CommandBuffer, pool: vk::QueryPool, query: u32, flags: vk::QueryControlFlags
    ) { |state, next| {
        running::begin(&state, buffer, pool, query);
        next(buffer, pool, query, flags)
    } }
    cmd_begin_query_indexed = (
        buffer: vk::CommandBuffer, pool: vk::QueryPool, query: u32, flags: vk::QueryControlFlags, index: u32
    ) { |state, next| {
        running::begin(&state, buffer, pool, query);
        next(buffer, pool, query, flags, index)
    } }
    cmd_end_query = (
        buffer: vk::CommandBuffer, pool: vk::QueryPool, query: u32
    ) { |state, next| {
        running::end(&state, buffer, pool, query);
        next(buffer, pool, query)
    } }
    cmd_end_query_indexed = (
        buffer: vk::CommandBuffer, pool: vk::QueryPool, query: u32, index: u32
    ) { |state, next| {
        running::end(&state, buffer, pool, query);
        next(buffer, pool, query, index)
    } }
    get_query_pool_results = (
        device: vk::Device, pool: vk::QueryPool, first: u32, count: u32, size: usize, data: *mut c_void, stride: vk::DeviceSize, flags: vk::QueryResultFlags
    ) -> vk::Result { |state, next| match state.queries.get(pool) {
        None => next(device, pool, first, count, size, data, stride, flags),
        Some(known) => {
            let mut raw = vec![0_u64; count as usize * known.stride()];
            let (asked, bytes) = (flags | results::RAW, size_of_val(raw.as_slice()));
            let result = next(device, pool, first, count, bytes, raw.as_mut_ptr().cast(), known.stride_in_bytes(), asked);
            if result.as_raw() >= 0 {
                HostResults { to: data.cast(), size, stride: stride as usize, flags }.write(&known, first, &raw);
            }
            result
        }
    } }
    cmd_copy_query_pool_results = (
        buffer: vk::CommandBuffer, pool: vk::QueryPool, first: u32, count: u32, to: vk::Buffer, offset: vk::DeviceSize, stride: vk::DeviceSize, flags: vk::QueryResultFlags
    ) { |state, next| {
        let wanted = copies::CopiedResults { queries: (first, count), to, place: (offset, stride), flags };
        state.queries.copy(&state, buffer, pool, &wanted, |to, offset, stride, flags| next(buffer, pool, first, count, to, offset, stride, flags))
    } }
}

#[cfg(test)]
mod tests {
    use super::{Quantity, quantities};
    use ash::vk;

    #[test]
    fn each_number_has_its_meaning_in_the_order_of_the_bits() {
        use vk::QueryPipelineStatisticFlags as S;
        let asked = S::FRAGMENT_SHADER_INVOCATIONS | S::INPUT_ASSEMBLY_VERTICES | S::COMPUTE_SHADER_INVOCATIONS;
        let info = vk::QueryPoolCreateInfo::default().query_type(vk::QueryType::PIPELINE_STATISTICS);
        let all = quantities(&info.pipeline_statistics(asked));
        assert_eq!(all, [Quantity::Primitives, Quantity::Samples, Quantity::Unscaled]);
        assert!(quantities(&info.query_type(vk::QueryType::TIMESTAMP)).is_empty());
    }
}
