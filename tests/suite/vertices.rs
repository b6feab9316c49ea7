//! Methods `vertex` and `primitive`, which project vertices directly to an output, compared with
//! the exact map.

use crate::compare::{
    OUTLINES, Shown, beyond_neighbours, compare, expect_alike, expect_good, expect_identical, expect_points, far,
};
use crate::dialects::{camera_of, shown_by_fisheye};
use crate::harness::{note, tests};
use crate::picture::Picture;
use crate::programs::{Finished, Run, scratch};
use crate::projected::{CIRCLE, Projectors, against_the_map, on_opengl, run};
use crate::reference::{Fisheye, Vector, dot};

tests! {
    fine_triangles_are_where_the_exact_map_has_them,
    large_triangles_stay_straight_between_their_vertices,
    points_are_where_the_exact_map_has_them,
    every_projector_gets_its_own_pass_and_blends,
    the_fixed_function_pipeline_s_vertices_are_where_the_exact_map_has_them,
    what_stands_in_for_the_pipeline_lights_as_it_does,
    other_programs_get_views,
    divided_triangles_are_where_the_exact_map_has_them,
    tessellated_primitives_are_where_the_exact_map_has_them,
    the_processor_divides_what_goes_through_the_fixed_function_pipeline,
    triangles_around_the_antipode_are_not_smeared,
    what_is_not_divided_far_enough_is_counted,
    what_is_not_counted_is_not_said_to_be_nothing,
    divided_triangles_are_right_for_every_projector,
    the_first_read_is_the_program_s_own_picture,
    the_measured_error_follows_the_bound,
    a_greater_error_is_cheaper_and_worse,
}

fn fisheye(run: &Run) -> Option<Finished> {
    on_opengl(run, "fisheye")
}

fn fine_triangles_are_where_the_exact_map_has_them() {
    let cupola = ["--method", "vertex"];
    for mode in ["triangles", "ball"] {
        let extra = ["--mode", mode];
        let run = run("fine", &extra, &cupola);
        let Some(finished) = fisheye(&run) else { return };
        let picture = finished.picture("capture.png");
        expect_good(&against_the_map(&run, &picture), &picture, &format!("fine {mode}, vertex"));
        let statistics = finished.statistics();
        assert_eq!(statistics["views"].as_array().map(Vec::len), Some(1), "one pass: {statistics:#}");
    }
}

/// Negative control, and the known limit of the method: lines between vertices stay straight.
fn large_triangles_stay_straight_between_their_vertices() {
    let run = run("core330_mvp", &[], &["--method", "vertex"]);
    let Some(finished) = fisheye(&run) else { return };
    let report = against_the_map(&run, &finished.picture("capture.png"));
    assert!(report.wrong > report.compared / 4, "{} of {} pixels are wrong", report.wrong, report.compared);
}

fn points_are_where_the_exact_map_has_them() {
    let extra = ["--mode", "points"];
    let run = run("fine", &extra, &["--method", "vertex"]);
    let Some(finished) = fisheye(&run) else { return };
    let picture = finished.picture("capture.png");
    expect_points(&picture, [0; 3], shown_by_fisheye(CIRCLE, camera_of(&run)));
}

fn every_projector_gets_its_own_pass_and_blends() {
    let projectors = Projectors::new();
    let vertex = run("fine", &[], &["--method", "vertex"]);
    let Some(plain) = projectors.unblended(&vertex, on_opengl) else { return };
    let Some(blended) = projectors.blended(&vertex, on_opengl) else { return };
    let Some(expected) = projectors.blended(&run("fine", &[], &[]), on_opengl) else { return };
    projectors.expect_good(&plain, &vertex, "fine, vertex");
    projectors.expect_blended(&plain, &blended, &expected);
}

/// Vertices from Begin/End, lists, arrays in memory and in buffers.
fn the_fixed_function_pipeline_s_vertices_are_where_the_exact_map_has_them() {
    for mode in ["triangles", "list", "arrays", "buffers"] {
        let extra = ["--mode", mode];
        let run = run("fixed_fine", &extra, &["--method", "vertex"]);
        let Some(finished) = fisheye(&run) else { return };
        let picture = finished.picture("capture.png");
        expect_good(&against_the_map(&run, &picture), &picture, &format!("fixed_fine {mode}, vertex"));
        let statistics = finished.statistics();
        assert_eq!(statistics["views"].as_array().map(Vec::len), Some(1), "one pass: {statistics:#}");
    }
}

