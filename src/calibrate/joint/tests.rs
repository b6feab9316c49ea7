//! A closed loop: observations of a known rig, with known errors.

use super::*;
use crate::geom::pose;
use crate::rig::{self, OutputKind};
use crate::testing::random::Random;

const SIZES: [(u32, u32); 6] = [(1920, 1080); 6];
const PHOTOGRAPH: (u32, u32) = (4000, 3000);

/// The rig as a technician would measure it.
fn rough(exact: &Rig, random: &mut Random) -> Rig {
    let mut rough = exact.clone();
    for output in &mut rough.outputs {
        let OutputKind::Projector { position, angles, .. } = &mut output.kind else { panic!("a projector") };
        *position += random.vector(-0.1, 0.1);
        angles.iter_mut().for_each(|angle| *angle += random.range(-0.05, 0.05));
    }
    rough
}

/// A camera near the centre with a fisheye that looks up, or with a wide lens that looks at a part.
fn camera(lens: CameraLens, random: &mut Random) -> Camera {
    let position = random.vector(-0.6, 0.6);
    let fisheye = lens == CameraLens::Fisheye;
    let pitch = if fisheye { 1.2 } else { 0.8 };
    let mut camera = Camera::new(Pose::new(position, 0.4, pitch, 0.3), lens, 1.0, PHOTOGRAPH);
    (camera.focal, camera.radial) = if fisheye { (905.0, [-0.03, 0.002, 0.0]) } else { (1300.0, [-0.05, 0.006, 0.0]) };
    camera.center += DVec2::new(31.0, -18.0);
    camera
}

/// Observations of the camera: `each` places of each projector, and `landmarks` of known direction.
fn observed(exact: &Rig, camera: &Camera, each: usize, landmarks: usize, noise: f64, random: &mut Random) -> Observed {
    let screen = exact.surface();
    let inside = |place: &DVec2| place.cmpge(DVec2::ZERO).all() && place.cmple(DVec2::new(4000.0, 3000.0)).all();
    let mut observed = Observed { photograph: PHOTOGRAPH, ..Observed::default() };
    for (output, described) in exact.outputs.iter().enumerate() {
        let projector = Projector::new(described, SIZES[output], &[Part::Pose], 5.0).expect("one");
        let optics = projector.optics(&[]);
        let mut found = 0;
        for _ in 0..30 * each {
            let pixel = DVec2::new(random.range(0.0, 1920.0), random.range(0.0, 1080.0));
            let (origin, direction) = projector.ray(&optics, pixel).expect("a ray");
            let Some(hit) = screen.hit(origin, direction) else { continue };
            let Some(seen) = camera.place(hit.point).filter(inside) else { continue };
            observed.sightings.push(Sighting { output, pixel, seen: seen + noise * random.gaussian() });
            found += 1;
            if found == each {
                break;
            }
        }
    }
    while observed.landmarks.len() < landmarks {
        let direction = random.direction();
        let Some(seen) = camera.place(5.0 * direction).filter(inside) else { continue };
        observed.landmarks.push((seen + noise * random.gaussian(), direction));
    }
    observed
}

#[test]
fn exact_photographs_give_the_exact_rig_although_some_places_are_wrong() {
    let mut random = Random::new(101);
    let exact = rig::load("planetarium-6").expect("a preset");
    for lens in [CameraLens::Fisheye, CameraLens::Pinhole] {
        let mut exact = exact.clone();
        if lens == CameraLens::Pinhole {
            // The camera sees a part of the dome.
            exact.outputs.truncate(2);
        }
        let camera = camera(lens, &mut random);
        let mut observed = observed(&exact, &camera, 50, 8, 0.0, &mut random);
        for sighting in observed.sightings.iter_mut().step_by(10) {
            sighting.seen += random.gaussian() * 300.0 + 10.0;
        }
        let found = solve(&rough(&exact, &mut random), &SIZES, &observed, &[Part::Pose]).expect("determined");
        assert!((found.camera.lens, found.aimed_by_first) == (lens, false) && found.rms < 1e-6, "{found:?}");
        assert!((found.camera.focal / camera.focal - 1.0).abs() < 1e-6, "{:?}", found.camera);
        assert!(found.camera.pose.position.distance(camera.pose.position) < 1e-6);
        for (output, solved) in &found.outputs {
            let OutputKind::Projector { position, angles: [yaw, pitch, roll], .. } = exact.outputs[*output].kind else {
                panic!("a projector")
            };
            assert!(solved.optics.pose.position.distance(position) < 1e-6, "{lens:?} {output}");
            assert!(solved.optics.pose.rotation.abs_diff_eq(pose::rotation(yaw, pitch, roll), 1e-6));
            assert!(solved.quality.used.iter().filter(|used| !**used).count() >= 4);
        }
    }
}

