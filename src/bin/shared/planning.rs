//! Requests to the planner for windows of a given size.

use cupola::rig::Rig;
use cupola::views::Request;

/// Largest texture size of current graphics hardware, for plans that are made without a driver.
pub const LARGEST_ATLAS: u32 = 16384;

/// A request for outputs of the given sizes, without a panel and without the program's own picture.
pub fn request(output_sizes: Vec<(u32, u32)>, window: (u32, u32)) -> Request {
    Request { output_sizes, window, panel: false, primary: false, max_atlas: LARGEST_ATLAS }
}

/// A request for all outputs of `rig` in a window of `size` pixels. Without a size the rig's own is
/// taken, or 1920 × 1200.
pub fn window_request(rig: &Rig, size: Option<(u32, u32)>) -> Request {
    let window = size.or_else(|| rig.extent()).unwrap_or((1920, 1200));
    request(rig.sizes(window), window)
}
