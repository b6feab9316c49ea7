//! Forms of camera matrices in programs: arrays of vectors, row vectors, elements of arrays.

use crate::compare::{Report, compare, expect_good};
use crate::dialects::{CAMERAS, camera_of, shown_by_fisheye, shown_by_window};
use crate::harness::tests;
use crate::picture::Picture;
use crate::programs::{Finished, Run, scratch};
use crate::reference::Fisheye;

tests! {
    four_vectors_of_an_array,
    rows_row_vectors_and_64_bit_numbers,
    an_element_of_an_array,
    an_element_that_is_not_known,
    an_attribute_of_each_instance,
    parameters_of_a_vertex_program,
    a_storage_block,
    a_model_that_is_stretched,
    a_vertex_shader_of_two_programs,
}

fn run<'a>(program: &'a str, extra: &'a [&'a str]) -> Run<'a> {
    let (fov, yaw, pitch) = CAMERAS[1];
    Run { fov, yaw, pitch, extra, ..Run::new(program) }
}

/// Runs a form of a program on a dome.
fn on_dome(program: &str, form: &str, rig: &str) -> Option<(Finished, Picture, Report)> {
    let extra = ["--mode", form];
    let run = run(program, &extra);
    let finished = run.under(rig)?.expect_success().expect_no_gl_errors();
    let picture = finished.picture("capture.png");
    let circle = Fisheye { width: 256.0, height: 256.0, aperture: 180.0, tilt: 90.0 };
    let report = compare(&picture, shown_by_fisheye(circle, camera_of(&run)));
    Some((finished, picture, report))
}

/// The forms of a program show the predicted picture, without Cupola and on a dome.
fn right(program: &str, forms: &[&str]) {
    for form in forms {
        let extra = ["--mode", form, "--shot", "shot.ppm"];
        let run = run(program, &extra);
        let Some(plain) = run.plain() else { return };
        let picture = plain.expect_success().picture("shot.ppm");
        let report = compare(&picture, shown_by_window(run.size, run.fov, camera_of(&run)));
        expect_good(&report, &picture, &format!("{program} {form} without Cupola"));
        let Some((_, picture, report)) = on_dome(program, form, "fisheye") else { return };
        expect_good(&report, &picture, &format!("{program} {form} fisheye"));
    }
}

fn four_vectors_of_an_array() {
    let uniforms = ["columns", "rows", "elements", "scalars", "by_name"];
    let translated = ["registers", "macros", "constructor", "constructor_rows", "computed", "block", "block_rows"];
    right("vec4_matrices", &uniforms);
    right("vec4_matrices", &translated);
}

fn rows_row_vectors_and_64_bit_numbers() {
    let row_vectors = ["row_vector", "row_vector_parts", "row_vector_transposed"];
    right("matrix_orders", &row_vectors);
    right("matrix_orders", &["block_by_rows", "block_row_vector", "block_by_rows_row_vector"]);
    right("matrix_orders", &["view_4x3", "view_3x4"]);
    right("matrix_orders", &["double", "double_block", "double_block_by_rows"]);
}

fn an_element_of_an_array() {
    right("matrix_arrays", &["constant", "uniform", "unsigned", "same", "structures"]);
    right("matrix_arrays", &["block_constant", "block_uniform", "block_same", "block_index"]);
}

/// A form whose lens cannot be determined is flat, and the log says so. With a rig that gives the
/// lens the picture is right.
fn flat_but_for_a_given_lens(program: &str, form: &str) {
    let Some((finished, _, report)) = on_dome(program, form, "fisheye") else { return };
    assert!(report.wrong > 1000, "control: without a lens it is flat");
    assert!(finished.words().contains("camera.lens"), "{program} {form}: {}", finished.words());
    let fov = CAMERAS[1].0;
    let path = scratch("lens").join(format!("{program}-{form}.toml"));
    let dome = "[dome]\ntilt = 90\n[[output]]\nkind = \"domemaster\"\naperture = 180\ntilt = 90\n";
    std::fs::write(&path, format!("[camera]\nlens = [{fov}, {fov}]\n{dome}")).expect("a file can be written");
    let rig = path.to_str().expect("a UTF-8 path");
    let Some((_, picture, report)) = on_dome(program, form, rig) else { return };
    expect_good(&report, &picture, &format!("{program} {form} with a lens that the rig gives"));
}

fn an_element_that_is_not_known() {
    flat_but_for_a_given_lens("matrix_arrays", "instance");
    flat_but_for_a_given_lens("matrix_arrays", "block_instance");
}

fn an_attribute_of_each_instance() {
    right("instanced_matrix", &["array", "second", "constant", "columns", "rows", "models"]);
    flat_but_for_a_given_lens("instanced_matrix", "vertices");
}

fn parameters_of_a_vertex_program() {
    right("assembly_camera", &["state", "environment", "local", "columns"]);
}

fn a_storage_block() {
    right("storage_camera", &["member", "rows", "constant", "far", "uniform", "same"]);
    right("storage_camera", &["structures", "structure_by_uniform"]);
    flat_but_for_a_given_lens("storage_camera", "instance");
}

/// Matrices of stretched models do not show the lens, so that of the other models is used. If the
/// camera looks along the axes of a stretched model, the model's matrix looks like that of another
/// lens.
fn a_model_that_is_stretched() {
    for (yaw, pitch) in [(0.0, 0.0), (CAMERAS[1].1, CAMERAS[1].2)] {
        for form in ["axes", "skew"] {
            let extra = ["--mode", form, "--shot", "shot.ppm"];
            let run = Run { yaw, pitch, ..run("stretched_models", &extra) };
            let Some(plain) = run.plain() else { return };
            let picture = plain.expect_success().picture("shot.ppm");
            let what = format!("{form} {yaw} {pitch}");
            expect_good(&compare(&picture, shown_by_window(run.size, run.fov, camera_of(&run))), &picture, &what);
            let Some(under) = run.under("fisheye") else { return };
            let picture = under.expect_success().expect_no_gl_errors().picture("capture.png");
            let circle = Fisheye { width: 256.0, height: 256.0, aperture: 180.0, tilt: 90.0 };
            expect_good(&compare(&picture, shown_by_fisheye(circle, camera_of(&run))), &picture, &what);
        }
    }
}

/// The vertex shader is the last stage of another program. Cupola has changed the shader for that
/// program.
fn a_vertex_shader_of_two_programs() {
    right("geometry", &["shared"]);
}
