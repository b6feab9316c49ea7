//! The present frame, and facts that are known from earlier frames.
//!
//! [`background`] separates flat drawing before the scene from drawing on the panel, [`draw_count`]
//! counts draws, [`front_buffer`] limits flushes, [`panel_use`] tells when the panel is useless.
//! [`statistics`] counts for `--stats`,
//! [`device_times`] measures for it, [`publishing`] reads pictures back for other processes.

pub mod background;
pub mod device_times;
pub mod draw_count;
pub mod front_buffer;
pub mod panel_use;
pub mod publishing;
pub mod statistics;

use crate::correct::LowerLeftRect;
use crate::intercept::gl::state::frame::background::Background;
use crate::intercept::gl::state::frame::device_times::DeviceTimes;
use crate::intercept::gl::state::frame::draw_count::DrawCount;
use crate::intercept::gl::state::frame::front_buffer::FrontBufferThrottle;
use crate::intercept::gl::state::frame::panel_use::PanelUse;
use crate::intercept::gl::state::frame::publishing::Publishing;
use crate::intercept::gl::state::frame::statistics::Counts;
use crate::intercept::process::small_window::SmallWindow;
use crate::intercept::scene::camera::Cameras;
use crate::intercept::scene::culling_program::CullingProgram;
use crate::intercept::scene::flat_program::{FlatProgram, MissingLens};
use crate::intercept::scene::viewport::parts::PanelPart;
use crate::runtime::frame_times::FrameTimes;
use crate::runtime::session::{Intrinsics, Session};
use glam::DMat4;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex};
use std::time::Instant;

/// Area of the largest viewport that a scene was drawn to.
#[derive(Default)]
struct LargestViewport {
    in_this_frame: i64,
    in_last_frame: i64,
}

/// Number of frames that all windows have ended.
static ENDED: AtomicU64 = AtomicU64::new(0);

/// State of a window's frames.
#[derive(Default)]
pub struct Frame {
    /// Number of the last frame among those of all windows; 0 if none has ended.
    last: u64,
    /// True if something was drawn since the last swap.
    begun: bool,
    /// Flat drawing behind the scene.
    background: Background,
    /// The cameras of the frame.
    cameras: Cameras,
    /// The lens of the last draw of the scene.
    lens: Option<Intrinsics>,
    largest_viewport: LargestViewport,
    /// Number of draws.
    draw_count: DrawCount,
    panel_use: PanelUse,
    /// Limit of the flushes of the front buffer that are answered.
    front_buffer: FrontBufferThrottle,
    /// Number of corrections in a row in which the driver reported an error.
    failed_corrections: u32,
    /// Test whether the program draws no scene.
    flat_program: FlatProgram,
    small_window: SmallWindow,
    /// Test whether the program leaves out objects beside its own picture.
    culling_program: CullingProgram,
    /// True if a scene was ever shown in the window.
    shows_scene: bool,
    /// For views that are drawn in turn: true if a scene was drawn off screen in this frame.
    scene_off_screen: bool,
    /// Counts for `--stats`.
    counts: Counts,
    /// Times for `--stats`; `None` if they are not asked for.
    times: Option<Times>,
    /// Read-back of the published pictures; `None` if none are published.
    publishing: Option<Box<Publishing>>,
}

/// Times of a window's frames.
pub struct Times {
    /// Measured times; the report of the last frame reads them when it is written.
    pub(in crate::intercept::gl) shared: Arc<Mutex<FrameTimes>>,
    /// Timestamps of the device.
    pub(in crate::intercept::gl) device: DeviceTimes,
}

impl Frame {
    /// Returns what reads the pictures that are published, to be used.
    pub fn publishing_mut(&mut self) -> Option<&mut Publishing> {
        self.publishing.as_deref_mut()
    }

    /// Takes out what reads the pictures that are published.
    pub fn take_publishing(&mut self) -> Option<Box<Publishing>> {
        self.publishing.take()
    }

    /// Puts back what reads the pictures that are published, or something new.
    pub fn put_publishing(&mut self, publishing: Box<Publishing>) {
        self.publishing = Some(publishing);
    }

    /// Number of the last frame among those of all windows; 0 if none has ended.
    pub fn last(&self) -> u64 {
        self.last
    }

    /// Number of frames that ended in all windows.
    pub fn ended() -> u64 {
        ENDED.load(Ordering::Relaxed)
    }

    /// True if something was drawn since the last swap.
    pub fn begun(&self) -> bool {
        self.begun
    }

