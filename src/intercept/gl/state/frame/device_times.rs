//! Times of frames on the device, by timestamps that are read when they are there.

use crate::backend::gl::driver::api::{self, Gl};
use crate::intercept::gl::state::driver::profile::Profile;
use crate::intercept::gl::state::queries;
use crate::runtime::frame_times::FrameTimes;
use std::time::Duration;

/// Number of frames that are measured at the same time; more are not measured.
const FRAMES: usize = 4;

/// Timestamps of a frame: at its begin, when all is drawn, when it is corrected.
const MOMENTS: usize = 3;

/// Timestamps.
#[derive(Default)]
pub struct DeviceTimes {
    /// Objects of each frame on its way; empty where the driver has no timestamps.
    objects: Vec<[u32; MOMENTS]>,
    /// Number of the frame that is drawn, and of the oldest one that was not read.
    frame: usize,
    oldest: usize,
    /// Timestamps of this frame that were written.
    written: usize,
    /// A buffer may be bound that results go to.
    has_result_buffer: bool,
}

impl DeviceTimes {
    /// For the current context.
    pub fn new(gl: &Gl, profile: &Profile) -> Self {
        let mut times = Self { has_result_buffer: profile.version >= 44, ..Self::default() };
        if !profile.es && profile.version >= 33 {
            let names = queries::own_names(gl, FRAMES * MOMENTS);
            times.objects = names.as_chunks::<MOMENTS>().0.to_vec();
        }
        times
    }

    /// A frame begins; `times` gets those of frames that the device has finished.
    pub fn begin(&mut self, gl: &Gl, times: &mut FrameTimes) {
        self.written = 0;
        if !self.objects.is_empty() {
            self.read(gl, times);
        }
        self.mark(gl, 0);
    }

    /// All draws of the frame are issued.
    pub fn drawn(&mut self, gl: &Gl) {
        self.mark(gl, 1);
    }

    /// The correction is issued.
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
