//! Queries of a submitted command buffer: which draws they count, and how often each draw is
//! issued.

use crate::intercept::scene::query_scaling::{QueryScaling, factor};
use crate::intercept::vk::commands::passes::panel_clears::clear_pending;
use crate::intercept::vk::state::device::Device;
use crate::intercept::vk::state::queries::Pool;
use crate::intercept::vk::state::recording::Event;
use ash::vk;
use std::sync::Arc;

/// Factor for the samples of a draw.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SampleScale {
    /// The factor.
    pub factor: f64,
    /// True if the draw belongs to the scene.
    pub of_scene: bool,
}

impl SampleScale {
    /// The scale of a draw that is issued once.
    pub const ONCE: Self = Self { factor: 1.0, of_scene: false };
}

/// A query of a submitted command buffer.
pub struct RunningQuery {
    pool: Arc<Pool>,
    query: u32,
    sample_scale: Option<SampleScale>,
    /// Vertices of the program's draws.
    drawn: f64,
    /// Vertices that were issued for these draws.
    issued: f64,
}

impl RunningQuery {
    /// Returns a query that begins.
    pub fn new(pool: Arc<Pool>, query: u32) -> Self {
        Self { pool, query, sample_scale: None, drawn: 0.0, issued: 0.0 }
    }

    /// True if it is this query.
    pub fn is(&self, pool: &Arc<Pool>, query: u32) -> bool {
        Arc::ptr_eq(&self.pool, pool) && self.query == query
    }

    /// Adds draws of `vertices` vertices that are issued `times` times. If draws of a scene are
    /// counted together with others, the scale of the scene's samples is used for all.
    pub fn add(&mut self, sample_scale: SampleScale, vertices: u64, times: u32) {
        if self.sample_scale.is_none_or(|known| sample_scale.of_scene && !known.of_scene) {
            self.sample_scale = Some(sample_scale);
        }
        self.drawn += vertices as f64;
        self.issued += vertices as f64 * f64::from(times);
    }

    /// Returns the factors for its results.
    fn factors(&self) -> QueryScaling {
        let samples = self.sample_scale.unwrap_or(SampleScale::ONCE).factor;
        QueryScaling { samples, primitives: factor(self.drawn, self.issued) }
    }

    /// Ends the query.
    pub fn end(self, device: &Device) {
        self.pool.set_factors(&device.driver, self.query, self.factors());
    }
}

/// Begins a query in a command buffer. Pending clears of Cupola are done first, so that the query
/// does not count them.
///
/// # Safety
/// The command buffer is being recorded.
pub unsafe fn begin(device: &Device, buffer: vk::CommandBuffer, pool: vk::QueryPool, query: u32) {
    let Some(pool) = device.queries.get(pool) else { return };
    device.recordings.with(buffer, |recording| {
        // SAFETY: as promised.
        unsafe { clear_pending(device, buffer, recording) };
        recording.counting += 1;
        recording.events.push(Event::BeginQuery(pool, query));
    });
}

/// Ends a query in a command buffer.
pub fn end(device: &Device, buffer: vk::CommandBuffer, pool: vk::QueryPool, query: u32) {
    let Some(pool) = device.queries.get(pool) else { return };
    device.recordings.with(buffer, |recording| {
        recording.counting = recording.counting.saturating_sub(1);
        recording.events.push(Event::EndQuery(pool, query));
    });
}

#[cfg(test)]
mod tests {
    use super::{RunningQuery, SampleScale};
    use crate::intercept::scene::query_scaling::QueryScaling;
    use crate::intercept::vk::state::queries::{Pool, fixed, scaled};
    use std::sync::Arc;

    fn query() -> RunningQuery {
        RunningQuery::new(Arc::new(Pool::new(Vec::new(), Vec::new())), 2)
    }

    #[test]
    fn what_is_issued_at_different_numbers_is_counted_once() {
        let mut running = query();
        running.add(SampleScale::ONCE, 30, 1);
        running.add(SampleScale { factor: 0.5, of_scene: true }, 36, 6);
        running.add(SampleScale { factor: 0.25, of_scene: true }, 6, 7);
        let factors = running.factors();
        assert_eq!(scaled(30 + 36 * 6 + 6 * 7, fixed(factors.primitives)), 30 + 36 + 6);
        assert_eq!(factors.samples, 0.5, "the first draw of a scene says it");
    }

    #[test]
    fn what_counts_nothing_has_usual_factors() {
        assert_eq!(query().factors(), QueryScaling::ONCE);
    }
}
