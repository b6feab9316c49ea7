//! The present frame, and facts that are known from earlier frames.
//!
//! [`background`] separates flat drawing before the scene from drawing on the panel, [`draw_count`]
//! counts draws, [`front_buffer`] limits flushes. [`statistics`] counts for `--stats`,
//! [`device_times`] measures for it, [`publishing`] reads pictures back for other processes.

pub mod background;
pub mod device_times;
pub mod draw_count;
pub mod front_buffer;
pub mod publishing;
pub mod statistics;

use crate::correct::LowerLeftRect;
use crate::intercept::gl::state::frame::background::Background;
use crate::intercept::gl::state::frame::device_times::DeviceTimes;
use crate::intercept::gl::state::frame::draw_count::DrawCount;
use crate::intercept::gl::state::frame::front_buffer::FrontBufferThrottle;
use crate::intercept::gl::state::frame::publishing::Publishing;
use crate::intercept::gl::state::frame::statistics::Counts;
use crate::intercept::scene::camera::Cameras;
use crate::intercept::scene::culling_program::CullingProgram;
use crate::intercept::scene::flat_program::FlatProgram;
use crate::runtime::frame_times::FrameTimes;
use crate::runtime::session::Intrinsics;
use std::sync::{Arc, Mutex};

/// State of a window's frames.
#[derive(Default)]
pub struct Frame {
    /// True if something was drawn since the last swap.
    pub(in crate::intercept::gl) begun: bool,
    /// Flat drawing behind the scene.
    pub(in crate::intercept::gl) background: Background,
    /// The cameras of the frame.
    pub(in crate::intercept::gl) cameras: Cameras,
    /// The lens of the last draw of the scene.
    pub(in crate::intercept::gl) lens: Option<Intrinsics>,
    /// Area of the largest viewport that a scene was drawn to: in this frame, and in the last one.
    viewport_area: [i64; 2],
    /// Number of draws.
    pub(in crate::intercept::gl) draw_count: DrawCount,
    /// Limit of the flushes of the front buffer that are answered.
    pub(in crate::intercept::gl) front_buffer: FrontBufferThrottle,
    /// Number of corrections in a row in which the driver reported an error.
    pub(in crate::intercept::gl) failed_corrections: u32,
    /// Test whether the program draws no scene.
    pub(in crate::intercept::gl) flat_program: FlatProgram,
    /// Test whether the program leaves out objects beside its own picture.
    pub(in crate::intercept::gl) culling_program: CullingProgram,
    /// True if a scene was ever shown in the window.
    shows_scene: bool,
    /// For views that are drawn in turn: true if a scene was drawn off screen in this frame.
    pub(in crate::intercept::gl) scene_off_screen: bool,
    /// Counts for `--stats`.
    pub(in crate::intercept::gl) counts: Counts,
    /// Times for `--stats`; `None` if they are not asked for.
    pub(in crate::intercept::gl) times: Option<Times>,
    /// Read-back of the published pictures; `None` if none are published.
    pub(in crate::intercept::gl) publishing: Option<Box<Publishing>>,
}

/// Times of a window's frames.
pub struct Times {
    /// Measured times; the report of the last frame reads them when it is written.
    pub(in crate::intercept::gl) shared: Arc<Mutex<FrameTimes>>,
    /// Timestamps of the device.
    pub(in crate::intercept::gl) device: DeviceTimes,
}

impl Frame {
    /// Notes a viewport that a scene is drawn to.
    pub fn note_viewport(&mut self, LowerLeftRect { width, height, .. }: LowerLeftRect) {
        let area = i64::from(width) * i64::from(height);
        self.viewport_area[0] = self.viewport_area[0].max(area);
    }

    /// Notes that a scene is shown in the window.
    pub fn note_scene(&mut self) {
        self.background.note_scene();
        self.shows_scene = true;
    }

    /// True if a scene was ever shown in the window.
    pub fn shows_scene(&self) -> bool {
        self.shows_scene
    }

    /// Forgets the viewports, as the window may have another size now.
    pub fn forget_viewports(&mut self) {
        self.viewport_area = [0; 2];
    }

    /// Returns the area of the program's main viewport; 0 = not known. It is the largest viewport of
    /// the last frame. In the first frame, and after a change of the window's size, it is the
    /// largest viewport so far in the present frame.
    pub fn main_area(&self) -> i64 {
        if self.viewport_area[1] > 0 { self.viewport_area[1] } else { self.viewport_area[0] }
    }

    /// True if a scene was drawn in this frame or in the last one.
    pub fn has_scene(&self) -> bool {
        self.viewport_area.iter().any(|area| *area > 0)
    }

    /// Ends the frame.
    pub fn end(&mut self) {
        self.cameras.end_frame();
        self.background.end_frame();
        self.viewport_area = [0, self.viewport_area[0]];
        self.begun = false;
        self.scene_off_screen = false;
        self.draw_count.end_frame(self.counts.draws_seen);
    }
}
