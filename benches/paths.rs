//! Code of the processor that runs at a start, in each frame, for each draw or for each vertex.
//!
//! `cargo bench --bench paths [FILTER]`.

use cupola::blend::Weights;
use cupola::correct::shaders::draws::{Rows, draws};
use cupola::correct::shaders::glsl::{Language, Stage, specialise};
use cupola::correct::{self, Plan};
use cupola::geom::Frustum;
use cupola::intercept::gl::per_view::culling::bounds::{PlacedBox, extent, outside};
use cupola::intercept::gl::per_view::culling::position::{Transform, View};
use cupola::intercept::gl::state::compat::vertex_commands::VertexCommand;
use cupola::intercept::gl::state::compat::vertex_recorder::{Recorder, Sets, add_vertex};
use cupola::intercept::gl::state::draw::bounds::Bounds;
use cupola::rig::{self, Rig};
use cupola::runtime::session::{Extras, MatrixClass, Session, classify};
use cupola::views::{self, Request};
use divan::{Bencher, black_box};
use glam::{DMat4, DVec2, DVec3};

fn main() {
    divan::main();
}

/// Rigs whose plans are timed.
const RIGS: [&str; 4] = ["fisheye", "planetarium-2", "planetarium-6", "idome"];
const WINDOW: (u32, u32) = (1920, 1080);

fn rig(name: &str) -> Rig {
    rig::load(name).expect("a preset")
}

fn request(rig: &Rig) -> Request {
    let rects = rig.layout(WINDOW);
    let output_sizes = rects.iter().map(|rect| rect.size()).collect();
    Request { output_sizes, window: WINDOW, panel: true, primary: false, max_atlas: 16384 }
}

fn plan(rig: &Rig) -> Plan {
    correct::build(rig, &request(rig)).expect("a plan")
}

/// A session of the library for a preset.
fn session(name: &str) -> Session {
    Session::new(&rig(name), WINDOW, false, 16384, Extras::default()).expect("a session")
}

fn program_matrix() -> DMat4 {
    Frustum::symmetric(1.2, 0.8).projection_matrix(0.1, 1000.0)
}

mod start {
    use super::*;

    /// Plans only the views.
    #[divan::bench(args = RIGS)]
    fn views(bencher: Bencher, name: &str) {
        let rig = rig(name);
        let request = request(&rig);
        bencher.bench(|| views::plan(black_box(&rig), &request));
    }

    /// Plans everything.
    #[divan::bench(args = RIGS)]
    fn plan(bencher: Bencher, name: &str) {
        let rig = rig(name);
        let request = request(&rig);
        bencher.bench(|| correct::build(black_box(&rig), &request));
    }

    /// Finds the parts of views that no output samples.
    #[divan::bench(args = RIGS)]
    fn unsampled_areas(bencher: Bencher, name: &str) {
        let plan = super::plan(&rig(name));
        bencher.bench(|| correct::unsampled_areas(black_box(&plan)));
    }

    /// Finds the parts of views that the parts of outputs sample.
    #[divan::bench(args = RIGS)]
    fn footprints(bencher: Bencher, name: &str) {
        let plan = super::plan(&rig(name));
        bencher.bench(|| {
            let passes = plan.passes.iter().zip(&plan.views.output_views);
            passes.map(|(pass, views)| correct::footprints(black_box(&plan), pass, views)).collect::<Vec<_>>()
        });
    }

    /// Writes the texts of all shaders, with their constants.
    #[divan::bench(args = RIGS)]
    fn shaders(bencher: Bencher, name: &str) {
        let plan = super::plan(&rig(name));
        bencher.bench(|| {
            let list = draws(black_box(&plan), &plan.passes, true, Rows::FromBottom).expect("draws");
            let draws = list.outputs.iter().flatten();
            draws.map(|draw| specialise(&draw.constants, Language::Glsl330, Stage::Present)).collect::<Vec<_>>()
        });
    }

    /// Computes the weights of a hundred pixels of each output.
    #[divan::bench(args = ["planetarium-2", "planetarium-6"])]
    fn weights(bencher: Bencher, name: &str) {
        let rig = rig(name);
        let request = request(&rig);
        let weights = Weights::new(&rig, &request.output_sizes).expect("weights");
        let pixel = |(width, height): (u32, u32), i: u32| {
            DVec2::new(f64::from(i % 10 * width) / 10.0 + 0.5, f64::from(i / 10 * height) / 10.0 + 0.5)
        };
        bencher.bench(|| {
            let sizes = request.output_sizes.iter().enumerate();
            let of = |(output, size)| (0..100).filter_map(|i| weights.weight(output, pixel(size, i))).sum::<f64>();
            sizes.map(|(output, size)| of((output, *size))).sum::<f64>()
        });
    }
}

