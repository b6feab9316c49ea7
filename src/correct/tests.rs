//! The passes against brute force: every pixel of several rigs.

use super::plan::{Plan, Source, build};
use crate::rig::*;
use crate::views::tests::{fisheye, lens, projector, request, rig};
use glam::DVec3;

/// The batch of each pixel, row by row; panics where two claim one.
fn painted(plan: &Plan, output: usize) -> Vec<Option<usize>> {
    let pass = &plan.passes[output];
    let mut painted = vec![None; (pass.size.0 * pass.size.1) as usize];
    for (index, batch) in pass.batches.iter().enumerate() {
        for rect in &batch.rects {
            for y in rect.y..rect.y + rect.height {
                for x in rect.x..rect.x + rect.width {
                    let pixel = &mut painted[(y * pass.size.0 + x) as usize];
                    assert_eq!(*pixel, None, "pixel {x}, {y} is in two batches");
                    *pixel = Some(index);
                }
            }
        }
    }
    painted
}

/// Checks every pixel of every output against `plan`; returns how many show something.
pub(crate) fn check(rig: &Rig, plan: &Plan) -> usize {
    let mut lit = 0;
    for (index, pass) in plan.passes.iter().enumerate() {
        let painted = painted(plan, index);
        for y in 0..pass.size.1 {
            for x in 0..pass.size.0 {
                let (u, v) = pass.source.normalised(pass.size, f64::from(x) + 0.5, f64::from(y) + 0.5);
                let direction = pass.source.direction(u, v);
                let batch = painted[(y * pass.size.0 + x) as usize].map(|batch| &pass.batches[batch]);
                let Some(direction) = direction else {
                    assert!(batch.is_none_or(|batch| batch.edge), "dark pixel {x}, {y} in a batch without edge");
                    continue;
                };
                lit += 1;
                let batch = batch.unwrap_or_else(|| panic!("pixel {x}, {y} of {} is in no batch", pass.name));
                let answering = plan.views.output_views[index].iter().copied().find(|&view| {
                    let view = &plan.views.views[view];
                    let local = view.rotation * direction;
                    local.z < 0.0 && view.owned.contains(local.x / -local.z, local.y / -local.z)
                });
                let answering = answering.unwrap_or_else(|| panic!("no view shows pixel {x}, {y} of {}", pass.name));
                assert!(batch.views.contains(&answering), "pixel {x}, {y} of {} needs view {answering}", pass.name);
                // In the batch's own order of precedence the same view must answer.
                assert!(batch.views.is_sorted());
                if let Source::Projector(projector) = &pass.source {
                    for (number, neighbour) in projector.neighbours.iter().enumerate() {
                        let Some(at) = neighbour.picture.evaluate(u, v) else { continue };
                        let deep = at.z > 0.0 && at.x.abs() < 0.999 * at.z && at.y.abs() < 0.999 * at.z;
                        assert!(!deep || batch.neighbours.contains(&number), "pixel {x}, {y}: neighbour {number}");
                    }
                }
            }
        }
    }
    let _ = rig;
    lit
}

#[test]
fn every_pixel_of_the_fisheye_is_in_one_right_batch() {
    let rig = rig(vec![fisheye(180.0, 90.0)]);
    let plan = build(&rig, &request(&[(512, 512)])).unwrap();
    let lit = check(&rig, &plan);
    assert!((lit as f64 / 205887.0 - 1.0).abs() < 0.01, "{lit}");
    for batch in &plan.passes[0].batches {
        println!("views {:?} edge {} {} rects", batch.views, batch.edge, batch.rects.len());
    }
}

#[test]
fn every_pixel_of_overlapping_projectors_is_in_one_right_batch() {
    let mut rig = rig((0..6)
        .map(|index| {
            let yaw = 60.0 * f64::from(index);
            let out = DVec3::new(yaw.to_radians().sin(), 0.0, -yaw.to_radians().cos());
            projector(&format!("p{index}"), out * -3.0, [yaw, 25.0, 0.0], lens(60.0, 45.0))
        })
        .collect());
    for output in &mut rig.outputs {
        output.blend.overlap = true;
    }
    rig.dome.coverage = 200f64.to_radians();
    let plan = build(&rig, &request(&[(640, 400); 6])).unwrap();
    check(&rig, &plan);
    for pass in &plan.passes {
        println!("{}", pass.name);
        for batch in &pass.batches {
            println!(
                "  views {:?} neighbours {:?} edge {} {} rects",
                batch.views,
                batch.neighbours,
                batch.edge,
                batch.rects.len()
            );
        }
    }
}
