//! Pools of queries whose counts are scaled.

use crate::backend::vk::Buffer;
use crate::intercept::process::log;
use crate::intercept::scene::query_scaling::{Quantity, QueryScaling};
use crate::intercept::vk::state::driver::Driver;
use crate::lock::Lock;
use ash::vk;
use std::collections::HashMap;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, OnceLock};

/// The factor 1. Factors have 32 fractional bits.
pub(in crate::intercept::vk) const ONE: u64 = 1 << 32;

/// Returns a factor with 32 fractional bits.
pub(in crate::intercept::vk) fn fixed(factor: f64) -> u64 {
    if factor.is_finite() && factor > 0.0 { (factor * ONE as f64).round() as u64 } else { ONE }
}

/// Returns `count` × `factor`, rounded; at least 1 if `count` is at least 1.
pub(in crate::intercept::vk) fn scaled(count: u64, factor: u64) -> u64 {
    let product = (u128::from(count) * u128::from(factor) + u128::from(ONE / 2)) >> 32;
    u64::try_from(product).unwrap_or(u64::MAX).max(u64::from(count > 0))
}

/// A pool of queries that count.
pub struct Pool {
    pub(in crate::intercept::vk) quantities: Vec<Quantity>,
    /// Factors of the queries at their last submission.
    pub(in crate::intercept::vk) factors: Mutex<Vec<QueryScaling>>,
    /// Buffers for copies of its results, made for the first copy.
    pub(in crate::intercept::vk) scratch: Mutex<Option<Scratch>>,
}

impl Pool {
    /// Returns the factor of each number of a query's result.
    pub(in crate::intercept::vk) fn factors(&self, query: u32) -> impl Iterator<Item = u64> + '_ {
        let all = self.factors.locked();
        let factors = all.get(query as usize).copied().unwrap_or(QueryScaling::ONCE);
        self.quantities.iter().map(move |quantity| fixed(factors.of(*quantity)))
    }

    /// Sets the factors of a submitted query.
    pub(in crate::intercept::vk) fn set_factors(&self, driver: &Driver, query: u32, new: QueryScaling) {
        match self.factors.locked().get_mut(query as usize) {
            Some(factors) if *factors != new => *factors = new,
            _ => return,
        }
        if let Some(scratch) = &*self.scratch.locked() {
            scratch.set_factors(driver, query, &self.factors(query).collect::<Vec<_>>());
        }
    }

    /// Returns a pool whose queries have these factors.
    pub(in crate::intercept::vk) fn new(quantities: Vec<Quantity>, factors: Vec<QueryScaling>) -> Self {
        Self { quantities, factors: Mutex::new(factors), scratch: Mutex::default() }
    }
}

/// The program's pools of queries that count.
#[derive(Default)]
pub struct Queries {
    pub(in crate::intercept::vk) pools: Mutex<HashMap<vk::QueryPool, Arc<Pool>>>,
    /// True if there has been such a pool.
    pub(in crate::intercept::vk) have_counted: AtomicBool,
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
    /// The driver's results.
    pub(in crate::intercept::vk) counted: Buffer,
    pub(in crate::intercept::vk) factors: Buffer,
    /// The scaled results.
    pub(in crate::intercept::vk) scaled: Buffer,
    pub(in crate::intercept::vk) pool: vk::DescriptorPool,
    pub(in crate::intercept::vk) set: vk::DescriptorSet,
    /// Number of queries of the pool.
    pub(in crate::intercept::vk) queries: u32,
}

impl Queries {
    /// Returns a pool, if its queries are scaled.
    pub fn get(&self, handle: vk::QueryPool) -> Option<Arc<Pool>> {
        self.pools.locked().get(&handle).cloned()
    }

    /// True if there has been a pool whose queries are scaled.
    pub fn have_counted(&self) -> bool {
        self.have_counted.load(Ordering::Relaxed)
    }
}

impl Scratch {
    /// Sets the factors of a query's numbers. A copy of an earlier submission that still runs may
    /// use them, too. This is harmless, since the draws that a query counts seldom change from one
    /// frame to the next.
    pub fn set_factors(&self, driver: &Driver, query: u32, factors: &[u64]) {
        let bytes: Vec<u8> = factors.iter().flat_map(|factor| factor.to_ne_bytes()).collect();
        let offset = 8 + query as usize * bytes.len();
        if let Err(error) = self.factors.write(&driver.api, offset, &bytes) {
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
