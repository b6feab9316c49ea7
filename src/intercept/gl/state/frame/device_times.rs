//! Times of frames on the device. Timestamps are read when they are available.

use crate::backend::gl::driver::api::{self, Gl};
use crate::intercept::gl::state::driver::profile::Profile;
use crate::intercept::gl::state::queries;
use crate::runtime::frame_times::FrameTimes;
use std::time::Duration;

/// Greatest number of frames that are measured at the same time.
const FRAMES: usize = 4;

/// Number of timestamps of a frame: at its begin, after drawing, and after the correction.
const MOMENTS: usize = 3;

/// Timestamps of the latest frames.
#[derive(Default)]
pub struct DeviceTimes {
    /// Query objects of the frames that are being measured; empty if the driver has no timestamps.
    objects: Vec<[u32; MOMENTS]>,
    /// Number of the present frame; `oldest`: number of the oldest frame that was not read.
    frame: usize,
    oldest: usize,
    /// Number of timestamps of this frame that were written.
    written: usize,
    /// True if results of queries may go to a buffer that is bound.
    has_result_buffer: bool,
}

impl DeviceTimes {
    /// Returns the timestamps of the current context.
    pub fn new(gl: &Gl, profile: &Profile) -> Self {
        let mut times = Self { has_result_buffer: profile.version >= 44, ..Self::default() };
        if !profile.es && profile.version >= 33 {
            let names = queries::own_names(gl, FRAMES * MOMENTS);
            times.objects = names.as_chunks::<MOMENTS>().0.to_vec();
        }
        times
    }

    /// Begins a frame. `times` gets the times of frames that the device has finished.
    pub fn begin(&mut self, gl: &Gl, times: &mut FrameTimes) {
        self.written = 0;
        if !self.objects.is_empty() {
            self.read(gl, times);
        }
        self.mark(gl, 0);
    }

    /// Notes that all draws of the frame are issued.
    pub fn drawn(&mut self, gl: &Gl) {
        self.mark(gl, 1);
    }

    /// Notes that the correction is issued.
    pub fn corrected(&mut self, gl: &Gl) {
        self.mark(gl, 2);
        if self.written == MOMENTS {
            self.frame += 1;
            self.written = 0;
        }
    }

    fn mark(&mut self, gl: &Gl, moment: usize) {
        if self.written == moment && !self.objects.is_empty() && self.frame - self.oldest < FRAMES {
            // SAFETY: objects of Cupola, for timestamps alone.
            unsafe { gl.query_counter(self.objects[self.frame % FRAMES][moment], api::GL_TIMESTAMP) };
            self.written += 1;
        }
    }

    fn read(&mut self, gl: &Gl, times: &mut FrameTimes) {
        let mut buffer = 0;
        if self.has_result_buffer {
            // SAFETY: writes one integer.
            unsafe { gl.get_integerv(api::GL_QUERY_BUFFER_BINDING, &mut buffer) };
        }
        while buffer == 0 && self.oldest < self.frame {
            let objects = self.objects[self.oldest % FRAMES];
            if !queries::available(gl, objects[MOMENTS - 1]) {
                break;
            }
            let [begin, drawn, corrected] = objects.map(|object| queries::result(gl, true, object));
            times.device_drawing.add(Duration::from_nanos(drawn.saturating_sub(begin)));
            times.device_correction.add(Duration::from_nanos(corrected.saturating_sub(drawn)));
            self.oldest += 1;
        }
    }
}
