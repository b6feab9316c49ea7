//! Cost of the correction, in units of drawing one bilinear full-screen quad.
//!
//! `cargo bench --bench warp [-- WIDTH HEIGHT ROUNDS]`. All passes are timed in turn, round by
//! round, so that other load slows all of them equally. The medians of the ratios are printed.

use cupola::correct::Plan;
use cupola::correct::build;
use cupola::rig::{self, Rig};
use cupola::views::Request;
use std::path::{Path, PathBuf};
use trial::{Sampling, Trial, TrialMesh};

#[path = "../src/bin/cupola-lab/trial/gl.rs"]
#[allow(dead_code, reason = "the bench needs only a part of the laboratory's harness")]
mod trial;

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
    for (name, rig) in rigs(&mask)? {
        let plan = plan(&rig, size)?;
        let (_, first) = trial.add_plan(&plan)?;
        let pass = &plan.passes[0];
        let part = |wanted: &dyn Fn(&cupola::correct::Batch) -> bool| {
            let rects = pass.batches.iter().filter(|b| wanted(b)).flat_map(|b| &b.rects);
            let pixels: f64 = rects.fold(0.0, |sum, r| sum + f64::from(r.width) * f64::from(r.height));
            100.0 * pixels / f64::from(size.0) / f64::from(size.1)
        };
        println!(
            "{name}: {} views, {} batches, drawn for the first time after {:.0} ms; {:.0} % of the pixels drawn, {:.0} % with several views, {:.0} % blended, {:.0} % with an edge",
            plan.views.views.len(),
            pass.batches.len(),
            first * 1e3,
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

/// A window that is already projected.
const CONTENT: &str = "[content]\nkind = \"domemaster\"\naperture = 180\n";

/// Name and rig of each pass that is compared; the rig's first output is drawn. `mask` is the mask
/// of the masked output.
fn rigs(mask: &Path) -> Result<Vec<(String, Rig)>, Failure> {
    let projector = |yaw: f64, more: &str| {
        format!(
            "[[output]]\nkind = \"projector\"\nposition = [0, 0, 3]\nyaw = {yaw}\npitch = 5.73\nfov = [60, 40]\n{more}\n"
        )
    };
    let alone = "blend = { overlap = false }";
    let blended = "blend = { overlap = true, ramp = 0.3 }";
    let three: String = [0.0, 40.0, -40.0].map(|yaw| projector(yaw, blended)).concat();
    let dome = |degrees: u32| format!("[[output]]\nkind = \"domemaster\"\naperture = {degrees}\ntilt = 90\n");
    let masked = format!("{alone}\nmask = {{ image = {:?} }}", mask.display().to_string());
    [
        ("projector 60×40° at 0.6 R", projector(0.0, alone)),
        ("the same, half of it masked", projector(0.0, &masked)),
        // One tight view for each output.
        ("blended on both sides", format!("[views]\nmethod = \"single\"\n{three}")),
        ("the same, views shared by all", three),
        ("fisheye 180°", dome(180)),
        ("fisheye 240°", dome(240)),
        ("projector, a domemaster", format!("{CONTENT}{}", projector(0.0, alone))),
        ("projector, equirectangular", format!("[content]\nkind = \"equirectangular\"\n{}", projector(0.0, alone))),
        ("fisheye 180°, a domemaster", format!("{CONTENT}{}", dome(180))),
    ]
    .into_iter()
    .map(|(name, outputs)| {
        let text = format!("[dome]\nradius = 5\ntilt = 0\ncoverage = 360\n{outputs}");
        Ok((name.to_owned(), rig::parse(&text, name, Path::new(""))?))
    })
    .collect()
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
