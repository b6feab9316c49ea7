//! Time that the device takes for corrections.

use crate::backend::vk::driver::api::{Api, refused};
use crate::error::Result;
use ash::vk;

/// Measured times.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Timing {
    /// Number of measured corrections.
    pub corrections: u64,
    /// Sum of their times, nanoseconds.
    pub total: f64,
    /// Time of the correction that was read last, nanoseconds.
    pub last: f64,
}

/// A pair of timestamps for each source. The default measures nothing.
#[derive(Default)]
pub(in crate::backend::vk) struct Timers {
    pool: vk::QueryPool,
    /// True for each source whose timestamps were written.
    written: Vec<bool>,
    /// Nanoseconds per step of a timestamp.
    period: f64,
    /// Mask of the valid bits of a timestamp.
    mask: u64,
    timing: Timing,
}

impl Timers {
    /// Makes timers for `sources` sources whose corrections run in queues of `family`.
    pub fn new(api: &Api, sources: usize, family: u32) -> Result<Self> {
        let bits = api.timestamp_bits(family);
        if bits == 0 || sources == 0 {
            return Ok(Self::default());
        }
        let info =
            vk::QueryPoolCreateInfo::default().query_type(vk::QueryType::TIMESTAMP).query_count(2 * sources as u32);
        // SAFETY: the device is live; the structure is complete.
        let pool = unsafe { api.device.create_query_pool(&info, None) }.map_err(refused("timestamps"))?;
        Ok(Self {
            pool,
            written: vec![false; sources],
            period: f64::from(api.limits.timestamp_period),
            mask: u64::MAX >> (64 - bits.min(64)),
            timing: Timing::default(),
        })
    }

    /// Returns the times measured so far.
    pub fn timing(&self) -> Timing {
        self.timing
    }

    /// Reads the timestamps of the last correction of `source`. Records the start of the next one:
    /// the time at which all commands before it are done.
    ///
    /// # Safety
    /// The command buffer is being recorded, outside a render pass; no other pending one measures
    /// the same source.
    pub unsafe fn start(&mut self, api: &Api, command_buffer: vk::CommandBuffer, source: usize) {
        if self.written.get(source).is_none() {
            return;
        }
        if std::mem::replace(&mut self.written[source], true) {
            self.read(api, source);
        }
        let first = 2 * source as u32;
        // SAFETY: as promised above.
        unsafe {
            api.device.cmd_reset_query_pool(command_buffer, self.pool, first, 2);
            let done = vk::PipelineStageFlags::BOTTOM_OF_PIPE;
            api.device.cmd_write_timestamp(command_buffer, done, self.pool, first);
        }
    }

    /// Reads the timestamps of a finished correction of `source`. If its commands are recorded once
    /// and submitted repeatedly, call this after each time that they are done.
    pub fn read(&mut self, api: &Api, source: usize) {
        if source >= self.written.len() {
            return;
        }
        let mut stamps = [0u64; 2];
        // SAFETY: the queries are Cupola's. The call does not wait for results that are not
        // available, for example if nothing was submitted.
        let read = unsafe {
            let (first, wide) = (2 * source as u32, vk::QueryResultFlags::TYPE_64);
            api.device.get_query_pool_results(self.pool, first, &mut stamps, wide)
        };
        if read.is_ok() {
            let steps = stamps[1].wrapping_sub(stamps[0]) & self.mask;
            self.timing.last = steps as f64 * self.period;
            self.timing.total += self.timing.last;
            self.timing.corrections += 1;
        }
    }

    /// Records the end of a correction.
    ///
    /// # Safety
    /// As for [`Timers::start`], which came before.
    pub unsafe fn stop(&self, api: &Api, command_buffer: vk::CommandBuffer, source: usize) {
        if source < self.written.len() {
            let done = vk::PipelineStageFlags::BOTTOM_OF_PIPE;
            // SAFETY: as promised above.
            unsafe { api.device.cmd_write_timestamp(command_buffer, done, self.pool, 2 * source as u32 + 1) };
        }
    }

    /// Destroys the timers and forgets the times. No pending commands may use them.
    pub fn destroy(&mut self, api: &Api) {
        let old = std::mem::take(self);
        // SAFETY: an object of Cupola or null.
        unsafe { api.device.destroy_query_pool(old.pool, None) };
    }
}
