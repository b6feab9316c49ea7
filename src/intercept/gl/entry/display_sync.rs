//! Swap intervals and swap groups: what the rig asks of the driver for each window, once, before a
//! swap.

use crate::intercept::process::live;
use crate::lock::Lock;
use crate::rig::WindowSwaps;
use std::sync::Mutex;

/// Windows with the settings that were made for them last.
static MADE: Mutex<Vec<(usize, WindowSwaps)>> = Mutex::new(Vec::new());

/// Returns the settings that a window should get before its next swap; `None` if it has them. They
/// then count as made.
pub fn take(window: usize) -> Option<WindowSwaps> {
    let wanted = live::rig()?.rig.window;
    let mut made = MADE.locked();
    match made.iter_mut().find(|(known, _)| *known == window) {
        Some((_, old)) if *old == wanted => return None,
        Some((_, old)) => *old = wanted,
        None if wanted == WindowSwaps::default() => return None,
        None => made.push((window, wanted)),
    }
    Some(wanted)
}

/// Forgets a window that was destroyed.
pub fn forget(window: usize) {
    MADE.locked().retain(|(known, _)| *known != window);
}
