//! A closed loop: marks are made from a known projector, with known errors.

use super::*;
use crate::rig::{self, OutputKind};
use crate::testing::random::Random;
use std::path::Path;

const SIZE: (u32, u32) = (1920, 1080);
const LENS: [Part; 4] = [Part::Pose, Part::Fov, Part::Shift, Part::Radial];

/// The planetarium, and the same with each projector moved by some centimetres and degrees, as a
/// technician would measure it.
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
                mark.pixel += random.gaussian() * 200.0 + 5.0;
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
    let mut squares = [Vec::new(), Vec::new()];
    for seed in 0..20 {
        let output = seed % 6;
        let mut marks = marks(&exact, output, 60, &mut random);
        let mut distorted = exact.clone();
        let optics = Box::new(truth(&exact, output).optics(&[]));
        distorted.outputs[output].kind = OutputKind::Optics { optics, even_light: 0.0 };
        let limit = limit(&distorted, output, SIZE, &marks, &LENS, 0.3).expect("a projector");
        least.push(limit.expect("determined"));
        marks.iter_mut().for_each(|mark| mark.pixel += 0.3 * random.gaussian());
        let solved = solve(&rough, output, SIZE, &marks, &LENS).expect("determined");
        found.push(distance(&exact, output, &solved.optics).1);
        told.push(solved.quality.expected);
        let right = truth(&exact, output).optics(&[]).pose;
        let turned = glam::DQuat::from_mat3(&(right.rotation.transpose() * solved.optics.pose.rotation));
        let moved = solved.optics.pose.position - right.position;
        let error = [moved, turned.to_scaled_axis()].map(|error| error.to_array()).concat();
        // Control: position and rotation go together in the opposite way.
        for (index, sign) in [1.0, -1.0].into_iter().enumerate() {
            let mut covariance = Symmetric::zero(6);
            for (row, column) in (0..6).flat_map(|row| (0..=row).map(move |column| (row, column))) {
                let sign = if row >= 3 && column < 3 { sign } else { 1.0 };
                covariance.add(row, column, sign * solved.quality.covariance[row][column]);
            }
            squares[index].push(covariance.inverse().expect("of full rank").form(&error));
        }
    }
    // Squared errors in units of their covariance have the median 5.35, as the sum of six squared normal numbers. Their
    // mean is larger: some projectors are so weakly determined that the errors are no linear function of the noise.
    let [with, opposite] = squares.map(|mut squares| median(&mut squares));
    assert!((3.5..8.5).contains(&with) && opposite > 30.0, "{with} with the covariance, control {opposite}");
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

/// Solves marks of the only output of a rig, a tenth of them wrong, starting from a rough rig.
fn check_lens(exact: &str, parts: &[Part], off: &[f64]) {
    let exact = rig::parse(exact, "a", Path::new("")).expect("a rig");
    let (mut random, screen) = (Random::new(84), exact.surface());
    let projector = Projector::new(&exact.outputs[0], SIZE, parts, screen.size()).expect("a projector");
    let right = projector.optics(&[]);
    let mut marks = Vec::new();
    while marks.len() < 60 {
        let pixel = DVec2::new(random.range(0.0, 1920.0), random.range(0.0, 1080.0));
        let Some((origin, direction)) = projector.ray(&right, pixel) else { continue };
        let Some(hit) = screen.hit(origin, direction) else { continue };
        marks.push(Mark { output: 0, pixel, direction: hit.point.normalize() });
    }
    marks.iter_mut().step_by(10).for_each(|mark| mark.pixel += 100.0 * random.gaussian() + 20.0);
    let mut rough = exact.clone();
    let optics = projector.optics(off);
    let before = difference(&projector, &right, &optics, &screen);
    rough.outputs[0].kind = OutputKind::Optics { optics: Box::new(optics), even_light: 0.0 };
    let solved = solve(&rough, 0, SIZE, &marks, parts).expect("determined");
    let after = difference(&projector, &right, &solved.optics, &screen);
    assert!(before > 5.0 && after < 1e-3, "{before} px became {after}");
    assert_eq!(solved.quality.used.iter().filter(|used| !**used).count(), 6);
    check_pose(&solved.optics, &right);
}

#[test]
fn mirrors_are_found() {
    let idome = rig::presets().iter().find(|preset| preset.name == "idome").expect("a preset");
    let off = [0.01, -0.008, 0.006, 0.01, -0.02, 0.015, -0.008, 0.01, 0.006, 0.02];
    check_lens(idome.text, &[Part::Pose, Part::Mirror], &off);
}

#[test]
fn fisheyes_are_found() {
    let text = "[dome]\nradius = 1.5\ntilt = 20\n[[output]]\nkind = \"projector\"\nposition = [0.0, -0.3, 0.1]\npitch = 90\n\
        fisheye = { projection = \"equisolid\", aperture = 175.0, size = [1.0, 1.777], center = [0.02, -0.01] }\n";
    let off = [0.02, -0.015, 0.01, 0.02, -0.02, 0.03, 0.02, -0.01, 0.01, 0.015];
    check_lens(text, &[Part::Pose, Part::Fov, Part::Shift], &off);
}
