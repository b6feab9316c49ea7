//! Vulkan programs by other authors.

use crate::compare::expect_similar;
use crate::display;
use crate::harness::tests;
use crate::programs::{installed_on, resized};
use crate::vkcube::{expect_cube, fisheye};

tests! {
    vkcube_is_drawn_for_each_view,
    vkcube_in_a_window_of_10_bits,
    vkcube_in_a_window_of_another_size,
    vkcube_through_twenty_sizes_in_a_thousand_frames,
}

const SIZE: &str = "300";

/// The cube of `vkcube` is on the dome. Its matrix is in a block.
fn vkcube_is_drawn_for_each_view() {
    let Some(under) = fisheye(&["--capture-views", "views"]) else { return };
    let statistics = under.statistics();
    assert_eq!((statistics["frames"].as_u64(), statistics["panel_draws"].as_u64()), (Some(12), Some(0)));
    assert!(statistics["driver"].as_str().is_some_and(|driver| driver.starts_with("Vulkan")), "{statistics:#}");
    expect_cube(&under.picture("capture.png"), "vkcube");
    assert!(under.wrote("views/front-left.png") && under.wrote("views/panel.png"));
}

/// Windows with 10 bits per colour show the same as windows with 8 bits.
fn vkcube_in_a_window_of_10_bits() {
    let Some(display) = display::own(30) else { return };
    let options = ["--frames", "12", "--capture", "capture.png"];
    let size = ["--width", SIZE, "--height", SIZE];
    let (Some(eight), Some(ten)) = (fisheye(&[]), installed_on(&display, "vkcube", &size, "fisheye", &options)) else {
        return;
    };
    let ten = ten.expect_success();
    assert!(!ten.words().contains("own picture"), "{}", ten.words());
    // 459 of 90,000 pixels were found to differ.
    expect_similar(&ten.picture("capture.png"), &eight.picture("capture.png"), 1, 0.0102, "vkcube in 10 and in 8 bits");
}

/// `--size` gives the window, which the program makes by libxcb, its size.
fn vkcube_in_a_window_of_another_size() {
    let Some(display) = display::own(24) else { return };
    let options = ["--frames", "4", "--capture", "capture.png", "--size", "280x190"];
    let size = ["--width", SIZE, "--height", SIZE];
    let Some(finished) = installed_on(&display, "vkcube", &size, "fisheye", &options) else { return };
    let picture = finished.expect_success().picture("capture.png");
    assert_eq!((picture.width, picture.height), (280, 190));
}

/// In a thousand frames with twenty sizes the validation layer writes only messages that it also
/// writes without Cupola. It would also report objects that were created and not destroyed. Memory
/// does not grow.
fn vkcube_through_twenty_sizes_in_a_thousand_frames() {
    let program = ["vkcube", "--width", "321", "--height", "243", "--c", "1000"];
    let (Some(plain), Some(under)) = (resized(None, "20", &program), resized(Some("fisheye"), "20", &program)) else {
        return;
    };
    let known = plain.kinds_of_messages();
    let new: Vec<_> = under.kinds_of_messages().into_iter().filter(|message| !known.contains(message)).collect();
    assert!(new.is_empty(), "{new:?}");
    under.expect_flat_memory("memory.txt", 20);
}