/// Lights, materials, fog, generated texture coordinates and clip planes are those of the
/// fixed-function pipeline itself.
fn what_stands_in_for_the_pipeline_lights_as_it_does() {
    let start = |mode: &str, method: &str| {
        let (extra, cupola) = (["--mode", mode], ["--method", method]);
        Some(fisheye(&run("fixed_fine", &extra, &cupola))?.picture("capture.png"))
    };
    let Some(expected) = start("lit", "fragment") else { return };
    let mut found = expected.clone();
    for method in ["vertex", "primitive"] {
        let Some(picture) = start("lit", method) else { return };
        let off = far(&picture, &expected);
        assert!(off < 0.01, "{method}: {off:.4} of the pixels are off");
        // All but one of these pixels are where an outline is resampled.
        expect_alike(&picture, &expected, OUTLINES, &format!("lit, {method}"));
        found = picture;
    }
    let Some(other) = start("list", "vertex") else { return };
    assert!(far(&found, &other) > 0.5, "the pictures show no lighting");
    assert!(beyond_neighbours(&found, &other, 1).0 > 100, "the comparison does not detect the lighting");
}

/// Programs that the method does not support are shown as without it, and the log says why.
fn other_programs_get_views() {
    // The programs have a geometry stage of their own, or materials that change between vertices.
    for program in ["geometry", "immediate_ways"] {
        let Some(expected) = fisheye(&run(program, &[], &[])) else { return };
        let Some(found) = fisheye(&run(program, &[], &["--method", "primitive"])) else { return };
        expect_identical(&found.picture("capture.png"), &expected.picture("capture.png"), program);
        assert_eq!(found.words().matches("by method \"fragment\" instead").count(), 1, "{}", found.words());
    }
}

/// Runs a program whose primitives are divided by `method`, with an allowed error of half a pixel.
/// Checks that all are fine enough and agree with the exact map.
fn divided(program: &str, extra: &[&str], method: &str) -> Option<Finished> {
    let (method, name) = (format!("{method},max_error=0.5"), format!("{program}, {method}"));
    let options = ["--method", &method];
    let run = run(program, extra, &options);
    let finished = fisheye(&run)?;
    let picture = finished.picture("capture.png");
    expect_good(&against_the_map(&run, &picture), &picture, &name);
    let statistics = finished.statistics();
    assert_eq!(statistics["coarse_primitives"].as_u64(), Some(0), "{name}: {statistics:#}");
    assert_eq!(statistics["views"].as_array().map(Vec::len), Some(1), "{name}, one pass: {statistics:#}");
    Some(finished)
}

/// Large triangles are divided, whatever form the shaders have.
fn divided_triangles_are_where_the_exact_map_has_them() {
    for program in ["core330_mvp", "core330_block", "glsl120"] {
        if divided(program, &[], "primitive").is_none() {
            return;
        }
    }
}

/// Tessellation shaders divide primitives that share no vertices, also quadrilaterals in
/// compatibility contexts.
fn tessellated_primitives_are_where_the_exact_map_has_them() {
    let cases: [(&str, &[&str]); 4] =
        [("core330_mvp", &[]), ("glsl120", &[]), ("core330_block", &[]), ("fixed_fine", &["--mode", "buffers"])];
    for (program, extra) in cases {
        let Some(finished) = divided(program, extra, "primitive-tessellation") else { return };
        assert!(!finished.words().contains("tessellated"), "{program}: {}", finished.words());
    }
}

/// Triangles, quadrilaterals and strips of the fixed-function pipeline, from Begin/End, lists and
/// arrays. No geometry stage accepts all of them, so the processor divides them.
fn the_processor_divides_what_goes_through_the_fixed_function_pipeline() {
    for program in ["immediate", "display_list", "client_arrays"] {
        if divided(program, &[], "primitive").is_none() {
            return;
        }
    }
}

/// With a lens that shows what is behind, triangles around the antipode of its axis are not smeared
/// over the picture.
fn triangles_around_the_antipode_are_not_smeared() {
    let aperture = 240.0;
    let file = scratch("rig").join("wide.toml");
    let text = format!("[[output]]\nkind = \"domemaster\"\naperture = {aperture}\ntilt = 90\n");
    std::fs::write(&file, text).expect("a rig can be written");
    let run = run("core330_mvp", &[], &["--method", "primitive,max_error=0.5"]);
    let Some(finished) = run.under(file.to_str().expect("a UTF-8 path")) else { return };
    let picture = finished.expect_success().expect_no_gl_errors().picture("capture.png");
    let circle = Fisheye { aperture, ..CIRCLE };
    let report = compare(&picture, shown_by_fisheye(circle, camera_of(&run)));
    expect_good(&report, &picture, "core330_mvp, primitive, 240°");
}

