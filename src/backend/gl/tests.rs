//! Tests that draw, on whatever driver EGL finds without a window.

mod accuracy;
mod canvas;
mod plans;
mod present;
mod presets;
mod quality;
mod sharing;
mod state;

use super::headless::{Api, Headless};

fn headless(api: Api) -> Headless {
    Headless::new(api).expect("a driver that draws without a window (Mesa's llvmpipe will do)")
}

/// One context of each kind, made current in turn.
fn contexts() -> impl Iterator<Item = Headless> {
    [Api::Core, Api::Compatibility, Api::Es3].into_iter().map(headless)
}
