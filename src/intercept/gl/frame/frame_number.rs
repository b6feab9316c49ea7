//! Number of a frame of a window, for `--frames`.

use crate::intercept::gl::state::drawable::window::Window;
use crate::intercept::last_frame;
use crate::intercept::settings::settings;
use crate::lock::Lock;
use std::collections::HashMap;
use std::sync::Mutex;

/// Presented frames of each window, by its window system's handle.
static PRESENTED: Mutex<Option<HashMap<usize, u64>>> = Mutex::new(None);

fn with<R>(window: usize, run: impl FnOnce(&mut u64) -> R) -> R {
    let mut presented = PRESENTED.locked();
    run(presented.get_or_insert_with(HashMap::new).entry(window).or_insert(0))
}

/// One more frame of `window` is presented; its number, from 1.
pub fn count(window: usize) -> u64 {
    with(window, |frames| {
        *frames += 1;
        *frames
    })
}

/// The number that the next frame of `window` will have.
pub fn next(window: usize) -> u64 {
    with(window, |frames| *frames + 1)
}

/// A window was swapped that is not that of the thread's current context. Its picture was corrected
/// when it was left.
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
        // Handles that no test with a window has.
        let (one, other) = (usize::MAX, usize::MAX - 1);
        assert_eq!((count(one), count(one), count(other)), (1, 2, 1));
        assert_eq!((next(one), next(other)), (3, 2));
    }
}
