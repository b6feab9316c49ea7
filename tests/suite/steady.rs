//! A steady frame allocates nothing and links no shader.
//!
//! `tests/apps/preload/allocations.c` counts the calls of malloc and its kin that come from Cupola's library, in
//! frames 20…199.

use crate::programs::{Finished, Run, embedding, preload};

const FRAMES: usize = 200;

/// Number of allocations in steady frames, and where they came from. `None`: nothing was counted.
fn allocations(finished: &Finished) -> (u64, String) {
    let text = finished.text("steady.txt");
    let number = |word: &str| -> u64 {
        let line = text.lines().find_map(|line| line.strip_prefix(word));
        line.and_then(|n| n.trim().parse().ok()).unwrap_or_else(|| panic!("no {word} in {text:?}"))
    };
    assert_eq!(number("libraries"), 1, "Cupola's library was not found in the process: {text}");
    (number("allocations"), text)
}

fn run<'a>(program: &'a str, extra: &'a [&'a str], frames: usize, environment: &'a [(&'a str, &'a str)]) -> Run<'a> {
    // Cupola ends a program in its last frame, before the swap.
    Run { size: (96, 96), frames, cupola_frames: frames, extra, environment, ..Run::new(program) }
}

fn counted(program: &str, extra: &[&str], rig: &str) -> Option<Finished> {
    let library = preload("allocations");
    let environment = [("LD_PRELOAD", library.as_str()), ("STEADY_REPORT", "steady.txt")];
    run(program, extra, FRAMES + 1, &environment).under(rig)
}

fn steady(program: &str, extra: &[&str], rig: &str) {
    let Some(finished) = counted(program, extra, rig) else { return };
    let finished = finished.expect_success();
    let (number, text) = allocations(&finished);
    assert_eq!(number, 0, "{program} {extra:?} {rig}: {text}");
    let Some(early) = run(program, extra, 20, &[]).under(rig) else { return };
    let linked = |finished: &Finished| finished.statistics()["shaders_linked"].as_u64().expect("a number");
    let early = linked(&early.expect_success());
    assert!(early > 0, "{program}: no correction was linked");
    assert_eq!(linked(&finished), early, "{program} {extra:?} {rig}: shaders are linked in steady frames");
}

#[test]
fn fixed_function_programs() {
    for program in
        ["immediate", "immediate_ways", "display_list", "client_arrays", "draws", "rectangles", "hud", "text"]
    {
        steady(program, &[], "fisheye");
    }
}

#[test]
fn programs_with_shaders() {
    for program in ["glsl120", "core330_p_mv", "core330_mvp", "core330_block", "geometry", "tessellation"] {
        steady(program, &[], "fisheye");
    }
    steady("core330_mvp", &["--samples", "4"], "fisheye");
}

#[test]
fn gles_programs() {
    steady("gles2", &[], "fisheye");
    steady("gles3", &[], "fisheye");
}

#[test]
fn scenes_that_are_drawn_off_screen() {
    steady("core330_mvp", &["--fbo"], "fisheye");
    steady("immediate", &["--fbo"], "fisheye");
    steady("post_process", &[], "fisheye");
}

#[test]
fn several_projectors() {
    steady("immediate", &[], "planetarium-6");
    steady("core330_block", &[], "planetarium-6");
}

#[test]
fn the_c_interface() {
    let environment = [("LD_PRELOAD", &*preload("allocations")), ("STEADY_REPORT", "steady.txt")];
    let Some(finished) = embedding("embed", &["96", "0", "0", "200"], &environment) else { return };
    let (number, text) = allocations(&finished.expect_success());
    assert_eq!(number, 0, "{text}");
}

/// A window that changes its size now and then is planned anew each time: the counter must see it.
#[test]
fn a_frame_that_is_not_steady_is_seen() {
    let Some(finished) = counted("resize", &[], "fisheye") else { return };
    let (number, text) = allocations(&finished);
    assert!(number > 100, "{text}");
}
