//! Results of queries that the program reads on the host.

use crate::intercept::vk::state::queries::{Pool, scaled};
use ash::vk;

/// Flags of each request for results, in addition to the program's own flag for waiting: 64-bit
/// values, each result followed by its availability.
pub const RAW: vk::QueryResultFlags = vk::QueryResultFlags::from_raw(
    vk::QueryResultFlags::TYPE_64.as_raw() | vk::QueryResultFlags::WITH_AVAILABILITY.as_raw(),
);

impl Pool {
    /// Distance of two raw results: the numbers of a result and its availability.
    pub fn stride(&self) -> usize {
        self.quantities.len() + 1
    }

    /// As [`stride`](Self::stride), in bytes.
    pub fn stride_in_bytes(&self) -> u64 {
        8 * self.stride() as u64
    }
}

/// Memory and form of the results that a program requests.
pub struct HostResults {
    /// Address of the results.
    pub to: *mut u8,
    /// Number of bytes there.
    pub size: usize,
    /// Distance of two results in bytes.
    pub stride: usize,
    /// The form.
    pub flags: vk::QueryResultFlags,
}

impl HostResults {
    /// Writes the results of the queries from `first` on, for which the driver returned `raw`. A
    /// result that is not available is not written, unless the program set `PARTIAL`.
    ///
    /// # Safety
    /// `to` must be the program's memory, with `size` bytes.
    pub unsafe fn write(&self, pool: &Pool, first: u32, raw: &[u64]) {
        use vk::QueryResultFlags as F;
        let length = if self.flags.contains(F::TYPE_64) { 8 } else { 4 };
        for (index, result) in raw.chunks_exact(pool.stride()).enumerate() {
            let Some((available, counts)) = result.split_last() else { return };
            let readable = *available != 0 || self.flags.contains(F::PARTIAL);
            let scaled =
                counts.iter().zip(pool.factors(first + index as u32)).map(|(c, w)| readable.then(|| scaled(*c, w)));
            let availability = self.flags.contains(F::WITH_AVAILABILITY).then_some(Some(*available));
            for (place, value) in scaled.chain(availability).enumerate() {
                let at = index * self.stride + place * length;
                let Some(value) = value.filter(|_| at + length <= self.size) else { continue };
                // SAFETY: within the program's memory, which need not be aligned.
                unsafe {
                    match length {
                        8 => self.to.add(at).cast::<u64>().write_unaligned(value),
                        _ => self.to.add(at).cast::<u32>().write_unaligned(u32::try_from(value).unwrap_or(u32::MAX)),
                    }
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::HostResults;
    use crate::intercept::scene::query_scaling::{Quantity, QueryScaling};
    use crate::intercept::vk::state::queries::Pool;
    use ash::vk::QueryResultFlags as F;

    #[test]
    fn results_have_the_form_that_is_asked_for_and_stay_within_their_memory() {
        let half = QueryScaling { samples: 0.5, primitives: 1.0 };
        let quantities = vec![Quantity::Primitives, Quantity::Samples];
        let pool = Pool::new(quantities, vec![QueryScaling::ONCE, half, half]);
        // Results of query 1, and of query 2, which is not available.
        let raw = [10, 20, 1, 30, 40, 0];
        let write = |length: usize, size: usize, flags| {
            let mut to = [7_u32; 12];
            let wanted = HostResults { to: to.as_mut_ptr().cast(), size, stride: length * 4, flags };
            // SAFETY: `size` bytes are in the array.
            unsafe { wanted.write(&pool, 1, &raw) };
            to
        };
        assert_eq!(write(2, 48, F::empty())[..5], [10, 10, 7, 7, 7]);
        assert_eq!(write(2, 48, F::PARTIAL)[..5], [10, 10, 30, 20, 7]);
        assert_eq!(write(3, 48, F::WITH_AVAILABILITY)[..7], [10, 10, 1, 7, 7, 0, 7]);
        assert_eq!(write(6, 24, F::WITH_AVAILABILITY | F::TYPE_64)[..8], [10, 0, 10, 0, 1, 0, 7, 7]);
    }
}