#[test]
fn noise_is_averaged_as_well_as_can_be() {
    let mut random = Random::new(102);
    let exact = rig::load("planetarium-6").expect("a preset");
    let screen = exact.surface();
    let (mut squares, mut least) = (Vec::new(), Vec::new());
    for _ in 0..3 {
        let camera = camera(CameraLens::Fisheye, &mut random);
        let observed = observed(&exact, &camera, 60, 20, 0.3, &mut random);
        let found = solve(&rough(&exact, &mut random), &SIZES, &observed, &[Part::Pose]).expect("determined");
        let limits_of_all = limits(&exact, &SIZES, &observed, &camera, &[Part::Pose], 0.3).expect("projectors");
        least.extend(limits_of_all.expect("determined"));
        for (output, solved) in &found.outputs {
            let projector = Projector::new(&exact.outputs[*output], SIZES[*output], &[Part::Pose], 5.0).expect("one");
            squares.push(marks::difference(&projector, &projector.optics(&[]), &solved.optics, &screen));
        }
    }
    let [found, limit] = [squares, least].map(|values| marks::rms(values.into_iter()));
    assert!(found < 1.2 * limit && found > 0.75 * limit, "{found} px, at least {limit}");
}

/// Decoded places are ten times as precise as clicks; all of the clicks count nevertheless.
#[test]
fn rough_marks_beside_precise_places_are_averaged() {
    let mut random = Random::new(104);
    let exact = rig::load("planetarium-6").expect("a preset");
    let camera = camera(CameraLens::Fisheye, &mut random);
    let mut observed = observed(&exact, &camera, 60, 60, 0.02, &mut random);
    observed.landmarks.iter_mut().for_each(|(seen, _)| *seen += 0.6 * random.gaussian());
    let found = solve(&rough(&exact, &mut random), &SIZES, &observed, &[Part::Pose]).expect("determined");
    let error = marks::rms(found.outputs.iter().map(|(output, solved)| {
        let projector = Projector::new(&exact.outputs[*output], SIZES[*output], &[Part::Pose], 5.0).expect("one");
        marks::difference(&projector, &projector.optics(&[]), &solved.optics, &exact.surface())
    }));
    let told = marks::rms(found.outputs.iter().map(|(_, solved)| solved.quality.expected));
    // The marks give the mean of 60 clicks.
    assert!(error < 0.25 && error < 2.0 * told, "{error} px, {told} px are told");
}

#[test]
fn without_marks_the_first_output_gives_the_aim() {
    let mut random = Random::new(103);
    let exact = rig::load("planetarium-6").expect("a preset");
    let camera = camera(CameraLens::Fisheye, &mut random);
    let seen = observed(&exact, &camera, 40, 0, 0.0, &mut random);
    // The rest of the rig is rough; the first output is right.
    let mut rough = rough(&exact, &mut random);
    rough.outputs[0] = exact.outputs[0].clone();
    let found = solve(&rough, &SIZES, &seen, &[Part::Pose]).expect("determined");
    assert!(found.aimed_by_first);
    for (output, solved) in &found.outputs {
        let OutputKind::Projector { position, .. } = exact.outputs[*output].kind else { panic!("a projector") };
        assert!(solved.optics.pose.position.distance(position) < 1e-6, "{output}: {solved:?}");
    }
    let few = Observed { sightings: seen.sightings[..5].to_vec(), ..seen };
    let refused = solve(&rough, &SIZES, &few, &[Part::Pose]).expect_err("too few");
    assert!(refused.message.contains("\"front\" was seen in 5 places"), "{refused}");
}