    /// Notes that something is drawn.
    pub fn note_drawn(&mut self) {
        self.begun = true;
    }

    /// Notes that the context draws to another window now.
    pub fn window_changed(&mut self) {
        self.begun = false;
    }

    /// Notes that the views changed. What was computed for them is not valid any more.
    pub fn views_changed(&mut self) {
        self.cameras.clear();
        self.background.clear();
    }

    /// Flat drawing behind the scene.
    pub fn background(&self) -> &Background {
        &self.background
    }

    /// Flat drawing behind the scene, to be changed.
    pub fn background_mut(&mut self) -> &mut Background {
        &mut self.background
    }

    /// Notes a flat draw to the window.
    pub fn note_flat(&mut self) {
        self.background.note_flat();
    }

    /// True if flat drawing comes before the scene now.
    pub fn is_behind(&self) -> bool {
        self.background.order.is_behind()
    }

    /// Computes the matrices of flat drawing behind the scene. Returns false if there are none.
    pub fn prepare_background(&mut self, session: &Session, projection: &DMat4, part: PanelPart) -> bool {
        self.background.prepare(session, projection, part)
    }

    /// The cameras of the frame.
    pub fn cameras(&self) -> &Cameras {
        &self.cameras
    }

    /// Returns the index of the camera with this lens, which is made if it is new.
    pub fn camera(&mut self, lens: &Intrinsics, session: &Session) -> usize {
        self.cameras.index(lens, session)
    }

    /// Notes that the views are drawn with the camera at `index`.
    pub fn show_camera(&mut self, index: usize) {
        self.cameras.show(index);
    }

    /// Notes that the views are drawn with the last lens, which is that of the fixed-function
    /// pipeline.
    pub fn show_fixed_camera(&mut self) {
        if let Some(lens) = &self.lens {
            self.cameras.show_fixed(lens);
        }
    }

    /// The lens of the last draw of the scene.
    pub fn lens(&self) -> Option<Intrinsics> {
        self.lens
    }

    /// Notes the lens of a draw of the scene; `how`: the way in which it was found.
    pub fn note_lens(&mut self, lens: Intrinsics, how: &'static str) {
        self.lens = Some(lens);
        self.counts.found.count(how);
    }

    /// Notes a draw to the window that has no lens.
    pub fn note_missing_lens(&mut self, reason: MissingLens) {
        self.counts.missing.count(reason, 1);
    }

    /// Notes a draw whose projection was found in this way, without a lens of its own.
    pub fn note_found(&mut self, how: &'static str) {
        self.counts.found.count(how);
    }

    /// Number of draws in a frame.
    pub fn draw_count(&self) -> &DrawCount {
        &self.draw_count
    }

    /// Notes that the program switched the stencil test on.
    pub fn note_stencil(&mut self) {
        self.draw_count.note_stencil();
    }

    /// Returns the number of draws to plan the views for. Returns it once, when it is known.
    pub fn draws_to_plan_for(&mut self) -> Option<u32> {
        self.draw_count.take()
    }

    /// Use of the flat panel.
    pub fn panel_use(&mut self) -> &mut PanelUse {
        &mut self.panel_use
    }

    /// True if the front buffer may be shown at this time. It may not if the program flushes too
    /// often.
    pub fn front_buffer_is_due(&mut self, now: Instant) -> bool {
        self.front_buffer.allows(now)
    }

    /// Notes a correction. Returns the number of corrections in a row that have `failed`.
    pub fn note_correction(&mut self, failed: bool) -> u32 {
        self.failed_corrections = if failed { self.failed_corrections + 1 } else { 0 };
        self.failed_corrections
    }

    /// Takes the tests whether the program draws no scene, whether it leaves out objects, and whether
    /// its window is too small.
    pub fn take_program_checks(&mut self) -> (FlatProgram, CullingProgram, SmallWindow) {
        (std::mem::take(&mut self.flat_program), self.culling_program, self.small_window)
    }

    /// The message for a program without a scene, if there was one.
    pub fn flat_note(&self) -> Option<&str> {
        self.flat_program.note()
    }

    /// Puts these tests back after they have looked at a frame.
    pub fn put_program_checks(&mut self, checks: (FlatProgram, CullingProgram, SmallWindow)) {
        (self.flat_program, self.culling_program, self.small_window) = checks;
    }

    /// True if the test whether the program leaves out objects needs the positions of draws.
    pub fn needs_places(&self) -> bool {
        !self.culling_program.is_decided()
    }

    /// Notes a draw of the scene that is beside the program's own picture.
    pub fn note_draw_beside(&mut self) {
        self.counts.places.outside += 1;
    }

