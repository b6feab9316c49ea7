//! A closed loop: marks are made from a projector that is known, with errors that are known.

use super::*;
use crate::rig::{self, OutputKind};
use crate::testing::random::Random;
use std::path::Path;

const SIZE: (u32, u32) = (1920, 1080);
const LENS: [Part; 4] = [Part::Pose, Part::Fov, Part::Shift, Part::Radial];

/// The planetarium, and the same with each projector moved by some centimetres and degrees: what a
/// technician would write down.
fn rigs(random: &mut Random) -> (Rig, Rig) {
    let exact = rig::load("planetarium-6").expect("a preset");
    let mut rough = exact.clone();
    for output in &mut rough.outputs {
        let OutputKind::Projector { position, angles, .. } = &mut output.kind else { panic!("a projector") };
        *position += random.vector(-0.15, 0.15);
        angles.iter_mut().for_each(|angle| *angle += random.range(-0.07, 0.07));
    }
    (exact, rough)
}

/// Marks of an output that has a lens with distortion.
fn truth(exact: &Rig, output: usize) -> Projector {
    let projector = Projector::new(&exact.outputs[output], SIZE, &LENS, 5.0).expect("a projector");
    let lens = [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.01, -0.008, 0.02, 0.01, -0.05, 0.02];
    projector.with(projector.optics(&lens), &LENS)
}

fn marks(exact: &Rig, output: usize, count: usize, random: &mut Random) -> Vec<Mark> {
    let projector = truth(exact, output);
    let (optics, screen) = (projector.optics(&[]), exact.surface());
    let mut marks = Vec::new();
    while marks.len() < count {
        let pixel = DVec2::new(random.range(0.0, 1920.0), random.range(0.0, 1080.0));
        let (origin, direction) = projector.ray(&optics, pixel).expect("a ray");
        let Some(hit) = screen.hit(origin, direction) else { continue };
        marks.push(Mark { output, pixel, direction: hit.point.normalize() });
    }
    marks
}

fn gaussian(random: &mut Random) -> DVec2 {
    let length = (-2.0 * (1.0 - random.unit()).ln()).sqrt();
    length * DVec2::from_angle(random.range(0.0, std::f64::consts::TAU))
}

/// Greatest and root mean square distance between the places of points all over a picture.
fn distance(exact: &Rig, output: usize, solved: &Optics) -> (f64, f64) {
    let (projector, screen) = (truth(exact, output), exact.surface());
    let optics = projector.optics(&[]);
    let distances: Vec<f64> = grid(SIZE)
        .filter_map(|pixel| {
            let (origin, direction) = projector.ray(&optics, pixel)?;
            let point = screen.hit(origin, direction)?.point;
            Some(projector.pixel(solved, point)?.distance(pixel))
        })
        .collect();
    (distances.iter().fold(0.0, |a, b| a.max(*b)), rms(distances.into_iter()))
}

fn check_pose(found: &Optics, right: &Optics) {
    assert!(found.pose.position.distance(right.pose.position) < 1e-6, "{found:?}");
    assert!(found.pose.rotation.abs_diff_eq(right.pose.rotation, 1e-6), "{found:?} {right:?}");
}

#[test]
fn exact_marks_give_the_exact_projector_although_some_are_wrong() {
    let mut random = Random::new(81);
    let (exact, rough) = rigs(&mut random);
    for wrong_each in [usize::MAX, 10, 4] {
        for output in 0..6 {
            let mut marks = marks(&exact, output, 40, &mut random);
            for mark in marks.iter_mut().step_by(wrong_each).skip(1) {
                mark.pixel += gaussian(&mut random) * 200.0 + 5.0;
            }
            let solved = solve(&rough, output, SIZE, &marks, &LENS).expect("determined");
            check_pose(&solved.optics, &truth(&exact, output).optics(&[]));
            assert!(distance(&exact, output, &solved.optics).0 < 1e-3);
            let right = solved.quality.used.iter().filter(|used| **used).count();
            assert_eq!(right, 40 - (39 / wrong_each), "those are found, and no others");
        }
    }
}

#[test]
fn noise_is_averaged_as_well_as_can_be() {
    let mut random = Random::new(82);
    let (exact, rough) = rigs(&mut random);
    let (mut found, mut least, mut told) = (Vec::new(), Vec::new(), Vec::new());
    for seed in 0..20 {
        let output = seed % 6;
        let mut marks = marks(&exact, output, 60, &mut random);
        let projector = truth(&exact, output);
        let points = marks.iter().map(|mark| (mark.pixel, mark.direction * 5.0)).collect();
        let model = MarksModel { projector, points };
        // The limit of Cramér and Rao.
        let information = least_squares::information(&model, &[0.0; 12], &[true; 60], &[0.3]);
        let limit = Fit {
            parameters: vec![0.0; 12],
            residuals: Vec::new(),
            used: Vec::new(),
            cost: 0.0,
            deviations: vec![0.3],
            covariance: information.inverse(),
        };
        least.push(
            expected(&model.projector, &model.projector.optics(&[]), &limit, 0, &exact.surface()).expect("determined"),
        );
        marks.iter_mut().for_each(|mark| mark.pixel += 0.3 * gaussian(&mut random));
        let solved = solve(&rough, output, SIZE, &marks, &LENS).expect("determined");
        found.push(distance(&exact, output, &solved.optics).1);
        told.push(solved.quality.expected);
    }
    let [found, least, told] = [found, least, told].map(|values| rms(values.into_iter()));
    assert!(found < 1.2 * least && found > 0.85 * least, "{found} px, at least {least}");
    assert!((told / least - 1.0).abs() < 0.15, "{told} px are told, {least} are right");
}

#[test]
fn marks_that_do_not_determine_a_projector_are_refused() {
    let mut random = Random::new(83);
    let (exact, _) = rigs(&mut random);
    let few = marks(&exact, 0, 4, &mut random);
    let refused = solve(&exact, 0, SIZE, &few, &[Part::Pose]).expect_err("too few");
    assert!(refused.message.contains("output \"front\" has 4 marks"), "{refused}");
    let same = vec![few[0]; 30];
    let refused = solve(&exact, 0, SIZE, &same, &[Part::Pose]).expect_err("one place");
    assert!(refused.message.contains("is not determined"), "{refused}");
    let refused = solve(&exact, 0, SIZE, &few, &[Part::Pose, Part::Mirror]).expect_err("no mirror");
    assert!(refused.message.contains("has no mirror"), "{refused}");
    let fisheye = rig::parse("[[output]]\nkind = \"domemaster\"\n", "a", Path::new("")).expect("a rig");
    let refused = solve(&fisheye, 0, SIZE, &few, &[Part::Pose]).expect_err("no projector");
    assert!(refused.message.contains("is no projector"), "{refused}");
}
