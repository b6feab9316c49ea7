//! Number of a frame of a window, for `--frames`.

use crate::intercept::gl::state::drawable::window::Window;
use crate::intercept::inspection::last_frame;
use crate::intercept::process::settings::settings;
use crate::lock::Lock;
use std::collections::HashMap;
use std::sync::Mutex;

/// Number of presented frames of each window, by the window's handle.
static PRESENTED: Mutex<Option<HashMap<usize, u64>>> = Mutex::new(None);

fn with<R>(window: usize, run: impl FnOnce(&mut u64) -> R) -> R {
    let mut presented = PRESENTED.locked();
    run(presented.get_or_insert_with(HashMap::new).entry(window).or_insert(0))
}

/// Counts a presented frame of `window`. Returns its number, from 1.
pub fn count(window: usize) -> u64 {
    with(window, |frames| {
        *frames += 1;
        *frames
    })
}

/// Returns the number that the next frame of `window` will have.
pub fn next(window: usize) -> u64 {
    with(window, |frames| *frames + 1)
}

/// Counts the frame of a window that was swapped while the thread's current context draws
/// elsewhere. The frame was corrected when the context left the window.
pub fn swapped_elsewhere(window: &Window) {
    let last = || {
        settings().is_some_and(|settings| {
            let number = count(window.handle());
            let last = last_frame::is_last(settings, number);
            if !last {
                last_frame::begin(settings, number + 1);
            }
            last
        })
    };
    if crate::fence::guard(last) == Some(true) {
        last_frame::end_program();
    }
}

#[cfg(test)]
mod tests {
    use super::{count, next};

    #[test]
    fn windows_have_frames_of_their_own() {
        // No test with a real window uses these handles.
        let (one, other) = (usize::MAX, usize::MAX - 1);
        assert_eq!((count(one), count(one), count(other)), (1, 2, 1));
        assert_eq!((next(one), next(other)), (3, 2));
    }
}