/// No stage can make enough parts of the sphere around the antipode. That is counted. The processor
/// can make enough.
fn what_is_not_divided_far_enough_is_counted() {
    let file = scratch("rig").join("whole.toml");
    std::fs::write(&file, "[[output]]\nkind = \"domemaster\"\naperture = 360\ntilt = 90\n")
        .expect("a rig can be written");
    for (program, method, suffices) in [
        ("core330_mvp", "primitive", false),
        ("core330_mvp", "primitive-tessellation", false),
        ("immediate", "primitive", true),
    ] {
        let cupola = ["--method", method];
        let Some(finished) = run(program, &[], &cupola).under(file.to_str().expect("a UTF-8 path")) else { return };
        let statistics = finished.expect_success().expect_no_gl_errors().statistics();
        assert_eq!(
            statistics["coarse_primitives"].as_u64() == Some(0),
            suffices,
            "{program}, {method}: {statistics:#}"
        );
    }
}

/// Before OpenGL 4.2 shaders cannot count. Then the statistics must not say that nothing was
/// coarse.
fn what_is_not_counted_is_not_said_to_be_nothing() {
    for (version, counts) in [("4.5", true), ("4.1", false)] {
        let environment = [("MESA_GL_VERSION_OVERRIDE", version)];
        let run = Run { environment: &environment, ..run("core330_mvp", &[], &["--method", "primitive"]) };
        let Some(finished) = fisheye(&run) else { return };
        let statistics = finished.statistics();
        let known = statistics["coarse_primitives"].as_u64();
        assert_eq!(known, counts.then_some(0), "{version}: {statistics:#}");
    }
}

fn divided_triangles_are_right_for_every_projector() {
    let projectors = Projectors::new();
    let run = run("core330_mvp", &[], &["--method", "primitive,max_error=0.25"]);
    let Some(plain) = projectors.unblended(&run, on_opengl) else { return };
    projectors.expect_good(&plain, &run, "core330_mvp, primitive");
}

/// If a program reads before its own picture was drawn, colours, depths and stencils come from the
/// outputs' pictures.
fn the_first_read_is_the_program_s_own_picture() {
    let judged = Run { frames: 4, cupola_frames: 4, cupola: &["--method", "primitive"], ..Run::new("first_depth") };
    if fisheye(&judged).is_none() {
        return;
    }
    let extra = ["--dump", "dump.ppm"];
    let run = Run { frames: 1, cupola_frames: 1, extra: &extra, ..Run::new("immediate") };
    let cupola = ["--method", "primitive"];
    let under = Run { size: (512, 512), cupola: &cupola, ..run.clone() };
    let (Some(found), Some(expected)) = (fisheye(&under), Run { size: (512, 512), ..run }.plain()) else { return };
    let (found, expected) = (found.picture("dump.ppm"), expected.expect_success().picture("dump.ppm"));
    // A texel of the fisheye is as wide as four of the program's pixels there.
    let wrong = (0..found.pixels.len())
        .filter(|&i| (0..3).any(|c| found.pixels[i][c].abs_diff(expected.pixels[i][c]) > 8))
        .count() as f64
        / found.pixels.len() as f64;
    assert!(wrong < 1e-3, "{wrong:.4} of the pixels are wrong");
    let [(there, _), (back, _)] = [beyond_neighbours(&found, &expected, 4), beyond_neighbours(&expected, &found, 4)];
    note(format_args!(
        "{wrong:.4} of the pixels are wrong, {there}/255 and {back}/255 beyond the values within a texel around"
    ));
    assert!(there.max(back) <= 2, "{there}/255 and {back}/255 beyond the values within a texel around");
}

/// The white triangles of `shards`.
const SHARDS: [[Vector; 3]; 5] = [
    [[-0.9, -0.8, -1.0], [0.3, -0.9, -1.0], [-0.2, 0.1, -1.0]],
    [[0.4, 0.2, -1.0], [1.0, 0.1, -0.3], [0.8, 0.9, -0.6]],
    [[-1.0, 0.2, -0.5], [-0.5, 1.0, -0.2], [-1.0, 0.9, 0.3]],
    [[0.1, 0.3, -1.0], [0.2, 1.0, -0.4], [-0.3, 0.7, -1.0]],
    [[0.5, -0.9, -0.6], [0.1, -1.0, -0.1], [0.9, -0.8, -0.2]],
];