    /// Notes a draw of the scene that crosses the border of the program's own picture.
    pub fn note_draw_at_border(&mut self) {
        self.counts.places.crossing += 1;
    }

    /// For views that are drawn in turn: notes that a scene is drawn off screen.
    pub fn note_scene_off_screen(&mut self) {
        self.scene_off_screen = true;
    }

    /// For views that are drawn in turn: true if a scene was drawn off screen in this frame.
    pub fn scene_off_screen(&self) -> bool {
        self.scene_off_screen
    }

    /// Counts for `--stats`.
    pub fn counts(&self) -> &Counts {
        &self.counts
    }

    /// Counts a draw of the program to its window.
    pub fn note_draw(&mut self) {
        self.counts.draws_seen += 1;
    }

    /// Counts a draw that was issued to the primary view.
    pub fn note_primary_draw(&mut self) {
        self.counts.primary_draws += 1;
    }

    /// Counts a flat draw that was issued to the panel.
    pub fn note_panel_draw(&mut self) {
        self.counts.panel_draws += 1;
    }

    /// Counts a draw of the scene whose area is known.
    pub fn note_bounded_draw(&mut self) {
        self.counts.bounded_draws += 1;
    }

    /// Counts a closing of the unsampled areas.
    pub fn note_closing(&mut self) {
        self.counts.closings += 1;
    }

    /// Counts shader programs that were linked for Cupola.
    pub fn note_linked(&mut self, programs: u64) {
        self.counts.linked += programs;
    }

    /// Counts a presented frame.
    pub fn note_presented(&mut self) {
        self.counts.frames += 1;
    }

    /// Counts a presented frame of which nothing was visible.
    pub fn note_hidden(&mut self) {
        self.counts.hidden_frames += 1;
    }

    /// True if times are measured for `--stats`.
    pub fn is_timed(&self) -> bool {
        self.times.is_some()
    }

    /// Begins to measure times, with these timestamps of the device.
    pub fn begin_timing(&mut self, device: DeviceTimes) {
        self.times = Some(Times { shared: Arc::default(), device });
    }

    /// Times for `--stats`, to be measured; `None` if they are not needed.
    pub fn times_mut(&mut self) -> Option<&mut Times> {
        self.times.as_mut()
    }

    /// Measured times, which the report of the last frame reads when it is written.
    pub fn measured_times(&self) -> Option<Arc<Mutex<FrameTimes>>> {
        self.times.as_ref().map(|times| Arc::clone(&times.shared))
    }

    /// Notes a viewport that a scene is drawn to.
    pub fn note_viewport(&mut self, viewport: LowerLeftRect) {
        let largest = &mut self.largest_viewport.in_this_frame;
        *largest = viewport.size().area().max(*largest);
    }

    /// Notes that a scene is shown in the window.
    pub fn note_scene(&mut self) {
        self.background.note_scene();
        self.shows_scene = true;
    }

    /// Notes that a scene is shown in a part of the window. Flat drawing before it is beside it, and
    /// not behind it.
    pub fn note_scene_in_part(&mut self) {
        self.shows_scene = true;
    }

    /// True if a scene was ever shown in the window.
    pub fn shows_scene(&self) -> bool {
        self.shows_scene
    }

    /// Forgets the viewports, as the window may have another size now.
    pub fn forget_viewports(&mut self) {
        self.largest_viewport = LargestViewport::default();
    }

    /// Returns the area of the program's main viewport; 0 = not known. It is the largest viewport of
    /// the last frame. In the first frame, and after a change of the window's size, it is the
    /// largest viewport so far in the present frame.
    pub fn main_area(&self) -> i64 {
        let LargestViewport { in_this_frame, in_last_frame } = self.largest_viewport;
        if in_last_frame > 0 { in_last_frame } else { in_this_frame }
    }

    /// True if a scene was drawn in this frame or in the last one.
    pub fn has_scene(&self) -> bool {
        self.main_area() > 0
    }

    /// Ends the frame.
    pub fn end(&mut self) {
        self.last = ENDED.fetch_add(1, Ordering::Relaxed) + 1;
        self.cameras.end_frame();
        self.background.end_frame();
        let in_last_frame = self.largest_viewport.in_this_frame;
        self.largest_viewport = LargestViewport { in_this_frame: 0, in_last_frame };
        self.begun = false;
        self.scene_off_screen = false;
        self.draw_count.end_frame(self.counts.draws_seen);
        self.panel_use.end_frame();
    }
}
