//! What correcting costs, in units of drawing one bilinear full-screen quad.
//!
//! `cargo bench --bench warp [-- WIDTH HEIGHT ROUNDS]`. All passes are timed in turn, round by
//! round, so that a busy machine slows all alike; the medians of the ratios are reported.

use cupola::backend::gl::trial::{Sampling, Trial, TrialMesh};
use cupola::correct::Plan;
use cupola::correct::plan::build;
use cupola::geom::Frustum;
use cupola::rig::*;
use cupola::views::Request;
use glam::DVec3;
use std::path::PathBuf;

type Failure = Box<dyn std::error::Error>;

fn main() -> Result<(), Failure> {
    let numbers: Vec<u32> = std::env::args().skip(1).filter_map(|a| a.parse().ok()).collect();
    let size = (numbers.first().copied().unwrap_or(1920), numbers.get(1).copied().unwrap_or(1080));
    let rounds = numbers.get(2).copied().unwrap_or(15);
    let mut trial = Trial::new(size)?;
    println!("{}; {}×{}, {rounds} rounds", trial.driver(), size.0, size.1);
    trial.add_mesh(&TrialMesh::quad(), &Sampling::Picture(size.0, size.1))?;
    let mut names = vec!["bilinear quad".to_owned()];
    let mask = half_masked(size)?;
    for (name, rig) in rigs(mask.clone()) {
        let plan = plan(&rig, size)?;
        let (_, prepared) = trial.add_plan(&plan)?;
        let pass = &plan.passes[0];
        let part = |wanted: &dyn Fn(&cupola::correct::Batch) -> bool| {
            let rects = pass.batches.iter().filter(|b| wanted(b)).flat_map(|b| &b.rects);
            let pixels: f64 = rects.fold(0.0, |sum, r| sum + f64::from(r.width) * f64::from(r.height));
            100.0 * pixels / f64::from(size.0) / f64::from(size.1)
        };
        println!(
            "{name}: {} views, {} batches prepared in {:.0} ms; {:.0} % of the pixels drawn, {:.0} % with several views, {:.0} % blended, {:.0} % with an edge",
            plan.views.views.len(),
            pass.batches.len(),
            prepared * 1e3,
            part(&|_| true),
            part(&|b| b.views.len() > 1),
            part(&|b| !b.neighbours.is_empty()),
            part(&|b| b.edge),
        );
        names.push(name);
    }
    std::fs::remove_file(mask)?;
    let times = trial.run(rounds, || {})?;
    println!("\n{:32} {:>10} {:>10} {:>7} {:>17}", "pass", "median ms", "least ms", "ratio", "processor's ratio");
    let ratio = |of: &[f64], base: &[f64]| median(of.iter().zip(base).map(|(a, b)| a / b).collect());
    for (name, own) in names.iter().zip(&times) {
        let least = own.seconds.iter().copied().fold(f64::INFINITY, f64::min);
        println!(
            "{name:32} {:10.2} {:10.2} {:7.2} {:17.2}",
            median(own.seconds.clone()) * 1e3,
            least * 1e3,
            ratio(&own.seconds, &times[0].seconds),
            ratio(&own.processor, &times[0].processor),
        );
    }
    Ok(())
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(f64::NAN)
}

/// A file with a mask whose left half is black.
fn half_masked((width, height): (u32, u32)) -> Result<PathBuf, Failure> {
    let path = std::env::temp_dir().join(format!("cupola-bench-{}.png", std::process::id()));
    image::GrayImage::from_fn(width, height, |x, _| image::Luma([if 2 * x < width { 0 } else { 255 }])).save(&path)?;
    Ok(path)
}

/// What is compared: name and rig; the first output is drawn. `mask`: of an output that is masked.
fn rigs(mask: PathBuf) -> Vec<(String, Rig)> {
    let frustum = Frustum::symmetric(60f64.to_radians(), 40f64.to_radians());
    let beamer = |name: &str, yaw: f64, overlap| {
        let kind = OutputKind::Projector {
            position: DVec3::new(0.0, 0.0, 3.0),
            angles: [yaw.to_radians(), 0.1, 0.0],
            frustum,
        };
        output(name, kind, overlap)
    };
    let dome = |degrees: f64| {
        let kind = OutputKind::Domemaster { aperture: degrees.to_radians(), tilt: std::f64::consts::FRAC_PI_2 };
        output("dome", kind, false)
    };
    vec![
        ("projector 60×40° at 0.6 R".into(), rig(vec![beamer("one", 0.0, false)])),
        ("the same, half of it masked".into(), rig(vec![Output { mask: Some(mask), ..beamer("one", 0.0, false) }])),
        (
            "blended on both sides".into(),
            with_own_views(rig(vec![
                beamer("one", 0.0, true),
                beamer("two", 40.0, true),
                beamer("three", -40.0, true),
            ])),
        ),
        (
            "the same, views shared by all".into(),
            rig(vec![beamer("one", 0.0, true), beamer("two", 40.0, true), beamer("three", -40.0, true)]),
        ),
        ("fisheye 180°".into(), rig(vec![dome(180.0)])),
        ("fisheye 240°".into(), rig(vec![dome(240.0)])),
    ]
}

fn output(name: &str, kind: OutputKind, overlap: bool) -> Output {
    let blend = Blend { overlap, ramp: 0.3, ..Blend::default() };
    Output {
        name: name.into(),
        kind,
        method: Default::default(),
        size: None,
        window: None,
        blend,
        mask: None,
        eye: 0.0,
    }
}

fn rig(outputs: Vec<Output>) -> Rig {
    Rig {
        name: "bench".into(),
        passthrough: false,
        dome: Dome { radius: 5.0, tilt: 0.0, coverage: std::f64::consts::TAU },
        screen: None,
        viewer: Viewer { position: DVec3::ZERO, yaw: 0.0, pitch: 0.0, roll: 0.0 },
        camera: Camera::default(),
        views: Views::default(),
        overlay: Overlay { yaw: 0.0, pitch: 0.0, width: 1.0 },
        outputs,
    }
}

/// One tight view for each output.
fn with_own_views(mut rig: Rig) -> Rig {
    rig.views.method = ViewMethod::Single;
    rig
}

fn plan(rig: &Rig, size: (u32, u32)) -> Result<Plan, Failure> {
    let mut plan = build(
        rig,
        &Request {
            output_sizes: vec![size; rig.outputs.len()],
            window: size,
            panel: false,
            primary: false,
            max_atlas: 16384,
        },
    )?;
    plan.passes.truncate(1);
    Ok(plan)
}