/// Planes through the viewpoint and a triangle's edges. Their normals point into the triangle.
fn planes([a, b, c]: [Vector; 3]) -> [Vector; 3] {
    let cross =
        |p: Vector, q: Vector| [p[1] * q[2] - p[2] * q[1], p[2] * q[0] - p[0] * q[2], p[0] * q[1] - p[1] * q[0]];
    let turned = if dot(cross(a, b), c) < 0.0 { -1.0 } else { 1.0 };
    [cross(a, b), cross(b, c), cross(c, a)].map(|plane| plane.map(|part| turned * part))
}

/// Greatest distance, in pixels, of a pixel on the wrong side of an edge of `shards`, and the
/// number of such pixels.
fn displaced(picture: &Picture, shown: impl Fn(f64, f64) -> Shown) -> (f64, usize) {
    let (mut worst, mut count) = (0.0f64, 0);
    for (x, y) in (0..picture.height).flat_map(|y| (0..picture.width).map(move |x| (x, y))) {
        let at = |dx: f64, dy: f64| match shown(x as f64 + 0.5 + dx, y as f64 + 0.5 + dy) {
            Shown::Direction(direction) => Some(direction),
            _ => None,
        };
        let (Some(middle), Some(aside), Some(below)) = (at(0.0, 0.0), at(0.5, 0.0), at(0.0, 0.5)) else { continue };
        // Distance inside a triangle, negative beyond its nearest edge.
        let inside = |corners: &[Vector; 3]| {
            let depth = |plane: &Vector| {
                let here = dot(*plane, middle);
                let slope = f64::hypot(dot(*plane, aside) - here, dot(*plane, below) - here) * 2.0;
                here / slope
            };
            planes(*corners).iter().map(depth).fold(f64::INFINITY, f64::min)
        };
        let depth = SHARDS.iter().map(inside).fold(f64::NEG_INFINITY, f64::max);
        if (depth > 0.0) != (picture.at(x, y)[0] > 127) {
            worst = worst.max(depth.abs());
            count += 1;
        }
    }
    (worst, count)
}

/// Edges are no farther from their right place than the allowed error, with each stage that
/// divides.
fn the_measured_error_follows_the_bound() {
    let circle = Fisheye { width: 1024.0, height: 1024.0, ..CIRCLE };
    let measured = |method: &str| {
        let cupola = ["--method", method];
        let run = Run { size: (1024, 1024), ..run("shards", &[], &cupola) };
        let picture = fisheye(&run)?.picture("capture.png");
        Some(displaced(&picture, shown_by_fisheye(circle, camera_of(&run))))
    };
    for method in ["primitive", "primitive-tessellation"] {
        let mut last = 0.0;
        for bound in [0.25, 0.5, 1.0, 2.0, 4.0] {
            let Some((worst, count)) = measured(&format!("{method},max_error={bound}")) else { return };
            note(format_args!("{method}, {bound} px allowed: {worst:.3} px, {count} pixels"));
            // Rasterisers place corners on a grid of 1/256 pixel.
            assert!(worst <= bound + 0.01, "{method}, {bound} px: {worst} px");
            assert!(worst >= 0.5 * last, "{method}, {bound} px: {worst} px, less than half of the {last} px before");
            last = worst;
        }
        assert!(last > 0.5, "{method}: with 4 px allowed an error of {last} px is too small to be measured");
    }
    let Some((undivided, _)) = measured("vertex") else { return };
    assert!(undivided > 20.0, "without division the error is only {undivided} px");
}

/// A greater allowed error gives a greater error.
fn a_greater_error_is_cheaper_and_worse() {
    let worst = |max_error: &str| {
        let method = format!("primitive,max_error={max_error}");
        let cupola = ["--method", method.as_str()];
        let run = run("core330_mvp", &[], &cupola);
        let picture = fisheye(&run)?.picture("capture.png");
        Some(against_the_map(&run, &picture).worst)
    };
    let (Some(fine), Some(rough)) = (worst("0.25"), worst("8")) else { return };
    assert!(fine <= 2.0 && rough > 3.0 * fine, "{fine:.2}/255 and {rough:.2}/255");
}
