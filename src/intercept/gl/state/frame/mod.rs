//! What has been seen of the frame that is drawn, and of those before?

pub mod background;
pub mod draw_count;
pub mod front_buffer;
pub mod statistics;

use crate::intercept::camera::Cameras;
use crate::intercept::gl::state::frame::background::Background;
use crate::intercept::gl::state::frame::draw_count::DrawCount;
use crate::intercept::gl::state::frame::front_buffer::FrontBufferThrottle;
use crate::intercept::gl::state::frame::statistics::Counts;
use crate::runtime::session::Intrinsics;

/// What is known of a window's frames.
#[derive(Default)]
pub struct Frame {
    /// Something was drawn since the last swap.
    pub(in crate::intercept::gl) begun: bool,
    /// Flat drawing behind the scene.
    pub(in crate::intercept::gl) background: Background,
    /// The cameras of the frame.
    pub(in crate::intercept::gl) cameras: Cameras,
    /// The lens of the last draw of the scene.
    pub(in crate::intercept::gl) lens: Option<Intrinsics>,
    /// Largest viewport (area) that a scene was drawn to: in this frame, and in the last one.
    pub(in crate::intercept::gl) viewport_area: [i64; 2],
    /// Number of draws.
    pub(in crate::intercept::gl) draw_count: DrawCount,
    /// How often flushes of the front buffer are answered.
    pub(in crate::intercept::gl) front_buffer: FrontBufferThrottle,
    /// Counts for `--stats`.
    pub(in crate::intercept::gl) counts: Counts,
}
