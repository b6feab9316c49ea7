//! Behaviour of OpenGL that drawing for each view might break, apart from the picture after a swap.

use crate::harness::tests;
use crate::programs::{Finished, Run};

tests! {
    transform_feedback_records_a_draw_once,
    a_pipeline_of_separable_programs,
    names_that_a_program_never_asked_for_are_free,
    a_window_with_one_buffer_shows_what_one_with_two_shows,
    the_window_by_its_name_and_our_uniform_by_none,
    a_window_that_is_swapped_while_another_is_current,
    ways_to_set_colours_and_corners,
    attributes_after_the_last_vertex,
    a_condition_that_is_open_across_a_swap_holds_for_the_program_only,
    a_full_stack_of_attributes_stays_full,
    the_accumulation_buffer_is_that_of_every_view,
    a_lens_in_memory_that_stays_mapped,
    two_contexts_draw_one_picture,
    a_swap_without_a_current_context_is_a_frame,
    a_frame_asks_the_x_server_once,
    a_window_keeps_the_size_that_was_asked_for,
}

/// Runs a program that checks OpenGL's answers itself, without Cupola and under several rigs.
fn judges_itself(program: &str) {
    judges_itself_with(program, &[]);
}

/// As [`judges_itself`], with further options of the program.
fn judges_itself_with(program: &str, extra: &[&str]) {
    let run = Run { extra, ..Run::new(program) };
    let Some(plain) = run.plain() else { return };
    plain.expect_success();
    for rig in ["fisheye", "planetarium-6"] {
        // One frame more than the program draws, so that it reaches its own end and verdict.
        let run = Run { cupola_frames: run.frames + 1, ..run.clone() };
        if let Some(finished) = run.under(rig) {
            finished.expect_success();
        }
    }
}

fn transform_feedback_records_a_draw_once() {
    judges_itself("feedback");
}

fn a_pipeline_of_separable_programs() {
    judges_itself("separable");
    crate::dialects::fisheye("separable", &[]);
}

fn names_that_a_program_never_asked_for_are_free() {
    judges_itself("own_names");
}

fn a_window_with_one_buffer_shows_what_one_with_two_shows() {
    let shots = [&["--shot", "shot.ppm"][..], &["--shot", "shot.ppm", "--single"]].map(|extra| {
        // The program ends itself after its screenshot. Cupola would end it before.
        let run = Run { extra, cupola_frames: 9, ..Run::new("immediate") };
        run.under("fisheye").map(|finished| finished.expect_success().picture("shot.ppm"))
    });
    let [Some(double), Some(single)] = shots else { return };
    assert_eq!(double.difference(&single), (0, 0));
}

fn the_window_by_its_name_and_our_uniform_by_none() {
    judges_itself("direct_state");
}

fn a_window_that_is_swapped_while_another_is_current() {
    judges_itself("one_context");
}

fn ways_to_set_colours_and_corners() {
    crate::dialects::plain("immediate_ways");
    crate::dialects::fisheye("immediate_ways", &[]);
    judges_itself("immediate_ways");
}

fn attributes_after_the_last_vertex() {
    judges_itself("trailing_attribute");
}

fn a_condition_that_is_open_across_a_swap_holds_for_the_program_only() {
    crate::dialects::fisheye("conditional", &[]);
    judges_itself("conditional");
}

fn a_full_stack_of_attributes_stays_full() {
    judges_itself("attribute_stack");
}

fn the_accumulation_buffer_is_that_of_every_view() {
    crate::dialects::fisheye("accumulate", &["--accumulation"]);
    judges_itself_with("accumulate", &["--accumulation"]);
}

fn a_lens_in_memory_that_stays_mapped() {
    crate::dialects::fisheye("core440_mapped", &[]);
}

fn two_contexts_draw_one_picture() {
    crate::dialects::fisheye("two_contexts", &[]);
}

fn a_swap_without_a_current_context_is_a_frame() {
    crate::dialects::fisheye("no_context", &[]);
}

/// Greatest number of requests to the X server that the program counted in a swap.
fn requests(words: &str) -> Option<u32> {
    words.lines().filter_map(|line| line.strip_prefix("requests ")?.parse().ok()).max()
}

/// Cupola asks once, for size and visibility: Xlib sends both requests together and waits once. It
/// does not ask about a window that keeps the program's own picture.
fn a_frame_asks_the_x_server_once() {
    const QUESTION: u32 = 2;
    let run = Run { frames: 5, cupola_frames: 6, ..Run::new("requests") };
    let Some(plain) = run.plain() else { return };
    let sent = |finished: Finished| requests(&finished.expect_success().words()).expect("the program counts requests");
    let plain = sent(plain);
    for (rig, more) in [("fisheye", QUESTION), ("identity", 0)] {
        let Some(under) = run.under(rig).map(sent) else { return };
        assert!(under <= plain + more, "{rig}: a swap sends {under} requests instead of {plain}");
    }
}

/// The window keeps the size of `--size` although the program sets another size when it has its
/// context.
fn a_window_keeps_the_size_that_was_asked_for() {
    let size = |cupola: &[&str]| {
        let run = Run { extra: &["--mode", "fixed"], frames: 4, cupola_frames: 4, cupola, ..Run::new("resize") };
        let picture = run.under("fisheye")?.expect_success().expect_no_gl_errors().picture("capture.png");
        Some((picture.width, picture.height))
    };
    let (Some(own), Some(asked)) = (size(&[]), size(&["--size", "240x220"])) else { return };
    assert_eq!((own, asked), ((200, 260), (240, 220)));
}
