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
    let unit = screen.size();
    let inside = |place: &DVec2| place.cmpge(DVec2::ZERO).all() && place.cmple(DVec2::new(4000.0, 3000.0)).all();
    let mut observed = Observed { photograph: PHOTOGRAPH, ..Observed::default() };
    for (output, described) in exact.outputs.iter().enumerate() {
        let projector = Projector::new(described, SIZES[output], &[Part::Pose], unit).expect("one");
        let optics = projector.optics(&[]);
        let mut found = 0;
        for _ in 0..30 * each {
            let pixel = DVec2::new(random.range(0.0, 1920.0), random.range(0.0, 1080.0));
            let Some((origin, direction)) = projector.ray(&optics, pixel) else { continue };
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
        let Some(hit) = screen.hit(DVec3::ZERO, direction) else { continue };
        let Some(seen) = camera.place(hit.point).filter(inside) else { continue };
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
        let limits_of_all = limits(&exact, &SIZES, &observed, &camera, &[Part::Pose], [0.3; 3]).expect("projectors");
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

/// The rig with other numbers of these parts: up to `pose` for place (parts of the screen's size)
/// and angles (radians), up to `rest` for the others.
fn changed(rig: &Rig, parts: &[Part], pose: f64, rest: f64, random: &mut Random) -> Rig {
    let mut changed = rig.clone();
    for (output, size) in changed.outputs.iter_mut().zip(SIZES) {
        let projector = Projector::new(output, size, parts, rig.surface().size()).expect("a projector");
        let most = |index| if index < Part::Pose.parameters() { pose } else { rest };
        let numbers: Vec<f64> =
            (0..projector.parameters()).map(|index| random.range(-most(index), most(index))).collect();
        output.kind = OutputKind::Optics { optics: Box::new(projector.optics(&numbers)), even_light: 0.0 };
    }
    changed
}

/// Root mean square error over the pictures of all outputs, pixels.
fn error(exact: &Rig, found: &Found) -> f64 {
    let screen = exact.surface();
    marks::rms(found.outputs.iter().map(|(output, solved)| {
        let projector = Projector::new(&exact.outputs[*output], SIZES[*output], &[], 1.0).expect("one");
        marks::difference(&projector, &projector.optics(&[]), &solved.optics, &screen)
    }))
}

/// Lenses that are not known, with distortion, and a spherical mirror that is not known.
#[test]
fn lenses_and_mirrors_are_found() {
    let mut random = Random::new(105);
    let lens = [Part::Pose, Part::Fov, Part::Shift, Part::Radial];
    for (preset, parts) in [("planetarium-6", &lens[..]), ("idome", &[Part::Pose, Part::Mirror])] {
        let described = rig::load(preset).expect("a preset");
        let unit = described.surface().size();
        let mut squares = 0.0;
        let mut least = 0.0;
        for noise in [0.0, 0.3, 0.3] {
            let exact = changed(&described, parts, 0.01, 0.02, &mut random);
            let rough = changed(&exact, parts, 0.01, 0.01, &mut random);
            let mut camera = camera(CameraLens::Fisheye, &mut random);
            camera.pose.position *= 0.2 * unit;
            if preset == "idome" {
                camera.pose.rotation = pose::rotation(0.1, 0.05, 0.2);
            }
            let observed = observed(&exact, &camera, 100, 30, noise, &mut random);
            let found = solve(&rough, &SIZES[..exact.outputs.len()], &observed, parts).expect("determined");
            let error = error(&exact, &found);
            let limits = limits(&exact, &SIZES[..exact.outputs.len()], &observed, &camera, parts, [0.3; 3]);
            let limit = marks::rms(limits.expect("projectors").expect("determined").into_iter());
            println!("{preset} {noise}: {error} px, at least {limit}");
            if noise == 0.0 {
                assert!(error < 1e-3, "{preset}: {error} px of exact places");
            } else {
                squares += error * error;
                least += limit * limit;
            }
        }
        let ratio = (squares / least).sqrt();
        assert!(ratio < 1.2 && ratio > 0.3, "{preset}: {ratio} of the least error");
    }
}

/// As many places as a photograph with blurred patterns gives, some of them wrong, and a hundred
/// marks: a tenth of a pixel.
#[test]
fn noise_and_wrong_places_leave_a_tenth_of_a_pixel() {
    let mut random = Random::new(106);
    let exact = rig::load("planetarium-6").expect("a preset");
    let camera = camera(CameraLens::Fisheye, &mut random);
    let right = observed(&exact, &camera, 400, 100, 0.3, &mut random);
    let mut observed = right.clone();
    let mut wrong = |seen: &mut DVec2| *seen += random.gaussian() * 300.0 + 10.0;
    observed.sightings.iter_mut().step_by(10).for_each(|sighting| wrong(&mut sighting.seen));
    observed.landmarks.iter_mut().step_by(10).for_each(|(seen, _)| wrong(seen));
    let found = solve(&rough(&exact, &mut random), &SIZES, &observed, &[Part::Pose]).expect("determined");
    let mut right = right;
    let mut index = 0..;
    right.sightings.retain(|_| index.next().is_some_and(|index: usize| !index.is_multiple_of(10)));
    let mut index = 0..;
    right.landmarks.retain(|_| index.next().is_some_and(|index: usize| !index.is_multiple_of(10)));
    let limits = limits(&exact, &SIZES, &right, &camera, &[Part::Pose], [0.3; 3]).expect("projectors");
    let limit = marks::rms(limits.expect("determined").into_iter());
    let error = error(&exact, &found);
    println!("{error} px, at least {limit}");
    assert!(error < 0.1 && error < 1.2 * limit.max(0.05), "{error} px, at least {limit}");
}