mod link {
    use super::*;
    use cupola::intercept::gl::shader::source::dependence::position_names;
    use std::collections::HashMap;
    use std::fmt::Write;
    use std::sync::Arc;

    const VERTEX_SHADER: u32 = 0x8B31;

    /// Returns a vertex shader like those of shader translators: matrices as arrays of vectors, and
    /// this number of statements.
    fn translated(statements: usize) -> String {
        let mut text = "#version 330\nuniform vec4 vp[4]; uniform vec4 m[64];\nin vec4 v; out vec4 s;\n".to_owned();
        text.push_str("vec4 t0; vec4 t1;\nvoid main() {\n    t0 = v.yyyy * vp[1];\n    t0 = vp[0] * v.xxxx + t0;\n");
        text.push_str("    t0 = vp[2] * v.zzzz + t0;\n    gl_Position = vp[3] * v.wwww + t0;\n");
        for i in 0..statements {
            let (to, from, element) = (i % 2, (i + 1) % 2, i % 64);
            let _ = writeln!(text, "    t{to}.xyz = dot(t{from}.xyzw, m[{element}].xyzw) * v.xyz + m[{element}].xyz;");
        }
        text + "    s = t0 + t1;\n}\n"
    }

    /// Finds the names on which the position depends.
    #[divan::bench(args = [10, 100, 1000])]
    fn position(bencher: Bencher, statements: usize) {
        let sources = HashMap::from([(1, Arc::from(translated(statements)))]);
        bencher.bench(|| position_names(black_box(&sources), &[(1, VERTEX_SHADER)]).expect("understood"));
    }
}

mod draw {
    use super::*;
    use cupola::correct::projected::matrices::ReprojectionMatrix;

    /// Classifies a program's matrix.
    #[divan::bench]
    fn classify_matrix() -> MatrixClass {
        classify(&black_box(program_matrix()))
    }

    /// Computes the rows of every view for a new lens of the program.
    #[divan::bench(args = ["fisheye", "planetarium-6"])]
    fn rows(bencher: Bencher, name: &str) {
        let session = session(name);
        let MatrixClass::Perspective(lens) = classify(&program_matrix()) else { panic!("a perspective matrix") };
        bencher.bench(|| session.rows(black_box(&lens)).map(|rows| rows.x[0]).sum::<f64>());
    }

    /// Finds which of five views can show a box, and its extent there.
    #[divan::bench]
    fn cull(bencher: Bencher) {
        let rows: [ReprojectionMatrix; 5] = std::array::from_fn(|view| {
            let turn = view as f32 * 1.1;
            let (sine, cosine) = turn.sin_cos();
            let e = -1.0002;
            let rows = [cosine, 0.0, -sine, 0.0, 0.0, 1.0, 0.1, 0.0, sine, 0.0, cosine, 0.0, e, 1.0, 0.0, 0.0];
            ReprojectionMatrix::from_array(rows)
        });
        let model = Transform::of(&program_matrix());
        bencher.bench(|| {
            let (low, high) = black_box((DVec3::new(-1.0, -1.0, -12.0), DVec3::new(1.0, 2.0, -10.0)));
            let placed = PlacedBox::of(&model, low, high);
            rows.iter()
                .map(View::of_reprojection)
                .filter(|view| !outside(view, &placed, DVec2::splat(0.01)))
                .filter_map(|view| extent(&view, &placed))
                .count()
        });
    }
}

mod vertex {
    use super::*;

    /// Records a hundred vertices with normals between Begin and End.
    #[divan::bench]
    fn record(bencher: Bencher) {
        let mut recorder = Recorder::default();
        bencher.bench_local(|| {
            recorder.clear();
            let mut bounds = Bounds::EMPTY;
            for i in 0..100 {
                let position = [i as f32, 1.0, -2.0];
                recorder.push(VertexCommand::normal3fv, Sets::Normal, &[], &[0.0f32, 0.0, 1.0]);
                add_vertex(&mut bounds, Sets::Position, &position);
                recorder.push(VertexCommand::vertex3fv, Sets::Position, &[], &position);
            }
            (bounds, recorder.place())
        });
    }
}
