//! Pools of queries whose counts are scaled.

use crate::backend::vk::Buffer;
use crate::intercept::log;
use crate::intercept::scene::query_weights::{Quantity, QueryWeights};
use crate::intercept::vk::state::driver::Driver;
use crate::lock::Lock;
use ash::vk;
use std::collections::HashMap;
use std::sync::{Arc, Mutex, OnceLock};

/// A weight of one: weights have 32 bits behind the point.
pub(in crate::intercept::vk) const ONE: u64 = 1 << 32;

/// A weight with 32 bits behind the point.
pub(in crate::intercept::vk) fn fixed(weight: f64) -> u64 {
    if weight.is_finite() && weight > 0.0 { (weight * ONE as f64).round() as u64 } else { ONE }
}

/// `count` × `weight`, rounded; more than nothing if `count` is.
pub(in crate::intercept::vk) fn scaled(count: u64, weight: u64) -> u64 {
    let product = (u128::from(count) * u128::from(weight) + u128::from(ONE / 2)) >> 32;
    u64::try_from(product).unwrap_or(u64::MAX).max(u64::from(count > 0))
}

/// A pool of queries that count.
pub struct Pool {
    pub(in crate::intercept::vk) quantities: Vec<Quantity>,
    /// The queries' weights, as of their last submission.
    pub(in crate::intercept::vk) weights: Mutex<Vec<QueryWeights>>,
    /// Buffers for copies of its results, once there is one.
    pub(in crate::intercept::vk) scratch: Mutex<Option<Scratch>>,
}

impl Pool {
    /// The weight of each number of a query's result.
    pub(in crate::intercept::vk) fn weights(&self, query: u32) -> impl Iterator<Item = u64> + '_ {
        let all = self.weights.locked();
        let weights = all.get(query as usize).copied().unwrap_or(QueryWeights::ONCE);
        self.quantities.iter().map(move |quantity| fixed(weights.of(*quantity)))
    }

    /// A query that is submitted will count with these weights.
    pub(in crate::intercept::vk) fn set_weights(&self, driver: &Driver, query: u32, new: QueryWeights) {
        match self.weights.locked().get_mut(query as usize) {
            Some(weights) if *weights != new => *weights = new,
            _ => return,
        }
        if let Some(scratch) = &*self.scratch.locked() {
            scratch.set_weights(driver, query, &self.weights(query).collect::<Vec<_>>());
        }
    }

    /// Of queries whose weights are these.
    pub(in crate::intercept::vk) fn new(quantities: Vec<Quantity>, weights: Vec<QueryWeights>) -> Self {
        Self { quantities, weights: Mutex::new(weights), scratch: Mutex::default() }
    }
}

/// The program's pools of queries that count.
#[derive(Default)]
pub struct Queries {
    pub(in crate::intercept::vk) pools: Mutex<HashMap<vk::QueryPool, Arc<Pool>>>,
    pub(in crate::intercept::vk) scaler: OnceLock<Option<QueryScaler>>,
}

/// Compute pipeline that scales counts, for all pools of a device.
pub struct QueryScaler {
    pub(in crate::intercept::vk) set_layout: vk::DescriptorSetLayout,
    pub(in crate::intercept::vk) layout: vk::PipelineLayout,
    pub(in crate::intercept::vk) pipeline: vk::Pipeline,
}

/// Buffers for the copies of a pool's results.
pub struct Scratch {
    /// The results of the driver.
    pub(in crate::intercept::vk) counted: Buffer,
    pub(in crate::intercept::vk) weights: Buffer,
    /// The scaled results.
    pub(in crate::intercept::vk) scaled: Buffer,
    pub(in crate::intercept::vk) pool: vk::DescriptorPool,
    pub(in crate::intercept::vk) set: vk::DescriptorSet,
    /// Number of queries of the pool.
    pub(in crate::intercept::vk) queries: u32,
}

impl Queries {
    /// A pool, if its queries are scaled.
    pub fn get(&self, handle: vk::QueryPool) -> Option<Arc<Pool>> {
        self.pools.locked().get(&handle).cloned()
    }
}

impl Scratch {
    /// A query's numbers will have these weights. A copy of an earlier submission that still runs
    /// may see them, too: what a query counts seldom becomes something else from one frame to the
    /// next.
    pub fn set_weights(&self, driver: &Driver, query: u32, weights: &[u64]) {
        let bytes: Vec<u8> = weights.iter().flat_map(|weight| weight.to_ne_bytes()).collect();
        let offset = 8 + query as usize * bytes.len();
        if let Err(error) = self.weights.write(&driver.api, offset, &bytes) {
            log::once(&format!("Vulkan: counts of queries are not scaled: {error}"));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{ONE, scaled};

    #[test]
    fn counts_are_multiplied_and_rounded_and_what_was_seen_stays_seen() {
        assert_eq!([scaled(0, ONE / 1000), scaled(1, ONE / 1000), scaled(1600, ONE / 1000)], [0, 1, 2]);
        assert_eq!(scaled(36 * 7, ONE / 7), 36);
        for count in [1, 65535, u64::from(u32::MAX), u64::MAX] {
            assert_eq!(scaled(count, ONE), count, "one changes nothing");
            assert_eq!(scaled(count, 3 * ONE), count.saturating_mul(3));
        }
    }
}
