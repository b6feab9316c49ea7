//! A steady frame allocates no memory, links no shader, creates no object, and makes few calls.
//!
//! `tests/apps/preload/allocations.c` counts the calls of malloc and related functions that come
//! from Cupola's library, in frames 20…199. `tests/apps/preload/calls.c` counts calls of OpenGL
//! between Cupola and the driver.

use crate::harness::{note, tests};
use crate::programs::{Finished, Run, embedding, preload, vendor};
use std::collections::BTreeMap;

tests! {
    fixed_function_programs,
    programs_with_shaders,
    gles_programs,
    scenes_that_are_drawn_off_screen,
    several_projectors,
    the_c_interface,
    a_frame_that_is_not_steady_is_seen,
    draws_ask_for_nothing,
    no_call_is_made_for_nothing,
    no_object_is_made,
}

const FRAMES: usize = 200;

/// Number of allocations in steady frames, and the report with their origin.
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

fn fixed_function_programs() {
    for program in
        ["immediate", "immediate_ways", "display_list", "client_arrays", "draws", "rectangles", "hud", "text"]
    {
        steady(program, &[], "fisheye");
    }
}

fn programs_with_shaders() {
    for program in ["glsl120", "core330_p_mv", "core330_mvp", "core330_block", "geometry", "tessellation"] {
        steady(program, &[], "fisheye");
    }
    steady("core330_mvp", &["--samples", "4"], "fisheye");
}

fn gles_programs() {
    steady("gles2", &[], "fisheye");
    steady("gles3", &[], "fisheye");
}

fn scenes_that_are_drawn_off_screen() {
    steady("core330_mvp", &["--fbo"], "fisheye");
    steady("immediate", &["--fbo"], "fisheye");
    steady("post_process", &[], "fisheye");
    steady("computed", &[], "fisheye");
    steady("backdrop", &[], "fisheye");
}

fn several_projectors() {
    steady("immediate", &[], "planetarium-6");
    steady("core330_block", &[], "planetarium-6");
}

fn the_c_interface() {
    let environment = [("LD_PRELOAD", &*preload("allocations")), ("STEADY_REPORT", "steady.txt")];
    let Some(finished) = embedding("embed", &["96", "0", "0", "200"], &environment) else { return };
    let (number, text) = allocations(&finished.expect_success());
    assert_eq!(number, 0, "{text}");
}

/// Negative control: views are planned again each time a window changes its size. The counter must
/// count that.
fn a_frame_that_is_not_steady_is_seen() {
    let Some(finished) = counted("resize", &[], "fisheye") else { return };
    let (number, text) = allocations(&finished);
    assert!(number > 100, "{text}");
}

/// Number of calls of OpenGL in a steady frame by function, those of the program and of Cupola.
/// `None` if there is no display or if the processor is not supported.
fn calls_per_frame(program: &str, rig: &str) -> Option<BTreeMap<String, u64>> {
    let folder = vendor()?;
    let total = |frames: usize| -> Option<BTreeMap<String, u64>> {
        let environment = [
            ("LD_LIBRARY_PATH", folder),
            ("CUPOLA_GLX_REAL", "calls"),
            ("CALLS_REPORT", "calls.txt"),
            // Without the cache both runs make the same calls.
            ("CUPOLA_CACHE", "0"),
        ];
        // The program must end by itself, because the calls are written then.
        let finished = Run { cupola_frames: 1000, ..run(program, &[], frames, &environment) }.under(rig)?;
        let text = finished.expect_success().text("calls.txt");
        let line = |line: &str| {
            let (name, number) = line.split_once(' ').expect("a name and a number");
            (name.to_owned(), number.parse().expect("a number"))
        };
        Some(text.lines().map(line).collect())
    };
    let (few, many) = (total(20)?, total(40)?);
    let steady = |(name, number): (&String, &u64)| (name.clone(), (number - few.get(name).unwrap_or(&0)) / 20);
    Some(many.iter().map(steady).filter(|(_, number)| *number > 0).collect())
}

