//! Compares the exact map with known directions.

use super::*;
use crate::geom::Sphere;
use crate::testing::random::Random;
use crate::warp::testing::{projector, rig, two_projectors};
use std::f64::consts::PI;

fn close(found: Option<DVec3>, expected: DVec3) {
    let found = found.expect("the pixel shows something");
    assert!(found.distance(expected) < 1e-12, "{found} is not {expected}");
}

#[test]
fn domemasters_follow_the_documented_orientation() {
    let size = (200, 100);
    let middle = DVec2::new(100.0, 50.0);
    for (tilt, centre, top, bottom) in
        [(FRAC_PI_2, DVec3::NEG_Z, DVec3::Y, DVec3::NEG_Y), (0.0, DVec3::Y, DVec3::Z, DVec3::NEG_Z)]
    {
        let rig = rig(tilt, DVec3::ZERO, &[OutputKind::Domemaster { aperture: PI, tilt }]);
        close(exact_direction(&rig, 0, size, middle), centre);
        close(exact_direction(&rig, 0, size, middle - DVec2::new(0.0, 50.0)), top);
        close(exact_direction(&rig, 0, size, middle + DVec2::new(0.0, 50.0)), bottom);
        close(exact_direction(&rig, 0, size, middle + DVec2::new(50.0, 0.0)), DVec3::X);
        assert_eq!(exact_direction(&rig, 0, size, middle + DVec2::new(50.1, 0.0)), None, "outside the circle");
        let between = (centre + DVec3::X).normalize();
        close(exact_direction(&rig, 0, size, middle + DVec2::new(25.0, 0.0)), between);
    }
}

#[test]
fn a_viewer_off_centre_sees_the_same_point_of_the_dome() {
    let position = DVec3::new(0.0, 0.0, 3.0);
    let mut rig = rig(FRAC_PI_2, position, &[OutputKind::Domemaster { aperture: PI, tilt: FRAC_PI_2 }]);
    let rim = DVec2::new(100.0, 50.0);
    close(exact_direction(&rig, 0, (100, 100), rim), (DVec3::X * 5.0 - position).normalize());
    // If the viewer turns, the picture turns: its centre is the viewer's straight ahead.
    rig.viewer.position = DVec3::ZERO;
    rig.viewer.yaw = 0.7;
    let map = WarpMap::new(&rig, 0, (100, 100), None).expect("valid");
    close(map.direction(DVec2::splat(50.0)), DVec3::NEG_Z);
    close(map.hit(DVec2::splat(50.0)).map(|hit| hit / 5.0), DVec3::new(0.7f64.sin(), 0.0, -0.7f64.cos()));
}

#[test]
fn projectors_light_the_dome_where_their_rays_end() {
    // From the centre and with the viewer there, a projector is a plain camera.
    let rig1 = rig(FRAC_PI_2, DVec3::ZERO, &[projector(DVec3::ZERO, 90.0, 0.0, (90.0, 60.0))]);
    assert_eq!(exact_direction(&rig1, 0, (100, 60), DVec2::new(50.5, 30.0)), None, "right of the hemisphere in front");
    close(exact_direction(&rig1, 0, (100, 60), DVec2::new(0.0, 30.0)), DVec3::new(1.0, 0.0, -1.0).normalize());
    let top = exact_direction(&rig1, 0, (100, 60), DVec2::new(0.0, 0.0)).expect("on the dome");
    assert!(top.y > 0.1, "row 0 is at the top");
    // From outside, it shines through to the far side.
    let far = rig(FRAC_PI_2, DVec3::ZERO, &[projector(DVec3::new(0.0, 0.0, 50.0), 0.0, 0.0, (20.0, 20.0))]);
    close(exact_direction(&far, 0, (10, 10), DVec2::splat(5.0)), DVec3::NEG_Z);
    assert_eq!(exact_direction(&far, 0, (10, 10), DVec2::ZERO), None, "past the dome");
    let away = rig(FRAC_PI_2, DVec3::ZERO, &[projector(DVec3::new(0.0, 0.0, 50.0), 180.0, 0.0, (20.0, 20.0))]);
    assert_eq!(exact_direction(&away, 0, (10, 10), DVec2::splat(5.0)), None, "the dome is behind it");
}

#[test]
fn pixels_and_hits_are_inverse() {
    let mut random = Random::new(20);
    let mut rig = two_projectors(DVec3::new(0.5, -0.4, 0.8));
    rig.viewer.yaw = 0.3;
    rig.outputs.push(crate::warp::testing::output("fisheye", OutputKind::Domemaster { aperture: 3.5, tilt: 0.4 }));
    let frustum = Some(Frustum::symmetric(1.0, 1.2).shifted(0.1, 0.2));
    rig.outputs
        .push(crate::warp::testing::output("wall", OutputKind::Perspective { angles: [0.2, 0.3, 0.4], frustum }));
    let sphere = Sphere { center: DVec3::ZERO, radius: rig.dome.radius };
    let viewer = Pose::new(rig.viewer.position, rig.viewer.yaw, 0.0, 0.0);
    for output in 0..rig.outputs.len() {
        let map = WarpMap::new(&rig, output, (1920, 1080), None).expect("valid");
        let mut shown = 0;
        for _ in 0..4_000 {
            let pixel = DVec2::new(random.range(0.0, 1920.0), random.range(0.0, 1080.0));
            let Some(direction) = map.direction(pixel) else { continue };
            shown += 1;
            let seen = sphere.far_hit(viewer.position, viewer.direction_to_parent(direction)).expect("viewer inside");
            if let Some(hit) = map.hit(pixel) {
                assert!(hit.distance(seen) < 1e-12);
            }
            let back = map.pixel(seen).expect("it came from a pixel");
            assert!(back.distance(pixel) < 1e-8, "{output}: {pixel} {back}");
        }
        assert!(shown > 1_000);
    }
}

#[test]
fn the_program_s_own_lens_must_be_given() {
    let rig = rig(FRAC_PI_2, DVec3::ZERO, &[OutputKind::Perspective { angles: [0.0; 3], frustum: None }]);
    assert!(WarpMap::new(&rig, 0, (10, 10), None).is_err());
    assert!(WarpMap::new(&rig, 1, (10, 10), None).is_err() && WarpMap::new(&rig, 0, (0, 10), None).is_err());
    let map = WarpMap::new(&rig, 0, (10, 10), Some(Frustum::symmetric(FRAC_PI_2, FRAC_PI_2))).expect("valid");
    close(map.direction(DVec2::ZERO), DVec3::new(-1.0, 1.0, -1.0).normalize());
    assert_eq!(map.hit(DVec2::ZERO), None);
    assert!(exact_map(&rig, 0, (2, 2)).is_err());
}

#[test]
fn maps_and_camera_directions() {
    let mut rig = rig(FRAC_PI_2, DVec3::ZERO, &[OutputKind::Domemaster { aperture: PI, tilt: FRAC_PI_2 }]);
    let map = exact_map(&rig, 0, (4, 2)).expect("valid");
    assert!(map.len() == 8 && map[0][0].is_nan() && map[3][2].is_nan());
    assert!(map[1][0] < 0.0 && map[1][1] > 0.0 && map[6][0] > 0.0 && map[6][1] < 0.0);
    // The camera is turned right by 90°: its forward direction is the viewer's right.
    rig.camera.yaw = FRAC_PI_2;
    assert!(camera_direction(&rig, DVec3::X).distance(DVec3::NEG_Z) < 1e-15);
}