/// Number of calls by the name of the function without the type of its arguments, because Cupola
/// calls `glVertex3dv` where the program calls `glVertex3d`. Queries are left out.
fn by_family(calls: &BTreeMap<String, u64>) -> BTreeMap<String, u64> {
    let mut families = BTreeMap::new();
    for (name, number) in calls.iter().filter(|(name, _)| !name.starts_with("glGet") && !name.starts_with("glIs")) {
        let family = match name.find(|letter: char| letter.is_ascii_digit()) {
            Some(digit) if name.starts_with("glVertex") || name.starts_with("glColor") => &name[..digit],
            _ => name,
        };
        *families.entry(family.to_owned()).or_default() += number;
    }
    families
}

/// Cupola queries vertex arrays once and not in each draw. It queries switches, masks and similar
/// state once and not in each frame.
fn draws_ask_for_nothing() {
    // The first has 136 draws per frame. The second has eight, with five changes of the matrices.
    // The last sets its arrays for each draw.
    for (program, most) in [("positions", 16), ("fixed_buffers", 24), ("hud", 26), ("client_arrays", 23)] {
        let Some(plain) = calls_per_frame(program, "identity") else { return };
        let Some(calls) = calls_per_frame(program, "fisheye") else { return };
        let asks = |name: &str| name.starts_with("glGet") || name.starts_with("glIs");
        let sum = |calls: &BTreeMap<String, u64>| -> u64 {
            calls.iter().filter(|(name, _)| asks(name)).map(|(_, number)| number).sum()
        };
        let ours = sum(&calls) - sum(&plain);
        assert!(ours > 0 && ours <= most, "{program}: Cupola asks {ours} times in a frame: {calls:?}");
    }
}

/// Number of calls of a correction with one output that save, set and restore state, without those
/// for each view.
const CALLS_OF_A_CORRECTION: u64 = 25;

/// A frame makes the program's calls once for each view, the calls that select the view, and those
/// of the correction. [`draws_ask_for_nothing`] counts the queries.
fn no_call_is_made_for_nothing() {
    // For each view: a viewport, its matrix, and a program and a draw of the correction. Without
    // shaders: a matrix and its mode for each of three groups of primitives, and each time the
    // program's own again.
    for (program, of_a_view) in [("core330_mvp", 4), ("immediate", 13)] {
        let Some(plain) = calls_per_frame(program, "identity") else { return };
        let Some(calls) = calls_per_frame(program, "fisheye") else { return };
        let Some(finished) = run(program, &[], 40, &[]).under("fisheye") else { return };
        let views = finished.statistics()["views"].as_array().map_or(0, Vec::len) as u64;
        assert_eq!(calls["glXSwapBuffers"], 1);
        let (plain, calls) = (by_family(&plain), by_family(&calls));
        let ours = |(name, number): (&String, &u64)| number.saturating_sub(views * plain.get(name).unwrap_or(&0));
        let ours: u64 = calls.iter().map(ours).sum();
        let most = CALLS_OF_A_CORRECTION + views * of_a_view;
        note(format_args!("{program}: {views} views, {ours} calls of {most} that are not the program's own"));
        assert!(views > 1 && ours <= most, "{program}: {ours} calls of {most}: {calls:?}, the program's {plain:?}");
        // Negative control: one more call per view would exceed the bound.
        assert!(ours + views > most, "{program}: {ours} calls of {most}");
        // One atlas needs one texture binding. The program's draws need one framebuffer binding and
        // the window another.
        assert!(calls["glBindTexture"] <= 2 && calls["glBindFramebuffer"] <= 2, "{program}: {calls:?}");
    }
}

/// Steady frames create no objects of OpenGL, so no object can remain.
fn no_object_is_made() {
    for program in ["core330_mvp", "immediate", "post_process"] {
        let Some(calls) = calls_per_frame(program, "fisheye") else { return };
        let makes =
            |name: &str| name.starts_with("glGen") && name != "glGenerateMipmap" || name.starts_with("glCreate");
        let made: Vec<_> = calls.iter().filter(|(name, _)| makes(name)).collect();
        assert!(made.is_empty() && calls.contains_key("glXSwapBuffers"), "{program}: {made:?}");
    }
}
